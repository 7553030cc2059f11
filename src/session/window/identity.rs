//! The labels of objects from window to window of a long clip.
//!
//! Windows overlap, and the trajectories of their common frames are the same ones. An object keeps the label that most
//! points of its trajectories had in the previous window. A trajectory that has become background remembers its last label,
//! so that an object that stops and moves on keeps its label as long as trajectories on it live.
//!
//! An object that left the frame and returns within the shot shares no trajectory with its past. It takes the unused label
//! of the most similar appearance (`appearance`).

use crate::cut::{Colour, Histogram};
use crate::image::Frame;
use crate::objects::Objects;
use crate::order;
use crate::trajectory::Trajectories;
use serde::{Deserialize, Serialize};

/// An object takes over a label only with at least one in this many of the label's points in the common frames; chosen by
/// eye, so that a few misplaced trajectories do not count.
const MIN_SHARE_DENOMINATOR: u64 = 10;
/// Least similarity of an object that returns; chosen by eye on clips whose objects leave and return.
const MIN_SIMILARITY: f32 = 0.86;

/// Labels of trajectories and appearances of objects in the previous windows.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Identities {
    /// Number and label of each trajectory that is alive in the overlap, by number.
    track_labels: Vec<(u32, u8)>,
    /// The last window with each label, counted from 1; 0 for none.
    last_window: Vec<u32>,
    window: u32,
    /// The last appearance of each label in this shot.
    appearances: Vec<Option<Appearance>>,
}

impl Default for Identities {
    fn default() -> Self {
        Self { track_labels: Vec::new(), last_window: vec![0; 256], window: 1, appearances: vec![None; 256] }
    }
}

/// The trajectories of a window with the cluster and the clip-wide number of each.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NumberedTracks<'a> {
    pub(crate) tracks: &'a Trajectories,
    pub(crate) label: &'a [u32],
    pub(crate) number: &'a [u32],
}

impl Identities {
    /// Gives objects the labels of the previous window. New objects take labels that were never used, or else those unused
    /// for longest. A cluster of the trajectories of an old object stays an object even where it now touches the frame border
    /// like the scene behind it.
    ///
    /// The first `overlap` frames are shared with the previous window; `appearances` has one entry for each object.
    pub(crate) fn relabel(
        &self,
        objects: &Objects,
        labelled: NumberedTracks,
        overlap: usize,
        appearances: &[(usize, Appearance)],
    ) -> Objects {
        // For each cluster the points in the common frames by the old label of their trajectory.
        let NumberedTracks { tracks, label, number } = labelled;
        let mut cluster_votes = vec![[0_u64; 256]; objects.of_cluster.len()];
        for i in 0..tracks.len() {
            let common = tracks.frames(i).filter(|&t| t < overlap).count() as u64;
            if let Some(votes) = cluster_votes.get_mut(label[i] as usize) {
                votes[usize::from(self.old_label(number[i]))] += common;
            }
        }
        // The same for each new label, since the user may have joined clusters.
        let mut votes = vec![0_u64; 256 * 256];
        for (of_cluster, &new) in cluster_votes.iter().zip(&objects.of_cluster) {
            (0..256).for_each(|old| votes[usize::from(new) * 256 + old] += of_cluster[old]);
        }
        let total = |old: usize| (0..256).map(|new| votes[new * 256 + old]).sum::<u64>();
        // The largest overlap chooses first: an object that splits keeps its label in the larger part.
        let mut pairs: Vec<(u64, usize, usize)> = Vec::new();
        for old in 1..256 {
            let min_votes = total(old).div_ceil(MIN_SHARE_DENOMINATOR).max(1);
            pairs.extend((1..256).map(|new| (votes[new * 256 + old], old, new)).filter(|pair| pair.0 >= min_votes));
        }
        order::sort_by_key(&mut pairs, |pair| u64::MAX - pair.0);
        let mut new_labels = [0_u8; 256];
        let mut is_used = [false; 256];
        for (_, old, new) in pairs {
            if new_labels[new] == 0 && !is_used[old] {
                (new_labels[new], is_used[old]) = (old as u8, true);
            }
        }
        // Labels of clusters that stay objects are not free either.
        for (c, votes) in cluster_votes.iter().enumerate() {
            is_used[usize::from(persistent_label(votes, c))] = true;
        }
        self.recognise(appearances, &mut new_labels, &mut is_used);
        for new in (1..=objects.highest_label).filter(|&new| objects.of_cluster.contains(&(new as u8))) {
            if new_labels[new] == 0 {
                let free = self.free_label(&is_used);
                (new_labels[new], is_used[free]) = (free as u8, true);
            }
        }
        let relabelled = |(c, &new): (usize, &u8)| match new {
            0 => persistent_label(&cluster_votes[c], c),
            _ => new_labels[usize::from(new)],
        };
        let of_cluster: Vec<u8> = objects.of_cluster.iter().enumerate().map(relabelled).collect();
        Objects { highest_label: of_cluster.iter().copied().max().map_or(0, usize::from), of_cluster }
    }

