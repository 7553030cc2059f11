//! What a session has found so far.

use super::dense;
use super::session::{Session, state_error};
use crate::Error;
use crate::affinity::affinities;
use crate::connectedness::Components;
use crate::contour::BoundaryMap;
use crate::cut::Objects;
use crate::discontinuity::{Discontinuities, discontinuities};
use crate::discretize::{
    Clusters, DiscretizeMethod, DiscretizeParams, discretize, discretize_into, threshold_segmentation,
};
use crate::embedding::{Embedding, embed};
use crate::flow::FlowField;
use crate::image::Plane;
use crate::saliency::Saliency;
use crate::sparse::SymCsr;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

impl Session {
    /// Number of frames pushed, or of the outside trajectories' clip.
    pub fn num_frames(&self) -> usize {
        if self.frames.is_empty() { self.trajectories.as_ref().map_or(0, |t| t.num_frames) } else { self.frames.len() }
    }

    /// Width and height of the input frames in pixels; `None` before the first.
    pub fn input_size(&self) -> Option<(usize, usize)> {
        self.scale.map(|s| s.input)
    }

    /// Width and height at which frames are processed.
    pub fn working_size(&self) -> Option<(usize, usize)> {
        self.scale.map(|s| s.working)
    }

    /// Forward flow from frame `t` to `t + 1`: displacements in input pixels, rounded to 1/64 working pixel, on the grid of the
    /// working size.
    ///
    /// # Errors
    /// [`Error::State`] while that flow is not yet known or when trajectories came from outside.
    pub fn flow(&self, t: usize) -> Result<FlowField, Error> {
        match (self.flows.get(t), self.scale) {
            (Some(flow), Some(scale)) => Ok(flow.unpack(scale.x() as f32, scale.y() as f32)),
            _ => Err(state_error(&format!(
                "flow of pair {t} is not available (expected a pair in 0..{})",
                self.flows.len()
            ))),
        }
    }

    /// Trajectories in input pixels, once tracked.
    pub fn trajectories(&self) -> Option<&Trajectories> {
        self.trajectories.as_ref()
    }

    /// The denser trajectories that the masks are made from, in working pixels; `None` before they are tracked and with `clip.dense`
    /// off.
    pub fn mask_trajectories(&self) -> Option<&Trajectories> {
        self.dense.tracks.as_ref()
    }

    /// The affinity matrix A; where the foreground keeps trajectories apart, without their affinities.
    pub fn affinities(&self) -> Option<&SymCsr> {
        self.affinities.as_ref()
    }

    /// The spectral embedding of [`Session::affinities`].
    pub fn embedding(&self) -> Option<&Embedding> {
        self.embedding.as_ref()
    }

    /// Neighbour pairs and discontinuities.
    pub fn discontinuities(&self) -> Option<&Discontinuities> {
        self.discontinuities.as_ref()
    }

    /// How salient each trajectory is; `None` until known, and for trajectories from outside, which come without flow.
    pub fn saliency(&self) -> Option<&Saliency> {
        self.foreground.saliency.as_ref()
    }

    /// How salient each pixel of frame `t` is, in `0.0..=1.0`, at working size; computed anew at each call. The last frame, which has no
    /// flow of its own, is seen through the flow that leads to it.
    ///
    /// # Errors
    /// [`Error::State`] when there is no such frame, or while saliency is not yet known.
    pub fn saliency_map(&self, t: usize) -> Result<Plane<f32>, Error> {
        let pair = t.min(self.flows.len().saturating_sub(1));
        match (self.foreground.maps(), self.flows.get(pair)) {
            (Some(maps), Some(flow)) if t < self.frames.len() => Ok(maps.map(pair, &flow.unpack(1.0, 1.0))),
            _ => {
                let known = if self.foreground.maps().is_some() { self.frames.len() } else { 0 };
                Err(missing_frame("saliency map", t, known))
            }
        }
    }

    /// The connected pieces of the foreground in each frame; `None` as [`Session::saliency`].
    pub fn components(&self) -> Option<&Components> {
        self.foreground.components.as_ref()
    }

    /// Cluster labels.
    pub fn clusters(&self) -> Option<&Clusters> {
        self.clusters.as_ref()
    }

