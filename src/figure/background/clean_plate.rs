//! Clean plate of a frame: the scene without the objects.
//!
//! Background pixels are the frame's own. Occluded pixels have the median of the nearest frames that show them, warped by
//! the camera's motion ([`Warp`]); pixels that no frame shows are holes. Not in the paper; Wexler, Shechtman and Irani
//! (2004) complete videos of a rigid scene in this way, and then synthesize the holes, which is not done here. Cost:
//! O(occluded pixels · frames). It fails where the scene changes, as by shadows, and where the warp is badly known.

use super::plate::{median_colour, reduce, sample_colour};
use crate::camera::{Camera, Warp};
use crate::image::{Frame, Plane};
use crate::trajectory::Trajectories;

/// Most samples that a pixel is the median of. Chosen by eye.
const MAX_SAMPLES: usize = 5;
/// Most frames that are searched. Chosen by eye.
const MAX_SOURCES: usize = 64;
/// Width of the band around an object that may show some of it. Chosen by eye.
const OBJECT_MARGIN_PX: usize = 2;

/// Input of clean plates, all of one size. `is_scene` marks the trajectories of the scene.
#[derive(Debug)]
pub(crate) struct CleanPlateInput<'a> {
    pub(crate) frames: &'a [Frame],
    pub(crate) masks: &'a [Plane<u8>],
    pub(crate) camera: &'a Camera,
    pub(crate) tracks: &'a Trajectories,
    pub(crate) is_scene: Vec<bool>,
}

/// A pixel behind an object, and its colours in other frames.
#[derive(Debug, Clone, Default)]
struct OccludedPixel {
    at: (usize, usize),
    colours: Vec<[u8; 3]>,
}

/// Renders frame `t` without objects, as RGBA: alpha is 0 in holes, and 255 elsewhere. Each frame must have a mask.
pub(crate) fn clean_plate(input: &CleanPlateInput<'_>, t: usize) -> Plane<[u8; 4]> {
    let (frame, mask) = (&input.frames[t], &input.masks[t]);
    let w = mask.width();
    let pixels = (0..w * mask.height()).map(|i| (i % w, i / w)).filter(|&(x, y)| is_near_object(mask, x, y));
    let mut occluded: Vec<_> = pixels.map(|at| OccludedPixel { at, colours: Vec::new() }).collect();
    for s in source_frames(t, input.frames.len()) {
        if occluded.iter().all(|pixel| pixel.colours.len() >= MAX_SAMPLES) {
            break;
        }
        collect_colours(input, t, s, &mut occluded);
    }
    let mut plate = reduce(frame, 1).map(|[r, g, b]| [r, g, b, 255]);
    for OccludedPixel { at: (x, y), colours } in occluded {
        let [r, g, b] = if colours.is_empty() { [0; 3] } else { median_colour(&colours).0 };
        plate.row_mut(y)[x] = [r, g, b, if colours.is_empty() { 0 } else { 255 }];
    }
    plate
}

/// The frames that are searched for pixels of frame `t`, nearest first.
fn source_frames(t: usize, num_frames: usize) -> impl Iterator<Item = usize> {
    let step = num_frames.div_ceil(MAX_SOURCES).max(1);
    let pair = move |distance: usize| [t.checked_sub(distance), Some(t + distance).filter(|&s| s < num_frames)];
    (step..num_frames).step_by(step).flat_map(pair).flatten()
}

/// Adds the colours that frame `s` shows of occluded pixels of frame `t`.
fn collect_colours(input: &CleanPlateInput<'_>, t: usize, s: usize, occluded: &mut [OccludedPixel]) {
    let (source, mask, tracks) = (reduce(&input.frames[s], 1), &input.masks[s], input.tracks);
    let (right, bottom) = ((mask.width() - 1) as f32, (mask.height() - 1) as f32);
    let moves = !input.camera.is_still();
    let scene = tracks.alive(t).filter(|&(i, ..)| moves && input.is_scene.get(i) == Some(&true));
    let matches = scene.filter_map(|(i, x, y)| tracks.at(i, s).map(|to| ((x, y), to)));
    let warp = Warp::new((mask.width(), mask.height()), input.camera.between(t, s), matches);
    for pixel in occluded.iter_mut().filter(|pixel| pixel.colours.len() < MAX_SAMPLES) {
        let (x, y) = warp.apply(pixel.at.0 as f32, pixel.at.1 as f32);
        let inside = x >= 0.0 && y >= 0.0 && x <= right && y <= bottom;
        if inside && !is_near_object(mask, (x + 0.5) as usize, (y + 0.5) as usize) {
            pixel.colours.push(sample_colour(&source, x, y));
        }
    }
}

