//! Reprojection errors of each pixel: against the scene's motion and against the objects'.
//!
//! A pixel of the scene reappears in other frames where the scene has moved to, a pixel of an object where the objects
//! have. Both motions are known from trajectories ([`Warp`]). The error of a motion is the colour difference at a low
//! quantile of the reference frames, since objects occlude the scene in some. Plain areas have low errors both ways, and
//! neither is evidence. Not in the paper. Cost: O(pixels / 2) for each of up to six reference frames. It fails where the
//! objects' motion is badly known between trajectories.

use super::plate::{Picture, max_channel_difference, sample_colour};
use crate::camera::{CameraPath, Warp};
use crate::cut::OUTLIER;
use crate::discretize::Clusters;
use crate::image::Plane;
use crate::trajectory::Trajectories;

/// Distances of the reference frames, before and after. Chosen by eye.
const REFERENCE_OFFSETS_FRAMES: [usize; 3] = [3, 9, 17];
/// Quantile of the differences over the reference frames that is the error. Chosen by eye.
const ERROR_QUANTILE: f32 = 0.35;
/// Fewest points to know the objects' motion by. Chosen by eye.
const MIN_OBJECT_POINTS: usize = 3;

/// Errors of each pixel in grey levels, for the scene's motion and the objects'. Every second pixel is compared
/// ([`is_compared`]), the others have 0.
pub(crate) type ReprojectionErrors = Plane<[u8; 2]>;

type Point = (f32, f32);

/// A reduced frame and the reference frames that it is compared with.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ReprojectionInput {
    pub(crate) picture: Picture,
    pub(crate) references: Vec<ReferenceFrame>,
}

/// Another frame, and the positions there of the frame's points.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ReferenceFrame {
    pub(crate) picture: Picture,
    /// By the motion of the scene.
    pub(crate) scene: WarpGrid,
    /// By the motion of the objects; `None` with too few points.
    pub(crate) object: Option<WarpGrid>,
}

impl ReprojectionInput {
    /// Gathers the input of frame `t`. `pictures` are the frames reduced by `step`.
    pub(super) fn new(
        pictures: &[Picture],
        step: usize,
        t: usize,
        path: &CameraPath,
        segmented: SegmentedTracks<'_>,
    ) -> Self {
        let tracks = segmented.tracks;
        let picture = pictures[t].clone();
        let points: Vec<_> =
            tracks.alive(t).filter_map(|(i, x, y)| Some((i, (x, y), segmented.is_object_track(i)?))).collect();
        let reference = |s: usize| {
            let matches = |of_object: bool| -> Vec<(Point, Point)> {
                let points = points.iter().filter(|&&(.., is_object)| is_object == of_object);
                points.filter_map(|&(i, from, _)| tracks.at(i, s).map(|to| (from, to))).collect()
            };
            let (homography, size) = (path.between(t, s), (picture.width(), picture.height()));
            let grid =
                |matches: Vec<_>| WarpGrid::new(size, step, &Warp::new(tracks.size, homography, matches.into_iter()));
            let object = Some(matches(true)).filter(|matches| matches.len() >= MIN_OBJECT_POINTS);
            ReferenceFrame { picture: pictures[s].clone(), scene: grid(matches(false)), object: object.map(grid) }
        };
        let references = REFERENCE_OFFSETS_FRAMES.iter().flat_map(|&k| [t.checked_sub(k), Some(t + k)]).flatten();
        let references = references.filter(|&s| s < pictures.len()).map(reference).collect();
        Self { picture, references }
    }

    /// Computes both errors of each compared pixel; both are 0 where either is unknown.
    pub(crate) fn errors(&self) -> ReprojectionErrors {
        let Self { picture, references } = self;
        let (mut by_scene, mut by_object) = (Differences::default(), Differences::default());
        for reference in references {
            by_scene.add(picture, &reference.picture, &reference.scene);
            reference.object.iter().for_each(|object| by_object.add(picture, &reference.picture, object));
        }
        let mut errors = Plane::filled(picture.width(), picture.height(), [0; 2]);
        let mut known = by_scene.into_quantiles().into_iter().zip(by_object.into_quantiles());
        for y in 0..picture.height() {
            let compared = errors.row_mut(y).iter_mut().skip(first_compared_column(y)).step_by(2);
            for (error, (scene, object)) in compared.zip(&mut known) {
                if scene != OUT_OF_FRAME && object != OUT_OF_FRAME {
                    *error = [scene, object];
                }
            }
        }
        errors
    }
}

/// The first compared pixel of a row: every second one is, as on a chessboard.
fn first_compared_column(y: usize) -> usize {
    y % 2
}

/// Returns `true` for pixels that are compared with other frames.
pub(super) fn is_compared(x: usize, y: usize) -> bool {
    x % 2 == first_compared_column(y)
}

/// Difference of a pixel that is outside of the reference frame.
const OUT_OF_FRAME: u8 = 255;

/// Colour differences of the compared pixels to each reference frame, or [`OUT_OF_FRAME`].
#[derive(Default)]
struct Differences(Vec<Vec<u8>>);

