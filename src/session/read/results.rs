//! The results of a session so far.

use crate::Error;
use crate::affinity::affinities;
use crate::background::{CleanPlateInput, clean_plate};
use crate::camera::Camera;
use crate::connectedness::Components;
use crate::contour::{BoundaryMap, frame_boundaries};
use crate::cut::paint;
use crate::discontinuity::{Discontinuities, discontinuities};
use crate::discretize::{
    Clusters, DiscretizeMethod, DiscretizeParams, discretize, discretize_into, oversegment, threshold_segmentation,
};
use crate::embedding::{Embedding, embed};
use crate::evidence::{ClusterCues, ClusterPair, EvidenceInput, UNLABELLED, cluster_motions, cluster_pairs};
use crate::flow::{CompactFlow, FlowField};
use crate::image::{Frame, Plane};
use crate::mask::{Agreement, CutMasks, agreement, expected_j, expected_j_terms};
use crate::objects::{Objects, cluster_cues};
use crate::saliency::Saliency;
use crate::session::base::{Outputs, Scale, Stage, TrackSet};
use crate::session::run::{Clip, Phase, Session, estimate_camera, model_background};
use crate::sparse::SymCsr;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

impl Session {
    /// Returns the number of frames pushed, or of the trajectories that were set.
    pub fn num_frames(&self) -> usize {
        match self.frames().len() {
            0 => self.trajectories().map_or(0, |t| t.num_frames),
            frames => frames,
        }
    }

    /// Returns width and height of the input frames in pixels; `None` before the first.
    #[doc(hidden)] // For the command line, the packages for Python and JavaScript, and benchmarks.
    pub fn input_size(&self) -> Option<(usize, usize)> {
        self.clip().map(|clip| clip.scale.input)
    }

    /// Returns width and height at which frames are processed.
    pub fn working_size(&self) -> Option<(usize, usize)> {
        self.clip().map(|clip| clip.scale.working)
    }

    /// Returns the forward flow from frame `t` to `t + 1`: displacements in input pixels, rounded to 1/64 working pixel, on
    /// the grid of the working size.
    ///
    /// # Errors
    /// [`Error::State`] until that flow is computed, and without frames.
    pub fn flow(&self, t: usize) -> Result<FlowField, Error> {
        let (flows, scale) = (self.flows(), self.clip().map(|clip| clip.scale));
        match (flows.get(t), scale) {
            (Some(flow), Some(scale)) => Ok(flow.unpack(scale.x() as f32, scale.y() as f32)),
            _ => {
                Err(Error::state(&format!("flow of pair {t} is not available (expected a pair in 0..{})", flows.len())))
            }
        }
    }

    /// Returns the trajectories in input pixels, once tracked.
    pub fn trajectories(&self) -> Option<&Trajectories> {
        self.track_set().map(|track_set| &track_set.input)
    }

    /// Returns the denser trajectories that masks are made from, in working pixels; `None` before they are tracked, and with
    /// `clip.dense` off.
    #[doc(hidden)] // For the packages for Python and JavaScript.
    pub fn mask_trajectories(&self) -> Option<&Trajectories> {
        self.track_set()?.mask_tracks.as_ref()
    }

    /// Returns the affinity matrix A, without the affinities between trajectories that the foreground separates.
    pub fn affinities(&self) -> Option<&SymCsr> {
        Some(&self.outputs_after(Stage::Affinities)?.affinities)
    }

    /// Returns the spectral embedding of [`Session::affinities`].
    pub fn embedding(&self) -> Option<&Embedding> {
        Some(&self.outputs_after(Stage::Embedding)?.embedding)
    }

    /// Returns the neighbour pairs and their discontinuities.
    pub fn discontinuities(&self) -> Option<&Discontinuities> {
        Some(&self.outputs_after(Stage::Discontinuities)?.discontinuities)
    }

    /// Returns the saliency of each trajectory; `None` until it is computed, and without frames.
    pub fn saliency(&self) -> Option<&Saliency> {
        Some(&self.outputs()?.saliency.as_ref()?.tracks)
    }

    /// Computes the saliency of each pixel of frame `t`, in `0.0..=1.0`, at working size. For the last frame the flow that leads
    /// to it is used.
    ///
    /// # Errors
    /// [`Error::State`] if there is no such frame, or until saliency is computed.
    pub fn saliency_map(&self, t: usize) -> Result<Plane<f32>, Error> {
        let (frames, flows) = (self.frames().len(), self.flows());
        let saliency = self.outputs().and_then(|outputs| outputs.saliency.as_ref());
        let pair = t.min(flows.len().saturating_sub(1));
        match (saliency, flows.get(pair)) {
            (Some(saliency), Some(flow)) if t < frames => Ok(saliency.maps.map_of_field(pair, flow)),
            (saliency, _) => Err(missing_frame("saliency map", t, saliency.map_or(0, |_| frames))),
        }
    }

