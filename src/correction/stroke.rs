//! Strokes, and the pixels and trajectories under them.

use crate::Error;
use crate::trajectory::Trajectories;

/// A painted line in one frame, in input pixels (pixel centres at whole numbers). A single point is a dot.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// The frame.
    pub t: usize,
    /// The centre line, from point to point.
    pub points: Vec<(f32, f32)>,
    /// Half the width of the brush.
    pub radius: f32,
}

/// Largest coordinate and radius: far outside any frame, and small enough for exact squares.
const MAX_COORDINATE_PX: f64 = 1e6;
/// Largest number of points of a stroke; chosen by eye.
const MAX_POINTS: usize = 100_000;

/// Radius of the core, whose pixels have the stroke's label, in radii of the brush; chosen by eye, since quick strokes cross
/// borders a little.
const CORE_SHARE: f64 = 0.5;
/// Least radius of the core, in working pixels: a little over √2, so that it has every pixel that the centre line crosses.
const MIN_CORE_RADIUS_PX: f64 = 1.42;

impl Stroke {
    /// Checks the stroke for a clip of `num_frames` frames of `size` input pixels; `name` is for the message.
    ///
    /// # Errors
    /// [`Error::Param`] for the first value that is not legal.
    pub(crate) fn check(&self, name: &str, num_frames: usize, size: (usize, usize)) -> Result<(), Error> {
        let illegal = |field: &str, value: String, expected: String| {
            Err(Error::Param { name: format!("{name}.{field}"), value, expected })
        };
        if self.t >= num_frames {
            return illegal("t", self.t.to_string(), format!("a frame, 0..={}", num_frames.saturating_sub(1)));
        }
        if !(0.0..=MAX_COORDINATE_PX).contains(&f64::from(self.radius)) {
            return illegal(
                "radius",
                f64::from(self.radius).to_string(),
                format!("a number of pixels, 0..={MAX_COORDINATE_PX}"),
            );
        }
        if !(1..=MAX_POINTS).contains(&self.points.len()) {
            return illegal("points", format!("{} points", self.points.len()), format!("1..={MAX_POINTS} of them"));
        }
        let is_legal = |v: f32| f64::from(v.abs()) <= MAX_COORDINATE_PX;
        if let Some(k) = self.points.iter().position(|&(x, y)| !is_legal(x) || !is_legal(y)) {
            let (x, y) = self.points[k];
            let value = format!("({}, {})", f64::from(x), f64::from(y));
            return illegal(
                &format!("points[{k}]"),
                value,
                format!("numbers of pixels, -{MAX_COORDINATE_PX}..={MAX_COORDINATE_PX}"),
            );
        }
        let is_inside = |v: f32, side: usize| v >= -0.5 && v <= side as f32 - 0.5;
        if !self.points.iter().any(|&(x, y)| is_inside(x, size.0) && is_inside(y, size.1)) {
            let expected = format!("at least one in the frame of {}x{} pixels", size.0, size.1);
            return illegal("points", "all outside".to_owned(), expected);
        }
        Ok(())
    }

    /// Returns the squared distance of a point to the centre line.
    fn distance_sq(&self, x: f64, y: f64) -> f64 {
        self.segments().map(|s| s.distance_sq(x, y)).fold(f64::INFINITY, f64::min)
    }

    fn segments(&self) -> impl Iterator<Item = Segment> + '_ {
        let last = self.points.len().saturating_sub(1);
        let ends = (0..self.points.len().max(1)).take(last.max(1)).map(move |k| (k, (k + 1).min(last)));
        ends.filter_map(|(a, b)| Some(Segment::new([*self.points.get(a)?, *self.points.get(b)?])))
    }

    /// Returns the pixels of the core, increasing, in a frame reduced from `input` to `working` pixels, each with its squared
    /// distance to the centre line in input pixels.
    fn core(&self, input: (usize, usize), working: (usize, usize)) -> Vec<(u32, f64)> {
        let scale = (input.0 as f64 / working.0 as f64, input.1 as f64 / working.1 as f64);
        let radius = (CORE_SHARE * f64::from(self.radius)).max(MIN_CORE_RADIUS_PX * scale.0.max(scale.1));
        (0..).zip(self.distances(radius, input, working)).filter(|(_, d)| *d < f64::INFINITY).collect()
    }

    /// Returns the squared distance of each pixel of such a frame to the centre line, in input pixels; infinite beyond `reach`
    /// input pixels.
    pub(crate) fn distances(&self, reach: f64, input: (usize, usize), working: (usize, usize)) -> Vec<f64> {
        let scale = (input.0 as f64 / working.0 as f64, input.1 as f64 / working.1 as f64);
        let first = |v: f64, s: f64| ((v - reach + 0.5) / s - 0.5).ceil().max(0.0) as usize;
        let end = |v: f64, s: f64, side: usize| {
            (((v + reach + 0.5) / s - 0.5).floor() + 1.0).clamp(0.0, side as f64) as usize
        };
        let mut nearest = vec![f64::INFINITY; working.0 * working.1];
        for s in self.segments() {
            for y in first(s.from.1.min(s.to().1), scale.1)..end(s.from.1.max(s.to().1), scale.1, working.1) {
                for x in first(s.from.0.min(s.to().0), scale.0)..end(s.from.0.max(s.to().0), scale.0, working.0) {
                    let centre = |v: usize, s: f64| (v as f64 + 0.5) * s - 0.5;
                    let d = s.distance_sq(centre(x, scale.0), centre(y, scale.1));
                    let nearest = &mut nearest[y * working.0 + x];
                    if d <= reach * reach && d < *nearest {
                        *nearest = d;
                    }
                }
            }
        }
        nearest
    }
}

