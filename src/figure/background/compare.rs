//! Two accounts of each pixel: that the scene behind shows it, as the camera moves, and that an object does.
//!
//! A pixel of the scene is found again in other frames where the scene has gone to, a pixel of an object where the
//! objects have gone to. Where it has gone is known from trajectories ([`Warp`]); how alike it is found is judged by
//! those other frames that show it best, since objects hide the scene in some. Plain areas are found again both ways,
//! and nothing is said of them.

use super::plate::{Picture, apart, sampled};
use crate::camera::{Camera, Warp};
use crate::cut::STRANGER;
use crate::image::Plane;
use crate::trajectory::Trajectories;

/// How many frames away the others are, before and after.
const AWAY: [usize; 3] = [3, 9, 17];
/// Of the other frames, ordered by how alike a pixel is found, the one that counts.
const COUNTS: f32 = 0.35;
/// A difference is as much error as evidence at this, in grey levels.
const HALF: f32 = 10.0;
/// Fewer points say nothing of where objects go.
const LEAST_POINTS: usize = 3;

/// How far each pixel of a frame is from what other frames show of it, in grey levels, if it is the scene's and if it is
/// an object's.
pub(super) type Accounts = Plane<[u8; 2]>;

/// Both accounts of frame `t`. `pictures` are the frames reduced by `step`; `is_object` says what each label of the
/// trajectories is. Where nothing can be told both are 0.
pub(super) fn accounts(
    pictures: &[Picture],
    step: usize,
    t: usize,
    camera: &Camera,
    (tracks, label): (&Trajectories, &[u32]),
    is_object: &[bool],
) -> Accounts {
    let of = |i: usize| label.get(i).and_then(|&l| object(l, is_object));
    let picture = &pictures[t];
    let pixels = picture.data().len();
    let (mut by_scene, mut by_object) = (Differences::new(pixels), Differences::new(pixels));
    let others = AWAY.iter().flat_map(|&k| [t.checked_sub(k), Some(t + k).filter(|&s| s < pictures.len())]).flatten();
    for s in others {
        let points = |wanted: bool| -> Vec<_> {
            let common = tracks.alive(t).filter(|&(i, ..)| of(i) == Some(wanted));
            common.filter_map(|(i, x, y)| tracks.at(i, s).map(|to| ((x, y), to))).collect()
        };
        let (scene, object) = (points(false), points(true));
        let way = camera.between(t, s);
        by_scene.add(picture, &pictures[s], step, &Warp::new(tracks.size, way, scene.into_iter()));
        if object.len() >= LEAST_POINTS {
            by_object.add(picture, &pictures[s], step, &Warp::new(tracks.size, way, object.into_iter()));
        }
    }
    let (scene, object) = (by_scene.representative(), by_object.representative());
    let value = |i: usize| match (scene[i], object[i]) {
        (Some(scene), Some(object)) => [scene, object],
        _ => [0, 0],
    };
    Plane::from_fn(picture.width(), picture.height(), |x, y| value(y * picture.width() + x))
}

/// What accounts of some pixels come to.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Verdict {
    scene: f32,
    object: f32,
    pixels: f32,
}

impl Verdict {
    pub(super) fn add(&mut self, [scene, object]: [u8; 2]) {
        self.scene += f32::from(scene) * f32::from(scene);
        self.object += f32::from(object) * f32::from(object);
        self.pixels += 1.0;
    }

    /// From -1 to 1 how surely the pixels are none of the scene, whatever else they are; 0 at this mean square.
    pub(super) fn strangeness(&self, half: f32) -> f32 {
        let unlike = self.unlike_scene();
        (unlike - half) / (unlike + half)
    }

    /// Mean square of the differences if it is the scene's, in grey levels.
    pub(super) fn unlike_scene(&self) -> f32 {
        self.scene / self.pixels.max(1.0)
    }

    /// -1 where the scene's motion alone explains the pixels, 0 where both are alike, 1 where the objects' alone does.
    pub(super) fn value(&self) -> f32 {
        (self.scene - self.object) / (self.scene + self.object + HALF * HALF * self.pixels).max(1.0)
    }
}

