//! Loose parts of objects: crumbs at refined borders, and superpixels that have an object's label by their colours or by one
//! stray trajectory.
//!
//! In: a mask, and the input of the cut that it was made by, with labelled trajectories. Out: the mask without loose parts.
//!
//! Pixels of one label that share an edge form a part. It is loose if it is small beside the object's largest part in the frame
//! and has hardly any of the object's trajectories. It takes the label along most of its border. Not in the paper. Cost:
//! O(pixels + points). It fails where a part of an object comes into view apart from the rest, until trajectories begin on it.

use crate::cut::{CutInput, pixel_index};
use crate::image::Plane;
use crate::sets::DisjointSets;
use std::collections::BTreeMap;
use std::ops::Range;

/// Fewest trajectories of an object that hold a part of it. Chosen by eye.
const MIN_TRACKS: u32 = 3;

/// Gives loose parts of objects in the mask of frame `t` to what surrounds them. `object` has the object of each label of the
/// input, 0 for the background. A part is small if its area is less than `min_share` of that of the object's largest part.
/// Parts with a pixel and an object that `is_fixed` stay.
pub fn attach_loose_parts(
    mask: &mut Plane<u8>,
    t: usize,
    input: &CutInput,
    object: &[u8],
    min_share: f32,
    is_fixed: impl Fn(usize, u8) -> bool,
) {
    if min_share <= 0.0 {
        return;
    }
    let Parts { runs, of_run, borders } = Parts::new(mask);
    let label_of = |run: usize| mask.data()[runs[run].start];
    let (mut area, mut tracks) = (vec![0; runs.len()], vec![0; runs.len()]);
    let mut largest = [0; 256];
    for (run, &part) in runs.iter().zip(&of_run) {
        area[part] += run.len();
        let largest = &mut largest[usize::from(label_of(part))];
        *largest = area[part].max(*largest);
    }
    for (i, x, y) in input.tracks.alive(t) {
        let pixel = pixel_index((mask.width(), mask.height()), x, y);
        let own = input.label.get(i).and_then(|&label| object.get(label as usize));
        let run = runs.partition_point(|run| run.end <= pixel);
        tracks[of_run[run]] += u32::from(own == Some(&label_of(run)));
    }
    let is_small = |part: usize| (area[part] as f32) < min_share * largest[usize::from(label_of(part))] as f32;
    let mut is_loose: Vec<bool> =
        (0..runs.len()).map(|part| label_of(part) > 0 && is_small(part) && tracks[part] < MIN_TRACKS).collect();
    for (run, &part) in runs.iter().zip(&of_run) {
        is_loose[part] = is_loose[part] && !run.clone().any(|pixel| is_fixed(pixel, label_of(part)));
    }
    let mut lengths = BTreeMap::new();
    for (a, b, length) in borders {
        for (from, to) in [(a, b), (b, a)] {
            if is_loose[of_run[from]] && !is_loose[of_run[to]] {
                *lengths.entry((of_run[from], label_of(to))).or_insert(0) += length;
            }
        }
    }
    let mut surrounding = BTreeMap::new();
    for ((part, label), length) in lengths {
        let longest = surrounding.entry(part).or_insert((length, label));
        *longest = if length > longest.0 { (length, label) } else { *longest };
    }
    for (run, part) in runs.into_iter().zip(of_run) {
        if let Some(&(_, label)) = surrounding.get(&part) {
            mask.data_mut()[run].fill(label);
        }
    }
}

/// The parts of a mask.
struct Parts {
    /// Runs of pixels of one label in a row, in their order.
    runs: Vec<Range<usize>>,
    /// The part of each run, by its first run.
    of_run: Vec<usize>,
    /// Neighbouring runs of different labels, and the number of edges between their pixels.
    borders: Vec<(usize, usize, usize)>,
}

