//! Enlargement of masks to the size of the source, with borders and opacity to the pixel.
//!
//! In: a mask and its picture, at least as large. Out: [`EnlargedMask`], a label and an opacity for each pixel of the picture.
//!
//! 1. From coarse to fine, doubling the size until it is the picture's: every pixel takes the label with the largest bilinear
//!    weight among its four neighbours in the smaller mask.
//! 2. At each size borders move to colour edges of the picture reduced to that size: the energy of [`super::refine`], in a narrow
//!    band. This is done block by block, which bounds memory.
//! 3. Opacity, in a band around the borders of the chosen objects (`opacity`).
//!
//! It fails where an object has the colours of its surroundings, and loses parts thinner than a pixel of the mask. Not in the
//! paper.

use super::RefineParams;
use super::opacity::opacity;
use super::refine::{Crop, TILE_PX, label_changes};
use crate::Error;
use crate::image::{Frame, Picture, Plane};

/// Parameters of the refinement at each size; chosen by eye. Doubling leaves an error of one or two pixels, and masks may be off by
/// as much; larger moves took good masks off their borders.
const REFINE_PARAMS: RefineParams =
    RefineParams { band: 4, colour_weight: 0.5, displacement_weight: 4.0, smoothness: 2.0, min_part: 0.0 };
/// σ² of the contrast term, in units of the mean squared difference in the band; chosen by eye, less than for frames, since pictures
/// at their full size have softer edges than reduced ones.
const CONTRAST_VARIANCE: f32 = 0.3;
/// Side of the blocks that are refined at once; chosen by eye.
const BLOCK_PX: usize = 20 * TILE_PX;
/// Largest difference of the mask's sides from the picture's shape, in pixels of the mask: sizes are to_steps when frames are
/// reduced.
const SHAPE_TOLERANCE_PX: f64 = 2.0;

/// A mask at the size of its picture.
#[derive(Debug, Clone, PartialEq)]
pub struct EnlargedMask {
    /// The label of each pixel.
    pub labels: Plane<u8>,
    /// The opacity of the chosen objects at each pixel, 0 to 255; at least 128 exactly where `labels` is one of them.
    pub alpha: Plane<u8>,
}

/// Enlarges a mask to the size of `picture`, with borders at colour edges of the picture. The opacity is computed for the
/// labels for which `is_chosen` returns true.
///
/// # Errors
/// [`Error::Param`] if the mask is empty, larger than the picture, or of another shape.
///
/// # Examples
/// The mask of a disc, at a quarter of the picture's width, is enlarged to a round disc.
///
/// ```
/// use tracecut::image::{Frame, Plane};
/// use tracecut::mask::enlarge;
///
/// let inside = |x: usize, y: usize, r: f32| (x as f32 - 63.5).hypot(y as f32 - 47.5) < r;
/// let rgb = (0..128 * 96).flat_map(|p| if inside(p % 128, p / 128, 30.0) { [150, 90, 60] } else { [60, 90, 150] });
/// let picture = Frame::from_rgb(rgb.collect(), 128, 96)?;
/// let mask = Plane::from_fn(32, 24, |x, y| u8::from(inside(4 * x + 2, 4 * y + 2, 30.0)));
/// let enlarged = enlarge(&mask, &picture, |label| label == 1)?;
/// assert_eq!(enlarged.labels, Plane::from_fn(128, 96, |x, y| u8::from(inside(x, y, 30.0))));
/// assert_eq!((enlarged.alpha[(64, 48)], enlarged.alpha[(10, 10)]), (255, 0));
/// # Ok::<(), tracecut::Error>(())
/// ```
pub fn enlarge(mask: &Plane<u8>, picture: &Frame, is_chosen: impl Fn(u8) -> bool) -> Result<EnlargedMask, Error> {
    enlarge_to(mask, picture.picture(), is_chosen)
}

