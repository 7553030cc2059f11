//! Background plate of a still camera: the scene without its movers.
//!
//! Each pixel has the temporal median of its colour, and the median absolute deviation from it as its noise, which is high
//! where leaves move or water flows. A temporal median is the oldest of background models. Not in the paper. Cost:
//! O(pixels · sources). It fails where a mover covers a pixel for half of the clip.

use crate::image::{Frame, Plane};
use crate::order;
use crate::superpixel::dilate3x3;

/// Most frames that the plate is made from. Chosen by eye.
const MAX_SOURCES: usize = 25;
/// Fewest frames that must show a pixel of the scene. Chosen by eye.
const MIN_SOURCES: usize = 3;
/// Least standard deviation, in grey levels: the noise of rounding and compression. Chosen by eye.
const MIN_NOISE: f32 = 1.5;
/// Distance that is as likely an object's as the plate's, in standard deviations of the noise. Chosen by eye.
const NEUTRAL_DEVIATIONS: f32 = 5.0;
/// Standard deviation over median absolute deviation, of a normal distribution.
const SIGMA_PER_MAD: f32 = 1.4826;

/// A reduced frame, as one colour a pixel.
pub(crate) type Picture = Plane<[u8; 3]>;

/// Colour and noise of each pixel of the scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Plate {
    colour: Picture,
    /// Largest variance of the noise in 3×3 pixels, plus the variance of the whole clip, in grey levels squared.
    variance: Plane<f32>,
    /// `true` where enough frames show the scene.
    is_known: Plane<bool>,
}

/// Distance of a pixel where the plate is unknown.
pub(super) const UNKNOWN_DISTANCE: u8 = 255;

impl Plate {
    /// Builds the plate of frames of equal size; `None` without any. `is_hidden(t, x, y)` marks pixels that do not show the
    /// scene. With too few others the plate is unknown there, and its colour the median of all.
    pub(super) fn new(frames: &[Picture], is_hidden: impl Fn(usize, usize, usize) -> bool) -> Option<Self> {
        let size = frames.first()?;
        let count = MAX_SOURCES.min(frames.len());
        let sources: Vec<usize> = (0..count).map(|k| k * (frames.len() - 1) / (count - 1).max(1)).collect();
        let mut colour = Plane::filled(size.width(), size.height(), [0; 3]);
        let mut noise = Plane::filled(size.width(), size.height(), 0.0);
        let mut is_known = Plane::filled(size.width(), size.height(), true);
        let mut colours = Vec::with_capacity(count);
        for y in 0..size.height() {
            let rows: Vec<&[[u8; 3]]> = sources.iter().map(|&t| frames[t].row(y)).collect();
            let (median, mad) = median_row(&rows);
            for x in 0..size.width() {
                if !sources.iter().any(|&t| is_hidden(t, x, y)) {
                    (colour.row_mut(y)[x], noise.row_mut(y)[x]) = (median[x], SIGMA_PER_MAD * f32::from(mad[x]));
                    continue;
                }
                colours.clear();
                colours.extend(sources.iter().filter(|&&t| !is_hidden(t, x, y)).map(|&t| frames[t][(x, y)]));
                if colours.len() < MIN_SOURCES.min(count) {
                    is_known.row_mut(y)[x] = false;
                    colours.clear();
                    colours.extend(sources.iter().map(|&t| frames[t][(x, y)]));
                }
                (colour.row_mut(y)[x], noise.row_mut(y)[x]) = median_colour(&colours);
            }
        }
        let clip_noise = order::nth_smallest(noise.data(), noise.data().len() / 2).max(MIN_NOISE);
        // Beside small movers the plate is uncertain, too.
        let variance = dilate3x3(&noise).map(|n| n * n + clip_noise * clip_noise);
        Some(Self { colour, variance, is_known })
    }

    /// Computes the distance `d² / (d² + k² σ²)` of each pixel from the plate, in 254ths, with `k` of
    /// [`NEUTRAL_DEVIATIONS`]; [`UNKNOWN_DISTANCE`] where the plate is unknown.
    pub(super) fn distance(&self, picture: &Picture) -> Plane<u8> {
        let pixels = picture.data().iter().zip(self.colour.data());
        let differences: Vec<u8> = pixels.map(|(&a, &b)| max_channel_difference(a, b)).collect();
        let scaled = |(&difference, &variance): (&u8, &f32)| {
            let (difference, half) = (f32::from(difference), NEUTRAL_DEVIATIONS * NEUTRAL_DEVIATIONS * variance);
            // Below 255, and converted through i32, which vectorizes.
            (254.0 * difference * difference / (difference * difference + half)) as i32 as u8
        };
        let mut distance: Vec<u8> = differences.iter().zip(self.variance.data()).map(scaled).collect();
        for (distance, _) in distance.iter_mut().zip(self.is_known.data()).filter(|(_, is_known)| !**is_known) {
            *distance = UNKNOWN_DISTANCE;
        }
        Plane::from_vec(picture.width(), picture.height(), distance).unwrap_or_default()
    }
}

