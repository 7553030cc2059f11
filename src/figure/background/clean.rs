//! The clean plate of a frame: the scene as it would be without the objects.
//!
//! Pixels of the background are the frame's own. Behind objects the scene is taken from the nearest frames that show it,
//! found again as the camera moves ([`Warp`]): of a few of them the median. What no frame shows is a hole. Not in the
//! paper; Wexler, Shechtman and Irani (2004) complete videos in this way where the scene is rigid, and go on to invent
//! what was never seen, which is not done here.

use super::plate::{median_of, picture, sampled};
use crate::camera::{Camera, Warp};
use crate::image::{Frame, Plane};
use crate::trajectory::Trajectories;

/// Other frames that a pixel is the median of, at most.
const SAMPLES: usize = 5;
/// Other frames looked at, at most.
const MOST_FRAMES: usize = 64;
/// Pixels around an object that may show some of it.
const MARGIN: usize = 2;

/// What clean plates are made from, all at one size. Trajectories are the scene's where `is_scene` says so.
#[derive(Debug)]
pub(crate) struct PlateInput<'a> {
    pub(crate) frames: &'a [Frame],
    pub(crate) masks: &'a [Plane<u8>],
    pub(crate) camera: &'a Camera,
    pub(crate) tracks: &'a Trajectories,
    pub(crate) is_scene: Vec<bool>,
}

/// What is known of a pixel behind an object.
#[derive(Debug, Clone, Default)]
struct Hidden {
    at: (usize, usize),
    seen: Vec<[u8; 3]>,
}

/// Frame `t` without objects, RGBA: alpha is 0 in holes, and 255 elsewhere. There are as many masks as frames.
pub(crate) fn clean_plate(input: &PlateInput<'_>, t: usize) -> Plane<[u8; 4]> {
    let (frame, mask) = (&input.frames[t], &input.masks[t]);
    let (w, h) = (mask.width(), mask.height());
    let of_object = |i: usize| near_object(mask, i % w, i / w);
    let mut hidden: Vec<Hidden> =
        (0..w * h).filter(|&i| of_object(i)).map(|i| Hidden { at: (i % w, i / w), seen: Vec::new() }).collect();
    for s in others(t, input.frames.len()) {
        if hidden.iter().all(|pixel| pixel.seen.len() >= SAMPLES) {
            break;
        }
        look_at(input, t, s, &mut hidden);
    }
    let mut plate = picture(frame, 1).map(|[r, g, b]| [r, g, b, 255]);
    for Hidden { at: (x, y), seen } in hidden {
        let [r, g, b] = if seen.is_empty() { [0; 3] } else { median_of(&seen).0 };
        plate.row_mut(y)[x] = [r, g, b, if seen.is_empty() { 0 } else { 255 }];
    }
    plate
}

/// The other frames, nearest first.
fn others(t: usize, num_frames: usize) -> impl Iterator<Item = usize> {
    let step = num_frames.div_ceil(MOST_FRAMES).max(1);
    let pair = move |away: usize| [t.checked_sub(away), Some(t + away).filter(|&s| s < num_frames)];
    (step..num_frames).step_by(step).flat_map(pair).flatten()
}

/// Takes what frame `s` shows of pixels of frame `t`.
fn look_at(input: &PlateInput<'_>, t: usize, s: usize, hidden: &mut [Hidden]) {
    let (other, mask, tracks) = (picture(&input.frames[s], 1), &input.masks[s], input.tracks);
    let (right, bottom) = ((mask.width() - 1) as f32, (mask.height() - 1) as f32);
    let moves = *input.camera != Camera::Still;
    let common = tracks.alive(t).filter(|&(i, ..)| moves && input.is_scene.get(i) == Some(&true));
    let points = common.filter_map(|(i, x, y)| tracks.at(i, s).map(|to| ((x, y), to)));
    let warp = Warp::new((mask.width(), mask.height()), input.camera.between(t, s), points);
    for pixel in hidden.iter_mut().filter(|pixel| pixel.seen.len() < SAMPLES) {
        let (x, y) = warp.apply(pixel.at.0 as f32, pixel.at.1 as f32);
        let inside = x >= 0.0 && y >= 0.0 && x <= right && y <= bottom;
        if inside && !near_object(mask, (x + 0.5) as usize, (y + 0.5) as usize) {
            pixel.seen.push(sampled(&other, x, y));
        }
    }
}

