//! `Session`: frames in, one bounded step at a time, results stage by stage.

use super::dense::{self, Clip, Dense};
use super::geometry::Scale;
use super::motion::Motion;
use crate::Error;
use crate::affinity::AffinityRows;
use crate::contour::BoundaryMap;
use crate::cut::Objects;
use crate::discontinuity::{Discontinuities, discontinuities, neighborhoods};
use crate::discretize::{Clusters, discretize, threshold_segmentation};
use crate::embedding::{Embedding, embed};
use crate::flow::{CompactFlow, FlowField};
use crate::image::{Frame, Plane};
use crate::params::Params;
use crate::sparse::SymCsr;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use serde::Serialize;

/// The stages, in the order in which they run; flow and trajectories take turns, pair by pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "camelCase")]
pub enum Stage {
    /// Dense optical flow, forward and backward; a step is one field.
    Flow,
    /// Point trajectories; a step is one frame pair.
    Trajectories,
    /// Motion affinities; a step is a block of trajectories.
    Affinities,
    /// Spectral embedding; one step, up to a few seconds for 10 000 trajectories.
    Embedding,
    /// Delaunay neighbourhoods and embedding discontinuities; one step.
    Discontinuities,
    /// Cluster labels; one step.
    Clusters,
    /// Boundary probability, contours and Gabriel superpixels; a step is one frame.
    Superpixels,
    /// The Gabriel cut; a step is one move of the expansion, of the first also making the energy.
    Cut,
    /// A label for every pixel; a step is one frame.
    Masks,
}

impl Stage {
    /// All stages in order.
    pub const ALL: [Self; 9] = [
        Self::Flow,
        Self::Trajectories,
        Self::Affinities,
        Self::Embedding,
        Self::Discontinuities,
        Self::Clusters,
        Self::Superpixels,
        Self::Cut,
        Self::Masks,
    ];

    /// The name used in JSON and JavaScript.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flow => "flow",
            Self::Trajectories => "trajectories",
            Self::Affinities => "affinities",
            Self::Embedding => "embedding",
            Self::Discontinuities => "discontinuities",
            Self::Clusters => "clusters",
            Self::Superpixels => "superpixels",
            Self::Cut => "cut",
            Self::Masks => "masks",
        }
    }
}

/// How far the session is: `done` of `total` steps of `stage`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Progress {
    /// The stage that the step just taken belongs to.
    pub stage: Stage,
    /// Steps of that stage taken so far.
    pub done: u32,
    /// Steps of that stage in all.
    pub total: u32,
}

/// What a call of [`Session::step`] did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// One step was taken; more may remain.
    Working(Progress),
    /// Nothing was left to do: all results can be read.
    Done,
}

/// Trajectories compared with all others in one step.
const AFFINITY_BLOCK: usize = 512;

/// The grid step at which counts of trajectories are stated in the parameters.
const REFERENCE_STEP: f32 = 8.0;

/// What is in progress: each variant owns the unfinished work of its stage.
#[derive(Debug)]
enum State {
    /// Taking frames.
    Open,
    Motion(Box<Motion>),
    Affinities(Box<AffinityRows>),
    Embedding,
    Discontinuities,
    Clusters,
    Dense,
    Done,
}

/// One clip on its way through the stages.
///
/// Push frames (or set trajectories), call [`Session::step`] until it returns [`Step::Done`], read results; those of a finished stage
/// can be read while later ones still run. To cancel, stop stepping: stepping again later goes on and ends in the same result.
#[derive(Debug)]
pub struct Session {
    params: Params,
    frames: Vec<Frame>,
    scale: Option<Scale>,
    /// Distance of neighbouring trajectories, in working pixels.
    spacing: f32,
    state: State,
    flows: Vec<CompactFlow>,
    working: Option<Trajectories>,
    trajectories: Option<Trajectories>,
    affinities: Option<SymCsr>,
    embedding: Option<Embedding>,
    discontinuities: Option<Discontinuities>,
    clusters: Option<Clusters>,
    dense: Dense,
}

impl Session {
    /// An empty session.
    ///
    /// # Errors
    /// [`Error::Param`] when a parameter is out of range.
    pub fn new(params: Params) -> Result<Self, Error> {
        params.validate()?;
        Ok(Self {
            spacing: params.trajectory.grid_step,
            params,
            frames: Vec::new(),
            scale: None,
            state: State::Open,
            flows: Vec::new(),
            working: None,
            trajectories: None,
            affinities: None,
            embedding: None,
            discontinuities: None,
            clusters: None,
            dense: Dense::default(),
        })
    }

