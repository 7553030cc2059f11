//! Two accounts of each pixel: that the scene behind shows it, as the camera moves, and that an object does.
//!
//! A pixel of the scene is found again in other frames where the scene has gone to, a pixel of an object where the
//! objects have gone to. Where it has gone is known from trajectories ([`Warp`]); how alike it is found is judged by
//! those other frames that show it best, since objects hide the scene in some. Plain areas are found again both ways,
//! and nothing is said of them.

use super::plate::{Picture, apart, sampled};
use crate::camera::{CameraPath, Warp};
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
/// an object's; of every second pixel ([`is_sought`]), 0 of the others.
pub(crate) type Accounts = Plane<[u8; 2]>;

/// What the accounts of a frame are made from: what it shows, and what others show where the scene and the objects have
/// gone to.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sought {
    pub(crate) picture: Picture,
    pub(crate) others: Vec<Other>,
}

/// Another frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Other {
    pub(crate) picture: Picture,
    pub(crate) scene: Lattice,
    /// `None` where too little is known of them.
    pub(crate) object: Option<Lattice>,
}

impl Sought {
    /// Of frame `t`. `pictures` are the frames reduced by `step`; `is_object` says what each label of the trajectories is.
    pub(super) fn new(
        pictures: &[Picture],
        step: usize,
        t: usize,
        path: &CameraPath,
        (tracks, label): (&Trajectories, &[u32]),
        is_object: &[bool],
    ) -> Self {
        let picture = pictures[t].clone();
        let of = |i: usize| label.get(i).and_then(|&l| object(l, is_object));
        let known: Vec<_> = tracks.alive(t).filter_map(|(i, x, y)| Some((i, (x, y), of(i)?))).collect();
        let near = AWAY.iter().flat_map(|&k| [t.checked_sub(k), Some(t + k)]).flatten();
        let other = |s: usize| {
            let points = |wanted: bool| -> Vec<_> {
                let own = known.iter().filter(|&&(.., object)| object == wanted);
                own.filter_map(|&(i, from, _)| tracks.at(i, s).map(|to| (from, to))).collect()
            };
            let (way, size) = (path.between(t, s), (picture.width(), picture.height()));
            let lattice = |points: Vec<_>| Lattice::new(size, step, &Warp::new(tracks.size, way, points.into_iter()));
            let object = Some(points(true)).filter(|points| points.len() >= LEAST_POINTS);
            Other { picture: pictures[s].clone(), scene: lattice(points(false)), object: object.map(lattice) }
        };
        let others = near.filter(|&s| s < pictures.len()).map(other).collect();
        Self { picture, others }
    }

    /// Both accounts. Where nothing can be told both are 0.
    pub(crate) fn accounts(&self) -> Accounts {
        let Self { picture, others } = self;
        let (mut by_scene, mut by_object) = (Differences::default(), Differences::default());
        for other in others {
            by_scene.add(picture, &other.picture, &other.scene);
            other.object.iter().for_each(|object| by_object.add(picture, &other.picture, object));
        }
        let mut accounts = Plane::filled(picture.width(), picture.height(), [0; 2]);
        let mut at = 0;
        for y in 0..picture.height() {
            for account in accounts.row_mut(y).iter_mut().skip(first_of_row(y)).step_by(2) {
                let found = (by_scene.representative(at), by_object.representative(at));
                if let (Some(scene), Some(object)) = found {
                    *account = [scene, object];
                }
                at += 1;
            }
        }
        accounts
    }
}

/// The first pixel of a row that is looked for: every second one is, as on a chessboard.
fn first_of_row(y: usize) -> usize {
    y % 2
}

/// Whether a pixel is looked for.
pub(super) fn is_sought(x: usize, y: usize) -> bool {
    x % 2 == first_of_row(y)
}

/// What accounts of some pixels come to: sums of squares, and their number.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Verdict {
    scene: u64,
    object: u64,
    pixels: u64,
}

impl Verdict {
    pub(super) fn of([scene, object, pixels]: [u64; 3]) -> Self {
        Self { scene, object, pixels }
    }

    pub(super) fn add(&mut self, [scene, object]: [u8; 2]) {
        let [scene, object] = [scene, object].map(u64::from);
        (self.scene, self.object) = (self.scene + scene * scene, self.object + object * object);
        self.pixels += 1;
    }

