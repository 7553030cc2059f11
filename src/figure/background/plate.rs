//! The background plate of a still camera: the scene without what moves before it.
//!
//! Each pixel has the median of what frames all over the clip show there, and the median distance from that as its
//! noise: high where leaves move or water flows. A median over time is the oldest of background models.

use crate::image::{Frame, Plane};
use crate::order;

/// Frames that the plate is made of, at most.
const MOST_SOURCES: usize = 25;
/// Fewer sources than these say nothing of a pixel.
const ENOUGH: usize = 3;
/// Least noise, in grey levels: what rounding and compression leave.
const LEAST_NOISE: f32 = 1.5;
/// Distance that is as much object as background, in standard deviations of the noise.
const HALF: f32 = 5.0;
/// Standard deviation over median distance, of a normal distribution.
const DEVIATION: f32 = 1.4826;

/// A frame reduced, a colour a pixel.
pub(crate) type Picture = Plane<[u8; 3]>;

/// The plate.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plate {
    colour: Picture,
    /// Variance of the noise at each pixel and around it, with the variance over the clip, in grey levels squared.
    variance: Plane<f32>,
    /// Whether enough frames show the scene there.
    is_known: Plane<bool>,
}

/// Distance from a plate that is not known there.
pub(super) const UNKNOWN: u8 = 255;

impl Plate {
    /// The plate of frames of equal size, which may be reduced. `None` without any. `hidden` says which pixels of which
    /// frame show something else. Where too few are left the plate is not known; its colour is the median of all.
    pub(super) fn new(frames: &[Picture], hidden: impl Fn(usize, usize, usize) -> bool) -> Option<Self> {
        let size = frames.first()?;
        let count = MOST_SOURCES.min(frames.len());
        let sources: Vec<usize> = (0..count).map(|k| k * (frames.len() - 1) / (count - 1).max(1)).collect();
        let mut colour = Plane::filled(size.width(), size.height(), [0; 3]);
        let mut noise = Plane::filled(size.width(), size.height(), 0.0);
        let mut is_known = Plane::filled(size.width(), size.height(), true);
        let mut seen = Vec::with_capacity(count);
        for y in 0..size.height() {
            let rows: Vec<&[[u8; 3]]> = sources.iter().map(|&t| frames[t].row(y)).collect();
            let (middle, apart) = median_row(&rows);
            for x in 0..size.width() {
                if !sources.iter().any(|&t| hidden(t, x, y)) {
                    (colour.row_mut(y)[x], noise.row_mut(y)[x]) = (middle[x], DEVIATION * f32::from(apart[x]));
                    continue;
                }
                seen.clear();
                seen.extend(sources.iter().filter(|&&t| !hidden(t, x, y)).map(|&t| frames[t][(x, y)]));
                if seen.len() < ENOUGH.min(count) {
                    is_known.row_mut(y)[x] = false;
                    seen.clear();
                    seen.extend(sources.iter().map(|&t| frames[t][(x, y)]));
                }
                (colour.row_mut(y)[x], noise.row_mut(y)[x]) = median_of(&seen);
            }
        }
        let of_clip = clip_noise(&noise);
        let variance = largest_around(&noise).map(|n| n * n + of_clip * of_clip);
        Some(Self { colour, variance, is_known })
    }

    /// How far each pixel is from the plate, in 255ths: one half at [`HALF`] standard deviations of the noise there;
    /// [`UNKNOWN`] where the plate is not known.
    pub(super) fn distance(&self, picture: &Picture) -> Plane<u8> {
        let apart: Vec<u8> = picture.data().iter().zip(self.colour.data()).map(|(&a, &b)| apart(a, b)).collect();
        let of = |(&apart, &variance): (&u8, &f32)| {
            let (apart, half) = (f32::from(apart), HALF * HALF * variance);
            // Below 255, and cut as a wide number: many at a time.
            (254.0 * apart * apart / (apart * apart + half)) as i32 as u8
        };
        let mut distance: Vec<u8> = apart.iter().zip(self.variance.data()).map(of).collect();
        for (distance, _) in distance.iter_mut().zip(self.is_known.data()).filter(|(_, known)| !**known) {
            *distance = UNKNOWN;
        }
        Plane::from_vec(picture.width(), picture.height(), distance).unwrap_or_default()
    }
}