    /// The parameters in force.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Adds the next frame: RGBA bytes, four a pixel.
    ///
    /// # Errors
    /// As [`Frame::from_rgba`] and [`Session::push_frame`]; the session stays as it was.
    pub fn push_rgba(&mut self, rgba: &[u8], width: usize, height: usize) -> Result<(), Error> {
        self.push_frame(Frame::from_rgba(rgba, width, height)?)
    }

    /// Adds the next frame from the bytes of a PNG or JPEG file.
    ///
    /// # Errors
    /// As [`Frame::decode`] and [`Session::push_frame`]; the session stays as it was.
    pub fn push_encoded(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.push_frame(Frame::decode(bytes)?)
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`Error::FrameSizeChanged`] unless it has the size of the first; [`Error::State`] once stepping has begun or when
    /// trajectories were set.
    pub fn push_frame(&mut self, frame: Frame) -> Result<(), Error> {
        self.require_open("a frame was pushed")?;
        if self.working.is_some() {
            return Err(state_error("a frame was pushed after trajectories were set: clear the session first"));
        }
        let actual = (frame.width(), frame.height());
        let scale = self.scale.unwrap_or_else(|| Scale::new(actual, self.params.clip.max_side as usize));
        if scale.input != actual {
            return Err(Error::FrameSizeChanged { index: self.frames.len(), expected: scale.input, actual });
        }
        self.scale = Some(scale);
        self.frames.push(frame.resized(scale.working.0, scale.working.1));
        Ok(())
    }

    /// Uses the trajectories of any tracker, in input pixels, in place of frames, flow and tracking.
    ///
    /// # Errors
    /// [`Error::Data`] when they break the law of [`Trajectories`] (NaN, wrong counts), [`Error::FrameSize`] and
    /// [`Error::TooFewFrames`] as for frames, [`Error::State`] when frames were pushed or stepping has begun.
    pub fn set_trajectories(&mut self, trajectories: Trajectories) -> Result<(), Error> {
        self.require_open("trajectories were set")?;
        if !self.frames.is_empty() {
            return Err(state_error("trajectories were set after frames were pushed: clear the session first"));
        }
        let scale = Scale::checked(trajectories.size, self.params.clip.max_side as usize)?;
        if trajectories.num_frames < 2 {
            return Err(Error::TooFewFrames { got: trajectories.num_frames, needed: 2 });
        }
        trajectories.check()?;
        let working = scale.to_working(&trajectories);
        self.spacing = typical_spacing(&working);
        self.scale = Some(scale);
        self.working = Some(working);
        self.trajectories = Some(trajectories);
        Ok(())
    }

    fn require_open(&self, what: &str) -> Result<(), Error> {
        match self.state {
            State::Open => Ok(()),
            _ => Err(state_error(&format!("{what} after the run had begun: clear the session or use a new one"))),
        }
    }

    /// Takes one bounded step.
    ///
    /// # Errors
    /// [`Error::TooFewFrames`] with fewer than two frames: more can be pushed then. The state is unchanged after any error.
    pub fn step(&mut self) -> Result<Step, Error> {
        if matches!(self.state, State::Open) {
            self.begin()?;
        }
        let progress = match &mut self.state {
            State::Open | State::Done => return Ok(Step::Done),
            State::Motion(motion) => {
                let progress = motion.step(&self.frames, &mut self.flows);
                if motion.is_finished() {
                    self.end_motion();
                }
                progress
            }
            State::Affinities(rows) => {
                let tracks = self.working.as_ref().ok_or_else(lost)?;
                let more = rows.advance(tracks, AFFINITY_BLOCK);
                let blocks = |rows: usize| rows.div_ceil(AFFINITY_BLOCK).max(1) as u32;
                let progress =
                    Progress { stage: Stage::Affinities, done: blocks(rows.done()), total: blocks(tracks.len()) };
                if !more {
                    self.end_affinities()?;
                }
                progress
            }
            State::Embedding => self.embed()?,
            State::Discontinuities => self.discontinue()?,
            State::Clusters => self.cluster()?,
            State::Dense => self.densify()?,
        };
        Ok(Step::Working(progress))
    }

