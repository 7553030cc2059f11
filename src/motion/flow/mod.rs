//! Dense optical flow between two frames.
//!
//! In: two [`FlowPyramid`]s, computed once per frame from its brightness. Out: a [`FlowField`], one displacement a pixel.
//!
//! The method is DIS (Kroeger, Timofte, Dai and Van Gool, "Fast Optical Flow using Dense Inverse Search", ECCV 2016) with
//! OpenCV's spatial propagation, down to full resolution. At each level, from the coarsest to the finest:
//!
//! 1. Lay square patches over the level, overlapping by half; each starts from the coarser level's flow (`patch`).
//! 2. Search each patch in the second frame: try the displacements of its neighbours, then descend on the sum of squared
//!    differences without their mean. The *inverse* formulation needs the gradient of the first frame only. At the two
//!    coarsest levels, where patches are few, all whole-pixel displacements nearby are tried first (`patch`).
//! 3. Every pixel takes the mean of the patches over it, weighted by their match at this pixel (`patch`).
//! 4. Refine the whole field by a variational method (`solver`).
//!
//! **Deviations from DIS and OpenCV.** Levels are halved with a wider Gaussian, a neighbour's displacement must be clearly
//! better to be adopted, and below the coarsest level a patch moves at most three pixels: without these three, repeated
//! texture misleads patches (mean end-point error on the eight Middlebury pairs with known flow 0.42 px, with them
//! 0.34 px, both before the last tuning). The scan of the coarsest levels is ours; it finds fast objects in front of a
//! still background. Patches are searched a second time only where a neighbour disagrees. The refinement solves for both
//! components of a pixel together.
//!
//! **The backward field** of a clip checks the forward one: where both disagree, something is hidden or the flow is wrong. It
//! is computed independently.
//!
//! Measured: 0.31 px on these pairs at full size (OpenCV's DIS at its finest scale: 0.49 px). Sessions
//! that make masks reduce frames to `max_side` first: at 480 pixels 0.44 px (Urban3 1.40, before 0.66); their masks do
//! not get worse.
//!
//! **Cost**: linear in pixels; see `patch` and `solver`. **Limits**: brightness only, no colour. Objects that move farther
//! than about half their size in a frame are missed if the background moves differently.

mod field;
mod patch;
mod pyramid;
mod solver;
mod variation;

#[doc(hidden)] // For `examples/method.rs`.
pub use field::CompactFlow;
pub(crate) use field::Field;
pub use field::FlowField;
pub(crate) use field::STEPS_PER_PIXEL_LOG2;
pub use pyramid::FlowPyramid;
#[doc(hidden)] // For benchmarks.
pub use variation::local_flow_variation;

use patch::{PatchMatcher, PatchSearch};
use solver::Refiner;

/// Longest descent of a patch below the coarsest level, in pixels of the level: the coarser level is off by a few at most.
/// Measured on the Middlebury pairs above.
const MAX_DESCENT_PX: f32 = 3.0;

/// Radius of the scan over whole-pixel displacements at the two coarsest levels, in pixels of the level. At finer levels a
/// scan would cost time and find chance matches. Chosen by eye.
const SCAN_RADIUS_PX: [i16; 2] = [4, 2];

#[doc(hidden)]
/// Working memory of [`flow_between_with`], about 60 bytes a pixel of the frame.
///
/// Its contents never affect results; dropping it is always safe.
#[derive(Debug, Clone, Default)]
pub struct FlowScratch {
    matcher: PatchMatcher,
    refiner: Refiner,
}

