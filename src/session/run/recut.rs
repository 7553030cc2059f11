//! The cut and the masks after a correction: computed again where labels are affected, unchanged elsewhere.

use crate::correction::{StrokeConstraint, regroup};
use crate::image::{Frame, Plane};
use crate::mask::{RefineParams, refine_since};
use crate::objects::Objects;
use crate::session::base::Outputs;
use crate::superpixel::Superpixels;

/// The labels of trajectories after a correction.
#[derive(Debug, Clone)]
pub(crate) struct TargetLabels {
    /// The mask label of each trajectory.
    pub(crate) labels: Vec<u8>,
    /// The mask labels that the correction may change.
    pub(crate) affected: Vec<u8>,
    /// The constraints of all strokes so far.
    pub(crate) constraints: Vec<StrokeConstraint>,
}

/// A cut to be made again after a correction.
#[derive(Debug, Clone)]
pub(crate) struct Recut {
    /// The objects of the clusters after the correction.
    pub(crate) objects: Objects,
    /// The cluster of each superpixel.
    pub(crate) clusters: Vec<Vec<u32>>,
    /// The mask label of each superpixel before the correction.
    old_labels: Vec<Vec<u8>>,
    old_masks: Vec<Plane<u8>>,
    /// True for each mask label (0 to 255) that may change.
    pub(crate) is_open: Vec<bool>,
    pub(crate) constraints: Vec<StrokeConstraint>,
}

impl Recut {
    /// Regroups the clusters of the outputs by the target labels, and takes the cut and the masks from the outputs, after
    /// saving a snapshot of them.
    pub(super) fn new(outputs: &mut Outputs, mut target: TargetLabels) -> Self {
        outputs.push_snapshot();
        let (cut, old_masks) = (std::mem::take(&mut outputs.cut), std::mem::take(&mut outputs.masks));
        let of_cluster = &cut.objects.of_cluster;
        let regrouped = regroup(&outputs.track_set.tracks, &outputs.clusters, of_cluster, &target.labels);
        outputs.clusters = regrouped.clusters;
        // A label without trajectories is no object's any more.
        target.constraints.retain(|constraint| regrouped.of_cluster.contains(&constraint.label));
        outputs.corrections.constraints.clone_from(&target.constraints);
        let old_label = |c: &u32| of_cluster.get(*c as usize).copied().unwrap_or(0);
        let new_cluster = |c: &u32| regrouped.heir.get(*c as usize).copied().unwrap_or(0);
        let clusters = &cut.labels.labels;
        Self {
            old_labels: clusters.iter().map(|frame| frame.iter().map(old_label).collect()).collect(),
            clusters: clusters.iter().map(|frame| frame.iter().map(new_cluster).collect()).collect(),
            objects: objects_from_labels(regrouped.of_cluster),
            old_masks,
            is_open: (0..=255).map(|l| target.affected.contains(&l)).collect(),
            constraints: target.constraints,
        }
    }

    /// Computes the mask of frame `t`. Without a changed superpixel or a stroke it is the old one; elsewhere existing
    /// borders stay and new ones are refined.
    pub(super) fn mask(&self, t: usize, frame: &Frame, outputs: &Outputs, params: &RefineParams) -> Plane<u8> {
        let (old, superpixels) = (&self.old_masks[t], &outputs.superpixels[t]);
        let (old_labels, clusters) = (&self.old_labels[t], &outputs.cut.labels.labels[t]);
        let of_cluster = &self.objects.of_cluster;
        let new_labels: Vec<u8> = clusters.iter().map(|&c| outputs.mask_label(c)).collect();
        let is_used: Vec<bool> = (0..=255).map(|l| of_cluster.contains(&l)).collect();
        let is_changed = new_labels != *old_labels;
        let strokes = || self.constraints.iter().filter(|constraint| constraint.t == t);
        let update = MaskUpdate { old, superpixels, old_labels, new_labels: &new_labels };
        let mut mask = if is_changed { update.mask(&is_used) } else { old.clone() };
        if is_changed {
            let mut refined = refine_since(&mask, old, frame, params);
            let is_drawn = |p: usize| strokes().any(|stroke| stroke.pixels.binary_search(&(p as u32)).is_ok());
            let is_fixed = |p: usize, label: u8| old.data()[p] == label || is_drawn(p);
            outputs.attach_loose_parts(&mut refined, t, params.min_part, is_fixed);
            for (label, &new) in mask.data_mut().iter_mut().zip(refined.data()) {
                if self.is_open[usize::from(*label)] && self.is_open[usize::from(new)] {
                    *label = new;
                }
            }
        }
        for (label, &s) in mask.data_mut().iter_mut().zip(superpixels.label().data()) {
            if !is_used[usize::from(*label)] {
                // Without a background cluster there is no background.
                *label = if is_used[0] { 0 } else { new_labels[s as usize] };
            }
        }
        for constraint in strokes() {
            constraint.pixels.iter().for_each(|&p| mask.data_mut()[p as usize] = constraint.label);
        }
        mask
    }
}