/// The largest difference of any channel.
pub(super) fn apart(a: [u8; 3], b: [u8; 3]) -> u8 {
    a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])).max(a[2].abs_diff(b[2]))
}

/// A frame reduced by `step`.
pub(super) fn picture(frame: &Frame, step: usize) -> Picture {
    let small = frame.resized((frame.width() / step).max(1), (frame.height() / step).max(1));
    let at = |x: usize, y: usize| 3 * (y * small.width() + x);
    Plane::from_fn(small.width(), small.height(), |x, y| std::array::from_fn(|c| small.rgb()[at(x, y) + c]))
}

/// The colour between pixels, to a sixteenth of a pixel.
pub(super) fn sampled(picture: &Picture, x: f32, y: f32) -> [u8; 3] {
    let (x, y) = ((16.0 * x) as u32, (16.0 * y) as u32);
    let (x0, y0) = ((x / 16) as usize, (y / 16) as usize);
    let (x1, y1) = ((x0 + 1).min(picture.width() - 1), (y0 + 1).min(picture.height() - 1));
    let (fx, fy) = (x % 16, y % 16);
    let (above, below) = (picture.row(y0), picture.row(y1));
    std::array::from_fn(|k| {
        let mix = |row: &[[u8; 3]]| (16 - fx) * u32::from(row[x0][k]) + fx * u32::from(row[x1][k]);
        (((16 - fy) * mix(above) + fy * mix(below) + 128) / 256) as u8
    })
}

/// For each pixel of a row the median of each channel over all frames, and the median distance from it.
fn median_row(frames: &[&[[u8; 3]]]) -> (Vec<[u8; 3]>, Vec<u8>) {
    let flat: Vec<&[u8]> = frames.iter().map(|row| row.as_flattened()).collect();
    let middle = medians(&flat).as_chunks().0.to_vec();
    let apart_from = |row: &&[[u8; 3]]| row.iter().zip(&middle).map(|(&a, &b)| apart(a, b)).collect();
    let distances: Vec<Vec<u8>> = frames.iter().map(apart_from).collect();
    let distances: Vec<&[u8]> = distances.iter().map(Vec::as_slice).collect();
    let noise = medians(&distances);
    (middle, noise)
}

/// [`median`] of what all rows have at a place, place by place: many at a time in vector registers.
fn medians(rows: &[&[u8]]) -> Vec<u8> {
    let half = (rows.len() / 2) as u8;
    let mut low = vec![0; rows.first().map_or(0, |row| row.len())];
    let mut less = vec![0_u8; low.len()];
    for bit in (0..8).rev().map(|bit| 1_u8 << bit) {
        less.fill(0);
        for row in rows {
            for ((less, low), value) in less.iter_mut().zip(&low).zip(*row) {
                *less += u8::from(*value < low | bit);
            }
        }
        for (low, less) in low.iter_mut().zip(&less) {
            *low |= if *less <= half { bit } else { 0 };
        }
    }
    low
}

/// The median of each channel of at most [`MOST_SOURCES`] colours, and the standard deviation that the median distance
/// from it stands for.
pub(super) fn median_of(seen: &[[u8; 3]]) -> ([u8; 3], f32) {
    let mut line = [0; MOST_SOURCES];
    let line = &mut line[..seen.len()];
    let colour = std::array::from_fn(|c| {
        line.iter_mut().zip(seen).for_each(|(value, own)| *value = own[c]);
        median(line)
    });
    line.iter_mut().zip(seen).for_each(|(value, &own)| *value = apart(own, colour));
    (colour, DEVIATION * f32::from(median(line)))
}

/// The middle one of all values by order, the upper of two: bit by bit, by how many are less.
fn median(values: &[u8]) -> u8 {
    (0..8).rev().fold(0, |low, bit| {
        let middle = low | 1_u8 << bit;
        let less = values.iter().filter(|&&v| v < middle).count();
        if less <= values.len() / 2 { middle } else { low }
    })
}