/// Returns `true` if any pixel within [`OBJECT_MARGIN_PX`] is an object's.
fn is_near_object(mask: &Plane<u8>, x: usize, y: usize) -> bool {
    let columns = x.saturating_sub(OBJECT_MARGIN_PX)..(x + OBJECT_MARGIN_PX + 1).min(mask.width());
    let mut rows = y.saturating_sub(OBJECT_MARGIN_PX)..(y + OBJECT_MARGIN_PX + 1).min(mask.height());
    rows.any(|y| mask.row(y)[columns.clone()].iter().any(|&label| label > 0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const SIZE: (usize, usize) = (64, 40);

    fn scene(x: usize, y: usize) -> [u8; 3] {
        [Rng::for_stage((y * 1000 + x) as u64, "scene").below(256) as u8; 3]
    }

    /// Returns `true` for pixels of the object in frame `t`; it moves four pixels a frame to the right.
    fn inside(t: usize, x: usize, y: usize) -> bool {
        (10 + 4 * t..22 + 4 * t).contains(&x) && (8..24).contains(&y)
    }

    /// Eight frames of a scene that moves `pan` pixels a frame to the left.
    fn clip(pan: usize) -> (Vec<Frame>, Vec<Plane<u8>>) {
        let frame = |t: usize| {
            let at = |i: usize| {
                let (x, y) = (i % SIZE.0, i / SIZE.0);
                if inside(t, x, y) { [9, 99, 199] } else { scene(x + pan * t, y) }
            };
            Frame::from_rgb((0..SIZE.0 * SIZE.1).flat_map(at).collect(), SIZE.0, SIZE.1).unwrap()
        };
        let mask = |t: usize| Plane::from_fn(SIZE.0, SIZE.1, |x, y| u8::from(inside(t, x, y)));
        ((0..8).map(frame).collect(), (0..8).map(mask).collect())
    }

    fn plate(pan: usize, camera: &Camera, t: usize) -> Plane<[u8; 4]> {
        let (frames, masks) = clip(pan);
        let tracks = Trajectories::empty(8, SIZE);
        clean_plate(
            &CleanPlateInput { frames: &frames, masks: &masks, camera, tracks: &tracks, is_scene: Vec::new() },
            t,
        )
    }

    #[test]
    fn a_still_camera_shows_the_scene() {
        let clean = plate(0, &Camera::still(), 3);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let [r, g, b] = scene(x, y);
                assert_eq!(clean[(x, y)], [r, g, b, 255], "{x} {y}");
            }
        }
    }

    #[test]
    fn a_panning_camera_shows_the_scene_of_that_frame() {
        let clean = plate(2, &Camera::panning(-2.0, 8), 3);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let [r, g, b] = scene(x + 6, y);
                assert_eq!(clean[(x, y)], [r, g, b, 255], "{x} {y}");
            }
        }
    }

    #[test]
    fn pixels_that_no_frame_shows_are_holes() {
        let (frames, mut masks) = clip(0);
        // An object that never moves.
        masks.iter_mut().for_each(|mask| mask.row_mut(35)[50] = 1);
        let (tracks, camera) = (Trajectories::empty(8, SIZE), Camera::still());
        let input =
            CleanPlateInput { frames: &frames, masks: &masks, camera: &camera, tracks: &tracks, is_scene: Vec::new() };
        let clean = clean_plate(&input, 0);
        let holes: Vec<usize> = (0..clean.data().len()).filter(|&i| clean.data()[i][3] == 0).collect();
        assert_eq!(holes.len(), 25);
        assert!(holes.iter().all(|&i| clean.data()[i] == [0; 4] && (i % SIZE.0).abs_diff(50) <= 2));
    }

    #[test]
    fn trajectories_refine_the_cameras_motion() {
        let (frames, masks) = clip(2);
        let mut tracks = Trajectories::empty(8, SIZE);
        for (x, y) in (0..16 * 10).map(|k| ((4 * (k % 16)) as f32, (4 * (k / 16)) as f32)) {
            tracks.push(0, (0..8).map(|t| (x - 2.0 * t as f32, y, 0.0)));
        }
        // A camera that is not known to pan.
        let camera = Camera::panning(0.0, 8);
        let is_scene = vec![true; tracks.len()];
        let input = CleanPlateInput { frames: &frames, masks: &masks, camera: &camera, tracks: &tracks, is_scene };
        let clean = clean_plate(&input, 3);
        let (mut right, mut total) = (0, 0);
        for (x, y) in (10..34).flat_map(|x| (8..24).map(move |y| (x, y))).filter(|&(x, y)| inside(3, x, y)) {
            total += 1;
            right += usize::from(clean[(x, y)][0].abs_diff(scene(x + 6, y)[0]) < 80);
        }
        assert!(4 * right > 3 * total, "{right} of {total}");
    }
}
