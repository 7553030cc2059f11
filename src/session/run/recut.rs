//! The cut and the masks made again where a correction asks for it, and left as they are elsewhere.

use crate::correction::{Held, regroup};
use crate::image::{Frame, Plane};
use crate::mask::refine_since;
use crate::objects::Objects;
use crate::session::base::{Outputs, Params};
use crate::superpixel::Superpixels;

/// What a correction wants of the trajectories.
#[derive(Debug, Clone)]
pub(crate) struct Wanted {
    /// The mask label of each.
    pub(crate) label: Vec<u8>,
    /// Which labels are concerned.
    pub(crate) concerned: Vec<u8>,
    /// What strokes hold from now on.
    pub(crate) held: Vec<Held>,
}

/// What is cut anew.
#[derive(Debug, Clone)]
pub(crate) struct Recut {
    /// Which clusters are which objects after the correction.
    pub(crate) objects: Objects,
    /// The cluster of each superpixel.
    pub(crate) present: Vec<Vec<u32>>,
    /// The mask label that each superpixel had.
    had: Vec<Vec<u8>>,
    masks: Vec<Plane<u8>>,
    /// Which mask labels can be given and taken, 0 to 255.
    pub(crate) open: Vec<bool>,
    pub(crate) held: Vec<Held>,
}

impl Recut {
    /// Puts clusters by the wanted labels to the outputs, in force from now on, and takes the cut and the masks from them,
    /// which can be restored.
    pub(crate) fn new(outputs: &mut Outputs, mut wanted: Wanted) -> Self {
        outputs.remember();
        let (cut, masks) = (std::mem::take(&mut outputs.cut), std::mem::take(&mut outputs.masks));
        let of_cluster = &cut.objects.of_cluster;
        let regrouped = regroup(&outputs.tracked.tracks, &outputs.clusters, of_cluster, &wanted.label);
        outputs.clusters = regrouped.clusters;
        // A label whose last trajectory has gone elsewhere is no object's any more.
        wanted.held.retain(|held| regrouped.of_cluster.contains(&held.label));
        outputs.corrections.held.clone_from(&wanted.held);
        let label_of = |c: &u32| of_cluster.get(*c as usize).copied().unwrap_or(0);
        let heir_of = |c: &u32| regrouped.heir.get(*c as usize).copied().unwrap_or(0);
        let labels = &cut.labels.labels;
        Self {
            had: labels.iter().map(|frame| frame.iter().map(label_of).collect()).collect(),
            present: labels.iter().map(|frame| frame.iter().map(heir_of).collect()).collect(),
            objects: objects_with(regrouped.of_cluster),
            masks,
            open: (0..=255).map(|l| wanted.concerned.contains(&l)).collect(),
            held: wanted.held,
        }
    }

    /// The mask of frame `t`. Where no superpixel has another label and no stroke was painted, it is what it was;
    /// elsewhere borders stay where there were some, and new ones are refined.
    pub(crate) fn mask(&self, t: usize, frame: &Frame, outputs: &Outputs, params: &Params) -> Plane<u8> {
        let (old, superpixels, clusters) = (&self.masks[t], &outputs.superpixels[t], &outputs.cut.labels.labels[t]);
        let of_cluster = &self.objects.of_cluster;
        let now: Vec<u8> = clusters.iter().map(|&c| outputs.label_of(c)).collect();
        let change = Change { old, superpixels, had: &self.had[t], now: &now };
        let used: Vec<bool> = (0..=255).map(|l| of_cluster.contains(&l)).collect();
        let mut mask = if now == self.had[t] { old.clone() } else { change.mask(&used) };
        if now != self.had[t] {
            let refined = refine_since(&mask, old, frame, &params.refine);
            for (label, &new) in mask.data_mut().iter_mut().zip(refined.data()) {
                if self.open[usize::from(*label)] && self.open[usize::from(new)] {
                    *label = new;
                }
            }
        }
        for (label, &s) in mask.data_mut().iter_mut().zip(superpixels.label().data()) {
            if !used[usize::from(*label)] {
                // Without a cluster of the background there is none.
                *label = if used[0] { 0 } else { now[s as usize] };
            }
        }
        for held in self.held.iter().filter(|h| h.t == t) {
            held.pixels.iter().for_each(|&p| mask.data_mut()[p as usize] = held.label);
        }
        mask
    }
}

/// The objects of clusters that bear these labels.
pub(crate) fn objects_with(of_cluster: Vec<u8>) -> Objects {
    Objects { highest_label: of_cluster.iter().max().map_or(0, |&l| l.into()), of_cluster }
}

/// One frame's superpixels with the labels that they had and have.
struct Change<'a> {
    old: &'a Plane<u8>,
    superpixels: &'a Superpixels,
    had: &'a [u8],
    now: &'a [u8],
}

impl Change<'_> {
    /// The mask with what superpixels have now. Pixels that had another label than their superpixel, since refining had
    /// moved a border, follow the nearest of their label; those without any keep it as long as it is in use.
    fn mask(&self, used: &[bool]) -> Plane<u8> {
        let (width, height) = (self.old.width(), self.old.height());
        let superpixel = self.superpixels.label();
        let mut mask = self.old.clone();
        let mut strays = Vec::new();
        for (p, &s) in superpixel.data().iter().enumerate() {
            if self.old.data()[p] == self.had[s as usize] {
                mask.data_mut()[p] = self.now[s as usize];
            } else {
                strays.push(p);
            }
        }
        let mut is_stray = vec![false; mask.data().len()];
        strays.iter().for_each(|&p| is_stray[p] = true);
        let mut found: Vec<(usize, u8)> = Vec::new();
        loop {
            found.clear();
            strays.retain(|&p| {
                let (x, y) = (p % width, p / width);
                let near = [
                    (y > 0, p.wrapping_sub(width)),
                    (x > 0, p.wrapping_sub(1)),
                    (x + 1 < width, p + 1),
                    (y + 1 < height, p + width),
                ];
                let known = |q: &usize| !is_stray[*q] && self.old.data()[*q] == self.old.data()[p];
                let next = near.into_iter().filter(|n| n.0).map(|n| n.1).find(known);
                found.extend(next.map(|q| (p, mask.data()[q])));
                next.is_none()
            });
            if found.is_empty() {
                break;
            }
            for &(p, label) in &found {
                (mask.data_mut()[p], is_stray[p]) = (label, false);
            }
        }
        for p in strays.into_iter().filter(|&p| !used[usize::from(self.old.data()[p])]) {
            mask.data_mut()[p] = self.now[superpixel.data()[p] as usize];
        }
        mask
    }
}