/// Largest difference of any channel.
pub(super) fn max_channel_difference(a: [u8; 3], b: [u8; 3]) -> u8 {
    a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])).max(a[2].abs_diff(b[2]))
}

/// Reduces a frame by `step`.
pub(super) fn reduce(frame: &Frame, step: usize) -> Picture {
    let small = frame.resized((frame.width() / step).max(1), (frame.height() / step).max(1));
    Plane::from_vec(small.width(), small.height(), small.rgb().as_chunks().0.to_vec()).unwrap_or_default()
}

/// Samples a colour bilinearly, to a sixteenth of a pixel.
pub(super) fn sample_colour(picture: &Picture, x: f32, y: f32) -> [u8; 3] {
    let (x, y) = ((16.0 * x) as u32, (16.0 * y) as u32);
    let (x0, y0) = ((x / 16) as usize, (y / 16) as usize);
    let (x1, y1) = ((x0 + 1).min(picture.width() - 1), (y0 + 1).min(picture.height() - 1));
    let (fx, fy) = (u64::from(x % 16), u64::from(y % 16));
    // All channels at once, in 16 bits each.
    let wide = |[r, g, b]: [u8; 3]| u64::from(r) | u64::from(g) << 16 | u64::from(b) << 32;
    let mix = |row: &[[u8; 3]]| (16 - fx) * wide(row[x0]) + fx * wide(row[x1]);
    let sum = (16 - fy) * mix(picture.row(y0)) + fy * mix(picture.row(y1));
    [0, 16, 32].map(|shift| (((sum >> shift & 0xffff) + 128) >> 8) as u8)
}

/// Median colour of each pixel of a row over all frames, and the median distance from it.
fn median_row(frames: &[&[[u8; 3]]]) -> (Vec<[u8; 3]>, Vec<u8>) {
    let flat: Vec<&[u8]> = frames.iter().map(|row| row.as_flattened()).collect();
    let median = medians(&flat).as_chunks().0.to_vec();
    let distances = |row: &&[[u8; 3]]| row.iter().zip(&median).map(|(&a, &b)| max_channel_difference(a, b)).collect();
    let distances: Vec<Vec<u8>> = frames.iter().map(distances).collect();
    let distances: Vec<&[u8]> = distances.iter().map(Vec::as_slice).collect();
    let mad = medians(&distances);
    (median, mad)
}

/// [`median`] over the rows, column by column: many at a time in vector registers.
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

/// Median of each channel of at most [`MAX_SOURCES`] colours, and the standard deviation by the median distance from it.
pub(super) fn median_colour(colours: &[[u8; 3]]) -> ([u8; 3], f32) {
    let mut values = [0; MAX_SOURCES];
    let values = &mut values[..colours.len()];
    let median_colour = std::array::from_fn(|c| {
        values.iter_mut().zip(colours).for_each(|(value, colour)| *value = colour[c]);
        median(values)
    });
    let differences = colours.iter().map(|&colour| max_channel_difference(colour, median_colour));
    values.iter_mut().zip(differences).for_each(|(value, difference)| *value = difference);
    (median_colour, SIGMA_PER_MAD * f32::from(median(values)))
}

/// Median of some values, the upper of two, bit by bit from the number of lesser values.
fn median(values: &[u8]) -> u8 {
    (0..8).rev().fold(0, |low, bit| {
        let middle = low | 1_u8 << bit;
        let less = values.iter().filter(|&&v| v < middle).count();
        if less <= values.len() / 2 { middle } else { low }
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
            let value = median(&values);
            values.sort_unstable();
            assert_eq!(value, values[n / 2], "{values:?}");
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
            reduce(&Frame::from_rgb(rgb, SIZE.0, SIZE.1).unwrap(), 1)
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
        assert!((0..SIZE.1).all(|y| (0..SIZE.0).all(|x| (distance[(x, y)] == UNKNOWN_DISTANCE) == (x < 10))));
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
                    let value = distance[(x, y)];
                    assert!(if inside { value > 200 } else { value < 60 }, "{value} at {x}, {y} of frame {t}");
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
