//! YUV4MPEG2 (`.y4m`): uncompressed video as many tools pipe it. 8 bits, 4:2:0, 4:2:2, 4:4:4 or brightness only.
//!
//! Colour is ITU-R BT.601, in the limited range (16..=235) unless the header says `XCOLORRANGE=FULL`. Chroma samples
//! are repeated over the pixels that they belong to; siting is ignored, as motion is found in the brightness.

use crate::failure::Failure;
use crate::timeline::check;
use std::io::{BufRead, Read};
use tracecut::image::{Frame, MAX_SIDE};

/// Duration of a frame if the header has no rate.
const DEFAULT_DURATION_S: f64 = 1.0 / 25.0;

/// Longest header line accepted: real ones are below 200 bytes.
const MAX_LINE_BYTES: u64 = 4096;

/// The frames of a stream, one after the other. After an error it ends.
#[derive(Debug)]
pub(crate) struct Y4m<R> {
    reader: R,
    format: StreamFormat,
    num_read: usize,
    ended: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct StreamFormat {
    width: usize,
    height: usize,
    /// Pixels per chroma sample across and down; `None` without chroma.
    chroma: Option<(usize, usize)>,
    full_range: bool,
    /// Seconds of a frame.
    duration: f64,
}

impl<R: BufRead> Y4m<R> {
    /// Reads the header.
    ///
    /// # Errors
    /// If it is not a Y4M header, of a kind not supported, or of more than `max_pixels` pixels.
    pub(crate) fn new(mut reader: R, max_pixels: usize) -> Result<Self, Failure> {
        let header =
            read_line(&mut reader).and_then(|line| line.ok_or("is empty (expected a YUV4MPEG2 header)".into()));
        let format = header.and_then(|header| parse_header(&header)).map_err(Failure::input)?;
        check(format.width, format.height, max_pixels)?;
        Ok(Self { reader, format, num_read: 0, ended: false })
    }

    /// Returns the duration of each frame in seconds.
    pub(crate) fn frame_duration(&self) -> f64 {
        self.format.duration
    }

    fn read_frame(&mut self) -> Result<Option<Frame>, String> {
        let Some(line) = read_line(&mut self.reader)? else { return Ok(None) };
        if line.split(' ').next() != Some("FRAME") {
            return Err(format!("frame {} does not start with FRAME", self.num_read));
        }
        let expected = self.format.frame_bytes();
        // Allocates only as much memory as there are bytes.
        let mut bytes = Vec::new();
        self.reader.by_ref().take(expected as u64).read_to_end(&mut bytes).map_err(|e| e.to_string())?;
        if bytes.len() < expected {
            return Err(format!("is truncated: frame {} has {} of {expected} bytes", self.num_read, bytes.len()));
        }
        self.num_read += 1;
        let rgb = self.format.to_rgb(&bytes);
        Frame::from_rgb(rgb, self.format.width, self.format.height).map(Some).map_err(|e| e.to_string())
    }
}

impl<R: BufRead> Iterator for Y4m<R> {
    type Item = Result<Frame, String>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let frame = self.read_frame().transpose();
        self.ended = !matches!(frame, Some(Ok(_)));
        frame
    }
}

/// Reads a line without its end; `None` at the end of the stream.
fn read_line(reader: &mut impl BufRead) -> Result<Option<String>, String> {
    let mut line = Vec::new();
    reader.by_ref().take(MAX_LINE_BYTES).read_until(b'\n', &mut line).map_err(|e| e.to_string())?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.pop() != Some(b'\n') {
        return Err("is truncated or not Y4M: a header line does not end".to_owned());
    }
    Ok(Some(String::from_utf8_lossy(&line).into_owned()))
}

fn parse_header(header: &str) -> Result<StreamFormat, String> {
    let mut fields = header.trim_end().split(' ');
    if fields.next() != Some("YUV4MPEG2") {
        return Err("is not Y4M (expected it to start with YUV4MPEG2)".to_owned());
    }
    let mut format =
        StreamFormat { width: 0, height: 0, chroma: Some((2, 2)), full_range: false, duration: DEFAULT_DURATION_S };
    for field in fields.filter(|field| !field.is_empty()) {
        let (tag, value) = field.split_at(field.chars().next().map_or(0, char::len_utf8));
        match tag {
            "W" => format.width = parse_side(value, "width")?,
            "H" => format.height = parse_side(value, "height")?,
            "C" => format.chroma = parse_chroma(value)?,
            "F" => format.duration = parse_duration(value).unwrap_or(DEFAULT_DURATION_S),
            "X" if value == "COLORRANGE=FULL" => format.full_range = true,
            _ => {}
        }
    }
    Ok(format)
}

