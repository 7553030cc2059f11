//! `tracks.dat`: labelled trajectories as text, the file format of the Moseg benchmark.
//!
//! ```text
//! number of frames
//! number of tracks
//! label number-of-points      for each track,
//! x y frame                   followed by each of its points
//! ```
//!
//! Labels count from 0 without a gap. Frames count from 0 and are consecutive within a track. Coordinates are pixels, pixel
//! centres at integers; evaluators round them to the nearest pixel, halves upwards.
//!
//! Coordinates are written with three decimals. Up to the largest image side, the nearest 32-bit number to such a decimal is
//! on the same side of `.5` as the decimal, so programs that read 32-bit and 64-bit numbers round to the same pixel.

use crate::Error;
use crate::discretize::Clusters;
use crate::trajectory::Trajectories;
use std::fmt::Write;
use std::str::FromStr;

/// Formats `tracks.dat` for `tracks`, whose trajectory `i` has the label `clusters.label[i]`.
///
/// # Errors
/// [`Error::Data`] if trajectories and labels differ in number, or a label below `clusters.count` is unused.
pub fn write(tracks: &Trajectories, clusters: &Clusters) -> Result<String, Error> {
    check_labels(tracks.len(), clusters)?;
    let mut text = String::with_capacity(24 * tracks.x.len() + 12 * tracks.len() + 24);
    let mut line = |arguments: std::fmt::Arguments<'_>| {
        text.write_fmt(arguments).expect("writing to a string cannot fail");
    };
    line(format_args!("{}\n{}\n", tracks.num_frames, tracks.len()));
    for i in 0..tracks.len() {
        let points = tracks.points(i);
        line(format_args!("{} {}\n", clusters.label[i], points.len()));
        for (p, frame) in points.zip(tracks.frames(i)) {
            let [x, y] = [tracks.x[p], tracks.y[p]].map(Thousandths);
            line(format_args!("{x} {y} {frame}\n"));
        }
    }
    Ok(text)
}

/// A coordinate with three decimals, halves away from zero, as JavaScript has them; Rust's own are to even.
struct Thousandths(f32);

impl std::fmt::Display for Thousandths {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Exact: a coordinate has 24 bits.
        let thousandths = (1000.0 * f64::from(self.0).abs()).round() as u64;
        let sign = if self.0 < 0.0 { "-" } else { "" };
        write!(f, "{sign}{}.{:03}", thousandths / 1000, thousandths % 1000)
    }
}

/// Parses the text of a `tracks.dat`. The file has no image size: `size` of the result is `(0, 0)`.
///
/// # Errors
/// [`Error::Data`] with the line, its content and the expected content.
pub fn parse(text: &str) -> Result<(Trajectories, Clusters), Error> {
    let mut lines = LineReader { lines: text.lines(), number: 0 };
    let num_frames: u32 = lines.next_with("the number of frames")?.number("the number of frames")?;
    let count: usize = lines.next_with("the number of tracks")?.number("the number of tracks")?;
    let mut tracks = Trajectories::empty(num_frames as usize, (0, 0));
    let mut label = Vec::new();
    for _ in 0..count {
        label.push(read_track(&mut lines, &mut tracks)?);
    }
    lines.expect_end()?;
    let clusters = Clusters { count: label.iter().max().map_or(0, |&m: &u32| m as usize + 1), label };
    check_labels(count, &clusters)?;
    Ok((tracks, clusters))
}

/// Reads one track into `tracks` and returns its label.
fn read_track(lines: &mut LineReader<'_>, tracks: &mut Trajectories) -> Result<u32, Error> {
    let mut header = lines.next_with("a track's label and number of points")?;
    let label = header.number("a label")?;
    let points: usize = header.number("the number of points")?;
    if points == 0 {
        return Err(header.error("0", "at least 1 point"));
    }
    let mut start = 0;
    let mut positions = Vec::new();
    for k in 0..points {
        let mut line = lines.next_with("x, y and frame of a point")?;
        let (x, y): (f32, f32) = (line.number("x")?, line.number("y")?);
        let frame: usize = line.number("a frame index")?;
        if !(x.is_finite() && y.is_finite()) {
            return Err(line.error(&format!("{x} {y}"), "finite coordinates"));
        }
        if k == 0 {
            start = frame;
        }
        if frame >= tracks.num_frames {
            return Err(
                line.error(&frame.to_string(), &format!("a frame below the first line's {}", tracks.num_frames))
            );
        }
        if frame != start + k {
            return Err(line.error(&frame.to_string(), &format!("frame {}: tracks may have no gap", start + k)));
        }
        positions.push((x, y, 0.0));
    }
    tracks.push(start, positions);
    Ok(label)
}

fn check_labels(num_tracks: usize, clusters: &Clusters) -> Result<(), Error> {
    let breach = |reason: String| Err(Error::Data { reason });
    if clusters.label.len() != num_tracks {
        return breach(format!("{} labels (expected {num_tracks}, one for each track)", clusters.label.len()));
    }
    if clusters.count > num_tracks {
        return breach(format!(
            "labels reach {} with {num_tracks} tracks (expected every label used)",
            clusters.count - 1
        ));
    }
    let mut is_used = vec![false; clusters.count];
    for &label in &clusters.label {
        match is_used.get_mut(label as usize) {
            Some(is_used) => *is_used = true,
            None => return breach(format!("label {label} (expected 0..{})", clusters.count)),
        }
    }
    match is_used.iter().position(|&is_used| !is_used) {
        Some(label) => breach(format!("no track has label {label} (expected labels from 0 without a gap)")),
        None => Ok(()),
    }
}

/// Reads the lines of a text that are not blank, and counts them.
struct LineReader<'a> {
    lines: std::str::Lines<'a>,
    number: usize,
}