    /// Steps until done.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn run(&mut self) -> Result<(), Error> {
        while self.step()? != Step::Done {}
        Ok(())
    }

    fn begin(&mut self) -> Result<(), Error> {
        if let Some(tracks) = &self.working {
            self.state = self.affinity_state(tracks);
            return Ok(());
        }
        if self.frames.len() < 2 {
            return Err(Error::TooFewFrames { got: self.frames.len(), needed: 2 });
        }
        self.state = State::Motion(Box::new(Motion::new(&self.frames, &self.params)));
        Ok(())
    }

    fn affinity_state(&self, tracks: &Trajectories) -> State {
        let rows = AffinityRows::new(tracks, self.spacing, &self.params.affinity, self.params.clip.seed);
        State::Affinities(Box::new(rows))
    }

    fn end_motion(&mut self) {
        let State::Motion(motion) = std::mem::replace(&mut self.state, State::Open) else { return };
        let (working, mask_tracks) = motion.into_trajectories();
        self.dense.tracks = mask_tracks;
        self.state = self.affinity_state(&working);
        self.trajectories = self.scale.map(|scale| scale.to_input(&working));
        self.working = Some(working);
    }

    fn end_affinities(&mut self) -> Result<(), Error> {
        if let State::Affinities(rows) = std::mem::replace(&mut self.state, State::Embedding) {
            self.affinities = Some(rows.finish()?);
        }
        Ok(())
    }

    fn embed(&mut self) -> Result<Progress, Error> {
        let mut params = self.params.embedding.clone();
        params.min_component = self.scaled_count(params.min_component) as u32;
        self.embedding = Some(embed(self.affinities.as_ref().ok_or_else(lost)?, &params, self.params.clip.seed));
        self.state = State::Discontinuities;
        Ok(whole(Stage::Embedding))
    }

    fn discontinue(&mut self) -> Result<Progress, Error> {
        let tracks = self.working.as_ref().ok_or_else(lost)?;
        let embedding = self.embedding.as_ref().ok_or_else(lost)?;
        self.discontinuities = Some(discontinuities(neighborhoods(tracks), embedding, &self.params.discontinuity));
        self.state = State::Clusters;
        Ok(whole(Stage::Discontinuities))
    }

    fn cluster(&mut self) -> Result<Progress, Error> {
        let (Some(tracks), Some(embedding), Some(found)) = (&self.working, &self.embedding, &self.discontinuities)
        else {
            return Err(lost());
        };
        let params = &self.params.discretize;
        let min_cluster = self.scaled_count(params.min_cluster);
        self.clusters = Some(discretize(tracks, embedding, found, params.merge_threshold, min_cluster));
        self.state = if self.params.clip.dense && !self.frames.is_empty() { State::Dense } else { State::Done };
        Ok(whole(Stage::Clusters))
    }

    fn densify(&mut self) -> Result<Progress, Error> {
        let (Some(tracks), Some(clusters)) = (&self.working, &self.clusters) else { return Err(lost()) };
        let clip = Clip { frames: &self.frames, flows: &self.flows, tracks, clusters, params: &self.params };
        let progress = self.dense.step(&clip);
        if self.dense.is_finished(&self.frames) {
            self.state = State::Done;
        }
        Ok(progress)
    }

    /// A count of trajectories stated at the reference grid step, at the present spacing.
    fn scaled_count(&self, count: u32) -> usize {
        (count as f32 * (REFERENCE_STEP / self.spacing).powi(2)).round() as usize
    }

    /// Drops frames and results; parameters stay.
    pub fn clear(&mut self) {
        if let Ok(fresh) = Self::new(self.params.clone()) {
            *self = fresh;
        }
    }

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

    /// The affinity matrix A.
    pub fn affinities(&self) -> Option<&SymCsr> {
        self.affinities.as_ref()
    }

    /// The spectral embedding.
    pub fn embedding(&self) -> Option<&Embedding> {
        self.embedding.as_ref()
    }

    /// Neighbour pairs and discontinuities.
    pub fn discontinuities(&self) -> Option<&Discontinuities> {
        self.discontinuities.as_ref()
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

    /// The other segmentation that the discontinuities give, Figure 1(c): what stays connected when all edges with `d` above
    /// `discontinuity.threshold` are cut. Computed anew at each call; single stray trajectories are clusters of their own.
    pub fn threshold_clusters(&self) -> Option<Clusters> {
        let (tracks, found) = (self.working.as_ref()?, self.discontinuities.as_ref()?);
        Some(threshold_segmentation(tracks, found, self.params.discontinuity.threshold))
    }
}