impl Differences {
    fn add(&mut self, picture: &Picture, reference: &Picture, grid: &WarpGrid) {
        let (right, bottom) = ((picture.width() - 1) as f32, (picture.height() - 1) as f32);
        let mut differences = Vec::with_capacity(picture.data().len().div_ceil(2));
        let mut row = Vec::new();
        for y in 0..picture.height() {
            grid.interpolate_row(y, picture.width(), &mut row);
            let first = first_compared_column(y);
            let mut pixels = picture.row(y).iter().skip(first).step_by(2);
            // Between two columns of the grid lie a few compared pixels.
            for ends in row.windows(2) {
                for (share, &colour) in shares_between_columns(first).zip(&mut pixels) {
                    let (x, y) = interpolate(ends[0], ends[1], share);
                    let inside = x >= 0.0 && y >= 0.0 && x <= right && y <= bottom;
                    let difference = || max_channel_difference(colour, sample_colour(reference, x, y));
                    differences.push(if inside { difference().min(OUT_OF_FRAME - 1) } else { OUT_OF_FRAME });
                }
            }
        }
        self.0.push(differences);
    }

    /// Returns the [`ERROR_QUANTILE`] of the differences of each pixel, [`OUT_OF_FRAME`] if it is in no reference frame.
    fn into_quantiles(self) -> Vec<u8> {
        let mut sorted = self.0;
        // Many pixels at a time in vector registers; what is out of the frame comes last.
        for end in (1..sorted.len()).rev() {
            for k in 0..end {
                let [low, high] = &mut sorted[k..k + 2] else { continue };
                for (low, high) in low.iter_mut().zip(high) {
                    (*low, *high) = ((*low).min(*high), (*low).max(*high));
                }
            }
        }
        let Some(least) = sorted.first() else { return Vec::new() };
        let mut counts = vec![0_u8; least.len()];
        for differences in &sorted {
            counts.iter_mut().zip(differences).for_each(|(count, d)| *count += u8::from(*d != OUT_OF_FRAME));
        }
        let place = |count: u8| (ERROR_QUANTILE * f32::from(count.saturating_sub(1)) + 0.5) as usize;
        let places: Vec<usize> = (0..=sorted.len() as u8).map(place).collect();
        counts.into_iter().enumerate().map(|(i, count)| sorted[places[usize::from(count)]][i]).collect()
    }
}

/// A warp of a reduced frame, sampled on a grid, row by row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WarpGrid(pub(crate) Vec<Point>);

fn interpolate(a: Point, b: Point, share: f32) -> Point {
    (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1))
}

/// Returns the positions of every second pixel between two columns of the grid, from `first` on (0 or 1), as shares of their distance.
fn shares_between_columns(first: usize) -> impl Iterator<Item = f32> {
    (first..WarpGrid::SPACING_PX).step_by(2).map(|k| k as f32 / WarpGrid::SPACING_PX as f32)
}

impl WarpGrid {
    /// Distance of neighbours on the grid. Chosen by eye.
    const SPACING_PX: usize = 8;

    /// Returns the columns and rows of the grid of a reduced frame of `size`.
    pub(crate) fn dimensions(size: (usize, usize)) -> (usize, usize) {
        (size.0 / Self::SPACING_PX + 2, size.1 / Self::SPACING_PX + 2)
    }

    fn new(size: (usize, usize), step: usize, warp: &Warp) -> Self {
        let (columns, rows) = Self::dimensions(size);
        // Pixel centres are at whole numbers.
        let full = |k: usize| ((k * Self::SPACING_PX) as f32 + 0.5) * step as f32 - 0.5;
        let reduced = |v: f32| (v + 0.5) / step as f32 - 0.5;
        let mut points = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            points.extend((0..columns).map(|column| {
                let (x, y) = warp.apply(full(column), full(row));
                (reduced(x), reduced(y))
            }));
        }
        Self(points)
    }

    /// Interpolates row `y` of the warp at the grid's columns, for a frame of this width.
    fn interpolate_row(&self, y: usize, width: usize, row: &mut Vec<Point>) {
        let columns = Self::dimensions((width, 0)).0;
        let line = |k: usize| &self.0[k * columns..(k + 1) * columns];
        let (k, share) = (y / Self::SPACING_PX, (y % Self::SPACING_PX) as f32 / Self::SPACING_PX as f32);
        row.clear();
        row.extend(line(k).iter().zip(line(k + 1)).map(|(&a, &b)| interpolate(a, b, share)));
    }
}

/// Trajectories, the label of each, and the labels that are objects. Other labels do not count.
#[derive(Debug, Clone, Copy)]
pub struct SegmentedTracks<'a> {
    /// The trajectories.
    pub tracks: &'a Trajectories,
    /// Label of each trajectory.
    pub label: &'a [u32],
    /// `true` for each label that is an object.
    pub is_object: &'a [bool],
}

impl SegmentedTracks<'_> {
    /// Returns `true` if trajectory `i` is an object's, `None` if it has no label. [`OUTLIER`]s are objects'.
    pub(super) fn is_object_track(&self, i: usize) -> Option<bool> {
        let &label = self.label.get(i)?;
        if label == OUTLIER { Some(true) } else { self.is_object.get(label as usize).copied() }
    }
}

/// Clusters, and which of them are objects.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ObjectClusters {
    pub(crate) clusters: Clusters,
    /// `true` for each cluster that is an object.
    pub(crate) is_object: Vec<bool>,
}
