//! Which objects of one window of a long clip are which of the next.
//!
//! Windows overlap, and the trajectories of their common frames are the same ones. So an object keeps the label that
//! most points of its trajectories bore in the window before. A trajectory that has become part of the background
//! remembers the label that it bore: what stops and moves on keeps its name as long as trajectories on it live.
//!
//! What left the frame and comes back within the shot shares no trajectory with its past. It takes the label of what
//! looked like it, if nothing bears that label now (`portrait`).

use super::portrait::Portrait;
use crate::objects::Objects;
use crate::order;
use crate::trajectory::Trajectories;
use serde::{Deserialize, Serialize};

/// An object takes over a label only with at least one in ten of the points that bear it in the common frames:
/// fewer are strays.
const LEAST_SHARE: u64 = 10;
/// Who resembles another as much as this is the same.
const SAME: f32 = 0.86;

/// Labels that trajectories bore in the windows before.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Identities {
    /// Number and label of each trajectory that is alive in the overlap, by number.
    of_track: Vec<(u32, u8)>,
    /// The window in which each label was last borne, counted from 1; 0 for never.
    last_seen: Vec<u32>,
    window: u32,
    /// What bore each label looked like when it was last seen in this shot.
    known: Vec<Option<Portrait>>,
}

impl Default for Identities {
    fn default() -> Self {
        Self { of_track: Vec::new(), last_seen: vec![0; 256], window: 1, known: vec![None; 256] }
    }
}

impl Identities {
    /// The objects under the labels that they keep; new ones take labels that no object has had, or, when all 255 are
    /// used up, that have not been borne for longest. What was an object stays one while its trajectories are a cluster
    /// of their own, also where it now holds the frame's rim like the scene behind it.
    ///
    /// `label` is the cluster of each trajectory, `number` its number, and `overlap` how many frames were in the window
    /// before too. `looks` has the portrait of each object.
    pub(crate) fn rename(
        &self,
        objects: &Objects,
        tracks: &Trajectories,
        label: &[u32],
        number: &[u32],
        overlap: usize,
        looks: &[(usize, Portrait)],
    ) -> Objects {
        // Of each cluster: how many points in the common frames belong to trajectories that bore which label.
        let mut borne = vec![[0_u64; 256]; objects.of_cluster.len()];
        for i in 0..tracks.len() {
            let common = tracks.frames(i).filter(|&t| t < overlap).count() as u64;
            if let Some(borne) = borne.get_mut(label[i] as usize) {
                borne[usize::from(self.label_of(number[i]))] += common;
            }
        }
        // The same of each new label, since the user may have made one object of several clusters.
        let mut votes = vec![0_u64; 256 * 256];
        for (borne, &new) in borne.iter().zip(&objects.of_cluster) {
            (0..256).for_each(|old| votes[usize::from(new) * 256 + old] += borne[old]);
        }
        let bearing = |old: usize| (0..256).map(|new| votes[new * 256 + old]).sum::<u64>();
        // Whoever shares most chooses first: an object that falls in two keeps its label in the larger part.
        let mut pairs: Vec<(u64, usize, usize)> = Vec::new();
        for old in 1..256 {
            let least = bearing(old).div_ceil(LEAST_SHARE).max(1);
            pairs.extend((1..256).map(|new| (votes[new * 256 + old], old, new)).filter(|pair| pair.0 >= least));
        }
        order::sort_by_key(&mut pairs, |pair| u64::MAX - pair.0);
        let mut renamed = [0_u8; 256];
        let mut taken = [false; 256];
        for (_, old, new) in pairs {
            if renamed[new] == 0 && !taken[old] {
                (renamed[new], taken[old]) = (old as u8, true);
            }
        }
        // What stays an object below must not lose its label to a newcomer.
        for (c, borne) in borne.iter().enumerate() {
            taken[usize::from(still_object(borne, c))] = true;
        }
        self.recognise(looks, &mut renamed, &mut taken);
        for new in (1..=objects.highest_label).filter(|&new| objects.of_cluster.contains(&(new as u8))) {
            if renamed[new] == 0 {
                let free = self.unused(&taken);
                (renamed[new], taken[free]) = (free as u8, true);
            }
        }
        let keeps =
            |(c, &new): (usize, &u8)| if new > 0 { renamed[usize::from(new)] } else { still_object(&borne[c], c) };
        let of_cluster: Vec<u8> = objects.of_cluster.iter().enumerate().map(keeps).collect();
        Objects { highest_label: of_cluster.iter().copied().max().map_or(0, usize::from), of_cluster }
    }

