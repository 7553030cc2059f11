//! Prompts for promptable video models: for each object its best frame, its bounding box, and points inside and outside.
//!
//! Promptable models of video take boxes, clicks and masks drawn by a user (SAM 2, Ravi et al., 2024); known objects replace the
//! user. Clicks are best far from every border (Xu et al., Deep Interactive Object Selection, CVPR 2016): each point is the
//! pixel farthest from the border and from the points before it.

use crate::image::Plane;
use crate::sets::DisjointSets;
use std::collections::BTreeMap;

/// Number of points inside an object, and of points outside; chosen by eye.
const NUM_POINTS: usize = 3;
/// Distances from the border count up to this many pixels; chosen by eye.
const MAX_DEPTH_PX: u8 = 12;

/// The prompt for one object, in pixels of the mask.
#[derive(Debug, Clone, PartialEq)]
pub struct Prompt {
    /// The object's label in the masks.
    pub object: u8,
    /// The frame in which it is largest and farthest from its border.
    pub frame: usize,
    /// Left, top, right and bottom of the bounding box of `mask`; the latter two are its last column and row.
    pub bounds: [usize; 4],
    /// Up to three pixels of the object, the one farthest from its border first.
    pub inside: Vec<(usize, usize)>,
    /// Up to three pixels outside the object, in its box extended by half on each side.
    pub outside: Vec<(usize, usize)>,
    /// 1 in the largest connected part of the object in this frame, 0 elsewhere.
    pub mask: Plane<u8>,
}

/// Finds prompts frame by frame; holds one mask for each object.
#[derive(Debug, Default)]
pub struct Prompts {
    best: BTreeMap<u8, BestFrame>,
}

/// The best frame of an object so far.
#[derive(Debug)]
struct BestFrame {
    frame: usize,
    score: u64,
    mask: Plane<u8>,
}

impl Prompts {
    /// Adds the mask of frame `frame`. Its score for an object is the sum of the border distances of the object's pixels.
    pub fn add(&mut self, frame: usize, mask: &Plane<u8>) {
        let mut scores = [0_u64; 256];
        for (&label, &depth) in mask.data().iter().zip(border_distance(mask).data()) {
            scores[usize::from(label)] += 1 + u64::from(depth);
        }
        for object in (1..=255).filter(|&label| scores[usize::from(label)] > 0) {
            let score = scores[usize::from(object)];
            if self.best.get(&object).is_none_or(|best| score > best.score) {
                let mask = mask.map(|label| u8::from(label == object));
                self.best.insert(object, BestFrame { frame, score, mask });
            }
        }
    }

    /// Returns the prompt for each object, ascending.
    #[must_use]
    pub fn finish(self) -> Vec<Prompt> {
        self.best.into_iter().map(|(object, best)| prompt(object, best)).collect()
    }
}

fn prompt(object: u8, BestFrame { frame, mask: object_mask, .. }: BestFrame) -> Prompt {
    let mask = largest_component(&object_mask);
    let bounds @ [left, top, right, bottom] = bounds(&mask);
    let (width, height) = (right - left + 1, bottom - top + 1);
    let (x, y) = (left.saturating_sub(width / 2), top.saturating_sub(height / 2));
    let extended = [x, y, (right + width / 2 + 1).min(mask.width()), (bottom + height / 2 + 1).min(mask.height())];
    let inside = farthest_points(&mask, 1, [left, top, right + 1, bottom + 1]);
    let outside = farthest_points(&object_mask, 0, extended);
    Prompt { object, frame, bounds, inside, outside, mask }
}

/// Returns the largest connected component of the pixels that are 1. Smaller ones are more often errors than occluded parts.
fn largest_component(mask: &Plane<u8>) -> Plane<u8> {
    let width = mask.width();
    let is_inside = |k: usize| mask.data()[k] == 1;
    let mut sets = DisjointSets::new(mask.data().len());
    let mut sizes = vec![0_u32; mask.data().len()];
    for k in (0..sizes.len()).filter(|&k| is_inside(k)) {
        let (left, above) = ((k % width > 0).then(|| k - 1), k.checked_sub(width));
        [left, above].into_iter().flatten().filter(|&j| is_inside(j)).for_each(|j| sets.join(j, k));
    }
    (0..sizes.len()).filter(|&k| is_inside(k)).for_each(|k| sizes[sets.root(k)] += 1);
    let largest = (0..sizes.len()).rev().max_by_key(|&k| sizes[k]);
    Plane::from_fn(width, mask.height(), |x, y| {
        let k = y * width + x;
        u8::from(is_inside(k) && Some(sets.root(k)) == largest)
    })
}