/// Enlarges a mask as [`enlarge`] does.
///
/// # Errors
/// As of [`enlarge`].
pub(crate) fn enlarge_to<const CHANNELS: usize>(
    mask: &Plane<u8>,
    picture: Picture<'_, CHANNELS>,
    is_chosen: impl Fn(u8) -> bool,
) -> Result<EnlargedMask, Error> {
    let size = (picture.width, picture.height);
    check((mask.width(), mask.height()), size)?;
    let mut labels = mask.clone();
    while (labels.width(), labels.height()) != size {
        let doubled = (2 * labels.width(), 2 * labels.height());
        let is_last = doubled.0 >= size.0 || doubled.1 >= size.1;
        let (width, height) = if is_last { size } else { doubled };
        labels = refine_borders(upscale(&labels, width, height), |&Crop { left, top, width: w, height: h }| {
            let (columns, rows) = (left..left + w, top..top + h);
            if is_last { picture.part(columns, rows) } else { picture.reduced((width, height), columns, rows) }
        });
    }
    let is_chosen: [bool; 256] = std::array::from_fn(|label| is_chosen(label as u8));
    let alpha = opacity(&map_labels(&labels, |label| is_chosen[usize::from(label)]), picture);
    Ok(EnlargedMask { labels, alpha })
}

/// Pixels that are looked at together: most of them have one label.
const CHUNK_PX: usize = 32;

/// Returns a plane with `f` applied to every label, faster than [`Plane::map`] where neighbours are equal.
fn map_labels<T: Copy>(labels: &Plane<u8>, f: impl Fn(u8) -> T) -> Plane<T> {
    let mut mapped = Vec::with_capacity(labels.data().len());
    for chunk in labels.data().chunks(CHUNK_PX) {
        if chunk.iter().fold(false, |differs, &label| differs | (label != chunk[0])) {
            mapped.extend(chunk.iter().map(|&label| f(label)));
        } else {
            mapped.resize(mapped.len() + chunk.len(), f(chunk[0]));
        }
    }
    Plane::from_vec(labels.width(), labels.height(), mapped).expect("as many values as labels")
}

fn check((width, height): (usize, usize), size: (usize, usize)) -> Result<(), Error> {
    let illegal =
        |expected: String| Err(Error::Param { name: "mask".to_owned(), value: format!("{width}x{height}"), expected });
    if width == 0 || height == 0 {
        return illegal("at least one pixel".to_owned());
    }
    if width > size.0 || height > size.1 {
        return illegal(format!("at most the picture's size, {}x{}", size.0, size.1));
    }
    // The difference of each side from the shape of the picture; one of them may be large if the mask is long and narrow.
    let (w, h, pw, ph) = (width as f64, height as f64, size.0 as f64, size.1 as f64);
    if (h - w * ph / pw).abs() > SHAPE_TOLERANCE_PX && (w - h * pw / ph).abs() > SHAPE_TOLERANCE_PX {
        return illegal(format!("the shape of the picture, {}x{}", size.0, size.1));
    }
    Ok(())
}

