//! What a session has found so far.

use crate::Error;
use crate::affinity::affinities;
use crate::background::{Background, CleanPlateInput, clean_plate};
use crate::camera::Camera;
use crate::connectedness::Components;
use crate::contour::{BoundaryMap, frame_boundaries};
use crate::cut::paint;
use crate::discontinuity::{Discontinuities, discontinuities};
use crate::discretize::{
    Clusters, DiscretizeMethod, DiscretizeParams, discretize, discretize_into, oversegment, threshold_segmentation,
};
use crate::embedding::{Embedding, embed};
use crate::evidence::{ClusterCues, ClusterPair, EvidenceInput, UNLABELLED, cluster_pairs, motion_contrasts};
use crate::flow::{CompactFlow, FlowField};
use crate::image::{Frame, Plane};
use crate::objects::{Objects, cluster_cues};
use crate::saliency::Saliency;
use crate::session::base::{Outputs, Scale, Stage, Tracked};
use crate::session::run::{Phase, Session, background_of, camera_of};
use crate::sparse::SymCsr;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

impl Session {
    /// Number of frames pushed, or of the outside trajectories' clip.
    pub fn num_frames(&self) -> usize {
        match self.frames().len() {
            0 => self.trajectories().map_or(0, |t| t.num_frames),
            frames => frames,
        }
    }

    /// Width and height of the input frames in pixels; `None` before the first.
    pub fn input_size(&self) -> Option<(usize, usize)> {
        self.clip().map(|clip| clip.scale.input)
    }

    /// Width and height at which frames are processed.
    pub fn working_size(&self) -> Option<(usize, usize)> {
        self.clip().map(|clip| clip.scale.working)
    }

    /// Forward flow from frame `t` to `t + 1`: displacements in input pixels, rounded to 1/64 working pixel, on the
    /// grid of the working size.
    ///
    /// # Errors
    /// [`Error::State`] while that flow is not yet known or when trajectories came from outside.
    pub fn flow(&self, t: usize) -> Result<FlowField, Error> {
        let (flows, scale) = (self.flows(), self.clip().map(|clip| clip.scale));
        match (flows.get(t), scale) {
            (Some(flow), Some(scale)) => Ok(flow.unpack(scale.x() as f32, scale.y() as f32)),
            _ => {
                Err(Error::state(&format!("flow of pair {t} is not available (expected a pair in 0..{})", flows.len())))
            }
        }
    }

    /// Trajectories in input pixels, once tracked.
    pub fn trajectories(&self) -> Option<&Trajectories> {
        self.tracked().map(|tracked| &tracked.input)
    }

    /// The denser trajectories that the masks are made from, in working pixels; `None` before they are tracked and with
    /// `clip.dense` off.
    pub fn mask_trajectories(&self) -> Option<&Trajectories> {
        self.tracked()?.denser.as_ref()
    }

    /// The affinity matrix A; where the foreground keeps trajectories apart, without their affinities.
    pub fn affinities(&self) -> Option<&SymCsr> {
        Some(&self.after(Stage::Affinities)?.affinities)
    }

    /// The spectral embedding of [`Session::affinities`].
    pub fn embedding(&self) -> Option<&Embedding> {
        Some(&self.after(Stage::Embedding)?.embedding)
    }

    /// Neighbour pairs and discontinuities.
    pub fn discontinuities(&self) -> Option<&Discontinuities> {
        Some(&self.after(Stage::Discontinuities)?.discontinuities)
    }

    /// How salient each trajectory is; `None` until known, and for trajectories from outside, which come without flow.
    pub fn saliency(&self) -> Option<&Saliency> {
        Some(&self.outputs()?.salient.as_ref()?.saliency)
    }