fn whole(stage: Stage) -> Progress {
    Progress { stage, done: 1, total: 1 }
}

fn state_error(reason: &str) -> Error {
    Error::State { reason: reason.to_owned() }
}

fn missing_frame(what: &str, t: usize, known: usize) -> Error {
    state_error(&format!("the {what} of frame {t} is not available (expected a frame in 0..{known})"))
}

/// Each stage stores its result before the next begins; this error would be a bug, and is still no panic.
fn lost() -> Error {
    state_error("the result of an earlier stage is missing")
}

/// Distance of neighbouring trajectories in a frame, in pixels: the side of the square that one has for itself on average.
fn typical_spacing(tracks: &Trajectories) -> f32 {
    let alive = tracks.x.len() as f32 / tracks.num_frames.max(1) as f32;
    let area = (tracks.size.0 * tracks.size.1) as f32;
    if alive > 0.0 { (area / alive).sqrt().clamp(2.0, 64.0) } else { REFERENCE_STEP }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn session() -> Session {
        Session::new(Params::default()).unwrap()
    }

    fn shades(width: usize, height: usize, value: u8) -> Vec<u8> {
        vec![value; 4 * width * height]
    }

    #[test]
    fn too_few_frames_are_an_error_and_more_can_be_pushed() {
        let mut s = session();
        assert_eq!(s.step(), Err(Error::TooFewFrames { got: 0, needed: 2 }));
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        assert_eq!(s.step(), Err(Error::TooFewFrames { got: 1, needed: 2 }));
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        s.run().unwrap();
        assert_eq!(s.clusters().unwrap().count, 0);
    }

    #[test]
    fn a_frame_of_another_size_is_refused_and_the_session_goes_on() {
        let mut s = session();
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        let error = s.push_rgba(&shades(24, 32, 9), 24, 32).unwrap_err();
        assert_eq!(error, Error::FrameSizeChanged { index: 1, expected: (32, 24), actual: (24, 32) });
        s.push_rgba(&shades(32, 24, 9), 32, 24).unwrap();
        s.run().unwrap();
    }

    #[test]
    fn tiny_and_black_clips_run_to_their_end() {
        for (w, h, frames) in [(1, 1, 2), (17, 3, 3), (64, 48, 8)] {
            let mut s = session();
            for _ in 0..frames {
                s.push_rgba(&shades(w, h, 0), w, h).unwrap();
            }
            s.run().unwrap();
            assert!(s.trajectories().unwrap().is_empty());
            assert_eq!(s.flow(0).unwrap().u.width(), w);
            assert_eq!(s.flow(frames - 1).unwrap_err().code(), "state");
        }
    }

    #[test]
    fn outside_trajectories_are_checked() {
        let mut tracks = Trajectories::empty(3, (64, 48));
        tracks.push(0, [(1.0, 1.0, 0.0), (f32::NAN, 1.0, 0.0), (1.0, 1.0, 0.0)]);
        let message = session().set_trajectories(tracks).unwrap_err().to_string();
        assert_eq!(message, "x[1] = NaN (expected a finite number of pixels)");
        assert!(session().set_trajectories(Trajectories::empty(1, (64, 48))).is_err());
        assert!(session().set_trajectories(Trajectories::empty(3, (0, 48))).is_err());
        let mut s = session();
        s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap();
        assert_eq!(s.push_rgba(&shades(64, 48, 0), 64, 48).unwrap_err().code(), "state");
        s.run().unwrap();
        assert_eq!(s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap_err().code(), "state");
        s.clear();
        s.set_trajectories(Trajectories::empty(3, (64, 48))).unwrap();
    }

    #[test]
    fn progress_counts_up_to_its_total_in_every_stage() {
        let mut s = session();
        for _ in 0..4 {
            s.push_rgba(&shades(40, 30, 50), 40, 30).unwrap();
        }
        let mut last = std::collections::BTreeMap::new();
        while let Step::Working(p) = s.step().unwrap() {
            let before = last.insert(p.stage, p);
            assert!(p.done <= p.total && before.is_none_or(|b| b.done < p.done));
        }
        assert_eq!(last.len(), Stage::ALL.len());
        assert!(last.values().all(|p| p.done == p.total));
    }
}
