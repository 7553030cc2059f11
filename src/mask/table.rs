//! Objects frame by frame in numbers: where they are, how large, how they move.

use crate::image::Plane;
use crate::trajectory::Trajectories;
use std::fmt::Write;

/// An object in a frame, in pixels of the mask.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectRow {
    /// The frame.
    pub frame: usize,
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

/// The rows as a table of comma-separated values, with a heading. Places have three decimals. The time of a frame, which
/// rows do not have, is left empty, as is the motion where there is none.
pub fn object_table(rows: &[ObjectRow]) -> String {
    let mut text = String::from("frame,time,object,left,top,width,height,area,x,y,dx,dy,trajectories\n");
    for row in rows {
        let ObjectRow { frame, object, corner: (left, top), size: (width, height), area, centroid: (x, y), .. } = row;
        let (dx, dy) = row.motion.map_or_else(Default::default, |(dx, dy)| (decimals(dx), decimals(dy)));
        let (x, y, n) = (decimals(*x), decimals(*y), row.trajectories);
        writeln!(text, "{frame},,{object},{left},{top},{width},{height},{area},{x},{y},{dx},{dy},{n}")
            .expect("writing to a string cannot fail");
    }
    text
}

/// Rounded before it is written: how ties are written differs between languages.
fn decimals(value: f64) -> String {
    format!("{:.3}", (value * 1000.0 + 0.5).floor() / 1000.0)
}