    /// How salient each pixel of frame `t` is, in `0.0..=1.0`, at working size; computed anew at each call. The last
    /// frame, which has no flow of its own, is seen through the flow that leads to it.
    ///
    /// # Errors
    /// [`Error::State`] when there is no such frame, or while saliency is not yet known.
    pub fn saliency_map(&self, t: usize) -> Result<Plane<f32>, Error> {
        let (frames, flows) = (self.frames().len(), self.flows());
        let salient = self.outputs().and_then(|outputs| outputs.salient.as_ref());
        let pair = t.min(flows.len().saturating_sub(1));
        match (salient, flows.get(pair)) {
            (Some(salient), Some(flow)) if t < frames => Ok(salient.maps.map_of_field(pair, flow)),
            (salient, _) => Err(missing_frame("saliency map", t, salient.map_or(0, |_| frames))),
        }
    }

    /// The connected pieces of the foreground in each frame; `None` as [`Session::saliency`].
    pub fn components(&self) -> Option<&Components> {
        self.outputs()?.components.as_ref()
    }

    /// Cluster labels.
    pub fn clusters(&self) -> Option<&Clusters> {
        Some(&self.after(Stage::Clusters)?.clusters)
    }

    /// The mask of frame `t` at input size: 0 is the background, `1..=`[`Objects::highest_label`] are the objects.
    ///
    /// # Errors
    /// [`Error::State`] while it is not yet known, when there were no frames, or with `clip.dense` off.
    pub fn labels(&self, t: usize) -> Result<Plane<u8>, Error> {
        let masks = self.masks();
        match (masks.get(t), self.clip()) {
            (Some(mask), Some(clip)) => Ok(to_input(mask, clip.scale)),
            _ => Err(missing_frame("mask", t, masks.len())),
        }
    }