/// A straight segment of a centre line.
struct Segment {
    from: (f64, f64),
    along: (f64, f64),
    length_sq: f64,
}

impl Segment {
    fn new(ends: [(f32, f32); 2]) -> Self {
        let [from, to] = ends.map(|(x, y)| (f64::from(x), f64::from(y)));
        let along = (to.0 - from.0, to.1 - from.1);
        Self { from, along, length_sq: along.0 * along.0 + along.1 * along.1 }
    }

    fn to(&self) -> (f64, f64) {
        (self.from.0 + self.along.0, self.from.1 + self.along.1)
    }

    fn distance_sq(&self, x: f64, y: f64) -> f64 {
        let (dx, dy) = (x - self.from.0, y - self.from.1);
        let along = dx * self.along.0 + dy * self.along.1;
        let part = if self.length_sq > 0.0 { (along / self.length_sq).clamp(0.0, 1.0) } else { 0.0 };
        let (ex, ey) = (dx - part * self.along.0, dy - part * self.along.1);
        ex * ex + ey * ey
    }
}

/// Returns the nearest stroke over each trajectory, the first of equally near ones. The radius of a brush is at least
/// `spacing / 2`, or `spacing` if it then has no trajectory under it. Trajectories and `spacing`, the distance of neighbours,
/// are in input pixels.
pub(crate) fn strokes_over_tracks(tracks: &Trajectories, strokes: &[Stroke], spacing: f64) -> Vec<Option<u8>> {
    let mut nearest = vec![(f64::INFINITY, None); tracks.len()];
    for (k, stroke) in (0..=u8::MAX).zip(strokes) {
        let distance = |(i, x, y): (usize, f32, f32)| (i, stroke.distance_sq(x.into(), y.into()));
        let max_sq = f64::from(stroke.radius).max(spacing).powi(2);
        let candidates: Vec<(usize, f64)> = tracks.alive(stroke.t).map(distance).filter(|d| d.1 <= max_sq).collect();
        let radius = f64::from(stroke.radius).max(spacing / 2.0);
        let has_tracks = candidates.iter().any(|d| d.1 <= radius * radius);
        for (i, d) in candidates {
            if (d <= radius * radius || !has_tracks) && d < nearest[i].0 {
                nearest[i] = (d, Some(k));
            }
        }
    }
    nearest.into_iter().map(|n| n.1).collect()
}