/// Computes the flow from frame `from` to frame `to`; no motion if their sizes differ.
///
/// # Examples
/// A picture of digits moves one pixel to the right.
///
/// ```
/// use tracecut::flow::{FlowParams, FlowPyramid, flow_between};
/// use tracecut::image::Frame;
///
/// let rows = ["0013588531", "0136898631", "0137998731", "0136898631", "0013588531"];
/// // Each digit becomes a patch of 8 by 8 pixels of that brightness.
/// let grey = |x: usize, y: usize| 25 * (rows[y / 8 % 5].as_bytes()[x / 8 % 10] - b'0');
/// let frame = |shift| {
///     let pixels = (0..80 * 40).flat_map(|i| [grey(i % 80 + shift, i / 80); 3]);
///     Frame::from_rgb(pixels.collect(), 80, 40)
/// };
/// let (first, second) = (FlowPyramid::new(&frame(1)?), FlowPyramid::new(&frame(0)?));
/// let flow = flow_between(&first, &second, &FlowParams::default());
/// let (u, v) = (flow.u[(40, 20)], flow.v[(40, 20)]);
/// assert!((u - 1.0).abs() < 0.25 && v.abs() < 0.25, "{u}, {v}");
/// # Ok::<(), tracecut::Error>(())
/// ```
#[must_use]
pub fn flow_between(from: &FlowPyramid, to: &FlowPyramid, params: &FlowParams) -> FlowField {
    flow_between_with(from, to, params, &mut FlowScratch::default())
}

#[doc(hidden)]
/// Computes [`flow_between`] with working memory that is reused from pair to pair.
#[must_use]
pub fn flow_between_with(
    from: &FlowPyramid,
    to: &FlowPyramid,
    params: &FlowParams,
    scratch: &mut FlowScratch,
) -> FlowField {
    let (width, height) = from.size();
    if from.size() != to.size() || width * height == 0 {
        return FlowField::zero(width, height);
    }
    let num_levels = from.levels.len().min(to.levels.len());
    let mut coarser = None;
    for level in (0..num_levels).rev() {
        let (level_from, level_to) = (&from.levels[level], &to.levels[level]);
        let (stride, finest) = (params.patch_stride as usize, params.search_level as usize);
        let stride = if level > finest { (3 * stride / 4).max(1) } else { stride };
        // Patches that are not searched keep the coarser level's flow: each pixel then takes the best of the motions near it.
        let search = (level >= finest || coarser.is_none()).then(|| PatchSearch {
            max_descent: if coarser.is_some() { MAX_DESCENT_PX } else { PATCH_SIDE_PX as f32 },
            scan_radius: SCAN_RADIUS_PX.get(num_levels - 1 - level).copied(),
        });
        let mut flow = scratch.matcher.flow(level_from, level_to, stride, coarser.as_ref(), search);
        if params.fixed_points > 0 {
            scratch.refiner.refine(&level_from.image, &level_to.image, &mut flow.u, &mut flow.v, params);
        }
        coarser = Some(flow);
    }
    coarser.unwrap_or_default()
}

/// Side of a square patch, in pixels (OpenCV's presets: 8). Larger is smoother and loses small objects. A constant, so that
/// loops over a patch vectorise.
const PATCH_SIDE_PX: usize = 8;