    /// The mask of frame `t` at working size, which [`crate::mask::enlarge`] brings to the size of the source.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn working_labels(&self, t: usize) -> Result<&Plane<u8>, Error> {
        let masks = self.masks();
        masks.get(t).ok_or_else(|| missing_frame("mask", t, masks.len()))
    }

    /// The clean plate of frame `t`, at working size: the scene without the objects, RGBA; computed anew at each call.
    ///
    /// Pixels of the background are the frame's own; behind objects the nearest frames of the clip that show the scene
    /// there, as the camera moves, give the colour. Alpha is 0 where none does, and 255 elsewhere.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn background(&self, t: usize) -> Result<Plane<[u8; 4]>, Error> {
        let (frames, masks) = (self.frames(), self.masks());
        let outputs = self.outputs().filter(|_| masks.len() == frames.len() && t < masks.len());
        let outputs = outputs.ok_or_else(|| missing_frame("background", t, masks.len()))?;
        let none = Camera::new(&[], &[], None);
        let is_scene = outputs.clusters.label.iter().map(|&cluster| outputs.label_of(cluster) == 0).collect();
        let (camera, tracks) = (outputs.camera.as_ref().unwrap_or(&none), &outputs.tracked.tracks);
        Ok(clean_plate(&CleanPlateInput { frames, masks, camera, tracks, is_scene }, t))
    }

    /// The cluster of each pixel of frame `t` at input size: the masks before objects are told from background.
    ///
    /// Law: with any cluster at all, [`Objects::of_cluster`] of a pixel's cluster is its label in [`Session::labels`];
    /// otherwise 0.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn cluster_labels(&self, t: usize) -> Result<Plane<u32>, Error> {
        match (self.outputs(), self.clip()) {
            (Some(outputs), Some(clip)) if t < outputs.masks.len() => {
                Ok(to_input(&clusters_in(outputs, t), clip.scale))
            }
            _ => Err(missing_frame("cluster map", t, self.masks().len())),
        }
    }

    /// The Gabriel superpixels of frame `t`, at working size.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn superpixels(&self, t: usize) -> Result<&Superpixels, Error> {
        let superpixels = self.outputs().map_or(&[][..], |outputs| &outputs.superpixels);
        superpixels.get(t).ok_or_else(|| missing_frame("superpixels", t, superpixels.len()))
    }

    /// The boundary probability of frame `t`, at working size; computed anew at each call.
    ///
    /// # Errors
    /// [`Error::State`] when there is no such frame.
    pub fn boundaries(&self, t: usize) -> Result<BoundaryMap, Error> {
        let clip = self.clip();
        match clip.and_then(|clip| Some((clip.frames.get(t)?, clip))) {
            Some((frame, clip)) => Ok(frame_boundaries(frame, &clip.params.contour)),
            None => Err(missing_frame("boundary map", t, self.frames().len())),
        }
    }

    /// Which clusters are which objects of the masks; `None` until the cut is made. Without clusters there are no
    /// objects. An object whose pixels the cut gave to others is here, and has no pixel in any mask.
    pub fn objects(&self) -> Option<&Objects> {
        // A run without masks has no superpixels, and ends without a cut.
        let outputs = self.after(Stage::Cut).filter(|outputs| !outputs.superpixels.is_empty())?;
        Some(&outputs.cut.objects)
    }

    /// What the clusters would be with connectedness off, computed anew at each call from the affinities on: to see
    /// what it changes. `None` until the clusters are known.
    ///
    /// # Errors
    /// As [`affinities`].
    pub fn motion_clusters(&self) -> Result<Option<Clusters>, Error> {
        let (Some(clip), Some(outputs)) = (self.clip(), self.after(Stage::Clusters)) else { return Ok(None) };
        let (params, seed, tracked) = (&clip.params, clip.params.clip.seed, &outputs.tracked);
        let affinities = affinities(tracked.with_past(), params.spacing(), &params.affinity, seed)?;
        let embedding = embed(&affinities, &params.embedding, seed);
        let near = outputs.discontinuities.neighborhoods.clone();
        let edges = discontinuities(near, &embedding, &params.discontinuity);
        let maps = outputs.salient.as_ref().map(|salient| &salient.maps);
        let known = EvidenceInput::new(&tracked.tracks, &edges, &params.affinity, maps, None);
        Ok(Some(discretize(&embedding, &known, &params.discretize, seed)))
    }

    /// What `method` makes of the embedding with `count` clusters (before any merging) by as many eigenvectors,
    /// computed anew at each call: to compare discretizations. At most as many clusters as the embedding has
    /// eigenvectors. `None` until the discontinuities are known.
    pub fn clusters_by(&self, method: DiscretizeMethod, count: usize) -> Option<Clusters> {
        let (clip, outputs) = (self.clip()?, self.after(Stage::Discontinuities)?);
        let params = DiscretizeParams { method, ..clip.params.discretize.clone() };
        let known = outputs.known(&clip.params.affinity);
        Some(discretize_into(&outputs.embedding, &known, count, &params, clip.params.clip.seed))
    }

    /// The other segmentation that the discontinuities give, Figure 1(c): what stays connected when all edges with `d`
    /// above `discontinuity.threshold` are cut. Computed anew at each call; single stray trajectories are clusters of
    /// their own.
    pub fn threshold_clusters(&self) -> Option<Clusters> {
        let Outputs { tracked, discontinuities, .. } = self.after(Stage::Discontinuities)?;
        Some(threshold_segmentation(&tracked.tracks, discontinuities, self.params().discontinuity.threshold))
    }

    /// The label of each trajectory before any clusters are merged, and what is known of each two neighbouring ones, computed
    /// anew at each call: to fit the weights of what speaks for merging. Trajectories that are not embedded have a label of
    /// their own, the highest. `None` until the clusters are known, and without flow.
    #[doc(hidden)]
    pub fn pieces(&self) -> Option<(Vec<u32>, Vec<ClusterPair>)> {
        let (clip, outputs) = (self.clip()?, self.after(Stage::Discontinuities)?);
        let known = outputs.known(&clip.params.affinity);
        let mut label = oversegment(&outputs.embedding, &clip.params.discretize, clip.params.clip.seed);
        let pairs = cluster_pairs(&label, &known);
        let count = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l + 1);
        label.iter_mut().filter(|l| **l == UNLABELLED).for_each(|l| *l = count);
        Some((label, pairs))
    }

    /// The terms of each cluster by which objects are told, but for the one that is background in any case, computed anew at
    /// each call, to fit their weights; before them, whether the camera stands still. `None` until the clusters are known,
    /// without flow, and where the camera goes forward.
    #[doc(hidden)]
    pub fn cluster_terms(&self) -> Option<(bool, Vec<Option<Vec<f64>>>)> {
        let clip = self.clip()?;
        let outputs = self.after(Stage::Masks).filter(|outputs| outputs.masks.is_empty())?;
        let settings = &clip.params.background;
        let camera = camera_of(outputs, &clip.frames, settings, &mut |_, matches| matches.estimate_egomotion())?;
        let (tracks, clusters) = (&outputs.tracked.tracks, &outputs.clusters);
        let (still, cues) = match camera {
            Camera::Forward(..) => return None,
            Camera::Moving(_) => {
                let contrasts = motion_contrasts(&clusters.label, &outputs.known(&clip.params.affinity));
                (false, cluster_cues(tracks, clusters, &contrasts))
            }
            Camera::Still => {
                let Background::Still(scene) = background_of(camera, outputs, clip)? else { return None };
                let cues = scene.plate_distances(tracks, clusters).into_iter();
                (true, cues.map(|plate_distance| Some(ClusterCues::Still { plate_distance })).collect())
            }
        };
        Some((still, cues.iter().map(|cues| cues.as_ref()?.terms()).collect()))
    }

    /// The clip-wide number of each trajectory: one that lives on into the next window keeps it.
    pub fn trajectory_numbers(&self) -> &[u32] {
        self.tracked().map_or(&[], |tracked| &tracked.numbers)
    }

    /// The trajectories, also those from outside that no run has taken yet.
    fn tracked(&self) -> Option<&Tracked> {
        match &self.phase {
            Phase::Frames(clip) => clip.given.as_deref(),
            _ => Some(&self.after(Stage::Trajectories)?.tracked),
        }
    }

    /// The outputs so far.
    fn outputs(&self) -> Option<&Outputs> {
        Some(&self.begun()?.outputs)
    }

    /// The masks so far.
    fn masks(&self) -> &[Plane<u8>] {
        self.outputs().map_or(&[], |outputs| &outputs.masks)
    }

    /// The frames pushed, at working size.
    fn frames(&self) -> &[Frame] {
        self.clip().map_or(&[], |clip| &clip.frames)
    }

    /// The flow of each pair of them, as far as it is known.
    fn flows(&self) -> &[CompactFlow] {
        self.clip().map_or(&[], |clip| &clip.flows)
    }
}

