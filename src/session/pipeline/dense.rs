//! The last stages: superpixels frame by frame, the cut over the whole clip, masks frame by frame.

use super::clip::Clip;
use super::figure::{Figure, voted};
use super::found::{Clustered, Corrections, Cut, CutGround, Found, Parts, Segmented};
use super::geometry::Scale;
use super::ledger::Ledger;
use super::piece::{Made, PieceKind, Work};
use super::recut::{Recut, Wanted};
use super::stage::{Progress, Stage};
use super::turn::Turn;
use crate::background::{Background, BackgroundParams, LabelledTracks};
use crate::camera::{Camera, Forward, Travel, Ways};
use crate::cut::{CutInput, GabrielCut, add_appearance, paint};
use crate::image::{Frame, Plane};
use crate::mask::refine;
use crate::objects::Objects;
use crate::superpixel::{Superpixels, frame_superpixels};
use std::sync::{Arc, OnceLock};

/// Superpixels being made, frame by frame.
#[derive(Debug, Clone)]
pub(super) struct Dividing {
    clustered: Clustered,
    superpixels: Vec<Superpixels>,
}

impl Dividing {
    pub(super) fn new(clustered: Clustered) -> Self {
        Self { clustered, superpixels: Vec::new() }
    }

    pub(super) fn made(&self) -> usize {
        self.superpixels.len()
    }

    pub(super) fn step(mut self: Box<Self>, clip: &mut Clip) -> Turn<Box<Self>, Box<Cutting>> {
        let t = self.superpixels.len();
        self.superpixels.push(match clip.ledger.collect(PieceKind::Superpixels, t) {
            Some(Made::Superpixels(made)) => made,
            _ => frame_superpixels(&clip.frames[t], &clip.params.contour, &clip.params.superpixel),
        });
        let progress = Progress { stage: Stage::Superpixels, done: t as u32 + 1, total: clip.frames.len() as u32 };
        if t + 1 < clip.frames.len() {
            return Turn::more(progress, self);
        }
        let Self { clustered, superpixels } = *self;
        let mut tells = |k: usize, ways: Ways| match clip.ledger.collect(PieceKind::Ways, k) {
            Some(Made::Ways(forward)) => forward,
            _ => ways.forward(),
        };
        let camera = camera_of(&clustered, (&clip.frames, &clip.params.background), &mut tells);
        let background = camera.clone().and_then(|camera| background_of(camera, &clustered, clip));
        let corrections = Corrections::default();
        let parts = Parts { clustered, superpixels, camera, background, doubts: Vec::new(), corrections };
        Turn::done(progress, Box::new(Cutting { parts, recut: None, figure: None }))
    }

    pub(super) fn found(&self) -> Found<'_> {
        Found { superpixels: &self.superpixels, ..self.clustered.found() }
    }
}

/// A cut to be begun.
#[derive(Debug, Clone)]
pub(super) struct Cutting {
    pub(super) parts: Parts,
    /// What a correction asks for; `None` for the first cut.
    recut: Option<Recut>,
    /// Once it is known which clusters are objects.
    figure: Option<Figure>,
}

/// What a step towards a cut leads to.
#[derive(Debug)]
pub(super) enum Towards {
    Energy(Box<Cutting>),
    Moves(Box<Moving>),
}

/// A cut being made, move by move.
#[derive(Debug, Clone)]
pub(super) struct Moving {
    pub(super) parts: Parts,
    recut: Option<Recut>,
    objects: Objects,
    terms: Terms,
    /// The evidence of this round.
    evidence: Vec<f32>,
    moves: GabrielCut,
    /// Steps of the rounds before.
    made: u32,
    /// Rounds by appearance that are left.
    rounds: u32,
}

/// What speaks for labels in all rounds.
#[derive(Debug, Clone)]
struct Terms {
    /// The labels of the denser trajectories; `None` without them.
    voted: Option<Vec<u32>>,
    is_object: Vec<bool>,
    /// For an object in each superpixel; empty without a background.
    evidence: Vec<f32>,
}

/// Masks being made, frame by frame.
#[derive(Debug, Clone)]
pub(super) struct Masking {
    pub(super) parts: Parts,
    recut: Option<Recut>,
    cut: Cut,
    masks: Vec<Plane<u8>>,
}

impl Cutting {
    /// The cut anew, where a correction asks for it.
    pub(super) fn again(found: Segmented, wanted: Wanted) -> Self {
        let (parts, recut) = Recut::new(found, wanted);
        Self { parts, recut: Some(recut), figure: None }
    }