    /// Gives objects without an old label the unused label of the most similar appearance; larger objects choose first.
    fn recognise(&self, appearances: &[(usize, Appearance)], new_labels: &mut [u8; 256], is_used: &mut [bool; 256]) {
        for &(new, ref appearance) in appearances {
            let mut best = (MIN_SIMILARITY, 0);
            for (old, before) in
                self.appearances.iter().enumerate().filter(|&(l, _)| new_labels[new] == 0 && !is_used[l])
            {
                let similarity = before.as_ref().map_or(0.0, |before| before.similarity(appearance));
                best = if similarity > best.0 { (similarity, old) } else { best };
            }
            if best.1 > 0 {
                (new_labels[new], is_used[best.1]) = (best.1 as u8, true);
            }
        }
    }

    /// Returns the first free label that was never used, or else the one unused for longest.
    fn free_label(&self, is_used: &[bool; 256]) -> usize {
        (1..256).filter(|&label| !is_used[label]).min_by_key(|&label| self.last_window[label]).unwrap_or(255)
    }

    /// Advances to the next window, which shares the frames from `first_shared` on with this one. `objects` have been
    /// relabelled.
    pub(crate) fn advance(
        &mut self,
        objects: &Objects,
        labelled: NumberedTracks,
        first_shared: usize,
        appearances: &[(usize, Appearance)],
    ) {
        for label in objects.labels() {
            self.last_window[usize::from(label)] = self.window;
        }
        for (label, appearance) in appearances {
            self.appearances[*label] = Some(appearance.clone());
        }
        self.window += 1;
        let NumberedTracks { tracks, label, number } = labelled;
        let mut track_labels = Vec::new();
        for i in (0..tracks.len()).filter(|&i| tracks.frames(i).end > first_shared) {
            let present = objects.of_cluster.get(label[i] as usize).copied().unwrap_or(0);
            // Trajectories at rest keep their old label, for when they move on.
            let label = if present > 0 { present } else { self.old_label(number[i]) };
            if label > 0 {
                track_labels.push((number[i], label));
            }
        }
        order::sort_by_key(&mut track_labels, |&(number, _)| u64::from(number));
        self.track_labels = track_labels;
    }

    /// Forgets appearances at the begin of another shot.
    pub(crate) fn forget_appearances(&mut self) {
        self.appearances.fill(None);
    }

    /// Returns the last label of a trajectory; 0 if it had none or is new.
    fn old_label(&self, number: u32) -> u8 {
        self.track_labels.binary_search_by_key(&number, |&(n, _)| n).map_or(0, |k| self.track_labels[k].1)
    }
}

/// Returns the old label of most points of a cluster; 0 if they had none, and for the largest cluster, which is the scene.
fn persistent_label(votes: &[u64; 256], cluster: usize) -> u8 {
    let total = votes.iter().sum::<u64>();
    let label = (1..256).find(|&label| 2 * votes[label] > total).filter(|_| cluster > 0);
    label.map_or(0, |label| label as u8)
}

// The appearance of objects, to recognise them when they return.
//
// In: the trajectories of a window with their objects, and its frames. Out: for each object the histogram of the colours
// along its trajectories and its last position; two appearances are compared by both. Not in the paper.

/// Loss of similarity over a distance of one side of the frame; chosen by eye, and small, since the camera may have turned
/// meanwhile.
const DISTANCE_PENALTY: f32 = 0.1;

/// The colours along the trajectories of an object, and its last position.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Appearance {
    colours: Histogram,
    /// Mean position of its points in the last frame that has any, relative to the sides of the frame.
    position: (f32, f32),
}

