//! The cut and the masks made anew where a correction asks for it, and left as they are elsewhere.

use super::dense::Clip;
use crate::correction::Held;
use crate::cut::{CutInput, CutLabels, GabrielCut, Objects, Region, paint, refine};
use crate::image::Plane;
use crate::superpixel::Superpixels;

/// What is cut anew. Clusters and objects are already those after the correction.
#[derive(Debug)]
pub(super) struct Recut {
    /// The cluster of each superpixel.
    present: Vec<Vec<u32>>,
    /// The mask label that each superpixel had.
    had: Vec<Vec<u8>>,
    masks: Vec<Plane<u8>>,
    /// Which mask labels can be given and taken.
    open: Vec<bool>,
    held: Vec<Held>,
}

/// What was before a correction.
#[derive(Debug)]
pub(super) struct Before {
    pub(super) cut: CutLabels,
    pub(super) objects: Objects,
    pub(super) masks: Vec<Plane<u8>>,
}

impl Recut {
    /// `heir` is what each cluster before has become. `open` has an entry for each mask label, 0 to 255.
    pub(super) fn new(before: Before, heir: &[u32], open: Vec<bool>, held: Vec<Held>) -> Self {
        let Before { cut, objects, masks } = before;
        let label_of = |c: &u32| objects.of_cluster.get(*c as usize).copied().unwrap_or(0);
        let heir_of = |c: &u32| heir.get(*c as usize).copied().unwrap_or(0);
        let had = cut.labels.iter().map(|frame| frame.iter().map(label_of).collect()).collect();
        let present = cut.labels.iter().map(|frame| frame.iter().map(heir_of).collect()).collect();
        Self { present, had, masks, open, held }
    }

    /// The energy of the part that is cut anew.
    pub(super) fn cut(&self, input: &CutInput, objects: &Objects, clip: &Clip<'_>) -> GabrielCut {
        let open: Vec<bool> = objects.of_cluster.iter().map(|&l| self.open[usize::from(l)]).collect();
        let mut held = Vec::new();
        for (t, superpixels) in input.superpixels.iter().enumerate() {
            for (superpixel, label) in self.held_superpixels(t, superpixels) {
                held.push((t, superpixel, objects.of_cluster.iter().map(|&l| l == label).collect()));
            }
        }
        GabrielCut::within(input, &clip.params.cut, &Region { present: &self.present, open: &open, held: &held })
    }

    /// The superpixels of frame `t` under strokes that agree on their label.
    fn held_superpixels(&self, t: usize, superpixels: &Superpixels) -> Vec<(u32, u8)> {
        let of_frame = self.held.iter().filter(|h| h.t == t);
        let under = of_frame.flat_map(|h| h.pixels.iter().map(|&p| (superpixels.label.data()[p as usize], h.label)));
        let mut under: Vec<(u32, u8)> = under.collect();
        crate::order::sort_by_key(&mut under, |&(s, l)| crate::order::pair(s, l.into()));
        under.dedup();
        under.chunk_by(|a, b| a.0 == b.0).filter(|labels| labels.len() == 1).map(|labels| labels[0]).collect()
    }

    /// The mask of frame `t`. Where no superpixel has another label and no stroke was painted, it is what it was; otherwise borders
    /// between labels that are not concerned stay.
    pub(super) fn mask(
        &self,
        t: usize,
        superpixels: &Superpixels,
        clusters: &[u32],
        objects: &Objects,
        clip: &Clip<'_>,
    ) -> Plane<u8> {
        let label_of = |c: u32| objects.of_cluster.get(c as usize).copied().unwrap_or(0);
        let mut mask = self.masks[t].clone();
        if clusters.iter().zip(&self.had[t]).any(|(&c, &had)| label_of(c) != had) {
            let painted = paint(superpixels, clusters).map(label_of);
            let refined = refine(&painted, &clip.frames[t], &clip.params.refine);
            for (old, &new) in mask.data_mut().iter_mut().zip(refined.data()) {
                if self.open[usize::from(*old)] && self.open[usize::from(new)] {
                    *old = new;
                }
            }
        }
        for held in self.held.iter().filter(|h| h.t == t) {
            held.pixels.iter().for_each(|&p| mask.data_mut()[p as usize] = held.label);
        }
        mask
    }
}
