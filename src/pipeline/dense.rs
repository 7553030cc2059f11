//! The last stages: superpixels frame by frame, the cut over the whole clip, masks frame by frame.

use super::geometry::Scale;
use super::recut::{Before, Recut};
use super::stage::{Progress, Stage};
use super::windows::Windows;
use crate::contour::{BoundaryMap, boundary_map, contour_segments};
use crate::cut::{
    CutInput, CutLabels, GabrielCut, Objects, STRANGER, UNKNOWN, find_objects, labels_for, paint, refine,
};
use crate::discretize::Clusters;
use crate::flow::CompactFlow;
use crate::image::{Frame, Plane};
use crate::params::Params;
use crate::superpixel::{Superpixels, gabriel_superpixels};
use crate::trajectory::Trajectories;

/// What the dense stages are made from: the frames, and what the stages before have found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clip<'a> {
    pub(super) frames: &'a [Frame],
    pub(super) flows: &'a [CompactFlow],
    /// The trajectories that were clustered, in working pixels.
    pub(super) tracks: &'a Trajectories,
    pub(super) clusters: &'a Clusters,
    /// The greatest saliency of each of the denser trajectories that the masks are made from.
    pub(super) salience: &'a [f32],
    /// The clip-wide number of each clustered trajectory.
    pub(super) numbers: &'a [u32],
    /// Where the clip is taken window by window.
    pub(super) windows: Option<&'a Windows>,
    pub(super) params: &'a Params,
}

impl Clip<'_> {
    /// Which clusters are objects, under the labels that they had in the window before.
    fn objects(&self) -> Objects {
        let found = find_objects(self.tracks, self.clusters);
        match self.windows {
            Some(w) => w.identities.rename(&found, self.tracks, &self.clusters.label, self.numbers, w.overlap),
            None => found,
        }
    }
}

/// What the dense stages have found so far, at working size.
#[derive(Debug, Default)]
pub(super) struct Dense {
    /// Trajectories denser and shorter than those that were clustered, in working pixels.
    pub(super) tracks: Option<Trajectories>,
    pub(super) superpixels: Vec<Superpixels>,
    /// The cut while it is being made.
    moves: Option<Box<GabrielCut>>,
    pub(super) cut: CutLabels,
    pub(super) objects: Objects,
    pub(super) masks: Vec<Plane<u8>>,
    /// What a correction asks for, until it is done.
    recut: Option<Box<Recut>>,
}

impl Dense {
    pub(super) fn is_finished(&self, frames: &[Frame]) -> bool {
        self.masks.len() == frames.len()
    }

    /// Which clusters are which objects, once the cut is made.
    pub(super) fn objects(&self) -> Option<&Objects> {
        (!self.cut.labels.is_empty()).then_some(&self.objects)
    }

    /// The cluster of each pixel of frame `t`, in agreement with its mask.
    ///
    /// Refining moves borders between mask labels: a pixel moved to another label takes the largest cluster there in this frame.
    pub(super) fn clusters(&self, t: usize) -> Option<Plane<u32>> {
        let mask = self.masks.get(t)?;
        let mut clusters = paint(self.superpixels.get(t)?, self.cut.labels.get(t)?);
        let label_of = &self.objects.of_cluster;
        let mut area = vec![0_u64; label_of.len()];
        for &c in clusters.data() {
            area.get_mut(c as usize).into_iter().for_each(|a| *a += 1);
        }
        let members = |label: u8| (0..label_of.len()).filter(move |&c| label_of[c] == label);
        let largest: Vec<_> = (0..=255).map(|label| members(label).max_by_key(|&c| area[c])).collect();
        for (cluster, &label) in clusters.data_mut().iter_mut().zip(mask.data()) {
            if label_of.get(*cluster as usize).is_some_and(|&own| own != label) {
                *cluster = largest[usize::from(label)].map_or(*cluster, |c| c as u32);
            }
        }
        Some(clusters)
    }

    /// Begins the cut anew, with the objects of corrected clusters.
    pub(super) fn begin_again(&mut self, objects: Objects, recut: impl FnOnce(Before) -> Recut) {
        let before = Before {
            cut: std::mem::take(&mut self.cut),
            objects: std::mem::replace(&mut self.objects, objects),
            masks: std::mem::take(&mut self.masks),
        };
        self.recut = Some(Box::new(recut(before)));
    }

    /// Puts back what was found before, whatever is under way.
    pub(super) fn restore(&mut self, cut: CutLabels, objects: Objects, masks: Vec<Plane<u8>>) {
        (self.cut, self.objects, self.masks) = (cut, objects, masks);
        (self.moves, self.recut) = (None, None);
    }