    /// Returns the connected components of the foreground in each frame; `None` as [`Session::saliency`].
    pub fn components(&self) -> Option<&Components> {
        self.outputs()?.components.as_ref()
    }

    /// Returns the cluster of each trajectory.
    pub fn clusters(&self) -> Option<&Clusters> {
        Some(&self.outputs_after(Stage::Clusters)?.clusters)
    }

    /// Returns the mask of frame `t` at input size: 0 is the background, `1..=`[`Objects::highest_label`] are the objects.
    ///
    /// # Errors
    /// [`Error::State`] until it is computed, without frames, and with `clip.dense` off.
    pub fn labels(&self, t: usize) -> Result<Plane<u8>, Error> {
        let masks = self.masks();
        match (masks.get(t), self.clip()) {
            (Some(mask), Some(clip)) => Ok(to_input(mask, clip.scale)),
            _ => Err(missing_frame("mask", t, masks.len())),
        }
    }

    /// Returns the mask of frame `t` at working size; [`crate::mask::enlarge`] brings it to the size of the source.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn working_labels(&self, t: usize) -> Result<&Plane<u8>, Error> {
        let masks = self.masks();
        masks.get(t).ok_or_else(|| missing_frame("mask", t, masks.len()))
    }

    /// Computes the clean plate of frame `t` at working size: the scene without the objects, RGBA.
    ///
    /// Background pixels are copied from the frame; pixels behind objects come from the nearest frames of the clip that show the
    /// scene there, warped by the camera's motion. Alpha is 0 if no frame does, and 255 elsewhere.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn background(&self, t: usize) -> Result<Plane<[u8; 4]>, Error> {
        let (frames, masks) = (self.frames(), self.masks());
        let outputs = self.outputs().filter(|_| masks.len() == frames.len() && t < masks.len());
        let outputs = outputs.ok_or_else(|| missing_frame("background", t, masks.len()))?;
        let still = Camera::new(&[], &[], None);
        let is_scene = outputs.clusters.label.iter().map(|&cluster| outputs.mask_label(cluster) == 0).collect();
        let (camera, tracks) = (outputs.camera.as_ref().unwrap_or(&still), &outputs.track_set.tracks);
        Ok(clean_plate(&CleanPlateInput { frames, masks, camera, tracks, is_scene }, t))
    }

    /// Returns the cluster of each pixel of frame `t` at input size.
    ///
    /// Invariant: [`Objects::of_cluster`] of a pixel's cluster is its label in [`Session::labels`]. Without clusters the result
    /// is 0.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn cluster_labels(&self, t: usize) -> Result<Plane<u32>, Error> {
        match (self.outputs(), self.clip()) {
            (Some(outputs), Some(clip)) if t < outputs.masks.len() => {
                Ok(to_input(&frame_clusters(outputs, t), clip.scale))
            }
            _ => Err(missing_frame("cluster map", t, self.masks().len())),
        }
    }

    /// Returns the Gabriel superpixels of frame `t`, at working size.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn superpixels(&self, t: usize) -> Result<&Superpixels, Error> {
        let superpixels = self.outputs().map_or(&[][..], |outputs| &outputs.superpixels);
        superpixels.get(t).ok_or_else(|| missing_frame("superpixels", t, superpixels.len()))
    }

    /// Computes the boundary probability of frame `t`, at working size.
    ///
    /// # Errors
    /// [`Error::State`] if there is no such frame.
    #[doc(hidden)] // For the command line, and the packages for Python and JavaScript.
    pub fn boundaries(&self, t: usize) -> Result<BoundaryMap, Error> {
        let clip = self.clip();
        match clip.and_then(|clip| Some((clip.frames.get(t)?, clip))) {
            Some((frame, clip)) => Ok(frame_boundaries(frame, &clip.params.contour)),
            None => Err(missing_frame("boundary map", t, self.frames().len())),
        }
    }

    /// Returns the object of each cluster; `None` until the cut is made. Without clusters there are no objects. An object may have
    /// no pixel in any mask, if the cut gave all of them to others.
    pub fn objects(&self) -> Option<&Objects> {
        // A run without masks ends without superpixels and without a cut.
        let outputs = self.outputs_after(Stage::Cut).filter(|outputs| !outputs.superpixels.is_empty())?;
        Some(&outputs.cut.objects)
    }

    /// Computes the clusters with connectedness off, from the affinities on, to show its effect. `None` until the clusters are
    /// computed.
    ///
    /// # Errors
    /// As [`affinities`].
    #[doc(hidden)] // For the Python package and benchmarks.
    pub fn motion_clusters(&self) -> Result<Option<Clusters>, Error> {
        let (Some(clip), Some(outputs)) = (self.clip(), self.outputs_after(Stage::Clusters)) else { return Ok(None) };
        let (params, seed, track_set) = (&clip.params, clip.params.clip.seed, &outputs.track_set);
        let affinities = affinities(track_set.with_past(), params.spacing(), &params.affinity, seed)?;
        let embedding = embed(&affinities, &params.embedding, seed);
        let neighborhoods = outputs.discontinuities.neighborhoods.clone();
        let edges = discontinuities(neighborhoods, &embedding, &params.discontinuity);
        let maps = outputs.saliency.as_ref().map(|saliency| &saliency.maps);
        let evidence = EvidenceInput::new(&track_set.tracks, &edges, &params.affinity, maps, None);
        Ok(Some(discretize(&embedding, &evidence, &params.discretize, seed)))
    }

    /// Discretizes the embedding by another method, with `count` clusters (before merging) from as many eigenvectors, to compare
    /// methods. `count` is limited by the number of eigenvectors. `None` until the discontinuities are computed.
    #[doc(hidden)] // For the Python package and benchmarks.
    pub fn clusters_by(&self, method: DiscretizeMethod, count: usize) -> Option<Clusters> {
        let (clip, outputs) = (self.clip()?, self.outputs_after(Stage::Discontinuities)?);
        let params = DiscretizeParams { method, ..clip.params.discretize.clone() };
        let evidence = outputs.cluster_evidence(&clip.params.affinity);
        Some(discretize_into(&outputs.embedding, &evidence, count, &params, clip.params.clip.seed))
    }

    /// Segments the trajectories by thresholded discontinuities (Figure 1(c) of the paper): the connected components without the
    /// edges of `d` above `discontinuity.threshold`. Isolated trajectories are clusters of their own.
    #[doc(hidden)] // For the packages for Python and JavaScript.
    pub fn threshold_clusters(&self) -> Option<Clusters> {
        let Outputs { track_set, discontinuities, .. } = self.outputs_after(Stage::Discontinuities)?;
        Some(threshold_segmentation(&track_set.tracks, discontinuities, self.params().discontinuity.threshold))
    }

    /// Computes the cluster of each trajectory before merging, and the evidence of each pair of neighbouring clusters, to fit the
    /// weights of merging. Trajectories that are not embedded share the highest label. `None` until the discontinuities are
    /// computed.
    #[doc(hidden)]
    pub fn pieces(&self) -> Option<(Vec<u32>, Vec<ClusterPair>)> {
        let (clip, outputs) = (self.clip()?, self.outputs_after(Stage::Discontinuities)?);
        let evidence = outputs.cluster_evidence(&clip.params.affinity);
        let mut label = oversegment(&outputs.embedding, &clip.params.discretize, clip.params.clip.seed);
        let pairs = cluster_pairs(&label, &evidence);
        let count = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l + 1);
        label.iter_mut().filter(|l| **l == UNLABELLED).for_each(|l| *l = count);
        Some((label, pairs))
    }

    /// Returns the agreement of the present masks with the masks of nearby frames along the flow: low where masks change
    /// against the motion. In windows only frames of the window are compared. `None` until all masks are made, and without
    /// masks.
    pub fn agreement(&self) -> Option<&Agreement> {
        let outputs = self.outputs_after(Stage::Masks).filter(|outputs| !outputs.masks.is_empty())?;
        let clip = self.clip()?;
        let [given, used] = [&self.params, &*clip.params].map(|params| params.discretize.merge_log_odds);
        let merge_log_odds = (used != given).then_some(used);
        let compute = || {
            let agreement = agreement(&outputs.masks, &clip.flows);
            let expected_j = expected_j(&cut_masks(outputs, clip), &agreement.frames);
            Agreement { merge_log_odds, expected_j, ..agreement }
        };
        Some(outputs.cut.agreement.get_or_init(compute))
    }

    /// Computes the terms by which the J of each frame is expected, to fit their weights; `None` as [`Session::agreement`], and for
    /// frames that are not judged.
    #[doc(hidden)]
    pub fn expected_j_terms(&self) -> Option<Vec<Option<Vec<f64>>>> {
        let (frames, outputs) = (&self.agreement()?.frames, self.outputs()?);
        let terms = expected_j_terms(&cut_masks(outputs, self.clip()?), frames);
        Some(terms.into_iter().map(|terms| terms.map(Vec::from)).collect())
    }

    /// Computes whether the camera is still, and the terms by which each cluster is selected as an object, to fit their weights.
    /// `None` before the end of a run without masks, without flow, and with a camera that moves forward.
    #[doc(hidden)]
    pub fn cluster_terms(&self) -> Option<(bool, Vec<Vec<f64>>)> {
        let clip = self.clip()?;
        let outputs = self.outputs_after(Stage::Masks).filter(|outputs| outputs.masks.is_empty())?;
        let settings = &clip.params.background;
        let camera = estimate_camera(outputs, &clip.frames, settings, &mut |_, matches| matches.estimate_egomotion())?;
        let (tracks, clusters) = (&outputs.track_set.tracks, &outputs.clusters);
        if camera.forward.is_some() {
            return None;
        }
        let is_still = camera.is_still();
        let cues = if is_still {
            let background = model_background(camera, outputs, clip)?;
            let cues = background.still()?.0.plate_distances(tracks, clusters).into_iter();
            cues.map(|plate_distance| ClusterCues::Still { plate_distance }).collect()
        } else {
            let motions = cluster_motions(&clusters.label, &outputs.cluster_evidence(&clip.params.affinity));
            cluster_cues(tracks, clusters, &motions)
        };
        Some((is_still, cues.iter().map(ClusterCues::terms).collect::<Option<_>>()?))
    }

    /// Returns the clip-wide number of each trajectory, which it keeps in the next window.
    #[doc(hidden)] // For the packages for Python and JavaScript.
    pub fn trajectory_numbers(&self) -> &[u32] {
        self.track_set().map_or(&[], |track_set| &track_set.numbers)
    }

    /// Returns the trajectories, also those that were set before the run.
    fn track_set(&self) -> Option<&TrackSet> {
        match &self.phase {
            Phase::Frames(clip) => clip.external.as_deref(),
            _ => Some(&self.outputs_after(Stage::Trajectories)?.track_set),
        }
    }

    fn outputs(&self) -> Option<&Outputs> {
        Some(&self.running()?.outputs)
    }

    fn masks(&self) -> &[Plane<u8>] {
        self.outputs().map_or(&[], |outputs| &outputs.masks)
    }

    /// Returns the frames at working size.
    fn frames(&self) -> &[Frame] {
        self.clip().map_or(&[], |clip| &clip.frames)
    }

    /// Returns the flow of each frame pair computed so far.
    fn flows(&self) -> &[CompactFlow] {
        self.clip().map_or(&[], |clip| &clip.flows)
    }
}

