//! Masks of frames that were not segmented, from those of the frames beside them.
//!
//! **In:** two consecutive segmented frames, their masks and the flow between them, and the frame between. **Out:** the mask
//! of that frame. Each of its pixels lies half of the flow after a pixel of the first frame and before one of the second;
//! where their labels differ, the one of the more similar colour counts.

use tracecut::flow::FlowField;
use tracecut::image::{Frame, Plane};

/// The flow at a pixel of the frame between is looked up this many times; chosen by eye.
const LOOKUPS: usize = 2;

/// A segmented frame.
#[derive(Debug, Clone, Copy)]
pub struct Segmented<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// Its mask, of equal size.
    pub mask: &'a Plane<u8>,
}

/// Returns the mask of the frame `between` two segmented frames of its size. `flow` leads from the first to the second, in
/// their pixels, on a grid of any size.
#[must_use]
pub fn mask_between(first: Segmented<'_>, between: &Frame, second: Segmented<'_>, flow: &FlowField) -> Plane<u8> {
    let (width, height) = (between.width(), between.height());
    let pixel = |x: f32, y: f32| {
        let nearest = |v: f32, size: usize| v.round().clamp(0.0, (size - 1) as f32) as usize;
        (nearest(x, width), nearest(y, height))
    };
    let half_flow = |(x, y): (usize, usize)| {
        let at = (x * flow.u.width() / width, y * flow.u.height() / height);
        (0.5 * flow.u[at], 0.5 * flow.v[at])
    };
    let colour = |frame: &Frame, (x, y): (usize, usize)| {
        let at = 3 * (y * width + x);
        [0, 1, 2].map(|c| i32::from(frame.rgb()[at + c]))
    };
    let label = |x: usize, y: usize| {
        let (px, py) = (x as f32, y as f32);
        let (u, v) = (0..LOOKUPS).fold(half_flow((x, y)), |(u, v), _| half_flow(pixel(px - u, py - v)));
        let places = [(first, pixel(px - u, py - v)), (second, pixel(px + u, py + v))];
        let target = colour(between, (x, y));
        let difference = |&(source, at): &(Segmented<'_>, (usize, usize))| -> i32 {
            colour(source.frame, at).into_iter().zip(target).map(|(a, b)| (a - b).pow(2)).sum()
        };
        places.iter().min_by_key(|place| difference(place)).map_or(0, |&(source, at)| source.mask[at])
    };
    Plane::from_fn(width, height, label)
}

/// Returns the length that `share` of the displacements of a field do not exceed, in its units.
#[must_use]
pub fn displacement_quantile(flow: &FlowField, share: f64) -> f32 {
    let mut lengths: Vec<f32> = flow.u.data().iter().zip(flow.v.data()).map(|(u, v)| u.hypot(*v)).collect();
    let index = (share * lengths.len().saturating_sub(1) as f64) as usize;
    if lengths.is_empty() { 0.0 } else { *lengths.select_nth_unstable_by(index, f32::total_cmp).1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (40, 24);

    /// A bright square whose left side is at `left`, and its mask.
    fn square(left: usize) -> (Frame, Plane<u8>) {
        let mask =
            Plane::from_fn(SIZE.0, SIZE.1, |x, y| u8::from((left..left + 10).contains(&x) && (6..16).contains(&y)));
        let rgb = mask.data().iter().flat_map(|&label| [60 + 120 * label; 3]).collect();
        (Frame::from_rgb(rgb, SIZE.0, SIZE.1).unwrap(), mask)
    }

    #[test]
    fn a_moving_square_has_its_mask_between() {
        let [first, between, second] = [10, 11, 12].map(square);
        let segmented = |(frame, mask)| Segmented { frame, mask };
        // The flow of the square reaches a little beyond it.
        let moves = |x: usize, y: usize| if (8..24).contains(&x) && (4..18).contains(&y) { 2.0 } else { 0.0 };
        let flow = FlowField { u: Plane::from_fn(SIZE.0, SIZE.1, moves), v: Plane::filled(SIZE.0, SIZE.1, 0.0) };
        let [before, after] = [&first, &second].map(|(frame, mask)| segmented((frame, mask)));
        assert_eq!(mask_between(before, &between.0, after, &flow), between.1);
        assert_eq!((displacement_quantile(&flow, 0.5), displacement_quantile(&flow, 0.99)), (0.0, 2.0));
        let still = FlowField { u: Plane::filled(20, 12, 0.0), v: Plane::filled(20, 12, 0.0) };
        assert_eq!(mask_between(before, &first.0, before, &still), first.1);
    }
}