/// Whether any pixel up to [`MARGIN`] away is an object's.
fn near_object(mask: &Plane<u8>, x: usize, y: usize) -> bool {
    let columns = x.saturating_sub(MARGIN)..(x + MARGIN + 1).min(mask.width());
    let mut rows = y.saturating_sub(MARGIN)..(y + MARGIN + 1).min(mask.height());
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

    /// Whether the object of frame `t` covers a pixel: it goes four pixels a frame to the right.
    fn inside(t: usize, x: usize, y: usize) -> bool {
        (10 + 4 * t..22 + 4 * t).contains(&x) && (8..24).contains(&y)
    }

    /// Eight frames of a scene that goes by `pan` pixels a frame to the left.
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
        clean_plate(&PlateInput { frames: &frames, masks: &masks, camera, tracks: &tracks, is_scene: Vec::new() }, t)
    }

    #[test]
    fn before_a_still_camera_it_is_the_scene() {
        let found = plate(0, &Camera::Still, 3);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let [r, g, b] = scene(x, y);
                assert_eq!(found[(x, y)], [r, g, b, 255], "{x} {y}");
            }
        }
    }

    #[test]
    fn before_a_camera_that_pans_it_is_the_scene_as_that_frame_sees_it() {
        let found = plate(2, &Camera::panning(-2.0, 8), 3);
        for y in 0..SIZE.1 {
            for x in 0..SIZE.0 {
                let [r, g, b] = scene(x + 6, y);
                assert_eq!(found[(x, y)], [r, g, b, 255], "{x} {y}");
            }
        }
    }

    #[test]
    fn what_no_frame_shows_is_a_hole_and_all_else_the_frame_itself() {
        let (frames, mut masks) = clip(0);
        // Something that never leaves its place.
        masks.iter_mut().for_each(|mask| mask.row_mut(35)[50] = 1);
        let (tracks, camera) = (Trajectories::empty(8, SIZE), Camera::Still);
        let input =
            PlateInput { frames: &frames, masks: &masks, camera: &camera, tracks: &tracks, is_scene: Vec::new() };
        let found = clean_plate(&input, 0);
        let holes: Vec<usize> = (0..found.data().len()).filter(|&i| found.data()[i][3] == 0).collect();
        assert_eq!(holes.len(), 25);
        assert!(holes.iter().all(|&i| found.data()[i] == [0; 4] && (i % SIZE.0).abs_diff(50) <= 2));
    }

    #[test]
    fn trajectories_say_where_the_scene_goes_besides_the_camera() {
        let (frames, masks) = clip(2);
        let mut tracks = Trajectories::empty(8, SIZE);
        for (x, y) in (0..16 * 10).map(|k| ((4 * (k % 16)) as f32, (4 * (k / 16)) as f32)) {
            tracks.push(0, (0..8).map(|t| (x - 2.0 * t as f32, y, 0.0)));
        }
        // A camera that is not known to pan.
        let camera = Camera::panning(0.0, 8);
        let is_scene = vec![true; tracks.len()];
        let input = PlateInput { frames: &frames, masks: &masks, camera: &camera, tracks: &tracks, is_scene };
        let found = clean_plate(&input, 3);
        let (mut right, mut all) = (0, 0);
        for (x, y) in (10..34).flat_map(|x| (8..24).map(move |y| (x, y))).filter(|&(x, y)| inside(3, x, y)) {
            all += 1;
            right += usize::from(found[(x, y)][0].abs_diff(scene(x + 6, y)[0]) < 80);
        }
        assert!(4 * right > 3 * all, "{right} of {all}");
    }
}
