//! The cut and the masks made again where a correction asks for it, and left as they are elsewhere.

use crate::correction::{Held, regroup};
use crate::cut::{CutInput, CutParams, GabrielCut, Region, pixel_of};
use crate::image::{Frame, Plane};
use crate::mask::refine_since;
use crate::objects::Objects;
use crate::order::{pair, sort_by_key};
use crate::session::base::{CutRegion, Outputs, Params};
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

/// A stroke holds a superpixel if this share of the stroke lies in it, or if it covers this share of the superpixel.
/// One that it only brushes may be large, and belong elsewhere.
const STROKE_SHARE: f32 = 0.25;
const SUPERPIXEL_SHARE: f32 = 0.1;

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
    present: Vec<Vec<u32>>,
    /// The mask label that each superpixel had.
    had: Vec<Vec<u8>>,
    masks: Vec<Plane<u8>>,
    /// Which mask labels can be given and taken, 0 to 255.
    open: Vec<bool>,
    held: Vec<Held>,
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

    /// Whether a mask label is one of those that the correction is about.
    pub(crate) fn is_open(&self, label: u8) -> bool {
        self.open[usize::from(label)]
    }

    /// The cluster of each superpixel, frame by frame.
    pub(crate) fn present(&self) -> &[Vec<u32>] {
        &self.present
    }

    /// The energy of the part that is cut anew.
    pub(crate) fn cut(&self, input: &CutInput, params: &CutParams) -> GabrielCut {
        let CutRegion { open, held } = self.region(input.superpixels);
        GabrielCut::within(input, params, &Region { present: &self.present, open: &open, held: &held })
    }

    /// Which clusters can be given and taken, and which superpixels are held.
    pub(crate) fn region(&self, superpixels: &[Superpixels]) -> CutRegion {
        let of_cluster = &self.objects.of_cluster;
        let open = of_cluster.iter().map(|&l| self.open[usize::from(l)]).collect();
        let mut held = Vec::new();
        for (t, superpixels) in superpixels.iter().enumerate() {
            for (superpixel, label) in self.held_superpixels(t, superpixels) {
                held.push((t, superpixel, of_cluster.iter().map(|&l| l == label).collect()));
            }
        }
        CutRegion { open, held }
    }

    /// The denser trajectories that strokes were painted over have their labels, by the largest cluster of each.
    pub(crate) fn vote(&self, tracks: &Trajectories, label: &mut [u32], size: (usize, usize)) {
        for held in &self.held {
            let Some(cluster) = self.objects.of_cluster.iter().position(|&l| l == held.label) else { continue };
            for (i, x, y) in tracks.alive(held.t) {
                if held.pixels.binary_search(&(pixel_of(size, x, y) as u32)).is_ok() {
                    label[i] = cluster as u32;
                }
            }
        }
    }

    /// The superpixels of frame `t` that strokes lie over to a good part of the stroke or of the superpixel, where
    /// these agree on the label.
    fn held_superpixels(&self, t: usize, superpixels: &Superpixels) -> Vec<(u32, u8)> {
        let (label, area) = (superpixels.label(), superpixels.areas());
        let mut under: Vec<(u32, u8)> = Vec::new();
        for held in self.held.iter().filter(|h| h.t == t) {
            let mut of_stroke: Vec<u32> = held.pixels.iter().map(|&p| label.data()[p as usize]).collect();
            sort_by_key(&mut of_stroke, |&s| s.into());
            let good = |pixels: &&[u32]| {
                let count = pixels.len() as f32;
                count >= STROKE_SHARE * held.pixels.len() as f32
                    || count >= SUPERPIXEL_SHARE * area[pixels[0] as usize] as f32
            };
            under.extend(of_stroke.chunk_by(|a, b| a == b).filter(good).map(|pixels| (pixels[0], held.label)));
        }
        sort_by_key(&mut under, |&(s, l)| pair(s, l.into()));
        under.dedup();
        under.chunk_by(|a, b| a.0 == b.0).filter(|labels| labels.len() == 1).map(|labels| labels[0]).collect()
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