fn parse_side(text: &str, name: &str) -> Result<usize, String> {
    let side = text.parse().ok().filter(|s| (1..=MAX_SIDE).contains(s));
    side.ok_or_else(|| format!("has {name} \"{text}\" (expected 1..={MAX_SIDE})"))
}

/// Returns the duration of a frame at a rate such as `30000:1001`; `None` for the unknown rate `0:0`.
fn parse_duration(rate: &str) -> Option<f64> {
    let (frames, seconds) = rate.split_once(':')?;
    let (frames, seconds): (u32, u32) = (frames.parse().ok()?, seconds.parse().ok()?);
    (frames > 0 && seconds > 0).then(|| f64::from(seconds) / f64::from(frames))
}

fn parse_chroma(text: &str) -> Result<Option<(usize, usize)>, String> {
    match text {
        "420" | "420jpeg" | "420mpeg2" | "420paldv" => Ok(Some((2, 2))),
        "422" => Ok(Some((2, 1))),
        "444" => Ok(Some((1, 1))),
        "mono" => Ok(None),
        _ => Err(format!(
            "has pixel format C{text} (expected C420, C422, C444 or Cmono with 8 bits; with ffmpeg: -pix_fmt yuv420p)"
        )),
    }
}

impl StreamFormat {
    fn chroma_size(&self) -> (usize, usize) {
        self.chroma.map_or((0, 0), |(across, down)| (self.width.div_ceil(across), self.height.div_ceil(down)))
    }

    fn frame_bytes(&self) -> usize {
        let (width, height) = self.chroma_size();
        self.width * self.height + 2 * width * height
    }

    fn to_rgb(self, bytes: &[u8]) -> Vec<u8> {
        let (chroma_width, chroma_height) = self.chroma_size();
        let (luma, chroma) = bytes.split_at(self.width * self.height);
        let (cb, cr) = chroma.split_at(chroma_width * chroma_height);
        let (across, down) = self.chroma.unwrap_or((1, 1));
        let mut rgb = Vec::with_capacity(3 * luma.len());
        for y in 0..self.height {
            for x in 0..self.width {
                let c = y / down * chroma_width + x / across;
                let sample = |plane: &[u8]| if self.chroma.is_some() { f32::from(plane[c]) - 128.0 } else { 0.0 };
                rgb.extend(self.pixel(f32::from(luma[y * self.width + x]), sample(cb), sample(cr)));
            }
        }
        rgb
    }