    /// What is object, frame by frame where pixels are asked; with the last of them the energy, and the first move.
    pub(super) fn step(mut self: Box<Self>, clip: &mut Clip) -> Turn<Towards, Box<Masking>> {
        let Self { parts, recut, figure } = &mut *self;
        let (objects, voted, made) = match recut {
            Some(recut) => (recut.objects.clone(), voted(parts, clip), 0),
            None => {
                let known = match figure.take() {
                    Some(mut known) => {
                        known.step(parts, clip);
                        known
                    }
                    None => Figure::new(parts, clip),
                };
                let (made, wanted) = (known.made(), known.wanted);
                if made < wanted {
                    *figure = Some(known);
                    let progress = Progress { stage: Stage::Cut, done: made as u32 + 1, total: wanted as u32 + 2 };
                    return Turn::more(progress, Towards::Energy(self));
                }
                let (objects, voted) = known.finish(parts, clip);
                (objects, voted, wanted as u32)
            }
        };
        let Self { parts, recut, .. } = *self;
        let terms = Terms::new(&parts, recut.as_ref(), &objects, voted, clip);
        let before = recut.as_ref().filter(|_| clip.params.cut.appearance_rounds > 0).map(Recut::present);
        let evidence = before.map(|before| terms.evidence_with(&parts, before, clip));
        let evidence = evidence.unwrap_or_else(|| terms.evidence.clone());
        let moves = terms.moves(&parts, recut.as_ref(), &evidence, clip);
        // Without objects there is nothing to be learned.
        let is_once = recut.is_some() || !terms.is_object.contains(&true);
        let rounds = if is_once { 0 } else { clip.params.cut.appearance_rounds };
        let moving = Box::new(Moving { parts, recut, objects, terms, evidence, moves, made, rounds });
        moving.step(clip).map(Towards::Moves)
    }

    pub(super) fn take(&self, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        self.figure.as_ref()?.take(&self.parts, clip)
    }

    pub(super) fn awaits(&self, ledger: &Ledger) -> bool {
        self.figure.as_ref().is_some_and(|figure| figure.awaits(ledger))
    }

    pub(super) fn found(&self) -> Found<'_> {
        self.parts.found()
    }
}

impl Terms {
    /// `voted` has the labels of the denser trajectories.
    fn new(parts: &Parts, recut: Option<&Recut>, objects: &Objects, mut voted: Option<Vec<u32>>, clip: &Clip) -> Self {
        let Parts { clustered, superpixels, background, .. } = parts;
        let tracked = &clustered.embedded.tracked;
        let is_object: Vec<bool> = objects.of_cluster.iter().map(|&label| label > 0).collect();
        if let (Some(denser), Some(voted), Some(recut)) = (&tracked.denser, &mut voted, recut) {
            recut.vote(denser, voted, superpixels[0].runs().size());
        }
        let mut terms = Self { voted, is_object, evidence: Vec::new() };
        if let Some(background) = background {
            let (tracks, label) = clustered.counting(terms.voted.as_deref());
            let settings = &clip.params.background;
            let labelled = LabelledTracks { tracks, label, is_object: &terms.is_object };
            let is_told = |cluster: usize| recut.is_some_and(|recut| recut.is_open(objects.of_cluster[cluster]));
            let doubts = parts.doubts(is_told);
            terms.evidence = background.evidence(superpixels, &clip.flows, labelled, &doubts, settings);
        }
        terms
    }

    /// The energy.
    fn moves(&self, parts: &Parts, recut: Option<&Recut>, evidence: &[f32], clip: &Clip) -> GabrielCut {
        let (input, settings) = (self.input(parts, evidence), &clip.params.cut);
        match recut {
            Some(recut) => recut.cut(&input, settings),
            None => GabrielCut::new(&input, settings),
        }
    }

    fn input<'a>(&'a self, parts: &'a Parts, evidence: &'a [f32]) -> CutInput<'a> {
        parts.input(self.voted.as_deref(), &self.is_object, evidence)
    }

    /// The evidence with that of what the labels of a cut before look like.
    fn evidence_with(&self, parts: &Parts, before: &[Vec<u32>], clip: &Clip) -> Vec<f32> {
        let weight = clip.params.cut.appearance_weight;
        add_appearance(&self.evidence, &parts.superpixels, &clip.frames, before, &self.is_object, weight)
    }
}

impl Moving {
    /// A move. A cut without any left is followed by the next round.
    pub(super) fn step(mut self: Box<Self>, clip: &Clip) -> Turn<Box<Self>, Box<Masking>> {
        let more = self.moves.step();
        let (done, total) = self.moves.progress();
        // Making an energy counts as a step, so that a cut without any move is seen to end.
        let (done, of_round) = (self.made + done + 1, total + 1);
        let is_last = self.rounds == 0;
        let progress = Progress { stage: Stage::Cut, done, total: self.made + of_round * (1 + self.rounds) };
        if more {
            return Turn::more(progress, self);
        }
        if !is_last {
            let labels = self.moves.labels().labels;
            self.evidence = self.terms.evidence_with(&self.parts, &labels, clip);
            self.moves.begin_again(&self.terms.input(&self.parts, &self.evidence), &clip.params.cut);
            (self.made, self.rounds) = (done, self.rounds - 1);
            return Turn::more(progress, self);
        }
        let Self { parts, recut, objects, terms, evidence, moves, .. } = *self;
        let Terms { voted, is_object, evidence: cues } = terms;
        let region = recut.as_ref().map(|recut| recut.region(&parts.superpixels));
        let ground = Arc::new(CutGround { voted, is_object, cues, evidence, region });
        let cut = Cut { labels: moves.finish(), objects, ground, sure: OnceLock::new() };
        Turn::done(progress, Box::new(Masking { parts, recut, cut, masks: Vec::new() }))
    }