/// Returns the appearance of each object with its label. `cluster` has the cluster of each trajectory.
pub(crate) fn object_appearances(
    tracks: &Trajectories,
    cluster: &[u32],
    objects: &Objects,
    frames: &[Frame],
) -> Vec<(usize, Appearance)> {
    let blank = Appearance { colours: Histogram::new(), position: (0.5, 0.5) };
    let mut appearances: Vec<_> =
        objects.labels().into_iter().map(|label| (usize::from(label), blank.clone())).collect();
    for (t, frame) in frames.iter().enumerate().take(tracks.num_frames) {
        let (w, h) = (frame.width(), frame.height());
        let mut sums = [(0.0, 0.0, 0.0); 256];
        for (i, x, y) in tracks.alive(t) {
            let label = usize::from(objects.of_cluster[cluster[i] as usize]);
            let Some((_, appearance)) = appearances.iter_mut().find(|(l, _)| *l == label) else { continue };
            let pixel = |v: f32, side: usize| ((v + 0.5).max(0.0) as usize).min(side - 1);
            let offset = 3 * (pixel(y, h) * w + pixel(x, w));
            appearance.colours.add(&Colour::from_rgb(&frame.rgb()[offset..offset + 3]).corners(), 1.0);
            let sum = &mut sums[label];
            *sum = (sum.0 + x / w as f32, sum.1 + y / h as f32, sum.2 + 1.0);
        }
        for (label, appearance) in &mut appearances {
            let (x, y, n) = sums[*label];
            if n > 0.0 {
                appearance.position = (x / n, y / n);
            }
        }
    }
    appearances
}

