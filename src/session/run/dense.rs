//! Superpixels frame by frame, with what the camera and the background tell; and masks frame by frame.

use super::clip::Clip;
use super::recut::Recut;
use super::work::{StageWork, Turn};
use crate::Error;
use crate::background::{Background, BackgroundParams};
use crate::camera::{Camera, Egomotion, ForwardMotion, PointMatches};
use crate::cut::paint;
use crate::image::{Frame, Plane};
use crate::mask::refine;
use crate::session::base::{Outputs, Stage};
use crate::session::jobs::{Ledger, Made, Piece, PieceKind, Work};
use crate::superpixel::frame_superpixels;

/// Superpixels, a frame a step; with the last of them the camera and the background.
#[derive(Debug, Clone)]
pub(crate) struct SuperpixelWork;

impl StageWork for SuperpixelWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let t = outputs.superpixels.len();
        outputs.superpixels.push(match clip.ledger.collect(PieceKind::Superpixels, t) {
            Some(Made::Superpixels(made)) => made,
            _ => frame_superpixels(&clip.frames[t], &clip.params.contour, &clip.params.superpixel),
        });
        let turn = Turn::new(Stage::Superpixels, t + 1, clip.frames.len());
        if turn.is_last {
            let Clip { ledger, frames, params, .. } = &mut *clip;
            let mut egomotion_of = |k: usize, matches: PointMatches| match ledger.collect(PieceKind::Ways, k) {
                Some(Made::Ways(egomotion)) => egomotion,
                _ => matches.estimate_egomotion(),
            };
            outputs.camera = camera_of(outputs, frames, &params.background, &mut egomotion_of);
            outputs.background = outputs.camera.clone().and_then(|camera| background_of(camera, outputs, clip));
        }
        Ok(turn)
    }

    fn awaits(&self, ledger: &Ledger, outputs: &Outputs) -> bool {
        ledger.is_out(PieceKind::Superpixels, outputs.superpixels.len())
    }
}

/// Masks, a frame a step.
#[derive(Debug, Clone)]
pub(crate) struct MaskWork {
    /// What a correction cut again; `None` for the first masks.
    pub(crate) recut: Option<Recut>,
}

/// The label of each pixel of a frame, from the clusters of its superpixels, before borders are refined.
fn painted(outputs: &Outputs, t: usize) -> Plane<u8> {
    paint(&outputs.superpixels[t], &outputs.cut.labels.labels[t]).map(|cluster| outputs.label_of(cluster))
}

impl StageWork for MaskWork {
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let t = outputs.masks.len();
        let made = clip.ledger.collect(PieceKind::Mask, t);
        let frame = &clip.frames[t];
        let mask = match (&self.recut, made) {
            (Some(recut), _) => recut.mask(t, frame, outputs, &clip.params),
            (None, Some(Made::Mask(made))) => made,
            (None, _) => refine(&painted(outputs, t), frame, &clip.params.refine),
        };
        outputs.masks.push(mask);
        Ok(Turn::new(Stage::Masks, t + 1, clip.frames.len()))
    }

    /// One that is made for the first time.
    fn take(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Piece> {
        let left = if self.recut.is_none() { outputs.masks.len()..clip.frames.len() } else { 0..0 };
        let id = clip.ledger.take(PieceKind::Mask, left)?;
        let t = id.t as usize;
        Some(Piece { id, work: Work::Mask(clip.frames[t].clone(), painted(outputs, t)) })
    }

    fn awaits(&self, ledger: &Ledger, outputs: &Outputs) -> bool {
        ledger.is_out(PieceKind::Mask, outputs.masks.len())
    }
}

/// The camera of the clip, `None` without flow; `egomotion_of` estimates the egomotion of a pair of frames.
pub(crate) fn camera_of(
    outputs: &Outputs,
    frames: &[Frame],
    settings: &BackgroundParams,
    egomotion_of: &mut dyn FnMut(usize, PointMatches) -> Option<(Egomotion, bool)>,
) -> Option<Camera> {
    let motions = outputs.salient.as_ref()?.maps.motions();
    let tracks = &outputs.tracked.tracks;
    let forward = (settings.enabled && settings.rigid_scene)
        .then(|| ForwardMotion::estimate_with(tracks, egomotion_of))
        .flatten();
    Some(Camera::new(motions, frames, forward))
}

/// Background model of the clip, `None` unless enabled.
pub(crate) fn background_of(camera: Camera, outputs: &Outputs, clip: &Clip) -> Option<Background> {
    if !clip.params.background.enabled {
        return None;
    }
    let densest = outputs.tracked.denser.as_ref().unwrap_or(&outputs.tracked.tracks);
    Some(Background::new(&clip.frames, camera, densest, clip.params.trajectory.mask_step))
}