    /// The mask of frame `t` at input size: 0 is the background, `1..=`[`Objects::count`] are the objects.
    ///
    /// # Errors
    /// [`Error::State`] while it is not yet known, when there were no frames, or with `clip.dense` off.
    pub fn labels(&self, t: usize) -> Result<Plane<u8>, Error> {
        match (self.dense.masks.get(t), self.scale) {
            (Some(mask), Some(scale)) => Ok(dense::to_input(mask, scale)),
            _ => Err(missing_frame("mask", t, self.dense.masks.len())),
        }
    }

    /// The cluster of each pixel of frame `t` at input size: the masks before objects are told from background.
    ///
    /// Law: with any cluster at all, [`Objects::of_cluster`] of a pixel's cluster is its label in [`Session::labels`]; otherwise 0.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn cluster_labels(&self, t: usize) -> Result<Plane<u32>, Error> {
        match (self.dense.clusters(t), self.scale) {
            (Some(clusters), Some(scale)) => Ok(dense::to_input(&clusters, scale)),
            _ => Err(missing_frame("cluster map", t, self.dense.masks.len())),
        }
    }

    /// The Gabriel superpixels of frame `t`, at working size.
    ///
    /// # Errors
    /// As [`Session::labels`].
    pub fn superpixels(&self, t: usize) -> Result<&Superpixels, Error> {
        self.dense.superpixels.get(t).ok_or_else(|| missing_frame("superpixels", t, self.dense.superpixels.len()))
    }

    /// The boundary probability of frame `t`, at working size; computed anew at each call.
    ///
    /// # Errors
    /// [`Error::State`] when there is no such frame.
    pub fn boundaries(&self, t: usize) -> Result<BoundaryMap, Error> {
        let frame = self.frames.get(t).ok_or_else(|| missing_frame("boundary map", t, self.frames.len()))?;
        Ok(dense::boundaries_of(frame, dense::flow_at(&self.flows, t), &self.params))
    }

    /// Which clusters are which objects of the masks; `None` until the cut is made. Without clusters there are no objects.
    pub fn objects(&self) -> Option<&Objects> {
        self.dense.objects()
    }

    /// What the clusters would be with connectedness off, computed anew at each call from the affinities on: to see what it changes.
    /// `None` until the clusters are known.
    ///
    /// # Errors
    /// As [`affinities`].
    pub fn motion_clusters(&self) -> Result<Option<Clusters>, Error> {
        let (Some(tracks), Some(found), Some(_)) = (&self.working, &self.discontinuities, &self.clusters) else {
            return Ok(None);
        };
        let (params, seed) = (self.scaled_params(), self.params.clip.seed);
        let lived = self.with_past.as_ref().unwrap_or(tracks);
        let embedding = embed(&affinities(lived, self.spacing, &params.affinity, seed)?, &params.embedding, seed);
        let found = discontinuities(found.neighborhoods.clone(), &embedding, &params.discontinuity);
        Ok(Some(discretize(tracks, &embedding, &found, &params.discretize, seed)))
    }

    /// What `method` makes of the embedding with `count` clusters (before any merging) by as many eigenvectors, computed anew at each
    /// call: to compare discretizations. At most as many clusters as the embedding has eigenvectors. `None` until the discontinuities
    /// are known.
    pub fn clusters_by(&self, method: DiscretizeMethod, count: usize) -> Option<Clusters> {
        let (tracks, embedding, found) =
            (self.working.as_ref()?, self.embedding.as_ref()?, self.discontinuities.as_ref()?);
        let params = DiscretizeParams { method, ..self.scaled_params().discretize };
        Some(discretize_into(tracks, embedding, found, count, &params, self.params.clip.seed))
    }

    /// The other segmentation that the discontinuities give, Figure 1(c): what stays connected when all edges with `d` above
    /// `discontinuity.threshold` are cut. Computed anew at each call; single stray trajectories are clusters of their own.
    pub fn threshold_clusters(&self) -> Option<Clusters> {
        let (tracks, found) = (self.working.as_ref()?, self.discontinuities.as_ref()?);
        Some(threshold_segmentation(tracks, found, self.params.discontinuity.threshold))
    }
}

fn missing_frame(what: &str, t: usize, known: usize) -> Error {
    state_error(&format!("the {what} of frame {t} is not available (expected a frame in 0..{known})"))
}