crate::params! {
    /// Dense optical flow by inverse search (DIS) and variational refinement.
    pub struct FlowParams {
        /// Pixels between neighbouring patches down to the finest level that is searched, the patch's side at most; three
        /// quarters of it at coarser ones. Lower is slower.
        pub patch_stride: u32 = 4, in 1..=8, expert;
        /// Finest level at which patches are searched, 0 being full size; in finer ones each pixel takes the motion near
        /// it that fits best. Higher is faster and loses what is small.
        pub search_level: u32 = 0, in 0..=4;
        /// Longest side at which the flow of a clip is computed, in pixels; larger frames are reduced for it, and the field is
        /// enlarged. Single pairs, and runs that end with the labels of trajectories, keep their size. Higher is slower.
        pub max_side: u32 = 480, in 16..=4096, expert;
        /// Weight of smoothness in the refinement.
        pub smoothness: f32 = 25.0, in 0.001..=1000.0, expert;
        /// Fixed-point iterations of the refinement at every level, each with new robust weights; 0 skips the refinement.
        /// Higher is slower.
        pub fixed_points: u32 = 4, in 0..=12, expert;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Plane, gaussian_blur};
    use crate::rng::Rng;
    use std::f64::consts::TAU;

    /// Smooth random texture with brightness around 128.
    fn texture(width: usize, height: usize, seed: u64) -> Plane<f32> {
        let mut rng = Rng::for_stage(seed, "texture");
        let noise = Plane::from_fn(width, height, |_, _| rng.range(-1.0, 1.0) as f32);
        gaussian_blur(&noise, 2.0).map(|v| 128.0 + 350.0 * v)
    }

    /// Brightness made of waves no shorter than eight pixels, displaced by `(u, v)`.
    fn waves(width: usize, height: usize, u: f32, v: f32) -> Plane<f32> {
        let mut rng = Rng::for_stage(11, "waves");
        let waves: Vec<[f32; 3]> = (0..24)
            .map(|_| {
                let (frequency, direction) = (rng.range(0.1, 0.78), rng.range(0.0, TAU));
                let (fx, fy) = (frequency * direction.cos(), frequency * direction.sin());
                [fx as f32, fy as f32, rng.range(0.0, TAU) as f32]
            })
            .collect();
        Plane::from_fn(width, height, |x, y| {
            let (x, y) = (x as f32 - u, y as f32 - v);
            128.0 + 12.0 * waves.iter().map(|[fx, fy, phase]| (fx * x + fy * y + phase).sin()).sum::<f32>()
        })
    }

    fn flow(from: &Plane<f32>, to: &Plane<f32>) -> FlowField {
        let params = FlowParams::default();
        flow_between(&FlowPyramid::from_luma(from), &FlowPyramid::from_luma(to), &params)
    }

    /// Mean end-point error against one displacement over the columns and rows given.
    fn error(
        flow: &FlowField,
        (u, v): (f32, f32),
        columns: std::ops::Range<usize>,
        rows: std::ops::Range<usize>,
    ) -> f32 {
        let count = (columns.len() * rows.len()) as f32;
        let pixels = rows.flat_map(|y| columns.clone().map(move |x| (x, y)));
        pixels.map(|p| (flow.u[p] - u).hypot(flow.v[p] - v)).sum::<f32>() / count
    }

    /// Mean length of the difference of two fields.
    fn distance(a: &FlowField, b: &FlowField) -> f32 {
        let each = a.u.data().iter().zip(a.v.data()).zip(b.u.data().iter().zip(b.v.data()));
        each.map(|((au, av), (bu, bv))| (au - bu).hypot(av - bv)).sum::<f32>() / a.u.data().len() as f32
    }

    #[test]
    fn translation_of_smooth_noise_is_found_to_a_twentieth_of_a_pixel() {
        let motion = (3.4, -2.1);
        let flow = flow(&waves(160, 120, 0.0, 0.0), &waves(160, 120, motion.0, motion.1));
        let error = error(&flow, motion, 12..148, 12..108);
        assert!(error < 0.05, "error {error}");
    }

    #[test]
    fn where_patches_are_not_searched_they_keep_the_coarser_flow_and_the_refinement_makes_up_for_it() {
        let motion = (3.4, -2.1);
        let (from, to) = (waves(160, 120, 0.0, 0.0), waves(160, 120, motion.0, motion.1));
        // Beyond the coarsest level that one alone is searched.
        for search_level in [1, 2, 4] {
            let params = FlowParams { search_level, ..FlowParams::default() };
            let flow = flow_between(&FlowPyramid::from_luma(&from), &FlowPyramid::from_luma(&to), &params);
            let error = error(&flow, motion, 12..148, 12..108);
            assert!(error < 0.1, "level {search_level}: error {error}");
        }
    }

    #[test]
    fn a_square_that_moves_twenty_pixels_is_followed() {
        let (ground, square) = (texture(200, 150, 7), texture(64, 64, 8));
        let scene = |left: usize, top: usize| {
            Plane::from_fn(200, 150, |x, y| {
                let inside = (left..left + 64).contains(&x) && (top..top + 64).contains(&y);
                if inside { square[(x - left, y - top)] } else { ground[(x, y)] }
            })
        };
        let flow = flow(&scene(50, 40), &scene(70, 40));
        let (inside, outside) = (error(&flow, (20.0, 0.0), 54..110, 44..100), error(&flow, (0.0, 0.0), 4..40, 4..146));
        assert!(inside < 1.0, "error inside {inside}");
        assert!(outside < 0.1, "error outside {outside}");
    }

    #[test]
    fn a_brightness_offset_hardly_changes_the_flow() {
        let (from, to) = (waves(120, 90, 0.0, 0.0), waves(120, 90, 2.3, 1.2));
        let (plain, brighter) = (flow(&from, &to), flow(&from, &to.map(|v| v + 10.0)));
        let error = error(&brighter, (2.3, 1.2), 12..108, 12..78);
        assert!(error < 0.2, "error {error}");
        assert!(distance(&plain, &brighter) < 0.2, "distance {}", distance(&plain, &brighter));
    }

    #[test]
    fn identical_and_flat_frames_do_not_move() {
        let scene = texture(70, 50, 1);
        let still = flow(&scene, &scene);
        assert!(still.u.data().iter().chain(still.v.data()).all(|v| v.abs() < 1e-3));
        let flat = Plane::filled(70, 50, 90.0);
        let still = flow(&flat, &flat);
        assert!(still.u.data().iter().chain(still.v.data()).all(|&v| v == 0.0));
    }

    #[test]
    fn any_size_gives_finite_flow_of_that_size() {
        for (width, height) in [(1, 1), (17, 3), (1, 40), (40, 1), (2, 2), (9, 8), (65, 33), (300, 9)] {
            let flow = flow(&texture(width, height, 5), &texture(width, height, 6));
            assert_eq!(
                (flow.u.width(), flow.u.height(), flow.v.width(), flow.v.height()),
                (width, height, width, height)
            );
            assert!(flow.u.data().iter().chain(flow.v.data()).all(|v| v.is_finite()), "{width}x{height}");
        }
        assert_eq!(flow(&Plane::default(), &Plane::default()), FlowField::default());
    }

    #[test]
    fn extreme_settings_and_values_give_finite_flow() {
        let mut from = texture(60, 45, 5);
        (from[(3, 4)], from[(30, 20)], from[(31, 20)]) = (f32::NAN, f32::INFINITY, -1e30);
        let extremes = [
            FlowParams { patch_stride: 8, smoothness: 0.001, ..FlowParams::default() },
            FlowParams { patch_stride: 1, search_level: 4, ..FlowParams::default() },
            FlowParams { smoothness: 1000.0, fixed_points: 12, ..FlowParams::default() },
            FlowParams { fixed_points: 0, ..FlowParams::default() },
        ];
        for params in extremes {
            let [from, to] = [&from, &texture(60, 45, 6)].map(FlowPyramid::from_luma);
            let flow = flow_between(&from, &to, &params);
            assert_eq!((flow.u.width(), flow.v.height()), (60, 45));
            assert!(flow.u.data().iter().chain(flow.v.data()).all(|v| v.is_finite()), "{params:?}");
        }
    }

    #[test]
    fn mirrored_frames_give_mirrored_flow() {
        let mirrored = |plane: &Plane<f32>| {
            Plane::from_fn(plane.width(), plane.height(), |x, y| plane[(plane.width() - 1 - x, y)])
        };
        let (from, to) = (waves(128, 96, 0.0, 0.0), waves(128, 96, 2.6, 1.1));
        let plain = flow(&from, &to);
        let other = flow(&mirrored(&from), &mirrored(&to));
        let back = FlowField { u: mirrored(&other.u).map(|u| -u), v: mirrored(&other.v) };
        let error = error(&back, (2.6, 1.1), 12..116, 12..84);
        assert!(error < 0.05, "error {error}");
        assert!(distance(&plain, &back) < 0.1, "distance {}", distance(&plain, &back));
    }

    #[test]
    fn scratch_of_other_pairs_and_sizes_leaves_no_trace() {
        let params = FlowParams::default();
        let pyramid = |width, height, seed| FlowPyramid::from_luma(&texture(width, height, seed));
        let (from, to) = (pyramid(71, 50, 1), pyramid(71, 50, 2));
        let fresh = flow_between(&from, &to, &params);
        let mut scratch = FlowScratch::default();
        // 72 columns have as many cells in a half row as 71: the last odd one must not keep its value.
        for (width, height) in [(72, 50), (30, 90), (71, 50)] {
            let _ = flow_between_with(&pyramid(width, height, 8), &pyramid(width, height, 9), &params, &mut scratch);
            assert_eq!(flow_between_with(&from, &to, &params, &mut scratch), fresh, "after {width}x{height}");
        }
    }

    #[test]
    fn frames_of_different_size_give_no_motion() {
        let params = FlowParams::default();
        let [from, to] = [(20, 10), (10, 20)].map(|(w, h)| FlowPyramid::from_luma(&texture(w, h, 1)));
        assert_eq!(flow_between(&from, &to, &params), FlowField::zero(20, 10));
    }
}
