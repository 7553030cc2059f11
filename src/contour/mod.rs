//! Contours of one image: where its brightness, colour and texture change (section 4.1).
//!
//! In: a [`Frame`]. Out: [`BoundaryMap`], a boundary probability Pb for each pixel, and [`Segments`], straight pieces fitted to what is
//! left of it after thinning and thresholding.

mod blur;
mod fit;
mod gradient;
mod histogram;
mod lab;
mod link;
mod texton;
mod thin;

pub(crate) use thin::{ORIENTATIONS, normals, thin};

use crate::flow::FlowField;
use crate::image::{Frame, Plane};

crate::params! {
    /// Boundary probability and contours.
    pub struct ContourParams {
        /// Contours are followed where Pb is above this value.
        pub low: f32 = 0.03, in 0.0..=1.0;
        /// A contour is kept if its Pb is above this value somewhere.
        pub high: f32 = 0.08, in 0.0..=1.0;
        /// Contours of fewer pixels that end in nothing are left out.
        pub min_chain: u32 = 8, in 1..=10000;
        /// How far a line may be from the contour that it stands for, in pixels. Higher gives fewer lines.
        pub deviation: f32 = 1.5, in 0.1..=20.0;
        /// Longer lines are broken, in pixels, so that edges that bridge a gap can begin in their middle; 0 leaves them whole.
        pub max_line: f32 = 50.0, in 0.0..=10000.0;
        /// Weight of changes of colour (a and b of Lab), that of changes of brightness being 1.
        pub colour_weight: f32 = 0.6, in 0.0..=10.0;
        /// Weight of changes of texture.
        pub texture_weight: f32 = 0.7, in 0.0..=10.0;
        /// Weight of changes of motion; 0 leaves them out.
        pub motion_weight: f32 = 0.0, in 0.0..=10.0;
    }
}

/// How likely each pixel lies on a boundary between two things.
///
/// Law: both planes have the size of the image; `0 <= thin <= pb <= 1`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BoundaryMap {
    /// Boundary probability, the largest over all orientations.
    pub pb: Plane<f32>,
    /// The same on ridges one pixel wide, 0 elsewhere.
    pub thin: Plane<f32>,
}

/// Straight pieces of contours.
///
/// Law: every index of `lines` is below `points.len()`, both ends differ, no line occurs twice (in either direction), two lines meet at
/// most in a common end; points are finite, lie in `-0.5..=width-0.5` and `-0.5..=height-0.5`, and no two are equal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Segments {
    /// Ends of the lines in pixels, pixel centres at integers.
    pub points: Vec<(f32, f32)>,
    /// The lines, as indices of their ends.
    pub lines: Vec<(u32, u32)>,
}

/// Pb of `frame`. The flow to the next frame, where it is known, will add motion boundaries.
pub fn boundary_map(frame: &Frame, flow: Option<&FlowField>, params: &ContourParams) -> BoundaryMap {
    let oriented = gradient::oriented_strength(frame, flow, params);
    let (w, h) = (frame.width(), frame.height());
    let mut pb = Plane::filled(w, h, 0.0_f32);
    let mut orientation = Plane::filled(w, h, 0_u8);
    for (k, plane) in oriented.iter().enumerate() {
        for ((best, o), &v) in pb.data_mut().iter_mut().zip(orientation.data_mut()).zip(plane) {
            *o = if v > *best { k as u8 } else { *o };
            *best = v.max(*best);
        }
    }
    let logistic = |s: f32| 1.0 / (1.0 + libm::expf(-SLOPE * (s - CENTRE)));
    let none = logistic(0.0);
    let pb = pb.map(|s| (logistic(s) - none).clamp(0.0, 1.0));
    BoundaryMap { thin: thin(&pb, &orientation), pb }
}

/// Slope of the logistic that turns strengths into probabilities.
const SLOPE: f32 = 7.07;
/// Strength at which it is one half.
const CENTRE: f32 = 0.74;

/// The contours of `map` as line segments.
pub fn contour_segments(map: &BoundaryMap, params: &ContourParams) -> Segments {
    let chains = link::link(&map.thin, params.low, params.high, params.min_chain as usize);
    fit::fit(&chains, params.deviation, params.max_line)
}
