//! Position, size and motion of objects frame by frame, as a table.

use crate::image::Plane;
use crate::trajectory::Trajectories;
use std::fmt::Write;

/// An object in a frame, in pixels of the mask.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectRow {
    /// The frame.
    pub frame: usize,
    /// Its time in seconds; `None` if unknown.
    pub time: Option<f64>,
    /// The object's label in the masks.
    pub object: u8,
    /// First column and first row of its bounding box.
    pub corner: (usize, usize),
    /// Width and height of its bounding box.
    pub size: (usize, usize),
    /// Number of its pixels.
    pub area: usize,
    /// Mean position of its pixels; pixel centres are at integers.
    pub centroid: (f64, f64),
    /// Mean displacement of its trajectories to the next frame; `None` without trajectories.
    pub motion: Option<(f64, f64)>,
    /// Number of these trajectories.
    pub trajectories: usize,
    /// Whether the masks of the frame should be looked at ([`super::Agreement::doubts`]); `None` if unknown.
    pub doubt: Option<bool>,
}

/// Sums over the pixels and trajectories of one object.
#[derive(Debug, Clone, Copy)]
struct ObjectSums {
    low: (usize, usize),
    high: (usize, usize),
    area: usize,
    position: (f64, f64),
    motion: (f64, f64),
    trajectories: usize,
}

impl ObjectSums {
    const EMPTY: Self = Self {
        low: (usize::MAX, usize::MAX),
        high: (0, 0),
        area: 0,
        position: (0.0, 0.0),
        motion: (0.0, 0.0),
        trajectories: 0,
    };

    fn add_pixel(&mut self, x: usize, y: usize) {
        self.low = (self.low.0.min(x), self.low.1.min(y));
        self.high = (self.high.0.max(x), self.high.1.max(y));
        self.area += 1;
        self.position = (self.position.0 + x as f64, self.position.1 + y as f64);
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
            centroid: mean(self.position, self.area),
            motion: (self.trajectories > 0).then(|| mean(self.motion, self.trajectories)),
            trajectories: self.trajectories,
            doubt: None,
        }
    }
}

/// Measures the objects in the mask of frame `t`, by label. `tracks` are in pixels of the mask; an object's motion is the mean over the
/// trajectories on it that continue in the next frame.
pub fn object_rows(mask: &Plane<u8>, tracks: &Trajectories, t: usize) -> Vec<ObjectRow> {
    let mut sums = [ObjectSums::EMPTY; 256];
    for y in 0..mask.height() {
        for (x, &label) in mask.row(y).iter().enumerate() {
            sums[usize::from(label)].add_pixel(x, y);
        }
    }
    let pixel = |v: f32, limit: usize| ((f64::from(v) + 0.5).max(0.0) as usize).min(limit - 1);
    for i in 0..tracks.len() {
        let (Some((x, y)), Some((u, v))) = (tracks.at(i, t), tracks.at(i, t + 1)) else { continue };
        let sum = &mut sums[usize::from(mask[(pixel(x, mask.width()), pixel(y, mask.height()))])];
        sum.trajectories += 1;
        sum.motion.0 += f64::from(u) - f64::from(x);
        sum.motion.1 += f64::from(v) - f64::from(y);
    }
    let row = |object| Some(sums[usize::from(object)]).filter(|sums| sums.area > 0).map(|sums| sums.row(t, object));
    (1..=u8::MAX).filter_map(row).collect()
}

/// Formats rows as comma-separated values with a header. Positions have three decimals, times up to six; missing times,
/// motions and doubts are empty; a doubt is 1, none is 0.
pub fn object_table(rows: &[ObjectRow]) -> String {
    let mut text = String::from("frame,time,object,left,top,width,height,area,x,y,dx,dy,trajectories,doubt\n");
    for row in rows {
        let ObjectRow { frame, object, corner: (left, top), size: (width, height), area, centroid: (x, y), .. } = row;
        let (dx, dy) = row.motion.map_or_else(Default::default, |(dx, dy)| (decimals(dx), decimals(dy)));
        let time = row.time.map_or_else(Default::default, seconds);
        let (x, y, n) = (decimals(*x), decimals(*y), row.trajectories);
        let doubt = row.doubt.map_or("", |doubt| if doubt { "1" } else { "0" });
        writeln!(text, "{frame},{time},{object},{left},{top},{width},{height},{area},{x},{y},{dx},{dy},{n},{doubt}")
            .expect("writing to a string cannot fail");
    }
    text
}

/// Formats a time with up to six decimals, rounded half away from zero.
fn seconds(time: f64) -> String {
    // Fixed-point fractions of this many bits are exact down to the smallest that changes a rounding.
    const FRACTION_BITS: u32 = 100;
    let fraction = (time.abs().fract() * (1_u128 << FRACTION_BITS) as f64) as u128;
    let millionths = (fraction * 1_000_000 + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS;
    let micros = (time.abs().trunc() as u64).saturating_mul(1_000_000).saturating_add(millionths as u64);
    let sign = if time < 0.0 && micros > 0 { "-" } else { "" };
    let text = format!("{sign}{}.{:06}", micros / 1_000_000, micros % 1_000_000);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Formats a number with three decimals, rounded half up, as languages differ in how they format ties. Uses integers only, since
/// formatting of floats adds much to the size of the wasm file.
fn decimals(value: f64) -> String {
    let thousandths = (value * 1000.0 + 0.5).floor() as i64;
    let sign = if thousandths < 0 { "-" } else { "" };
    let magnitude = thousandths.unsigned_abs();
    format!("{sign}{}.{:03}", magnitude / 1000, magnitude % 1000)
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
    fn positions_have_three_decimals() {
        let rounded = |value: f64| format!("{:.3}", (value * 1000.0 + 0.5).floor() / 1000.0);
        for value in [0.0, -0.0, 0.0005, -0.0005, -0.0006, 1.25, -12.3456, 719.9996, 1e6 / 3.0] {
            assert_eq!(decimals(value), rounded(value));
        }
    }
}