/// Returns the objects of clusters with these labels.
pub(crate) fn objects_from_labels(of_cluster: Vec<u8>) -> Objects {
    Objects { highest_label: of_cluster.iter().max().map_or(0, |&l| l.into()), of_cluster }
}

/// The superpixels of a frame with their labels before and after a correction.
struct MaskUpdate<'a> {
    old: &'a Plane<u8>,
    superpixels: &'a Superpixels,
    old_labels: &'a [u8],
    new_labels: &'a [u8],
}

impl MaskUpdate<'_> {
    /// Returns the old mask with the new labels of superpixels. A pixel whose old label was not its superpixel's, since
    /// refining had moved a border, takes the new label of the nearest pixels with its old label; if there are none it keeps
    /// its label as long as that is in use.
    fn mask(&self, is_used: &[bool]) -> Plane<u8> {
        let (width, height) = (self.old.width(), self.old.height());
        let superpixel = self.superpixels.label();
        let mut mask = self.old.clone();
        let mut pending = Vec::new();
        for (p, &s) in superpixel.data().iter().enumerate() {
            if self.old.data()[p] == self.old_labels[s as usize] {
                mask.data_mut()[p] = self.new_labels[s as usize];
            } else {
                pending.push(p);
            }
        }
        let mut is_pending = vec![false; mask.data().len()];
        pending.iter().for_each(|&p| is_pending[p] = true);
        let mut resolved: Vec<(usize, u8)> = Vec::new();
        loop {
            resolved.clear();
            pending.retain(|&p| {
                let (x, y) = (p % width, p / width);
                let neighbours = [
                    (y > 0, p.wrapping_sub(width)),
                    (x > 0, p.wrapping_sub(1)),
                    (x + 1 < width, p + 1),
                    (y + 1 < height, p + width),
                ];
                let has_same_label = |q: &usize| !is_pending[*q] && self.old.data()[*q] == self.old.data()[p];
                let source = neighbours.into_iter().filter(|n| n.0).map(|n| n.1).find(has_same_label);
                resolved.extend(source.map(|q| (p, mask.data()[q])));
                source.is_none()
            });
            if resolved.is_empty() {
                break;
            }
            for &(p, label) in &resolved {
                (mask.data_mut()[p], is_pending[p]) = (label, false);
            }
        }
        for p in pending.into_iter().filter(|&p| !is_used[usize::from(self.old.data()[p])]) {
            mask.data_mut()[p] = self.new_labels[superpixel.data()[p] as usize];
        }
        mask
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::CutLabels;
    use crate::session::base::Cut;
    use crate::trajectory::Trajectories;

    #[test]
    fn a_small_new_part_goes_unless_a_stroke_is_on_it() {
        // A large object, and a piece apart that a correction gave the same label.
        let rows = ["1111111000", "1111111020", "1111111020", "1111111020", "1111111000"];
        let label = Plane::from_fn(10, 5, |x, y| u32::from(rows[y].as_bytes()[x] - b'0'));
        let frame = Frame::from_rgb(vec![90; 150], 10, 5).unwrap();
        let objects = objects_from_labels(vec![0, 1]);
        let mut outputs = Outputs { superpixels: vec![Superpixels::from(&label)], ..Outputs::default() };
        let labels = CutLabels { labels: vec![vec![0, 1, 1]] };
        outputs.cut = Cut { labels, objects: objects.clone(), ..Cut::default() };
        outputs.track_set.tracks = Trajectories::empty(1, (10, 5));
        let piece = |constraints: Vec<StrokeConstraint>| {
            let recut = Recut {
                objects: objects.clone(),
                clusters: vec![vec![0, 1, 0]],
                old_labels: vec![vec![0, 1, 0]],
                old_masks: vec![label.map(|l| u8::from(l == 1))],
                is_open: vec![true; 256],
                constraints,
            };
            let mask = recut.mask(0, &frame, &outputs, &RefineParams { band: 0, ..RefineParams::default() });
            [1, 2, 3].map(|y| mask[(8, y)])
        };
        let stroke = StrokeConstraint { t: 0, pixels: vec![28], tracks: Vec::new(), label: 1 };
        assert_eq!((piece(Vec::new()), piece(vec![stroke])), ([0; 3], [1; 3]));
    }
}
