//! The stages of superpixels and masks, a frame a step. Camera, background and objects are found before the superpixels.

use super::clip::Clip;
use super::cut::CutWork;
use super::recut::Recut;
use super::state::{StageWork, StepReport};
use crate::Error;
use crate::background::{Background, BackgroundParams};
use crate::camera::{Camera, Egomotion, ForwardMotion, PointMatches};
use crate::image::Frame;
use crate::mask::refine;
use crate::session::base::{Outputs, Stage};
use crate::session::jobs::{DescribedSuperpixels, Job, JobInput, JobKind, JobResult, PendingJobs};

/// First the camera, the background and the clusters that are objects, while other threads compute superpixels; then the
/// superpixels, a frame a step.
#[derive(Debug, Clone)]
pub(crate) struct SuperpixelWork {
    /// The cut that follows.
    pub(super) cut: Box<CutWork>,
}

impl SuperpixelWork {
    pub(super) fn new() -> Self {
        Self { cut: Box::new(CutWork::new(None)) }
    }
}

impl StageWork for SuperpixelWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        let t = outputs.superpixels.len();
        let report = |done| StepReport::new(Stage::Superpixels, done, clip.frames.len() + 1);
        if !self.cut.has_selected() {
            let report = report(1);
            let Clip { pending_jobs, frames, params, .. } = &mut *clip;
            let mut pair_motion =
                |k: usize, matches: PointMatches| match pending_jobs.take_result(JobKind::CameraMotion, k) {
                    Some(JobResult::CameraMotion(forward)) => forward,
                    _ => matches.estimate_egomotion(),
                };
            outputs.camera = estimate_camera(outputs, frames, &params.background, &mut pair_motion);
            outputs.background = outputs.camera.clone().and_then(|camera| model_background(camera, outputs, clip));
            self.cut.select(outputs, clip);
            return Ok(report);
        }
        let report = report(t + 2);
        let DescribedSuperpixels { superpixels, features } =
            match clip.pending_jobs.take_result(JobKind::Superpixels, t) {
                Some(JobResult::Superpixels(superpixels)) => superpixels,
                _ => DescribedSuperpixels::new(&clip.frames[t], &clip.params),
            };
        outputs.features.add_frame(features, &superpixels);
        outputs.superpixels.push(superpixels);
        Ok(report)
    }

    /// The longer jobs first: then no thread waits for a new one while this one takes a step.
    fn take_job(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Job> {
        clip.take_superpixel_job().or_else(|| self.cut.take_job(clip, outputs))
    }

    fn is_waiting(&self, pending_jobs: &PendingJobs, outputs: &Outputs) -> bool {
        self.cut.has_selected() && pending_jobs.is_pending(JobKind::Superpixels, outputs.superpixels.len())
    }
}

/// Masks, a frame a step.
#[derive(Debug, Clone)]
pub(crate) struct MaskWork {
    /// The correction that asked for new masks; `None` for the first ones.
    pub(crate) recut: Option<Recut>,
}

impl StageWork for MaskWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<StepReport, Error> {
        let t = outputs.masks.len();
        let result = clip.pending_jobs.take_result(JobKind::Mask, t);
        let frame = &clip.frames[t];
        let params = &clip.params.refine;
        let mask = match &self.recut {
            Some(recut) => recut.mask(t, frame, outputs, params),
            None => {
                let mut mask = match result {
                    Some(JobResult::Mask(mask)) => mask,
                    _ => refine(&outputs.cut.coarse_mask(&outputs.superpixels[t], t), frame, params),
                };
                outputs.attach_loose_parts(&mut mask, t, params.min_part, |_, _| false);
                mask
            }
        };
        outputs.masks.push(mask);
        Ok(StepReport::new(Stage::Masks, t + 1, clip.frames.len()))
    }

    /// Only the first masks of a clip are jobs.
    fn take_job(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Job> {
        let frames = if self.recut.is_none() { outputs.masks.len()..clip.frames.len() } else { 0..0 };
        let id = clip.pending_jobs.assign(JobKind::Mask, frames)?;
        let t = id.index as usize;
        Some(Job {
            id,
            input: JobInput::Mask(clip.frames[t].clone(), outputs.cut.coarse_mask(&outputs.superpixels[t], t)),
        })
    }

    fn is_waiting(&self, pending_jobs: &PendingJobs, outputs: &Outputs) -> bool {
        pending_jobs.is_pending(JobKind::Mask, outputs.masks.len())
    }
}

/// Estimates the motion of the camera; `None` without flow. `pair_motion` returns its forward motion in a frame pair.
pub(crate) fn estimate_camera(
    outputs: &Outputs,
    frames: &[Frame],
    settings: &BackgroundParams,
    pair_motion: &mut dyn FnMut(usize, PointMatches) -> Option<(Egomotion, bool)>,
) -> Option<Camera> {
    let motions = outputs.saliency.as_ref()?.maps.motions();
    let is_rigid = settings.enabled && settings.rigid_scene;
    let forward = is_rigid.then(|| ForwardMotion::estimate_with(&outputs.track_set.tracks, pair_motion)).flatten();
    Some(Camera::new(motions, frames, forward))
}

/// Models the background of the clip; `None` with `background.enabled` off.
pub(crate) fn model_background(camera: Camera, outputs: &Outputs, clip: &Clip) -> Option<Background> {
    if !clip.params.background.enabled {
        return None;
    }
    Some(Background::new(&clip.frames, camera, outputs.track_set.densest(), clip.params.trajectory.mask_step))
}