    /// ITU-R BT.601: Kr = 0.299, Kb = 0.114.
    fn pixel(self, y: f32, cb: f32, cr: f32) -> [u8; 3] {
        let (y, scale) = if self.full_range { (y, 1.0) } else { ((y - 16.0) * (255.0 / 219.0), 255.0 / 224.0) };
        let (cb, cr) = (cb * scale, cr * scale);
        [y + 1.402 * cr, y - 0.344_136 * cb - 0.714_136 * cr, y + 1.772 * cb].map(|v| (v + 0.5) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracecut::image::MAX_PIXELS;

    fn frames(bytes: &[u8]) -> Result<Vec<Frame>, String> {
        Y4m::new(bytes, MAX_PIXELS).map_err(|e| e.reason)?.collect()
    }

    fn stream(header: &str, frames: &[&[u8]]) -> Vec<u8> {
        let mut bytes = format!("YUV4MPEG2 {header}\n").into_bytes();
        for frame in frames {
            bytes.extend(b"FRAME Ip\n");
            bytes.extend(*frame);
        }
        bytes
    }

    #[test]
    fn limited_range_greys_map_to_the_full_range() {
        let all = frames(&stream("W3 H1 F25:1 Cmono", &[&[16, 126, 235], &[0, 255, 17]])).unwrap();
        assert_eq!(all[0].rgb(), [0, 0, 0, 128, 128, 128, 255, 255, 255]);
        assert_eq!(all[1].rgb(), [0, 0, 0, 255, 255, 255, 1, 1, 1]);
        let full = frames(&stream("W3 H1 Cmono XCOLORRANGE=FULL", &[&[16, 126, 235]])).unwrap();
        assert_eq!(full[0].rgb()[..4], [16, 16, 16, 126]);
    }

    #[test]
    fn primary_colours_come_back_within_one_level() {
        for (yuv, rgb) in [([81, 90, 240], [255, 0, 0]), ([145, 54, 34], [0, 255, 0]), ([41, 240, 110], [0, 0, 255])] {
            let frame = &frames(&stream("W1 H1 C444", &[&yuv])).unwrap()[0];
            for (got, want) in frame.rgb().iter().zip(rgb) {
                assert!(got.abs_diff(want) <= 1, "{yuv:?} gave {:?} (expected {rgb:?})", frame.rgb());
            }
        }
    }

    #[test]
    fn chroma_of_odd_sizes_is_rounded_up() {
        // 3x3 in 4:2:0 has 2x2 chroma samples; the last column and row take the last sample.
        let mut bytes = vec![126; 9];
        bytes.extend([128, 128, 128, 128, 128, 128, 128, 255]);
        let frame = &frames(&stream("W3 H3", &[&bytes])).unwrap()[0];
        assert_eq!(frame.rgb()[..3], [128, 128, 128]);
        assert_eq!(frame.rgb()[24], 255);
        // The same in 4:2:2: 2 samples across, 3 down.
        let mut bytes = vec![126; 9];
        bytes.extend([128; 11]);
        bytes.push(255);
        let frame = &frames(&stream("W3 H3 C422", &[&bytes])).unwrap()[0];
        assert_eq!((frame.rgb()[15], frame.rgb()[24]), (128, 255));
    }

    #[test]
    fn every_truncation_keeps_the_whole_frames_and_then_fails_or_ends() {
        let whole = stream("W2 H2 Cmono", &[&[20; 4], &[30; 4]]);
        let header = stream("W2 H2 Cmono", &[]).len();
        let frame = 9 + 4;
        for length in 0..whole.len() {
            match Y4m::new(&whole[..length], MAX_PIXELS) {
                Err(error) => assert!(length < header, "{length} bytes: {error:?}"),
                Ok(y4m) => {
                    let (good, bad): (Vec<_>, Vec<_>) = y4m.partition(|f| f.is_ok());
                    assert_eq!(good.len(), (length - header) / frame, "{length} bytes");
                    assert_eq!(bad.len(), usize::from(!(length - header).is_multiple_of(frame)), "{length} bytes");
                }
            }
        }
        let three = stream("W2 H2 Cmono", &[&[20; 4], &[30; 4], &[40; 3]]);
        let message = frames(&three).unwrap_err();
        assert_eq!(message, "is truncated: frame 2 has 3 of 4 bytes");
    }

    #[test]
    fn headers_of_other_kinds_are_refused_in_words() {
        for (header, reason) in [
            ("YUV4MPEG2 W2 H2 C420p10\n", "-pix_fmt yuv420p"),
            ("YUV4MPEG2 W0 H2\n", "has width \"0\""),
            ("YUV4MPEG2 W2\n", "frame size 2x0"),
            ("YUV4MPEG2 W16384 H16384\n", "268435456 pixels in a frame (expected at most 67108864"),
            ("RIFF\n", "is not Y4M"),
            ("", "is empty"),
        ] {
            let message = frames(header.as_bytes()).unwrap_err();
            assert!(message.contains(reason), "{header:?} gave: {message}");
        }
    }

    #[test]
    fn frames_last_as_the_rate_of_the_header_says() {
        for (rate, seconds) in [("F30000:1001 ", 1001.0 / 30000.0), ("F0:0 ", 0.04), ("Fx ", 0.04), ("", 0.04)] {
            let bytes = format!("YUV4MPEG2 W2 H2 {rate}Cmono\n");
            assert_eq!(Y4m::new(bytes.as_bytes(), MAX_PIXELS).unwrap().frame_duration(), seconds, "{rate}");
        }
    }

    #[test]
    fn a_stream_without_frames_is_empty() {
        assert_eq!(frames(b"YUV4MPEG2 W2 H2\n").unwrap().len(), 0);
    }

    /// Sums of the pixels (FNV-1a), which no machine may change.
    #[test]
    fn pixels_are_the_same_everywhere() {
        let mixed = |k: usize| (k * 7 + (k >> 8) * 13 + (k >> 16) * 91) as u8;
        for (header, length, sum) in [
            ("W128 H128 F25:1 C444", 3 * 128 * 128, 0x14c1_89a9),
            ("W128 H128 C444 XCOLORRANGE=FULL", 3 * 128 * 128, 0x277e_5219),
            ("W33 H21 F30000:1001 Ip C420jpeg", 33 * 21 + 2 * 17 * 11, 0xb33c_712f),
            ("W33 H21 C422", 33 * 21 + 2 * 17 * 21, 0x0a32_3128),
            ("W33 H21 Cmono", 33 * 21, 0xc258_8092_u32),
        ] {
            let bytes: Vec<u8> = (0..length).map(mixed).collect();
            let frame = &frames(&stream(header, &[&bytes])).unwrap()[0];
            let found = frame.rgb().iter().fold(0x811c_9dc5, |h: u32, &b| (h ^ u32::from(b)).wrapping_mul(0x0100_0193));
            assert_eq!(found, sum, "{header}");
        }
    }
}