/// Step 1. Weights are integers, so that a mirrored mask gives the mirrored result. The lowest label of equal weight wins.
fn upscale(mask: &Plane<u8>, width: usize, height: usize) -> Plane<u8> {
    let columns = gaps(mask.width(), width);
    // The first pixel in each gap between columns of the mask, and the end of the last.
    let first: Vec<usize> = (0..mask.width() + 2).map(|gap| columns.partition_point(|&(of, _)| of < gap)).collect();
    let mut large = Plane::filled(width, height, 0);
    let mut is_mixed = vec![false; mask.width() + 1];
    for (y, (gap, down)) in gaps(mask.height(), height).into_iter().enumerate() {
        let (above, below) = (mask.row(gap.saturating_sub(1)), mask.row(gap.min(mask.height() - 1)));
        let pairs = above.windows(2).zip(below.windows(2));
        for (is_mixed, (a, b)) in is_mixed[1..].iter_mut().zip(pairs) {
            *is_mixed = (a[0] != a[1]) | (a[0] != b[0]) | (a[0] != b[1]);
        }
        let last = mask.width() - 1;
        (is_mixed[0], is_mixed[last + 1]) = (above[0] != below[0], above[last] != below[last]);
        let row = large.row_mut(y);
        let mut gap = 0;
        while gap <= last + 1 {
            let pure = is_mixed[gap..].iter().position(|&is_mixed| is_mixed).unwrap_or(last + 2 - gap);
            let (left, right) = (gap.saturating_sub(1), gap.min(last));
            row[first[gap]..first[gap + pure]].fill(above[left]);
            gap += pure;
            if pure > 0 || gap > last + 1 {
                continue;
            }
            let corners = [above[left], above[right], below[left], below[right]];
            for x in first[gap]..first[gap + 1] {
                let (right_weight, up) = (columns[x].1, 2 * height as u64 - down);
                let left_weight = 2 * width as u64 - right_weight;
                let weights = [up * left_weight, up * right_weight, down * left_weight, down * right_weight];
                let weight = |label: u8| (0..4).filter(|&k| corners[k] == label).map(|k| weights[k]).sum::<u64>();
                let best = corners.into_iter().max_by_key(|&label| (weight(label), std::cmp::Reverse(label)));
                row[x] = best.unwrap_or(corners[0]);
            }
            gap += 1;
        }
    }
    large
}

/// Returns, for each of `to` pixels over `from` pixels, the gap between two of these that its centre lies in (0 before the first),
/// and the weight of the second, of 2 `to` in total.
fn gaps(from: usize, to: usize) -> Vec<(usize, u64)> {
    let gap = |pixel: usize| {
        // The centre in units of 1 / (2 `to`) pixels, from the middle of the pixel before the first.
        let centre = (2 * pixel + 1) * from + to;
        (centre / (2 * to), (centre % (2 * to)) as u64)
    };
    (0..to).map(gap).collect()
}