    /// One frame's superpixels, a move of the cut, or one frame's mask, whichever is next.
    pub(super) fn step(&mut self, clip: &Clip<'_>) -> Progress {
        let total = clip.frames.len() as u32;
        let t = self.superpixels.len();
        if let Some(frame) = clip.frames.get(t) {
            let map = boundaries_of(frame, flow_at(clip.flows, t), clip.params);
            self.superpixels.push(superpixels_of(&map, clip.params));
            return Progress { stage: Stage::Superpixels, done: t as u32 + 1, total };
        }
        if self.cut.labels.is_empty() {
            return self.step_cut(clip);
        }
        let t = self.masks.len();
        if let Some(recut) = &self.recut {
            self.masks.push(recut.mask(t, &self.superpixels[t], &self.cut.labels[t], &self.objects, clip));
            if self.is_finished(clip.frames) {
                self.recut = None;
            }
            return Progress { stage: Stage::Masks, done: t as u32 + 1, total };
        }
        let mask = paint(&self.superpixels[t], &self.cut.labels[t]);
        // A clip without clusters is all background.
        let mask = mask.map(|cluster| self.objects.of_cluster.get(cluster as usize).copied().unwrap_or(0));
        self.masks.push(refine(&mask, &clip.frames[t], &clip.params.refine));
        Progress { stage: Stage::Masks, done: t as u32 + 1, total }
    }

    fn step_cut(&mut self, clip: &Clip<'_>) -> Progress {
        let mut moves = self.moves.take().unwrap_or_else(|| Box::new(self.begin_cut(clip)));
        let more = moves.step();
        let (done, total) = moves.progress();
        if more {
            self.moves = Some(moves);
        } else {
            self.cut = moves.finish();
            if self.recut.is_none() {
                self.objects = clip.objects();
            }
        }
        // Making the energy counts as a step, so that a cut without any move is seen to end.
        Progress { stage: Stage::Cut, done: done + 1, total: total + 1 }
    }

    /// The energy, from the denser trajectories labelled by those that were clustered.
    fn begin_cut(&self, clip: &Clip<'_>) -> GabrielCut {
        let params = &clip.params.cut;
        let num_labels = clip.clusters.count.max(1);
        let clustered = &clip.clusters.label;
        let mut voted = self.tracks.as_ref().map(|dense| labels_for(dense, clip.tracks, clustered, num_labels, params));
        // What moves like nothing around it is a sign of an object only where it stands out; elsewhere it is an error of the flow.
        for (label, &salience) in voted.iter_mut().flatten().zip(clip.salience) {
            if *label == STRANGER && f64::from(salience) <= clip.params.saliency.threshold {
                *label = UNKNOWN;
            }
        }
        if let (Some(recut), Some(dense), Some(voted), Some(first)) =
            (&self.recut, &self.tracks, &mut voted, self.superpixels.first())
        {
            recut.vote(dense, voted, &self.objects, &first.label);
        }
        let found = if self.recut.is_some() { self.objects.clone() } else { clip.objects() };
        let objects: Vec<bool> = found.of_cluster.iter().map(|&label| label > 0).collect();
        let input = CutInput {
            superpixels: &self.superpixels,
            tracks: self.tracks.as_ref().unwrap_or(clip.tracks),
            label: voted.as_ref().unwrap_or(clustered),
            num_labels,
            objects: &objects,
            flows: clip.flows,
            frames: clip.frames,
        };
        match &self.recut {
            Some(recut) => recut.cut(&input, &self.objects, clip),
            None => GabrielCut::new(&input, params),
        }
    }
}

/// Superpixels of one frame, from its boundary map.
fn superpixels_of(map: &BoundaryMap, params: &Params) -> Superpixels {
    gabriel_superpixels(&contour_segments(map, &params.contour), map, &params.superpixel)
}

/// Pb of one frame. `flow` leads from it to another; it is looked at only where motion has a weight.
pub(super) fn boundaries_of(frame: &Frame, flow: Option<&CompactFlow>, params: &Params) -> BoundaryMap {
    let flow = flow.filter(|_| params.contour.motion_weight > 0.0).map(|f| f.unpack(1.0, 1.0));
    boundary_map(frame, flow.as_ref(), &params.contour)
}

/// The flow from frame `t` to the next; for the last frame, that which leads to it.
pub(super) fn flow_at(flows: &[CompactFlow], t: usize) -> Option<&CompactFlow> {
    flows.get(t).or(flows.last())
}

/// Labels at input size: each input pixel takes the value of the working pixel that covers its centre.
pub(super) fn to_input<T: Copy>(mask: &Plane<T>, scale: Scale) -> Plane<T> {
    let (sx, sy) = (scale.x(), scale.y());
    let place = |v: usize, s: f64, limit: usize| (((v as f64 + 0.5) / s) as usize).min(limit - 1);
    Plane::from_fn(scale.input.0, scale.input.1, |x, y| mask[(place(x, sx, mask.width()), place(y, sy, mask.height()))])
}