impl<'a> LineReader<'a> {
    /// Returns the next line, which should contain `expected`.
    fn next_with(&mut self, expected: &str) -> Result<Line<'a>, Error> {
        for text in self.lines.by_ref() {
            self.number += 1;
            if !text.trim().is_empty() {
                return Ok(Line { fields: text.split_whitespace(), number: self.number });
            }
        }
        Err(Error::Data { reason: format!("track file ends after line {} (expected {expected})", self.number) })
    }

    fn expect_end(&mut self) -> Result<(), Error> {
        match self.lines.find(|l| !l.trim().is_empty()) {
            Some(text) => {
                let start: String = text.chars().take(40).collect();
                Err(Error::Data { reason: format!("track file goes on after its last track: \"{start}\"") })
            }
            None => Ok(()),
        }
    }
}

/// The fields of one line.
struct Line<'a> {
    fields: std::str::SplitWhitespace<'a>,
    number: usize,
}

impl Line<'_> {
    fn number<T: FromStr>(&mut self, expected: &str) -> Result<T, Error> {
        let field = self.fields.next().unwrap_or("");
        field.parse().map_err(|_| self.error(&format!("\"{field}\""), expected))
    }

    fn error(&self, actual: &str, expected: &str) -> Error {
        Error::Data { reason: format!("line {} of the track file: {actual} (expected {expected})", self.number) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::MAX_SIDE;
    use crate::rng::Rng;

    fn sample() -> (Trajectories, Clusters) {
        let mut tracks = Trajectories::empty(5, (0, 0));
        tracks.push(0, [(1.5, 2.25, 0.0), (2.0, 3.0, 0.0)]);
        tracks.push(3, [(0.125, 7.5, 0.0)]);
        tracks.push(1, [(4.0, 4.0, 0.0), (5.0, 5.0, 0.0), (6.0, 6.0, 0.0), (7.0, 7.0, 0.0)]);
        (tracks, Clusters { count: 2, label: vec![1, 0, 1] })
    }

    #[test]
    fn tracks_survive_writing_and_reading() {
        let (tracks, clusters) = sample();
        let text = write(&tracks, &clusters).unwrap();
        assert!(text.starts_with("5\n3\n1 2\n1.500 2.250 0\n2.000 3.000 1\n0 1\n0.125 7.500 3\n"), "{text}");
        assert_eq!(parse(&text).unwrap(), (tracks, clusters));
    }

    #[test]
    fn halves_of_the_last_decimal_are_rounded_away_from_zero() {
        let text = [0.0625, -0.1875, -0.0001, 7.9996, 12.3125].map(|x| Thousandths(x).to_string());
        assert_eq!(text, ["0.063", "-0.188", "-0.000", "8.000", "12.313"]);
    }

    #[test]
    fn no_tracks_survive_writing_and_reading() {
        let (tracks, clusters) = (Trajectories::empty(2, (0, 0)), Clusters::default());
        let text = write(&tracks, &clusters).unwrap();
        assert_eq!(text, "2\n0\n");
        assert_eq!(parse(&text).unwrap(), (tracks, clusters));
    }

    #[test]
    fn both_widths_of_numbers_round_the_written_text_to_the_same_pixel() {
        let mut rng = Rng::for_stage(7, "tracks");
        for _ in 0..20_000 {
            let pixel = rng.below(MAX_SIDE) as f32;
            for value in [pixel + 0.5, (pixel + 0.5).next_down(), pixel + 0.4995, pixel + 0.4996] {
                let written = format!("{value:.3}");
                let (short, long): (f32, f64) = (written.parse().unwrap(), written.parse().unwrap());
                assert_eq!((f64::from(short) + 0.5).floor(), (long + 0.5).floor(), "{written}");
            }
        }
    }

    #[test]
    fn broken_files_are_refused_with_line_and_reason() {
        for (text, reason) in [
            ("", "ends after line 0 (expected the number of frames)"),
            ("ten", "line 1 of the track file: \"ten\" (expected the number of frames)"),
            ("5\n1\n0 2\n1 1 0\n", "ends after line 4 (expected x, y and frame"),
            ("5\n1\n0 0\n", "at least 1 point"),
            ("5\n1\n0 1\n1 nan 0\n", "line 4 of the track file: 1 NaN (expected finite"),
            ("5\n1\n0 1\n1 1\n", "line 4 of the track file: \"\" (expected a frame index)"),
            ("5\n1\n0 1\n1 1 5\n", "a frame below the first line's 5"),
            ("5\n1\n0 2\n1 1 1\n1 1 3\n", "line 5 of the track file: 3 (expected frame 2: tracks may have no gap)"),
            ("5\n1\n-1 1\n1 1 1\n", "\"-1\" (expected a label)"),
            ("5\n1\n1 1\n1 1 1\n", "labels reach 1 with 1 tracks"),
            ("5\n2\n1 1\n1 1 1\n1 1\n2 2 2\n", "no track has label 0"),
            ("5\n1\n0 1\n1 1 1\n0 1\n", "goes on after its last track: \"0 1\""),
            ("5\n99999999999\n", "ends after line 2"),
            ("5\n1\n4294967295 1\n1 1 1\n", "labels reach 4294967295 with 1 tracks"),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.contains(reason), "{text:?} gave: {message}");
        }
    }

    #[test]
    fn labels_that_do_not_fit_the_tracks_are_not_written() {
        let (tracks, mut clusters) = sample();
        clusters.label[0] = 2;
        assert!(write(&tracks, &clusters).unwrap_err().to_string().contains("label 2 (expected 0..2)"));
        clusters.label.pop();
        assert!(write(&tracks, &clusters).unwrap_err().to_string().contains("2 labels (expected 3"));
    }
}
