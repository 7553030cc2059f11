//! What a session has found so far.

use crate::Error;
use crate::affinity::affinities;
use crate::background::{PlateInput, clean_plate};
use crate::camera::Camera;
use crate::connectedness::Components;
use crate::contour::{BoundaryMap, frame_boundaries};
use crate::discontinuity::{Discontinuities, discontinuities};
use crate::discretize::{
    Clusters, DiscretizeMethod, DiscretizeParams, discretize, discretize_into, pieces, threshold_segmentation,
};
use crate::embedding::{Embedding, embed};
use crate::evidence::{Known, Pair, Signs, UNLABELLED, pairs};
use crate::flow::{CompactFlow, FlowField};
use crate::image::{Frame, Plane};
use crate::objects::{Objects, signs};
use crate::saliency::Saliency;
use crate::session::run::State;
use crate::session::run::{Phase, Session};
use crate::session::run::{background_of, camera_of, clusters_of, to_input};
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
        self.found().tracked.map(|tracked| &tracked.input)
    }

    /// The denser trajectories that the masks are made from, in working pixels; `None` before they are tracked and with
    /// `clip.dense` off.
    pub fn mask_trajectories(&self) -> Option<&Trajectories> {
        self.found().tracked?.denser.as_ref()
    }

    /// The affinity matrix A; where the foreground keeps trajectories apart, without their affinities.
    pub fn affinities(&self) -> Option<&SymCsr> {
        self.found().affinities
    }

    /// The spectral embedding of [`Session::affinities`].
    pub fn embedding(&self) -> Option<&Embedding> {
        self.found().embedding
    }

    /// Neighbour pairs and discontinuities.
    pub fn discontinuities(&self) -> Option<&Discontinuities> {
        self.found().discontinuities
    }

    /// How salient each trajectory is; `None` until known, and for trajectories from outside, which come without flow.
    pub fn saliency(&self) -> Option<&Saliency> {
        self.found().salient.map(|salient| &salient.saliency)
    }

    /// How salient each pixel of frame `t` is, in `0.0..=1.0`, at working size; computed anew at each call. The last
    /// frame, which has no flow of its own, is seen through the flow that leads to it.
    ///
    /// # Errors
    /// [`Error::State`] when there is no such frame, or while saliency is not yet known.
    pub fn saliency_map(&self, t: usize) -> Result<Plane<f32>, Error> {
        let (frames, flows, salient) = (self.frames().len(), self.flows(), self.found().salient);
        let pair = t.min(flows.len().saturating_sub(1));
        match (salient, flows.get(pair)) {
            (Some(salient), Some(flow)) if t < frames => Ok(salient.maps.whole(pair, flow)),
            (salient, _) => Err(missing_frame("saliency map", t, salient.map_or(0, |_| frames))),
        }
    }

    /// The connected pieces of the foreground in each frame; `None` as [`Session::saliency`].
    pub fn components(&self) -> Option<&Components> {
        self.found().components
    }

    /// Cluster labels.
    pub fn clusters(&self) -> Option<&Clusters> {
        self.found().clusters
    }

    /// The mask of frame `t` at input size: 0 is the background, `1..=`[`Objects::highest_label`] are the objects.
    ///
    /// # Errors
    /// [`Error::State`] while it is not yet known, when there were no frames, or with `clip.dense` off.
    pub fn labels(&self, t: usize) -> Result<Plane<u8>, Error> {
        let masks = self.found().masks;
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
        let masks = self.found().masks;
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
        let found = self.found();
        let (frames, masks) = (self.frames(), found.masks);
        let missing = || missing_frame("background", t, masks.len());
        if masks.len() < frames.len() || t >= masks.len() {
            return Err(missing());
        }
        let none = Camera::new(&[], &[], None);
        let (Some(cut), Some(clusters), Some(tracked)) = (found.cut, found.clusters, found.tracked) else {
            return Err(missing());
        };
        let label_of = |cluster: &u32| cut.objects.of_cluster.get(*cluster as usize).copied().unwrap_or(0);
        let is_scene = clusters.label.iter().map(|cluster| label_of(cluster) == 0).collect();
        let camera = found.camera.unwrap_or(&none);
        Ok(clean_plate(&PlateInput { frames, masks, camera, tracks: &tracked.tracks, is_scene }, t))
    }

    /// The cluster of each pixel of frame `t` at input size: the masks before objects are told from background.
    ///
    /// Law: with any cluster at all, [`Objects::of_cluster`] of a pixel's cluster is its label in [`Session::labels`];
    /// otherwise 0.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn cluster_labels(&self, t: usize) -> Result<Plane<u32>, Error> {
        let found = self.found();
        match (found.cut, found.masks.get(t), self.clip()) {
            (Some(cut), Some(mask), Some(clip)) => {
                let clusters = clusters_of(&found.superpixels[t], &cut.labels.labels[t], &cut.objects, mask);
                Ok(to_input(&clusters, clip.scale))
            }
            _ => Err(missing_frame("cluster map", t, found.masks.len())),
        }
    }

    /// The Gabriel superpixels of frame `t`, at working size.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn superpixels(&self, t: usize) -> Result<&Superpixels, Error> {
        let superpixels = self.found().superpixels;
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
        self.found().cut.map(|cut| &cut.objects)
    }

    /// What the clusters would be with connectedness off, computed anew at each call from the affinities on: to see
    /// what it changes. `None` until the clusters are known.
    ///
    /// # Errors
    /// As [`affinities`].
    pub fn motion_clusters(&self) -> Result<Option<Clusters>, Error> {
        let found = self.found();
        let (Some(clip), Some(tracked), Some(edges), Some(_)) =
            (self.clip(), found.tracked, found.discontinuities, found.clusters)
        else {
            return Ok(None);
        };
        let (params, seed) = (&clip.params, clip.params.clip.seed);
        let affinities = affinities(tracked.lived(), params.spacing(), &params.affinity, seed)?;
        let embedding = embed(&affinities, &params.embedding, seed);
        let edges = discontinuities(edges.neighborhoods.clone(), &embedding, &params.discontinuity);
        let maps = found.salient.map(|salient| &salient.maps);
        let known = Known::new(&tracked.tracks, &edges, &params.affinity, maps, None);
        Ok(Some(discretize(&embedding, &known, &params.discretize, seed)))
    }

    /// What `method` makes of the embedding with `count` clusters (before any merging) by as many eigenvectors,
    /// computed anew at each call: to compare discretizations. At most as many clusters as the embedding has
    /// eigenvectors. `None` until the discontinuities are known.
    pub fn clusters_by(&self, method: DiscretizeMethod, count: usize) -> Option<Clusters> {
        let (clip, found) = (self.clip()?, self.found());
        let (embedding, known) = (found.embedding?, found.known(&clip.params.affinity)?);
        let params = DiscretizeParams { method, ..clip.params.discretize.clone() };
        Some(discretize_into(embedding, &known, count, &params, clip.params.clip.seed))
    }

    /// The other segmentation that the discontinuities give, Figure 1(c): what stays connected when all edges with `d`
    /// above `discontinuity.threshold` are cut. Computed anew at each call; single stray trajectories are clusters of
    /// their own.
    pub fn threshold_clusters(&self) -> Option<Clusters> {
        let found = self.found();
        let (tracks, edges) = (&found.tracked?.tracks, found.discontinuities?);
        Some(threshold_segmentation(tracks, edges, self.params().discontinuity.threshold))
    }

    /// The label of each trajectory before any clusters are merged, and what is known of each two neighbouring ones, computed
    /// anew at each call: to fit the weights of what speaks for merging. Trajectories that are not embedded have a label of
    /// their own, the highest. `None` until the clusters are known, and without flow.
    #[doc(hidden)]
    pub fn pieces(&self) -> Option<(Vec<u32>, Vec<Pair>)> {
        let (clip, found) = (self.clip()?, self.found());
        let (known, embedding) = (found.known(&clip.params.affinity)?, found.embedding?);
        let mut label = pieces(embedding, &clip.params.discretize, clip.params.clip.seed);
        let pairs = pairs(&label, &known);
        let count = label.iter().filter(|&&l| l != UNLABELLED).max().map_or(0, |&l| l + 1);
        label.iter_mut().filter(|l| **l == UNLABELLED).for_each(|l| *l = count);
        Some((label, pairs))
    }

    /// The terms of each cluster by which objects are told, but for the one that is background in any case, computed anew at
    /// each call, to fit their weights; before them, whether the camera stands still. `None` until the clusters are known,
    /// without flow, and where the camera goes forward.
    #[doc(hidden)]
    pub fn cluster_terms(&self) -> Option<(bool, Vec<Option<Vec<f64>>>)> {
        let (clip, Phase::Begun(_, State::Clustered(clustered))) = (self.clip()?, &self.phase) else { return None };
        let camera = camera_of(clustered, (&clip.frames, &clip.params.background), &mut |_, ways| ways.forward())?;
        let (tracks, clusters) = (&clustered.embedded.tracked.tracks, &clustered.clusters);
        if camera.goes_forward() {
            return None;
        }
        let still = camera.still;
        let signs = if still {
            let unlike = background_of(camera, clustered, clip)?.unlike_plate(tracks, clusters);
            unlike.iter().map(|&unlike| Some(Signs::Still { unlike })).collect()
        } else {
            signs(tracks, clusters, &clustered.strangeness(&clip.params.affinity))
        };
        Some((still, signs.iter().map(|signs| signs.as_ref()?.terms()).collect()))
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