pub(super) fn missing_frame(result: &str, t: usize, available: usize) -> Error {
    Error::state(&format!("the {result} of frame {t} is not available (expected a frame in 0..{available})"))
}

/// Gathers the present masks and what they were made from.
fn cut_masks<'a>(outputs: &'a Outputs, Clip { params, frames, flows, .. }: &'a Clip) -> CutMasks<'a> {
    let (objects, masks) = (&outputs.cut.objects.of_cluster, &outputs.masks);
    CutMasks { input: outputs.cut_input(), params: &params.cut, objects, masks, frames, flows }
}

/// Returns the cluster of each pixel of frame `t`, in agreement with its mask.
///
/// Refining moves borders between mask labels; a pixel that it gave another label takes the label's largest cluster in this
/// frame.
fn frame_clusters(outputs: &Outputs, t: usize) -> Plane<u32> {
    let mut clusters = paint(&outputs.superpixels[t], &outputs.cut.labels.labels[t]);
    let label_of = &outputs.cut.objects.of_cluster;
    let mut area = vec![0_u64; label_of.len()];
    for &c in clusters.data() {
        area.get_mut(c as usize).into_iter().for_each(|a| *a += 1);
    }
    let members = |label: u8| (0..label_of.len()).filter(move |&c| label_of[c] == label);
    let largest: Vec<_> = (0..=255).map(|label| members(label).max_by_key(|&c| area[c])).collect();
    for (cluster, &label) in clusters.data_mut().iter_mut().zip(outputs.masks[t].data()) {
        if label_of.get(*cluster as usize).is_some_and(|&cluster_label| cluster_label != label) {
            *cluster = largest[usize::from(label)].map_or(*cluster, |c| c as u32);
        }
    }
    clusters
}

/// Enlarges labels to input size: each input pixel takes the value of the working pixel that covers its centre.
fn to_input<T: Copy>(mask: &Plane<T>, scale: Scale) -> Plane<T> {
    let (width, height) = scale.input;
    let columns: Vec<usize> = (0..width).map(|x| scale.working_pixel(x, 0).0).collect();
    let mut data = Vec::with_capacity(width * height);
    for y in 0..height {
        let row = mask.row(scale.working_pixel(0, y).1);
        data.extend(columns.iter().map(|&x| row[x]));
    }
    Plane::from_vec(width, height, data).unwrap_or_else(|| mask.clone())
}