    /// Objects that share no trajectory with the window before take the label of one that they look like, which nothing
    /// else bears; larger ones choose first.
    fn recognise(&self, looks: &[(usize, Portrait)], renamed: &mut [u8; 256], taken: &mut [bool; 256]) {
        for &(new, ref portrait) in looks {
            let mut best = (SAME, 0);
            for (old, known) in self.known.iter().enumerate().filter(|&(old, _)| renamed[new] == 0 && !taken[old]) {
                let resemblance = known.as_ref().map_or(0.0, |known| known.resemblance(portrait));
                best = if resemblance > best.0 { (resemblance, old) } else { best };
            }
            if best.1 > 0 {
                (renamed[new], taken[best.1]) = (best.1 as u8, true);
            }
        }
    }

    /// The first label that was never borne, or else that has not been for longest; of those not yet taken.
    fn unused(&self, taken: &[bool; 256]) -> usize {
        (1..256).filter(|&label| !taken[label]).min_by_key(|&label| self.last_seen[label]).unwrap_or(255)
    }

    /// Goes on to the next window, which shares the frames from `kept_from` on with this one, whose objects have been
    /// renamed.
    pub(crate) fn advance(
        &mut self,
        objects: &Objects,
        tracks: &Trajectories,
        label: &[u32],
        number: &[u32],
        kept_from: usize,
        looks: &[(usize, Portrait)],
    ) {
        for label in objects.labels() {
            self.last_seen[usize::from(label)] = self.window;
        }
        for (label, portrait) in looks {
            self.known[*label] = Some(portrait.clone());
        }
        self.window += 1;
        let mut of_track = Vec::new();
        for i in (0..tracks.len()).filter(|&i| tracks.frames(i).end > kept_from) {
            let now = objects.of_cluster.get(label[i] as usize).copied().unwrap_or(0);
            // Who has come to rest goes on bearing its old label, for when it moves on.
            let borne = if now > 0 { now } else { self.label_of(number[i]) };
            if borne > 0 {
                of_track.push((number[i], borne));
            }
        }
        order::sort_by_key(&mut of_track, |&(number, _)| u64::from(number));
        self.of_track = of_track;
    }

    /// Begins another shot, in which nothing comes back.
    pub(crate) fn forget_looks(&mut self) {
        self.known.fill(None);
    }

    /// The label that a trajectory bore; 0 if none, or if it is new.
    fn label_of(&self, number: u32) -> u8 {
        self.of_track.binary_search_by_key(&number, |&(n, _)| n).map_or(0, |at| self.of_track[at].1)
    }
}

/// The label that most points of a cluster bore in the common frames; 0 for background, and for the largest cluster,
/// which is what everything else stands before.
fn still_object(borne: &[u64; 256], cluster: usize) -> u8 {
    let all = borne.iter().sum::<u64>();
    let label = (1..256).find(|&label| 2 * borne[label] > all).filter(|_| cluster > 0);
    label.map_or(0, |label| label as u8)
}

#[cfg(test)]
mod tests {
    use super::super::portrait::portraits;
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

    const NUMBERS: [u32; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];

    /// After a window of six trajectories: 0 and 1 background, 2 and 3 object 1, 4 and 5 object 2.
    fn after_one_window() -> Identities {
        let mut known = Identities::default();
        let first = known.rename(&objects(&[0, 1, 2]), &tracks(6, 8), &[0, 0, 1, 1, 2, 2], &NUMBERS, 0, &[]);
        assert_eq!(first, objects(&[0, 1, 2]));
        known.advance(&first, &tracks(6, 8), &[0, 0, 1, 1, 2, 2], &NUMBERS, 4, &[]);
        known
    }

    #[test]
    fn objects_keep_their_labels_however_they_are_numbered_anew() {
        let next =
            after_one_window().rename(&objects(&[2, 1, 0]), &tracks(6, 8), &[2, 2, 0, 0, 1, 1], &NUMBERS, 4, &[]);
        assert_eq!(next.of_cluster, [1, 2, 0]);
    }

    #[test]
    fn the_larger_part_keeps_the_label_and_a_newcomer_takes_a_new_one() {
        let known = after_one_window();
        let label = [0, 0, 1, 1, 2, 3, 3, 3, 3];
        let next = known.rename(&objects(&[0, 3, 2, 1]), &tracks(9, 8), &label, &NUMBERS, 4, &[]);
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
        let mut known = Identities::default();
        let first = known.rename(&objects(&[0, 1]), &tracks(22, 8), &with_last(20), &numbers, 0, &[]);
        known.advance(&first, &tracks(22, 8), &with_last(20), &numbers, 4, &[]);
        let next = |count| known.rename(&objects(&[0, 1]), &tracks(22, 8), &with_last(count), &numbers, 4, &[]);
        assert_eq!(next(1).of_cluster, [0, 2]);
        assert_eq!(next(2).of_cluster, [0, 1]);
    }