/// Returns the pixels of each stroke's core at working size. A pixel in several cores belongs to the nearest stroke, the first
/// of equally near ones.
pub(crate) fn core_pixels(strokes: &[Stroke], input: (usize, usize), working: (usize, usize)) -> Vec<Vec<u32>> {
    let cores: Vec<_> = strokes.iter().map(|s| s.core(input, working)).collect();
    let is_nearest = |k: usize, (pixel, d): (u32, f64)| {
        let mut rivals = (0..strokes.len()).filter(|&l| l != k && strokes[l].t == strokes[k].t).filter_map(|l| {
            let entry = cores[l].binary_search_by(|entry| entry.0.cmp(&pixel)).ok()?;
            Some((l, cores[l][entry].1))
        });
        rivals.all(|(l, distance)| d < distance || (d == distance && k < l))
    };
    let pixels = |k: usize| cores[k].iter().filter(|&&entry| is_nearest(k, entry)).map(|e| e.0).collect();
    (0..strokes.len()).map(pixels).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stroke(t: usize, points: &[(f32, f32)], radius: f32) -> Stroke {
        Stroke { t, points: points.to_vec(), radius }
    }

    #[test]
    fn a_line_has_what_is_near_any_of_its_points_and_a_dot_what_is_near_it() {
        let line = stroke(0, &[(2.0, 5.0), (10.0, 5.0), (10.0, 9.0)], 1.0);
        assert_eq!(line.distance_sq(6.0, 7.0), 4.0);
        assert_eq!(line.distance_sq(13.0, 13.0), 25.0);
        assert_eq!(stroke(0, &[(3.0, 4.0)], 1.0).distance_sq(0.0, 0.0), 25.0);
        let twice = stroke(0, &[(3.0, 4.0), (3.0, 4.0)], 1.0);
        assert_eq!(twice.distance_sq(0.0, 0.0), 25.0);
    }

    #[test]
    fn the_core_is_what_comparing_all_pixels_finds_also_where_it_leaves_the_frame() {
        let strokes = [
            stroke(0, &[(-30.0, 3.0), (5.0, 4.0), (19.0, 30.0)], 5.0),
            stroke(0, &[(7.0, 7.0)], 0.0),
            stroke(0, &[(-1e6, -1e6), (1e6, 1e6)], 6.0),
        ];
        for (input, working) in [((20, 16), (20, 16)), ((20, 16), (10, 8)), ((21, 16), (13, 10))] {
            for s in &strokes {
                let (sx, sy) = (input.0 as f64 / working.0 as f64, input.1 as f64 / working.1 as f64);
                let radius = (0.5 * f64::from(s.radius)).max(1.42 * sx.max(sy));
                let mut all = Vec::new();
                for p in 0..working.0 * working.1 {
                    let centre = ((p % working.0) as f64, (p / working.0) as f64);
                    let d = s.distance_sq((centre.0 + 0.5) * sx - 0.5, (centre.1 + 0.5) * sy - 0.5);
                    all.extend((d <= radius * radius).then_some((p as u32, d)));
                }
                assert_eq!(s.core(input, working), all);
                assert!(!all.is_empty());
            }
        }
    }

    #[test]
    fn of_two_strokes_the_nearer_has_the_pixel_and_the_trajectory() {
        let strokes = [stroke(1, &[(4.0, 0.0), (4.0, 9.0)], 8.0), stroke(1, &[(8.0, 0.0), (8.0, 9.0)], 8.0)];
        let mut tracks = Trajectories::empty(2, (20, 10));
        for x in [5.0, 6.0, 7.0, 17.0] {
            tracks.push(0, [(x, 4.0, 0.0), (x, 4.0, 0.0)]);
        }
        tracks.push(0, [(5.0, 4.0, 0.0)]);
        assert_eq!(strokes_over_tracks(&tracks, &strokes, 0.0), [Some(0), Some(0), Some(1), None, None]);
        assert_eq!(strokes_over_tracks(&tracks, &strokes, 18.0)[3], Some(1));
        let thin = [stroke(1, &[(10.0, 4.0)], 0.5)];
        assert_eq!(strokes_over_tracks(&tracks, &thin, 2.0), [None; 5]);
        assert_eq!(strokes_over_tracks(&tracks, &thin, 3.0), [None, None, Some(0), None, None]);
        let cores = core_pixels(&strokes, (20, 10), (20, 10));
        let columns = |core: &[u32]| core.iter().filter(|&&p| p < 20).copied().collect::<Vec<_>>();
        assert_eq!((columns(&cores[0]), columns(&cores[1])), (vec![0, 1, 2, 3, 4, 5, 6], vec![7, 8, 9, 10, 11, 12]));
    }

    #[test]
    fn strokes_that_cannot_be_are_refused() {
        let good = stroke(2, &[(1.0, 1.0), (900.0, 1.0)], 3.0);
        good.check("strokes[0]", 3, (64, 48)).unwrap();
        let message = |s: Stroke| s.check("strokes[0]", 3, (64, 48)).unwrap_err().to_string();
        assert_eq!(message(Stroke { t: 3, ..good.clone() }), "strokes[0].t = 3 (expected a frame, 0..=2)");
        assert!(message(Stroke { radius: f32::NAN, ..good.clone() }).starts_with("strokes[0].radius = NaN"));
        assert!(message(Stroke { radius: -1.0, ..good.clone() }).starts_with("strokes[0].radius = -1"));
        assert!(message(Stroke { points: vec![], ..good.clone() }).starts_with("strokes[0].points = 0 points"));
        let nan = vec![(1.0, 1.0), (2.0, f32::NAN)];
        assert!(message(Stroke { points: nan, ..good.clone() }).starts_with("strokes[0].points[1] = (2, NaN)"));
        let infinite = vec![(f32::INFINITY, 1.0)];
        assert!(message(Stroke { points: infinite, ..good.clone() }).starts_with("strokes[0].points[0]"));
        assert!(message(Stroke { points: vec![(64.0, 1.0)], ..good }).contains("all outside"));
    }
}