impl Appearance {
    /// Returns the similarity of two appearances, at most 1: similarity of colours, less a little for their distance.
    pub(super) fn similarity(&self, other: &Self) -> f32 {
        let (x, y) = (self.position.0 - other.position.0, self.position.1 - other.position.1);
        self.colours.similarity(&other.colours) - DISTANCE_PENALTY * (x * x + y * y).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::super::identity::object_appearances;
    use super::*;
    use crate::image::Frame;

    /// Trajectories that live through all of `frames` frames.
    fn tracks(count: usize, frames: usize) -> Trajectories {
        let mut tracks = Trajectories::empty(frames, (64, 64));
        for i in 0..count {
            tracks.push(0, (0..frames).map(|_| (i as f32, 0.0, 0.0)));
        }
        tracks
    }

    fn objects(of_cluster: &[u8]) -> Objects {
        Objects { highest_label: of_cluster.iter().copied().max().unwrap_or(0).into(), of_cluster: of_cluster.to_vec() }
    }

    fn numbered<'a>(tracks: &'a Trajectories, label: &'a [u32], number: &'a [u32]) -> NumberedTracks<'a> {
        NumberedTracks { tracks, label, number }
    }

    const NUMBERS: [u32; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

    /// After a window of six trajectories: 0 and 1 background, 2 and 3 object 1, 4 and 5 object 2.
    fn after_one_window() -> Identities {
        let mut identities = Identities::default();
        let first =
            identities.relabel(&objects(&[0, 1, 2]), numbered(&tracks(6, 8), &[0, 0, 1, 1, 2, 2], &NUMBERS), 0, &[]);
        assert_eq!(first, objects(&[0, 1, 2]));
        identities.advance(&first, numbered(&tracks(6, 8), &[0, 0, 1, 1, 2, 2], &NUMBERS), 4, &[]);
        identities
    }

    #[test]
    fn objects_keep_their_labels_when_they_are_renumbered() {
        let next = after_one_window().relabel(
            &objects(&[2, 1, 0]),
            numbered(&tracks(6, 8), &[2, 2, 0, 0, 1, 1], &NUMBERS),
            4,
            &[],
        );
        assert_eq!(next.of_cluster, [1, 2, 0]);
    }

    #[test]
    fn the_larger_part_keeps_the_label_and_a_newcomer_takes_a_new_one() {
        let identities = after_one_window();
        let label = [0, 0, 1, 1, 2, 3, 3, 3, 3];
        let next = identities.relabel(&objects(&[0, 3, 2, 1]), numbered(&tracks(9, 8), &label, &NUMBERS), 4, &[]);
        // Trajectories 4 and 5 bore label 2 and are parted evenly: the first takes it; 6 to 8 are new.
        assert_eq!(next.of_cluster[1], 1);
        let mut rest = [next.of_cluster[2], next.of_cluster[3]];
        rest.sort_unstable();
        assert_eq!((rest, next.highest_label), ([2, 3], 3));
    }

    #[test]
    fn strays_among_its_trajectories_do_not_take_a_label_along() {
        let numbers: Vec<u32> = (0..22).collect();
        let with_last = |count: u32| numbers.iter().map(|&i| u32::from(i >= 22 - count)).collect::<Vec<_>>();
        let mut identities = Identities::default();
        let first = identities.relabel(&objects(&[0, 1]), numbered(&tracks(22, 8), &with_last(20), &numbers), 0, &[]);
        identities.advance(&first, numbered(&tracks(22, 8), &with_last(20), &numbers), 4, &[]);
        let next = |count| {
            identities.relabel(&objects(&[0, 1]), numbered(&tracks(22, 8), &with_last(count), &numbers), 4, &[])
        };
        assert_eq!(next(1).of_cluster, [0, 2]);
        assert_eq!(next(2).of_cluster, [0, 1]);
    }

    #[test]
    fn what_stops_and_moves_on_keeps_its_label_and_nobody_else_takes_it() {
        let mut identities = after_one_window();
        let still =
            identities.relabel(&objects(&[0, 1]), numbered(&tracks(6, 8), &[0, 0, 1, 1, 0, 0], &NUMBERS), 4, &[]);
        assert_eq!(still.of_cluster, [0, 1]);
        identities.advance(&still, numbered(&tracks(6, 8), &[0, 0, 1, 1, 0, 0], &NUMBERS), 4, &[]);
        let new = identities.relabel(
            &objects(&[0, 1, 2, 3]),
            numbered(&tracks(8, 8), &[0, 0, 1, 1, 2, 2, 3, 3], &NUMBERS),
            4,
            &[],
        );
        assert_eq!(new.of_cluster, [0, 1, 2, 3]);
    }

    #[test]
    fn what_was_an_object_stays_one_at_the_rim_but_not_within_the_background() {
        let identities = after_one_window();
        let own =
            identities.relabel(&objects(&[0, 0, 1]), numbered(&tracks(6, 8), &[0, 0, 1, 1, 2, 2], &NUMBERS), 4, &[]);
        assert_eq!(own.of_cluster, [0, 1, 2]);
        let mixed =
            identities.relabel(&objects(&[0, 0]), numbered(&tracks(6, 8), &[0, 1, 1, 0, 0, 0], &NUMBERS), 4, &[]);
        assert_eq!(mixed.of_cluster, [0, 0]);
    }

    #[test]
    fn when_labels_run_out_the_one_unseen_for_longest_is_used_again() {
        let mut identities = Identities::default();
        let all: Vec<u8> = (0..=255).collect();
        let many = tracks(256, 4);
        let numbers: Vec<u32> = (0..256).collect();
        let first = identities.relabel(&objects(&all), numbered(&many, &numbers, &numbers), 0, &[]);
        assert_eq!(first.of_cluster, all);
        identities.advance(&first, numbered(&many, &numbers, &numbers), 2, &[]);
        // Objects 1 and 3 live on; none of the new ones shares a trajectory.
        let later = objects(&[0, 1, 2, 3]);
        let next = identities.relabel(&later, numbered(&tracks(4, 4), &[0, 1, 2, 3], &[0, 1, 900, 3]), 2, &[]);
        assert_eq!(next.of_cluster, [0, 1, 2, 3]);
        identities.advance(&next, numbered(&tracks(4, 4), &[0, 1, 2, 3], &[0, 1, 900, 3]), 2, &[]);
        let last = identities.relabel(&objects(&[0, 1]), numbered(&tracks(2, 4), &[0, 1], &[0, 901]), 2, &[]);
        assert_eq!(last.of_cluster, [0, 4]);
    }

    #[test]
    fn what_comes_back_is_known_by_its_looks_unless_its_label_is_taken_or_the_shot_is_over() {
        let (grey, red, blue) = ([90, 90, 90], [200, 40, 30], [30, 60, 180]);
        let seen = |colours: &[[u8; 3]], found: &Objects| {
            let rgb = (0..64 * 64).flat_map(|i| colours[(i % 64).min(colours.len() - 1)]).collect();
            let frames = vec![Frame::from_rgb(rgb, 64, 64).unwrap(); 8];
            let label: Vec<u32> = (0..colours.len() as u32).collect();
            object_appearances(&tracks(colours.len(), 8), &label, found, &frames)
        };
        let mut identities = Identities::default();
        let two = objects(&[0, 1, 2]);
        identities.advance(&two, numbered(&tracks(3, 8), &[0, 1, 2], &NUMBERS), 4, &seen(&[grey, red, blue], &two));
        // Both are gone for a window.
        identities.advance(&objects(&[0]), numbered(&tracks(1, 8), &[0], &[0]), 4, &[]);
        let back = |identities: &Identities, colours: &[[u8; 3]]| {
            let count = colours.len() as u8;
            let label: Vec<u32> = (0..u32::from(count)).collect();
            let numbers: Vec<u32> = label.iter().map(|l| 50 + l).collect();
            let found = objects(&(0..count).collect::<Vec<_>>());
            identities
                .relabel(&found, numbered(&tracks(colours.len(), 8), &label, &numbers), 4, &seen(colours, &found))
                .of_cluster
        };
        assert_eq!(back(&identities, &[grey, blue]), [0, 2]);
        assert_eq!(back(&identities, &[grey, blue, red]), [0, 2, 1]);
        // Of two that are alike one is another; and so is what looks like none.
        assert_eq!(back(&identities, &[grey, red, red]), [0, 1, 3]);
        assert_eq!(back(&identities, &[grey, [20, 200, 40]]), [0, 3]);
        identities.forget_appearances();
        assert_eq!(back(&identities, &[grey, blue]), [0, 3]);
    }

    #[test]
    fn a_window_without_objects_or_trajectories_has_no_labels() {
        let identities = after_one_window();
        let none = identities.relabel(&Objects::default(), numbered(&Trajectories::empty(8, (8, 8)), &[], &[]), 4, &[]);
        assert_eq!(none, Objects::default());
    }

    /// The objects in a frame of three columns of these colours, with points all over.
    fn seen(columns: [[u8; 3]; 3], of_cluster: [u8; 3]) -> Vec<(usize, Appearance)> {
        let (w, h) = (60, 20);
        let frame = Frame::from_rgb((0..w * h).flat_map(|i| columns[i % w / 20]).collect(), w, h).unwrap();
        let mut tracks = Trajectories::empty(2, (w, h));
        let places: Vec<usize> = (0..60).step_by(2).collect();
        places.iter().for_each(|&x| tracks.push(0, [(x as f32, 9.0, 0.0); 2]));
        let cluster: Vec<u32> = places.iter().map(|&x| (x / 20) as u32).collect();
        let objects = Objects { highest_label: 2, of_cluster: of_cluster.to_vec() };
        object_appearances(&tracks, &cluster, &objects, &[frame.clone(), frame])
    }

    const RED: [u8; 3] = [200, 40, 30];
    const BLUE: [u8; 3] = [30, 60, 180];
    const GREY: [u8; 3] = [90, 90, 90];

    #[test]
    fn similar_colours_and_nearby_positions_are_similar() {
        let [left, right] = [[RED, GREY, GREY], [GREY, GREY, RED]].map(|columns| seen(columns, [1, 2, 0]));
        let other = seen([BLUE, GREY, GREY], [1, 2, 0]);
        assert_eq!((left[0].0, left[1].0, left.len()), (1, 2, 2));
        let red = &left[0].1;
        assert!((red.similarity(red) - 1.0).abs() < 1e-6);
        assert!(red.similarity(&other[0].1) < 0.1 && red.similarity(&right[0].1) < 0.1);
        let moved = seen([GREY, GREY, RED], [0, 0, 1])[0].1.similarity(red);
        assert!((0.9..0.95).contains(&moved), "{moved}");
    }

    #[test]
    fn an_object_of_several_clusters_has_one_appearance_and_one_without_trajectories_is_similar_to_none() {
        let both = seen([RED, BLUE, BLUE], [1, 0, 1]);
        let red = seen([RED, BLUE, BLUE], [1, 0, 0]);
        assert_eq!((both.len(), red.len()), (1, 1));
        let alike = both[0].1.similarity(&red[0].1);
        assert!((0.6..0.75).contains(&alike), "{alike}");
        let blank = Appearance { colours: Histogram::new(), position: (0.5, 0.5) };
        assert!(blank.similarity(&blank) <= 0.0);
    }
}