/// Returns the bounding box of the pixels that are 1.
fn bounds(mask: &Plane<u8>) -> [usize; 4] {
    let mut bounds = [usize::MAX, usize::MAX, 0, 0];
    for (k, _) in mask.data().iter().enumerate().filter(|(_, pixel)| **pixel == 1) {
        let (x, y) = (k % mask.width(), k / mask.width());
        bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
    }
    bounds
}

/// Finds pixels of this `value` in a box: one after the other the farthest from other values, from the edges of the box, and from
/// the pixels found before.
fn farthest_points(mask: &Plane<u8>, value: u8, [left, top, right, bottom]: [usize; 4]) -> Vec<(usize, usize)> {
    let mut free = Plane::from_fn(right - left, bottom - top, |x, y| mask[(left + x, top + y)] == value);
    let mut points = Vec::new();
    while points.len() < NUM_POINTS {
        let depth = squared_distance(&free);
        let deepest = (0..depth.data().len()).rev().max_by_key(|&k| depth.data()[k]);
        let Some(k) = deepest.filter(|&k| depth.data()[k] > 0) else { break };
        let (x, y) = (k % free.width(), k / free.width());
        free[(x, y)] = false;
        points.push((left + x, top + y));
    }
    points
}

/// Computes the squared distance of each pixel to the nearest that is not free; pixels beyond the edges are not free.
fn squared_distance(free: &Plane<bool>) -> Plane<usize> {
    let (w, h) = (free.width(), free.height());
    let mut column = Plane::from_fn(w, h, |_, _| 0);
    for x in 0..w {
        let mut above = 0;
        for y in 0..h {
            above = if free[(x, y)] { above + 1 } else { 0 };
            column[(x, y)] = above;
        }
        let mut below = 0;
        for y in (0..h).rev() {
            below = if free[(x, y)] { below + 1 } else { 0 };
            column[(x, y)] = column[(x, y)].min(below);
        }
    }
    Plane::from_fn(w, h, |x, y| {
        let mut min_sq = column[(x, y)] * column[(x, y)];
        let mut dx = 1;
        while dx * dx < min_sq {
            for u in [x.checked_sub(dx), Some(x + dx).filter(|&u| u < w)] {
                let dy = u.map_or(0, |u| column[(u, y)]);
                min_sq = min_sq.min(dx * dx + dy * dy);
            }
            dx += 1;
        }
        min_sq
    })
}