    #[cfg(test)]
    pub(super) fn moves(&self) -> &GabrielCut {
        &self.moves
    }

    pub(super) fn found(&self) -> Found<'_> {
        self.parts.found()
    }
}

impl Masking {
    pub(super) fn made(&self) -> usize {
        self.masks.len()
    }

    /// One that is made for the first time.
    pub(super) fn take(&self, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        let left = if self.recut.is_none() { self.made()..clip.frames.len() } else { 0..0 };
        let t = clip.ledger.take(PieceKind::Mask, left)?;
        Some((PieceKind::Mask, t, Work::Mask(clip.frames[t].clone(), self.labels(t))))
    }

    /// The label of each pixel of a frame, from the clusters of its superpixels, before borders are refined.
    fn labels(&self, t: usize) -> Plane<u8> {
        // A clip without clusters is all background.
        let label = |cluster: u32| self.cut.objects.of_cluster.get(cluster as usize).copied().unwrap_or(0);
        paint(&self.parts.superpixels[t], &self.cut.labels.labels[t]).map(label)
    }

    pub(super) fn step(mut self: Box<Self>, clip: &mut Clip) -> Turn<Box<Self>, Box<Segmented>> {
        let t = self.masks.len();
        let made = clip.ledger.collect(PieceKind::Mask, t);
        let (frame, superpixels, labels) = (&clip.frames[t], &self.parts.superpixels[t], &self.cut.labels.labels[t]);
        let mask = match (&self.recut, made) {
            (Some(recut), _) => recut.mask(t, frame, superpixels, labels, &clip.params),
            (None, Some(Made::Mask(made))) => made,
            (None, _) => refine(&self.labels(t), frame, &clip.params.refine),
        };
        self.masks.push(mask);
        let progress = Progress { stage: Stage::Masks, done: t as u32 + 1, total: clip.frames.len() as u32 };
        if t + 1 < clip.frames.len() {
            return Turn::more(progress, self);
        }
        let Self { parts, cut, masks, .. } = *self;
        Turn::done(progress, Box::new(Segmented { parts, cut, masks }))
    }

    pub(super) fn found(&self) -> Found<'_> {
        Found { cut: Some(&self.cut), masks: &self.masks, ..self.parts.found() }
    }
}

/// What the camera does; `tells` says of a pair of frames how it goes forward.
pub(super) fn camera_of(
    clustered: &Clustered,
    (frames, settings): (&[Frame], &BackgroundParams),
    tells: &mut dyn FnMut(usize, Ways) -> Option<(Forward, bool)>,
) -> Option<Camera> {
    let motions = clustered.foreground.as_ref()?.salient.maps.motions();
    let tracks = &clustered.embedded.tracked.tracks;
    let travel = (settings.judge && settings.rigid).then(|| Travel::by(tracks, tells)).flatten();
    Some(Camera::new(motions, frames, travel))
}

/// What the background tells.
pub(super) fn background_of(camera: Camera, clustered: &Clustered, clip: &Clip) -> Option<Background> {
    if !clip.params.background.judge {
        return None;
    }
    let tracked = &clustered.embedded.tracked;
    let densest = tracked.denser.as_ref().unwrap_or(&tracked.tracks);
    Some(Background::new(&clip.frames, camera, densest, clip.params.trajectory.mask_step))
}

/// The cluster of each pixel of a frame, in agreement with its mask.
///
/// Refining moves borders between mask labels: a pixel moved to another label takes the largest cluster there in this
/// frame.
pub(super) fn clusters_of(
    superpixels: &Superpixels,
    labels: &[u32],
    objects: &Objects,
    mask: &Plane<u8>,
) -> Plane<u32> {
    let mut clusters = paint(superpixels, labels);
    let label_of = &objects.of_cluster;
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
    clusters
}

/// Labels at input size: each input pixel takes the value of the working pixel that covers its centre.
pub(super) fn to_input<T: Copy>(mask: &Plane<T>, scale: Scale) -> Plane<T> {
    let (width, height) = scale.input;
    let columns: Vec<usize> = (0..width).map(|x| place(scale, x, 0).0).collect();
    let mut data = Vec::with_capacity(width * height);
    for y in 0..height {
        let row = mask.row(place(scale, 0, y).1);
        data.extend(columns.iter().map(|&x| row[x]));
    }
    Plane::from_vec(width, height, data).unwrap_or_else(|| mask.clone())
}

/// The working pixel that covers the centre of an input pixel.
pub(super) fn place(scale: Scale, x: usize, y: usize) -> (usize, usize) {
    let along = |v: usize, s: f64, limit: usize| (((v as f64 + 0.5) / s) as usize).min(limit - 1);
    (along(x, scale.x(), scale.working.0), along(y, scale.y(), scale.working.1))
}