pub(crate) fn missing_frame(what: &str, t: usize, known: usize) -> Error {
    Error::state(&format!("the {what} of frame {t} is not available (expected a frame in 0..{known})"))
}

/// The cluster of each pixel of frame `t`, in agreement with its mask.
///
/// Refining moves borders between mask labels: a pixel moved to another label takes the largest cluster there in this
/// frame.
fn clusters_in(outputs: &Outputs, t: usize) -> Plane<u32> {
    let mut clusters = paint(&outputs.superpixels[t], &outputs.cut.labels.labels[t]);
    let label_of = &outputs.cut.objects.of_cluster;
    let mut area = vec![0_u64; label_of.len()];
    for &c in clusters.data() {
        area.get_mut(c as usize).into_iter().for_each(|a| *a += 1);
    }
    let members = |label: u8| (0..label_of.len()).filter(move |&c| label_of[c] == label);
    let largest: Vec<_> = (0..=255).map(|label| members(label).max_by_key(|&c| area[c])).collect();
    for (cluster, &label) in clusters.data_mut().iter_mut().zip(outputs.masks[t].data()) {
        if label_of.get(*cluster as usize).is_some_and(|&own| own != label) {
            *cluster = largest[usize::from(label)].map_or(*cluster, |c| c as u32);
        }
    }
    clusters
}

/// Labels at input size: each input pixel takes the value of the working pixel that covers its centre.
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