/// Computes the city-block distance of each pixel to the nearest border pixel of its label, up to [`MAX_DEPTH_PX`].
fn border_distance(mask: &Plane<u8>) -> Plane<u8> {
    let (w, h) = (mask.width(), mask.height());
    let differs = |x: usize, y: usize| {
        let neighbours = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        neighbours.into_iter().any(|(a, b)| a < w && b < h && mask[(a, b)] != mask[(x, y)])
    };
    let mut depth = Plane::from_fn(w, h, |x, y| if differs(x, y) { 0 } else { MAX_DEPTH_PX });
    let mut lower = |at: (usize, usize), from: (usize, usize)| depth[at] = depth[at].min(depth[from] + 1);
    for y in 0..h {
        (1..w).for_each(|x| lower((x, y), (x - 1, y)));
        (1..w).rev().for_each(|x| lower((x - 1, y), (x, y)));
    }
    for x in 0..w {
        (1..h).for_each(|y| lower((x, y), (x, y - 1)));
        (1..h).rev().for_each(|y| lower((x, y - 1), (x, y)));
    }
    depth
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    #[test]
    fn distances_are_those_of_an_exhaustive_search() {
        let mut rng = Rng::for_stage(3, "prompts");
        for _ in 0..20 {
            let (w, h) = (1 + rng.below(20), 1 + rng.below(14));
            let holes: Vec<(usize, usize)> = (0..rng.below(6)).map(|_| (rng.below(w), rng.below(h))).collect();
            let free = Plane::from_fn(w, h, |x, y| !holes.contains(&(x, y)));
            let distance = squared_distance(&free);
            for (x, y) in (0..w * h).map(|k| (k % w, k / w)) {
                let edge = (x + 1).min(w - x).min(y + 1).min(h - y);
                let hole = holes.iter().map(|&(a, b)| a.abs_diff(x).pow(2) + b.abs_diff(y).pow(2)).min();
                assert_eq!(distance[(x, y)], hole.unwrap_or(usize::MAX).min(edge * edge), "{x} {y}");
            }
        }
    }

    #[test]
    fn points_lie_deep_in_the_object_and_beside_it() {
        let mask = Plane::from_fn(60, 40, |x, y| if (20..41).contains(&x) && (10..21).contains(&y) { 7 } else { 0 });
        let mut prompts = Prompts::default();
        prompts.add(4, &mask);
        let found = prompts.finish();
        let [prompt] = &found[..] else { panic!("{found:?}") };
        assert_eq!((prompt.object, prompt.frame, prompt.bounds), (7, 4, [20, 10, 40, 20]));
        assert_eq!((prompt.inside.len(), prompt.outside.len()), (3, 3));
        assert!(prompt.inside.iter().all(|&at| mask[at] == 7) && prompt.outside.iter().all(|&at| mask[at] == 0));
        assert_eq!(prompt.inside[0].1, 15, "on the middle line");
        assert_eq!(prompt.mask.data().iter().map(|&p| usize::from(p)).sum::<usize>(), 21 * 11);
    }

    #[test]
    fn the_frame_is_the_one_with_the_largest_object_and_of_two_the_one_with_the_deeper() {
        let best = |frames: &[Plane<u8>]| {
            let mut prompts = Prompts::default();
            frames.iter().enumerate().for_each(|(t, mask)| prompts.add(t, mask));
            prompts.finish()[0].frame
        };
        let block = |w: usize, h: usize| Plane::from_fn(30, 30, move |x, y| u8::from(x < w && y < h) * 3);
        assert_eq!(best(&[block(4, 4), block(20, 20), block(10, 10)]), 1);
        assert_eq!(best(&[block(25, 4), block(10, 10)]), 1);
    }

    #[test]
    fn of_an_object_in_parts_the_largest_counts() {
        let parts = |x: usize, y: usize| y < 9 && (x < 8 || (12..30).contains(&x)) || (x, y) == (8, 9);
        let mut prompts = Prompts::default();
        prompts.add(0, &Plane::from_fn(40, 20, |x, y| u8::from(parts(x, y))));
        let prompt = &prompts.finish()[0];
        assert_eq!(prompt.bounds, [12, 0, 29, 8]);
        assert!(prompt.mask.data().iter().map(|&p| usize::from(p)).sum::<usize>() == 18 * 9);
        assert!(prompt.inside.iter().all(|&(x, _)| x >= 12));
        assert!(prompt.outside.len() == 3 && prompt.outside.iter().all(|&(x, y)| !parts(x, y)), "{prompt:?}");
    }

    #[test]
    fn an_object_of_a_pixel_and_one_that_fills_the_frame_have_what_there_is() {
        let mut prompts = Prompts::default();
        prompts.add(0, &Plane::from_fn(5, 4, |x, y| u8::from((x, y) == (0, 3))));
        prompts.add(1, &Plane::from_fn(5, 4, |_, _| 2));
        let [speck, all] = &prompts.finish()[..] else { panic!() };
        assert_eq!((&speck.inside[..], speck.bounds), (&[(0, 3)][..], [0, 3, 0, 3]));
        assert_eq!((all.inside.len(), all.outside.len(), all.bounds), (3, 0, [0, 0, 4, 3]));
        assert!(Prompts::default().finish().is_empty());
    }

    #[test]
    fn border_distances_are_those_of_an_exhaustive_search() {
        let mut rng = crate::rng::Rng::for_stage(1, "border distance");
        for _ in 0..10 {
            let seeds: Vec<(usize, usize)> = (0..3).map(|_| (rng.below(30), rng.below(20))).collect();
            let mask = Plane::from_fn(30, 20, |x, y| {
                u8::from(seeds.iter().any(|s| s.0.abs_diff(x) < 4 && s.1.abs_diff(y) < 3))
            });
            let distance = border_distance(&mask);
            let all = || (0..600).map(|p| (p % 30, p / 30));
            for (x, y) in all() {
                let away = |&(a, b): &(usize, usize)| a.abs_diff(x) + b.abs_diff(y);
                let other = all().filter(|&at| mask[at] != mask[(x, y)]).map(|at| away(&at)).min();
                assert_eq!(usize::from(distance[(x, y)]), other.map_or(12, |steps| (steps - 1).min(12)));
            }
        }
    }
}