    #[test]
    fn what_stops_and_moves_on_keeps_its_label_and_nobody_else_takes_it() {
        let mut known = after_one_window();
        let still = known.rename(&objects(&[0, 1]), &tracks(6, 8), &[0, 0, 1, 1, 0, 0], &NUMBERS, 4, &[]);
        assert_eq!(still.of_cluster, [0, 1]);
        known.advance(&still, &tracks(6, 8), &[0, 0, 1, 1, 0, 0], &NUMBERS, 4, &[]);
        let new = known.rename(&objects(&[0, 1, 2, 3]), &tracks(8, 8), &[0, 0, 1, 1, 2, 2, 3, 3], &NUMBERS, 4, &[]);
        assert_eq!(new.of_cluster, [0, 1, 2, 3]);
    }

    #[test]
    fn what_was_an_object_stays_one_at_the_rim_but_not_within_the_background() {
        let known = after_one_window();
        let own = known.rename(&objects(&[0, 0, 1]), &tracks(6, 8), &[0, 0, 1, 1, 2, 2], &NUMBERS, 4, &[]);
        assert_eq!(own.of_cluster, [0, 1, 2]);
        let mixed = known.rename(&objects(&[0, 0]), &tracks(6, 8), &[0, 1, 1, 0, 0, 0], &NUMBERS, 4, &[]);
        assert_eq!(mixed.of_cluster, [0, 0]);
    }

    #[test]
    fn when_labels_run_out_the_one_unseen_for_longest_is_used_again() {
        let mut known = Identities::default();
        let all: Vec<u8> = (0..=255).collect();
        let many = tracks(256, 4);
        let numbers: Vec<u32> = (0..256).collect();
        let first = known.rename(&objects(&all), &many, &numbers, &numbers, 0, &[]);
        assert_eq!(first.of_cluster, all);
        known.advance(&first, &many, &numbers, &numbers, 2, &[]);
        // Objects 1 and 3 live on; none of the new ones shares a trajectory.
        let later = objects(&[0, 1, 2, 3]);
        let next = known.rename(&later, &tracks(4, 4), &[0, 1, 2, 3], &[0, 1, 900, 3], 2, &[]);
        assert_eq!(next.of_cluster, [0, 1, 2, 3]);
        known.advance(&next, &tracks(4, 4), &[0, 1, 2, 3], &[0, 1, 900, 3], 2, &[]);
        let last = known.rename(&objects(&[0, 1]), &tracks(2, 4), &[0, 1], &[0, 901], 2, &[]);
        assert_eq!(last.of_cluster, [0, 4]);
    }

    #[test]
    fn what_comes_back_is_known_by_its_looks_unless_its_label_is_taken_or_the_shot_is_over() {
        let (grey, red, blue) = ([90, 90, 90], [200, 40, 30], [30, 60, 180]);
        let seen = |colours: &[[u8; 3]], found: &Objects| {
            let rgb = (0..64 * 64).flat_map(|i| colours[(i % 64).min(colours.len() - 1)]).collect();
            let frames = vec![Frame::from_rgb(rgb, 64, 64).unwrap(); 8];
            let label: Vec<u32> = (0..colours.len() as u32).collect();
            portraits(&tracks(colours.len(), 8), &label, found, &frames)
        };
        let mut known = Identities::default();
        let two = objects(&[0, 1, 2]);
        known.advance(&two, &tracks(3, 8), &[0, 1, 2], &NUMBERS, 4, &seen(&[grey, red, blue], &two));
        // Both are gone for a window.
        known.advance(&objects(&[0]), &tracks(1, 8), &[0], &[0], 4, &[]);
        let back = |known: &Identities, colours: &[[u8; 3]]| {
            let count = colours.len() as u8;
            let label: Vec<u32> = (0..u32::from(count)).collect();
            let numbers: Vec<u32> = label.iter().map(|l| 50 + l).collect();
            let found = objects(&(0..count).collect::<Vec<_>>());
            known.rename(&found, &tracks(colours.len(), 8), &label, &numbers, 4, &seen(colours, &found)).of_cluster
        };
        assert_eq!(back(&known, &[grey, blue]), [0, 2]);
        assert_eq!(back(&known, &[grey, blue, red]), [0, 2, 1]);
        // Of two that are alike one is another; and so is what looks like none.
        assert_eq!(back(&known, &[grey, red, red]), [0, 1, 3]);
        assert_eq!(back(&known, &[grey, [20, 200, 40]]), [0, 3]);
        known.forget_looks();
        assert_eq!(back(&known, &[grey, blue]), [0, 3]);
    }

    #[test]
    fn a_window_without_objects_or_trajectories_has_no_labels() {
        let known = after_one_window();
        let none = known.rename(&Objects::default(), &Trajectories::empty(8, (8, 8)), &[], &[], 4, &[]);
        assert_eq!(none, Objects::default());
    }
}