/// No difference is known, since the pixel has left the frame.
const GONE: u8 = 255;

/// How far each pixel is from what other frames show of it, frame by frame; [`GONE`] where it has left the frame.
struct Differences {
    of_frame: Vec<Vec<u8>>,
    pixels: usize,
}

impl Differences {
    fn new(pixels: usize) -> Self {
        Self { of_frame: Vec::new(), pixels }
    }

    fn add(&mut self, picture: &Picture, other: &Picture, step: usize, warp: &Warp) {
        let (right, bottom) = ((picture.width() - 1) as f32, (picture.height() - 1) as f32);
        let lattice = Lattice::new((picture.width(), picture.height()), step, warp);
        let mut found = Vec::with_capacity(self.pixels);
        for y in 0..picture.height() {
            let row = lattice.row(y);
            found.extend(picture.row(y).iter().enumerate().map(|(x, &own)| {
                let (to_x, to_y) = row.at(x);
                let inside = to_x >= 0.0 && to_y >= 0.0 && to_x <= right && to_y <= bottom;
                if inside { apart(own, sampled(other, to_x, to_y)).min(GONE - 1) } else { GONE }
            }));
        }
        self.of_frame.push(found);
    }

    /// The difference that counts for each pixel; `None` where it is in no other frame.
    fn representative(&self) -> Vec<Option<u8>> {
        let one = |i: usize| {
            let mut seen = [GONE; 2 * AWAY.len()];
            let mut count = 0;
            for frame in self.of_frame.iter().filter(|frame| frame[i] != GONE) {
                let mut place = count;
                while place > 0 && seen[place - 1] > frame[i] {
                    seen[place] = seen[place - 1];
                    place -= 1;
                }
                seen[place] = frame[i];
                count += 1;
            }
            (count > 0).then(|| seen[(COUNTS * (count - 1) as f32 + 0.5) as usize])
        };
        (0..self.pixels).map(one).collect()
    }
}

/// Where points of a reduced frame go, a few pixels apart.
struct Lattice {
    columns: usize,
    points: Vec<(f32, f32)>,
}

/// A row of pixels among them.
struct Row<'a> {
    above: &'a [(f32, f32)],
    below: &'a [(f32, f32)],
    share: f32,
}

impl Lattice {
    /// Pixels from point to point.
    const GAP: usize = 8;

    fn new((w, h): (usize, usize), step: usize, warp: &Warp) -> Self {
        let (columns, rows) = (w / Self::GAP + 2, h / Self::GAP + 2);
        // Pixel centres are at whole numbers.
        let full = |k: usize| ((k * Self::GAP) as f32 + 0.5) * step as f32 - 0.5;
        let small = |v: f32| (v + 0.5) / step as f32 - 0.5;
        let mut points = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            points.extend((0..columns).map(|column| {
                let (x, y) = warp.apply(full(column), full(row));
                (small(x), small(y))
            }));
        }
        Self { columns, points }
    }

    fn row(&self, y: usize) -> Row<'_> {
        let line = |k: usize| &self.points[k * self.columns..(k + 1) * self.columns];
        let k = y / Self::GAP;
        Row { above: line(k), below: line(k + 1), share: (y % Self::GAP) as f32 / Self::GAP as f32 }
    }
}

impl Row<'_> {
    fn at(&self, x: usize) -> (f32, f32) {
        let (k, share) = (x / Lattice::GAP, (x % Lattice::GAP) as f32 / Lattice::GAP as f32);
        let mix = |a: f32, b: f32, share: f32| a + share * (b - a);
        let down = |k: usize| {
            let (a, b) = (self.above[k], self.below[k]);
            (mix(a.0, b.0, self.share), mix(a.1, b.1, self.share))
        };
        let (left, right) = (down(k), down(k + 1));
        (mix(left.0, right.0, share), mix(left.1, right.1, share))
    }
}

/// Whether a label is an object's; of unknown ones it is not known.
pub(super) fn object(label: u32, is_object: &[bool]) -> Option<bool> {
    if label == STRANGER { Some(true) } else { is_object.get(label as usize).copied() }
}