/// Step 2. `picture` returns a part of the picture at the size of the mask.
fn refine_borders(mut mask: Plane<u8>, picture: impl Fn(&Crop) -> Frame) -> Plane<u8> {
    let (w, h) = (mask.width(), mask.height());
    let mut changes = Vec::new();
    for top in (0..h).step_by(BLOCK_PX) {
        for left in (0..w).step_by(BLOCK_PX) {
            // One more tile on each side, so that neighbouring blocks see the same colours.
            let (x, y) = (left.saturating_sub(TILE_PX), top.saturating_sub(TILE_PX));
            let (width, height) = ((left + BLOCK_PX + TILE_PX).min(w) - x, (top + BLOCK_PX + TILE_PX).min(h) - y);
            let block = Crop { left: x, top: y, width, height };
            let Some(crop) = block.around_borders(&mask, REFINE_PARAMS.band as usize) else { continue };
            // Every border may move.
            let before = Plane::filled(crop.width, crop.height, 0);
            let labels = label_changes(&crop.plane(&mask), &before, &picture(&crop), &REFINE_PARAMS, CONTRAST_VARIANCE);
            let is_inside =
                |(u, v): (usize, usize)| (left..left + BLOCK_PX).contains(&u) && (top..top + BLOCK_PX).contains(&v);
            changes.extend(
                labels.into_iter().map(|(p, label)| (crop.position(p), label)).filter(|&(at, _)| is_inside(at)),
            );
        }
    }
    changes.into_iter().for_each(|(at, label)| mask[at] = label);
    mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// A picture of `colours` mixed as `share` says of each pixel, with noise of that number of levels to either side.
    fn mixed(size: (usize, usize), noise: usize, share: impl Fn(usize, usize) -> f32) -> Frame {
        let mut rng = Rng::for_stage(3, "enlarge");
        let (outside, inside) = ([60.0_f32, 90.0, 50.0], [170.0_f32, 110.0, 120.0]);
        let mut rgb = Vec::new();
        for p in 0..size.0 * size.1 {
            let share = share(p % size.0, p / size.0);
            for c in 0..3 {
                let level = outside[c] + share * (inside[c] - outside[c]) + 0.5;
                rgb.push((level as i32 + rng.below(2 * noise + 1) as i32 - noise as i32).clamp(0, 255) as u8);
            }
        }
        Frame::from_rgb(rgb, size.0, size.1).unwrap()
    }

    /// How far a pixel is inside a disc whose rim is `width` pixels wide, 0 to 1.
    fn disc((cx, cy): (f32, f32), r: f32, width: f32) -> impl Fn(usize, usize) -> f32 {
        move |x, y| (0.5 + (r - (x as f32 - cx).hypot(y as f32 - cy)) / width).clamp(0.0, 1.0)
    }

    /// A mask as large as a part of the picture, by the share at the middle of its pixels.
    fn reduced(size: (usize, usize), by: usize, share: impl Fn(usize, usize) -> f32) -> Plane<u8> {
        Plane::from_fn(size.0 / by, size.1 / by, |x, y| u8::from(share(by * x + by / 2, by * y + by / 2) >= 0.5))
    }

    fn wrong(labels: &Plane<u8>, truth: &Plane<u8>) -> usize {
        labels.data().iter().zip(truth.data()).filter(|(a, b)| a != b).count()
    }

    fn nearest(mask: &Plane<u8>, (w, h): (usize, usize)) -> Plane<u8> {
        Plane::from_fn(w, h, |x, y| mask[(x * mask.width() / w, y * mask.height() / h)])
    }

    #[test]
    fn a_mask_of_the_size_of_its_picture_keeps_its_labels_and_on_a_flat_one_is_all_or_nothing() {
        let mask = Plane::from_fn(50, 40, |x, y| u8::from(x > 20) + 2 * u8::from(y > 30));
        let flat = mixed((50, 40), 0, |_, _| 0.0);
        let enlarged = enlarge(&mask, &flat, |label| label > 1).unwrap();
        assert_eq!(enlarged.labels, mask);
        assert_eq!(enlarged.alpha, mask.map(|label| if label > 1 { 255 } else { 0 }));
        let noisy = mixed((50, 40), 40, |_, _| 0.0);
        assert_eq!(enlarge(&mask, &noisy, |label| label > 1).unwrap().labels, mask);
    }

    #[test]
    fn borders_come_to_the_pixel_at_any_factor() {
        for (by, size) in [(2, (160, 120)), (3, (240, 180)), (4, (240, 180)), (7, (301, 210))] {
            let share = disc((size.0 as f32 * 0.48, size.1 as f32 * 0.53), size.1 as f32 * 0.31, 0.01);
            let truth = Plane::from_fn(size.0, size.1, |x, y| u8::from(share(x, y) >= 0.5));
            let mask = reduced(size, by, &share);
            let enlarged = enlarge(&mask, &mixed(size, 10, &share), |_| true).unwrap().labels;
            let (rough, fine) = (wrong(&nearest(&mask, size), &truth), wrong(&enlarged, &truth));
            assert!(10 * fine <= rough, "factor {by}: {fine} pixels wrong, {rough} of the nearest");
        }
    }

    #[test]
    fn opacity_is_that_of_a_soft_border_and_a_hard_one_stays_hard() {
        let size = (300, 200);
        for width in [0.01, 1.0, 3.0, 6.0] {
            let share = disc((150.3, 99.6), 61.4, width);
            let truth = |p: usize| share(p % size.0, p / size.0);
            let picture = mixed(size, 6, &share);
            let enlarged = enlarge(&reduced(size, 2, &share), &picture, |label| label == 1).unwrap();
            let error = |alpha: &dyn Fn(usize) -> f32| {
                (0..size.0 * size.1).map(|p| (alpha(p) - truth(p)).abs()).sum::<f32>() / (385.0 * width.max(1.0))
            };
            let soft = error(&|p| f32::from(enlarged.alpha.data()[p]) / 255.0);
            let hard = error(&|p| f32::from(enlarged.labels.data()[p]));
            if width < 0.1 {
                assert!(soft < 0.09, "{soft} at a hard border");
            } else {
                assert!(soft < 0.75 * hard, "{soft} at a border of {width} pixels, {hard} without opacity");
            }
        }
    }

    #[test]
    fn labels_are_those_of_the_mask_and_opacity_goes_with_them() {
        let mut rng = Rng::for_stage(4, "enlarge");
        let blocks: Vec<u8> = (0..12).map(|_| [0, 1, 2, 7][rng.below(4)]).collect();
        let mask = Plane::from_fn(64, 48, |x, y| blocks[x / 16 + 4 * (y / 16)]);
        let size = (160, 120);
        let picture = mixed(size, 127, |_, _| 0.5);
        let enlarged = enlarge(&mask, &picture, |label| label == 1 || label == 7).unwrap();
        let mut soft = 0;
        for y in 0..size.1 {
            for x in 0..size.0 {
                let (label, alpha) = (enlarged.labels[(x, y)], enlarged.alpha[(x, y)]);
                let chosen = label == 1 || label == 7;
                assert!(blocks.contains(&label));
                assert_eq!(chosen, alpha >= 128, "{alpha} at {x}, {y}, label {label}");
                // The radius of the windows is three, and two of them meet.
                let around = || {
                    (y.saturating_sub(6)..(y + 7).min(size.1))
                        .flat_map(move |v| (x.saturating_sub(6)..(x + 7).min(size.0)).map(move |u| (u, v)))
                };
                if around().all(|place| [1, 7].contains(&enlarged.labels[place]) == chosen) {
                    assert_eq!(alpha, if chosen { 255 } else { 0 }, "at {x}, {y}");
                } else {
                    soft += usize::from(alpha != 0 && alpha != 255);
                }
            }
        }
        assert!(soft > 0);
        assert_eq!(enlarge(&mask, &picture, |_| false).unwrap().alpha, Plane::filled(size.0, size.1, 0));
    }

    #[test]
    fn the_vote_is_that_of_bilinear_interpolation_and_goes_with_mirrors() {
        let mut rng = Rng::for_stage(5, "enlarge");
        let mask = Plane::from_fn(11, 7, |_, _| rng.below(3) as u8);
        for (w, h) in [(22, 14), (19, 12), (60, 39), (11, 7)] {
            let large = upscale(&mask, w, h);
            for y in 0..h {
                for x in 0..w {
                    let at = |v: usize, of: usize, to: usize| (v as f64 + 0.5) * of as f64 / to as f64 - 0.5;
                    let (u, v) = (at(x, 11, w), at(y, 7, h));
                    let clamped = |v: f64, end: usize| v.clamp(0.0, end as f64 - 1.0) as usize;
                    let mut weights = [0.0; 3];
                    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                        let weight = (1.0 - (u - (u.floor() + dx)).abs()) * (1.0 - (v - (v.floor() + dy)).abs());
                        weights[usize::from(mask[(clamped(u.floor() + dx, 11), clamped(v.floor() + dy, 7))])] += weight;
                    }
                    let own = weights[usize::from(large[(x, y)])];
                    assert!(weights.iter().all(|&other| other <= own + 1e-9), "{weights:?} at {x}, {y}");
                }
            }
            let mirrored = |plane: &Plane<u8>| {
                let (w, h) = (plane.width(), plane.height());
                Plane::from_fn(w, h, |x, y| plane[(w - 1 - x, h - 1 - y)])
            };
            assert_eq!(upscale(&mirrored(&mask), w, h), mirrored(&large));
        }
    }

    #[test]
    fn borders_that_run_through_several_blocks_are_those_of_the_whole_picture() {
        let size = (BLOCK_PX + 200, BLOCK_PX + 120);
        let share = |x: usize, y: usize| u8::from(x + y / 3 > BLOCK_PX + 60) as f32;
        let truth = Plane::from_fn(size.0, size.1, |x, y| share(x, y) as u8);
        let mask = Plane::from_fn(size.0, size.1, |x, y| truth[((x + 2).min(size.0 - 1), y)]);
        let picture = mixed(size, 12, share);
        let moved = refine_borders(mask.clone(), |crop| crop.frame(&picture));
        assert!(wrong(&mask, &truth) > 1000);
        assert!(wrong(&moved, &truth) < 20, "{} wrong", wrong(&moved, &truth));
    }

    #[test]
    fn mirrored_pictures_have_nearly_mirrored_masks() {
        let size = (160, 120);
        let share = disc((71.0, 65.0), 40.0, 2.0);
        let (mask, picture) = (reduced(size, 2, &share), mixed(size, 20, &share));
        let mirrored = |x: usize| size.0 - 1 - x;
        let rgb = (0..size.0 * size.1).flat_map(|p| {
            let at = 3 * (p / size.0 * size.0 + mirrored(p % size.0));
            [picture.rgb()[at], picture.rgb()[at + 1], picture.rgb()[at + 2]]
        });
        let other = Frame::from_rgb(rgb.collect(), size.0, size.1).unwrap();
        let mask_of_other = Plane::from_fn(80, 60, |x, y| mask[(79 - x, y)]);
        let (one, two) =
            (enlarge(&mask, &picture, |_| true).unwrap(), enlarge(&mask_of_other, &other, |_| true).unwrap());
        let back = Plane::from_fn(size.0, size.1, |x, y| two.labels[(mirrored(x), y)]);
        // Colours are gathered in tiles that begin on the left.
        assert!(wrong(&one.labels, &back) <= 12, "{}", wrong(&one.labels, &back));
    }

    #[test]
    fn masks_that_cannot_belong_to_the_picture_are_refused_by_name_and_size() {
        let picture = mixed((40, 30), 0, |_, _| 0.0);
        let illegal = |w: usize, h: usize| enlarge(&Plane::filled(w, h, 0), &picture, |_| true).unwrap_err();
        let message = |w: usize, h: usize| illegal(w, h).to_string();
        assert_eq!(message(41, 30), "mask = 41x30 (expected at most the picture's size, 40x30)");
        assert_eq!(message(30, 40), "mask = 30x40 (expected at most the picture's size, 40x30)");
        assert_eq!(message(20, 9), "mask = 20x9 (expected the shape of the picture, 40x30)");
        assert_eq!(message(0, 0), "mask = 0x0 (expected at least one pixel)");
        assert_eq!(illegal(20, 9).code(), "param");
        // Rounded sizes are none of these.
        for (w, h) in [(20, 15), (13, 10), (13, 9), (1, 1), (39, 30)] {
            let enlarged = enlarge(&Plane::filled(w, h, 3), &picture, |_| true).unwrap();
            assert_eq!(enlarged.labels, Plane::filled(40, 30, 3));
            assert_eq!(enlarged.alpha, Plane::filled(40, 30, 255));
        }
    }

    #[test]
    fn lines_and_single_pixels_have_masks_too() {
        for (w, h) in [(1, 1), (1, 9), (9, 1), (2, 3)] {
            let picture = mixed((3 * w, 3 * h), 90, |_, _| 0.5);
            let mask = Plane::from_fn(w, h, |x, y| ((x + y) % 2) as u8);
            let enlarged = enlarge(&mask, &picture, |label| label == 1).unwrap();
            assert_eq!((enlarged.alpha.width(), enlarged.labels.height()), (3 * w, 3 * h));
        }
    }
}