/// The noise of the pixel in the middle, when all are ordered by it.
fn clip_noise(noise: &Plane<f32>) -> f32 {
    order::nth_smallest(noise.data(), noise.data().len() / 2).max(LEAST_NOISE)
}

/// The largest value of the 3×3 pixels around each: beside what moves a little the plate is not sure either.
fn largest_around(plane: &Plane<f32>) -> Plane<f32> {
    let around = |v: usize, side: usize| v.saturating_sub(1)..(v + 2).min(side);
    Plane::from_fn(plane.width(), plane.height(), |x, y| {
        let rows = around(y, plane.height()).map(|y| &plane.row(y)[around(x, plane.width())]);
        rows.flatten().copied().fold(0.0, f32::max)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    const SIZE: (usize, usize) = (48, 32);

    #[test]
    fn the_median_is_that_of_sorted_values() {
        let mut rng = Rng::for_stage(5, "median");
        for n in 1..60 {
            let mut values: Vec<u8> = (0..n).map(|_| rng.below(if n % 3 == 0 { 4 } else { 256 }) as u8).collect();
            let found = median(&values);
            values.sort_unstable();
            assert_eq!(found, values[n / 2], "{values:?}");
        }
    }

    /// A scene of random colours with a square that moves before it, and noise of up to two grey levels.
    fn frames() -> (Vec<u8>, Vec<Picture>) {
        let mut rng = Rng::for_stage(7, "plate");
        let scene: Vec<u8> = (0..3 * SIZE.0 * SIZE.1).map(|_| 20 + rng.below(100) as u8).collect();
        let frame = |t: usize| {
            let mut rgb = scene.clone();
            for (i, value) in rgb.iter_mut().enumerate() {
                let (x, y) = (i / 3 % SIZE.0, i / 3 / SIZE.0);
                let inside = (4 * t..4 * t + 8).contains(&x) && (10..18).contains(&y);
                *value = if inside { 220 } else { *value + rng.below(3) as u8 };
            }
            picture(&Frame::from_rgb(rgb, SIZE.0, SIZE.1).unwrap(), 1)
        };
        let frames = (0..10).map(frame).collect();
        (scene, frames)
    }

    #[test]
    fn the_plate_is_the_scene_without_what_moves() {
        let (scene, frames) = frames();
        let plate = Plate::new(&frames, |_, _, _| false).unwrap();
        let furthest = plate.colour.data().iter().flatten().zip(&scene).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(furthest <= Some(2), "{furthest:?}");
    }

    #[test]
    fn where_too_few_frames_show_the_scene_it_is_not_known() {
        let (_, frames) = frames();
        let plate = Plate::new(&frames, |t, x, _| x < 10 && t > 1).unwrap();
        let distance = plate.distance(&frames[0]);
        assert!((0..SIZE.1).all(|y| (0..SIZE.0).all(|x| (distance[(x, y)] == UNKNOWN) == (x < 10))));
        // All that there is of a clip of two frames is enough.
        let plate = Plate::new(&frames[..2], |_, _, _| false).unwrap();
        assert!(plate.is_known.data().iter().all(|&known| known));
    }

    #[test]
    fn what_moves_is_far_from_it_and_what_does_not_is_near() {
        let (_, frames) = frames();
        let plate = Plate::new(&frames, |_, _, _| false).unwrap();
        for (t, frame) in frames.iter().enumerate() {
            let distance = plate.distance(frame);
            for y in 0..SIZE.1 {
                for x in 0..SIZE.0 {
                    let inside = (4 * t..4 * t + 8).contains(&x) && (10..18).contains(&y);
                    let found = distance[(x, y)];
                    assert!(if inside { found > 200 } else { found < 60 }, "{found} at {x}, {y} of frame {t}");
                }
            }
        }
    }

    #[test]
    fn any_number_of_frames_is_enough() {
        let (_, frames) = frames();
        for count in 1..=3 {
            assert_eq!(Plate::new(&frames[..count], |_, _, _| false).unwrap().distance(&frames[0]).width(), SIZE.0);
        }
        assert_eq!(Plate::new(&[], |_, _, _| false), None);
    }
}