    /// From -1 to 1 how surely the pixels are none of the scene, whatever else they are; 0 at this mean square.
    pub(super) fn strangeness(&self, half: f32) -> f32 {
        let unlike = self.unlike_scene();
        (unlike - half) / (unlike + half)
    }

    /// Mean square of the differences if it is the scene's, in grey levels.
    pub(super) fn unlike_scene(&self) -> f32 {
        self.scene as f32 / self.pixels.max(1) as f32
    }

    /// -1 where the scene's motion alone explains the pixels, 0 where both are alike, 1 where the objects' alone does.
    pub(super) fn value(&self) -> f32 {
        let [scene, object, pixels] = [self.scene, self.object, self.pixels].map(|v| v as f32);
        (scene - object) / (scene + object + HALF * HALF * pixels).max(1.0)
    }
}

/// No difference is known, since the pixel has left the frame.
const GONE: u8 = 255;

/// How far each pixel that is sought is from what other frames show of it, frame by frame; [`GONE`] where it has left the frame.
#[derive(Default)]
struct Differences(Vec<Vec<u8>>);

impl Differences {
    fn add(&mut self, picture: &Picture, other: &Picture, lattice: &Lattice) {
        let (right, bottom) = ((picture.width() - 1) as f32, (picture.height() - 1) as f32);
        let mut found = Vec::with_capacity(picture.data().len().div_ceil(2));
        let mut row = Vec::new();
        for y in 0..picture.height() {
            lattice.row(y, picture.width(), &mut row);
            let first = first_of_row(y);
            let pixels = picture.row(y).iter().skip(first).step_by(2);
            found.extend(pixels.zip(places(&row, first)).map(|(&own, (x, y))| {
                let inside = x >= 0.0 && y >= 0.0 && x <= right && y <= bottom;
                if inside { apart(own, sampled(other, x, y)).min(GONE - 1) } else { GONE }
            }));
        }
        self.0.push(found);
    }

    /// The difference that counts for pixel `i`; `None` where it is in no other frame.
    fn representative(&self, i: usize) -> Option<u8> {
        let mut seen = [GONE; 2 * AWAY.len()];
        let mut count = 0;
        for frame in self.0.iter().filter(|frame| frame[i] != GONE) {
            let mut place = count;
            while place > 0 && seen[place - 1] > frame[i] {
                seen[place] = seen[place - 1];
                place -= 1;
            }
            seen[place] = frame[i];
            count += 1;
        }
        (count > 0).then(|| seen[(COUNTS * (count - 1) as f32 + 0.5) as usize])
    }
}

/// Where points of a reduced frame go, a few pixels apart.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lattice(pub(crate) Vec<(f32, f32)>);

fn mix(a: (f32, f32), b: (f32, f32), share: f32) -> (f32, f32) {
    (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1))
}

/// Where every second pixel of a row goes from `first` on, 0 or 1, by those that are on the lattice's columns.
fn places(columns: &[(f32, f32)], first: usize) -> impl Iterator<Item = (f32, f32)> + '_ {
    let shares = move || (first..Lattice::GAP).step_by(2).map(|k| k as f32 / Lattice::GAP as f32);
    columns.windows(2).flat_map(move |ends| shares().map(|share| mix(ends[0], ends[1], share)))
}

impl Lattice {
    /// Pixels from point to point.
    const GAP: usize = 8;

    /// Columns and rows for a reduced frame of this size.
    pub(crate) fn size((w, h): (usize, usize)) -> (usize, usize) {
        (w / Self::GAP + 2, h / Self::GAP + 2)
    }

    fn new(size: (usize, usize), step: usize, warp: &Warp) -> Self {
        let (columns, rows) = Self::size(size);
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
        Self(points)
    }

    /// Where those pixels of row `y` go that are on columns, in a frame of this width.
    fn row(&self, y: usize, width: usize, into: &mut Vec<(f32, f32)>) {
        let columns = Self::size((width, 0)).0;
        let line = |k: usize| &self.0[k * columns..(k + 1) * columns];
        let (k, share) = (y / Self::GAP, (y % Self::GAP) as f32 / Self::GAP as f32);
        into.clear();
        into.extend(line(k).iter().zip(line(k + 1)).map(|(&a, &b)| mix(a, b, share)));
    }
}

/// Whether a label is an object's; of unknown ones it is not known.
pub(super) fn object(label: u32, is_object: &[bool]) -> Option<bool> {
    if label == STRANGER { Some(true) } else { is_object.get(label as usize).copied() }
}