impl Parts {
    fn new(mask: &Plane<u8>) -> Self {
        let (width, mut runs) = (mask.width(), Vec::new());
        for run in (0..mask.height()).flat_map(|y| mask.row(y).chunk_by(|a, b| a == b)) {
            let start = runs.last().map_or(0, |last: &Range<usize>| last.end);
            runs.push(start..start + run.len());
        }
        let (mut sets, mut borders, mut above) = (DisjointSets::new(runs.len()), Vec::new(), 0);
        for (k, run) in runs.iter().enumerate() {
            if run.end % width != 0 {
                borders.push((k, k + 1, 1));
            }
            let Some(start) = run.start.checked_sub(width) else { continue };
            let end = start + run.len();
            above += runs[above..].iter().take_while(|run| run.end <= start).count();
            for (other, upper) in (above..).zip(&runs[above..]).take_while(|(_, upper)| upper.start < end) {
                if mask.data()[upper.start] == mask.data()[run.start] {
                    sets.join(other, k);
                } else {
                    borders.push((other, k, upper.end.min(end) - upper.start.max(start)));
                }
            }
        }
        let of_run = (0..runs.len()).map(|run| sets.root(run)).collect();
        Self { runs, of_run, borders }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::Trajectories;

    fn mask(rows: &[&str]) -> Plane<u8> {
        Plane::from_fn(rows[0].len(), rows.len(), |x, y| rows[y].as_bytes()[x] - b'0')
    }

    /// Attaches loose parts of less than a tenth; `points` are the pixels of trajectories of object 1, `fixed` is a pixel.
    fn attached(rows: &[&str], points: &[usize], fixed: Option<usize>) -> Vec<String> {
        let mut mask = mask(rows);
        let width = mask.width();
        let mut tracks = Trajectories::empty(1, (width, mask.height()));
        points.iter().for_each(|p| tracks.push(0, [((p % width) as f32, (p / width) as f32, 0.0)]));
        let input = CutInput {
            superpixels: &[],
            tracks: &tracks,
            label: &vec![3; points.len()],
            num_labels: 4,
            objects: &[],
            evidence: &[],
            appearance: &[],
        };
        attach_loose_parts(&mut mask, 0, &input, &[0, 2, 0, 1], 0.1, |p, _| Some(p) == fixed);
        mask.data().chunks(width).map(|row| row.iter().map(|l| char::from(b'0' + l)).collect()).collect()
    }

    const CRUMB: [&str; 5] = ["111110000", "111110010", "111110010", "111110000", "111110000"];
    const CLEAN: [&str; 5] = ["111110000", "111110000", "111110000", "111110000", "111110000"];

    #[test]
    fn small_parts_without_trajectories_go_to_what_surrounds_them() {
        assert_eq!(attached(&CRUMB, &[], None), CLEAN);
        // Two trajectories are too few to hold a part, three are enough; so is a fixed pixel, or a tenth of the area.
        assert_eq!(attached(&CRUMB, &[16, 25], None), CLEAN);
        assert_eq!(attached(&CRUMB, &[16, 16, 25], None), CRUMB);
        assert_eq!(attached(&CRUMB, &[], Some(25)), CRUMB);
        let tenth = ["111110000", "111110010", "111110010", "111110010", "111110000"];
        assert_eq!(attached(&tenth, &[], None), tenth);
    }

    #[test]
    fn a_part_beside_another_object_takes_the_label_along_most_of_its_border() {
        let rows = ["1111100222", "1111100212", "1111100212", "1111100222", "1111100222"];
        let clean = ["1111100222", "1111100222", "1111100222", "1111100222", "1111100222"];
        assert_eq!(attached(&rows, &[], None), clean);
        // Of equal lengths the lowest label wins.
        let between = ["1111100022", "1111100122", "1111100022", "1111100022", "1111100022"];
        assert_eq!(attached(&between, &[], None)[1], "1111100022");
    }

    #[test]
    fn pixels_that_share_a_corner_only_are_two_parts() {
        assert_eq!(attached(&["111111000", "111111000", "000000100"], &[], None)[2], "000000000");
    }

    #[test]
    fn background_has_no_loose_parts_and_the_largest_part_stays() {
        for rows in [["11111", "11011", "11111"], ["00000", "00100", "00000"], ["11111", "11111", "11111"]] {
            assert_eq!(attached(&rows, &[], None), rows);
        }
    }
}
