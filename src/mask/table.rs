//! Objects frame by frame in numbers: where they are, how large, how they move.

use crate::image::Plane;
use crate::trajectory::Trajectories;
use std::fmt::Write;

/// An object in a frame, in pixels of the mask.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectRow {
    /// The frame.
    pub frame: usize,
    /// Its time in seconds; `None` where it is not known.
    pub time: Option<f64>,
    /// The object's label in the masks.
    pub object: u8,
    /// First column and first row with a pixel of it.
    pub corner: (usize, usize),
    /// Width and height of the box around it.
    pub size: (usize, usize),
    /// Number of its pixels.
    pub area: usize,
    /// Mean place of its pixels; pixel centres are at integers.
    pub centroid: (f64, f64),
    /// How far its trajectories go on average to the next frame; `None` where it has none that do.
    pub motion: Option<(f64, f64)>,
    /// The number of these trajectories.
    pub trajectories: usize,
}

/// Sums over one object.
#[derive(Debug, Clone, Copy)]
struct Sums {
    low: (usize, usize),
    high: (usize, usize),
    area: usize,
    place: (f64, f64),
    moved: (f64, f64),
    trajectories: usize,
}

const NOTHING: Sums = Sums {
    low: (usize::MAX, usize::MAX),
    high: (0, 0),
    area: 0,
    place: (0.0, 0.0),
    moved: (0.0, 0.0),
    trajectories: 0,
};

impl Sums {
    fn count(&mut self, x: usize, y: usize) {
        self.low = (self.low.0.min(x), self.low.1.min(y));
        self.high = (self.high.0.max(x), self.high.1.max(y));
        self.area += 1;
        self.place = (self.place.0 + x as f64, self.place.1 + y as f64);
    }

    fn row(&self, frame: usize, object: u8) -> ObjectRow {
        let mean = |(x, y): (f64, f64), n: usize| (x / n as f64, y / n as f64);
        ObjectRow {
            frame,
            time: None,
            object,
            corner: self.low,
            size: (self.high.0 + 1 - self.low.0, self.high.1 + 1 - self.low.1),
            area: self.area,
            centroid: mean(self.place, self.area),
            motion: (self.trajectories > 0).then(|| mean(self.moved, self.trajectories)),
            trajectories: self.trajectories,
        }
    }
}

/// The objects in `mask`, which is that of frame `t`, by their labels. `tracks` are in pixels of the mask; those whose
/// point in this frame lies on an object, and that go on to the next frame, say how it moves.
pub fn object_rows(mask: &Plane<u8>, tracks: &Trajectories, t: usize) -> Vec<ObjectRow> {
    let mut sums = [NOTHING; 256];
    for y in 0..mask.height() {
        for (x, &label) in mask.row(y).iter().enumerate() {
            sums[usize::from(label)].count(x, y);
        }
    }
    let place = |v: f32, limit: usize| ((f64::from(v) + 0.5).max(0.0) as usize).min(limit - 1);
    for i in 0..tracks.len() {
        let (Some((x, y)), Some((u, v))) = (tracks.at(i, t), tracks.at(i, t + 1)) else { continue };
        let sum = &mut sums[usize::from(mask[(place(x, mask.width()), place(y, mask.height()))])];
        sum.trajectories += 1;
        sum.moved.0 += f64::from(u) - f64::from(x);
        sum.moved.1 += f64::from(v) - f64::from(y);
    }
    let of = |object| Some(sums[usize::from(object)]).filter(|sums| sums.area > 0).map(|sums| sums.row(t, object));
    (1..=u8::MAX).filter_map(of).collect()
}

/// The rows as a table of comma-separated values, with a heading. Places have three decimals, times up to six; a time or a
/// motion that there is not is left empty.
pub fn object_table(rows: &[ObjectRow]) -> String {
    let mut text = String::from("frame,time,object,left,top,width,height,area,x,y,dx,dy,trajectories\n");
    for row in rows {
        let ObjectRow { frame, object, corner: (left, top), size: (width, height), area, centroid: (x, y), .. } = row;
        let (dx, dy) = row.motion.map_or_else(Default::default, |(dx, dy)| (decimals(dx), decimals(dy)));
        let time = row.time.map_or_else(Default::default, seconds);
        let (x, y, n) = (decimals(*x), decimals(*y), row.trajectories);
        writeln!(text, "{frame},{time},{object},{left},{top},{width},{height},{area},{x},{y},{dx},{dy},{n}")
            .expect("writing to a string cannot fail");
    }
    text
}

/// Up to six decimals, the nearest; of two that are as near the one farther from 0.
fn seconds(time: f64) -> String {
    const BITS: u32 = 100;
    let (whole, part) = (time.abs().trunc(), time.abs().fract());
    // In whole numbers, which lose nothing; what needs more bits is too small to count.
    let millionths = ((part * (1_u128 << BITS) as f64) as u128 * 1_000_000 + (1 << (BITS - 1))) >> BITS;
    let all = (whole as u64).saturating_mul(1_000_000).saturating_add(millionths as u64);
    let sign = if time < 0.0 && all > 0 { "-" } else { "" };
    let text = format!("{sign}{}.{:06}", all / 1_000_000, all % 1_000_000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Three decimals, rounded before they are written: how ties are written differs between languages. As a whole number,
/// because what writes others is large.
fn decimals(value: f64) -> String {
    let thousandths = (value * 1000.0 + 0.5).floor() as i64;
    let sign = if thousandths < 0 { "-" } else { "" };
    let all = thousandths.unsigned_abs();
    format!("{sign}{}.{:03}", all / 1000, all % 1000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_short_and_round_away_from_zero() {
        let text = |time: f64| seconds(time);
        assert_eq!([0.0, 0.2, 2.5, 10.0, 1.0 / 3.0].map(text), ["0", "0.2", "2.5", "10", "0.333333"]);
        assert_eq!([1.0 / 128.0, -1.0 / 128.0, 3.0 / 128.0].map(text), ["0.007813", "-0.007813", "0.023438"]);
        assert_eq!([5e-7, 1.5e-6, -1e-9, 1.0 / 64.0].map(text), ["0", "0.000002", "0", "0.015625"]);
        assert_eq!([0.999_999_9, 1_700_000_000.25].map(text), ["1", "1700000000.25"]);
    }

    #[test]
    fn places_have_three_decimals() {
        let rounded = |value: f64| format!("{:.3}", (value * 1000.0 + 0.5).floor() / 1000.0);
        for value in [0.0, -0.0, 0.0005, -0.0005, -0.0006, 1.25, -12.3456, 719.9996, 1e6 / 3.0] {
            assert_eq!(decimals(value), rounded(value));
        }
    }
}
