//! The cut over the whole clip, move by move; before it, which clusters are objects.
//!
//! The background (`classify`) or the frame border (`objects`) says it of the clusters, and pixels doubt it (`background`).
//! Objects take the labels that they had in the window before (`window`).

use super::clip::Clip;
use super::recut::Recut;
use super::work::{StageWork, Turn};
use crate::Error;
use crate::background::{ReprojectionErrors, ReprojectionInput, SegmentedTracks};
use crate::classify::{Observations, classify_clusters, cluster_penalties};
use crate::cut::{CutInput, CutParams, GabrielCut, Region, add_appearance, pixel_index};
use crate::evidence::EvidenceInput;
use crate::objects::{Objects, find_objects, number_objects};
use crate::order::{pair, sort_by_key};
use crate::session::base::{Cut, CutGround, CutRegion, Outputs, Stage};
use crate::session::jobs::{Ledger, Made, Piece, PieceKind, Work};
use crate::session::window::portraits;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;
use std::sync::{Arc, OnceLock};

/// A stroke holds a superpixel if this share of the stroke lies in it, or if it covers this share of the superpixel.
/// One that it only brushes may be large, and belong elsewhere.
const STROKE_SHARE: f32 = 0.25;
const SUPERPIXEL_SHARE: f32 = 0.1;

/// A cut, the first one or one that a correction asks for.
#[derive(Debug, Clone)]
pub(crate) struct CutWork {
    /// What a correction asks for; `None` for the first cut.
    recut: Option<Recut>,
    step: CutStep,
}

/// The step of a cut that is next.
#[derive(Debug, Clone)]
enum CutStep {
    /// Clusters become objects, frame by frame where pixels are asked, and then an energy.
    Energy(Option<Judging>),
    /// The energy is made less, move by move.
    Moves(Box<Moving>),
}

/// A cut being made.
#[derive(Debug, Clone)]
struct Moving {
    objects: Objects,
    terms: Terms,
    /// The evidence of this round.
    evidence: Vec<f32>,
    moves: GabrielCut,
    /// Steps of the rounds before.
    made: usize,
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

impl CutWork {
    /// The first cut, or one that a correction asks for.
    pub(crate) fn new(recut: Option<Recut>) -> Self {
        Self { recut, step: CutStep::Energy(None) }
    }

    /// Puts the finished cut to the outputs. Returns what a correction asked for.
    pub(crate) fn finish(self, outputs: &mut Outputs) -> Option<Recut> {
        if let CutStep::Moves(moving) = self.step {
            let Moving { objects, terms: Terms { voted, is_object, evidence: cues }, evidence, moves, .. } = *moving;
            let region = self.recut.as_ref().map(|recut| recut.region(&outputs.superpixels));
            let ground = Arc::new(CutGround { voted, is_object, cues, evidence, region });
            outputs.cut = Cut { labels: moves.finish(), objects, ground, sureness: OnceLock::new() };
        }
        self.recut
    }

    /// The energy.
    fn moving(&self, objects: Objects, voted: Option<Vec<u32>>, made: usize, clip: &Clip, outputs: &Outputs) -> Moving {
        let (recut, settings) = (self.recut.as_ref(), &clip.params.cut);
        let terms = Terms::new(outputs, recut, &objects, voted, clip);
        let before = recut.filter(|_| settings.appearance_rounds > 0).map(|recut| &recut.present);
        let evidence = before.map(|before| terms.evidence_with(outputs, before, clip));
        let evidence = evidence.unwrap_or_else(|| terms.evidence.clone());
        let input = terms.input(outputs, &evidence);
        let moves = recut.map_or_else(|| GabrielCut::new(&input, settings), |recut| recut.cut(&input, settings));
        // Without objects there is nothing to be learned.
        let is_once = recut.is_some() || !terms.is_object.contains(&true);
        let rounds = if is_once { 0 } else { settings.appearance_rounds };
        Moving { objects, terms, evidence, moves, made, rounds }
    }

    #[cfg(test)]
    pub(crate) fn moves(&self) -> Option<&GabrielCut> {
        match &self.step {
            CutStep::Moves(moving) => Some(&moving.moves),
            CutStep::Energy(_) => None,
        }
    }
}

impl StageWork for CutWork {
    /// What is object, frame by frame where pixels are asked; with the last of them the energy, and the first move; then
    /// a move.
    fn step(&mut self, clip: &mut Clip, outputs: &mut Outputs) -> Result<Turn, Error> {
        let judging = match &mut self.step {
            CutStep::Moves(moving) => return Ok(moving.step(clip, outputs)),
            CutStep::Energy(judging) => judging,
        };
        let (objects, voted, made) = if let Some(recut) = &self.recut {
            (recut.objects.clone(), voted(outputs, clip), 0)
        } else {
            let judging = match judging {
                Some(judging) => {
                    judging.step(outputs, clip);
                    judging
                }
                None => judging.insert(Judging::new(outputs, clip)),
            };
            let (made, wanted) = (judging.accounts.len(), judging.wanted);
            if made < wanted {
                return Ok(Turn::new(Stage::Cut, made + 1, wanted + 2));
            }
            let (objects, voted) = judging.finish(outputs, clip);
            (objects, voted, wanted)
        };
        let mut moving = Box::new(self.moving(objects, voted, made, clip, outputs));
        let turn = moving.step(clip, outputs);
        self.step = CutStep::Moves(moving);
        Ok(turn)
    }

    fn take(&self, clip: &mut Clip, outputs: &Outputs) -> Option<Piece> {
        let CutStep::Energy(Some(judging)) = &self.step else { return None };
        let id = clip.ledger.take(PieceKind::Accounts, judging.accounts.len()..judging.wanted)?;
        Some(Piece { id, work: Work::Accounts(judging.reprojection_input(id.t as usize, outputs)?) })
    }

    fn awaits(&self, ledger: &Ledger, _: &Outputs) -> bool {
        let CutStep::Energy(Some(judging)) = &self.step else { return false };
        let made = judging.accounts.len();
        made < judging.wanted && ledger.is_out(PieceKind::Accounts, made)
    }
}

impl Moving {
    /// A move. A cut without any left is followed by the next round.
    fn step(&mut self, clip: &Clip, outputs: &Outputs) -> Turn {
        let is_more = self.moves.step();
        let (done, total) = self.moves.progress();
        // Making an energy counts as a step, so that a cut without any move is seen to end.
        let (done, of_round) = (self.made + done as usize + 1, total as usize + 1);
        let turn = Turn::new(Stage::Cut, done, self.made + of_round * (1 + self.rounds as usize));
        let is_last = !is_more && self.rounds == 0;
        if !is_more && self.rounds > 0 {
            let labels = self.moves.labels().labels;
            self.evidence = self.terms.evidence_with(outputs, &labels, clip);
            self.moves.restart(&self.terms.input(outputs, &self.evidence), &clip.params.cut);
            (self.made, self.rounds) = (done, self.rounds - 1);
        }
        Turn { is_last, ..turn }
    }
}

impl Terms {
    /// `voted` has the labels of the denser trajectories.
    fn new(
        outputs: &Outputs,
        recut: Option<&Recut>,
        objects: &Objects,
        mut voted: Option<Vec<u32>>,
        clip: &Clip,
    ) -> Self {
        let superpixels = &outputs.superpixels;
        let is_object: Vec<bool> = objects.of_cluster.iter().map(|&label| label > 0).collect();
        if let (Some(denser), Some(voted), Some(recut)) = (&outputs.tracked.denser, &mut voted, recut) {
            recut.vote(denser, voted, superpixels[0].runs().size());
        }
        let mut terms = Self { voted, is_object, evidence: Vec::new() };
        if let Some(background) = &outputs.background {
            let CutInput { tracks, label, objects: is_object, .. } = terms.input(outputs, &[]);
            let is_sure =
                |cluster: usize| recut.is_some_and(|recut| recut.open[usize::from(objects.of_cluster[cluster])]);
            let penalties = cluster_penalties(&outputs.clusters, &outputs.doubts, is_sure);
            let segmented = SegmentedTracks { tracks, label, is_object };
            let params = &clip.params.background;
            terms.evidence = background.evidence(superpixels, &clip.flows, segmented, &penalties, params);
        }
        terms
    }

    fn input<'a>(&'a self, outputs: &'a Outputs, evidence: &'a [f32]) -> CutInput<'a> {
        outputs.input_of_cut(self.voted.as_deref(), &self.is_object, evidence)
    }

    /// The evidence with that of what the labels of a cut before look like.
    fn evidence_with(&self, outputs: &Outputs, before: &[Vec<u32>], clip: &Clip) -> Vec<f32> {
        let weight = clip.params.cut.appearance_weight;
        add_appearance(&self.evidence, &outputs.superpixels, &clip.frames, before, &self.is_object, weight)
    }
}

impl Recut {
    /// The energy of the part that is cut anew.
    fn cut(&self, input: &CutInput, params: &CutParams) -> GabrielCut {
        let CutRegion { open, held } = self.region(input.superpixels);
        GabrielCut::of_region(input, params, &Region { current: &self.present, open: &open, constraints: &held })
    }

    /// Which clusters can be given and taken, and which superpixels are held.
    fn region(&self, superpixels: &[Superpixels]) -> CutRegion {
        let of_cluster = &self.objects.of_cluster;
        let open = of_cluster.iter().map(|&l| self.open[usize::from(l)]).collect();
        let mut held = Vec::new();
        for (t, superpixels) in superpixels.iter().enumerate() {
            for (superpixel, label) in self.held_superpixels(t, superpixels) {
                held.push((t, superpixel, of_cluster.iter().map(|&l| l == label).collect()));
            }
        }
        CutRegion { open, held }
    }

    /// The denser trajectories that strokes were painted over have their labels, by the largest cluster of each.
    fn vote(&self, tracks: &Trajectories, label: &mut [u32], size: (usize, usize)) {
        for held in &self.held {
            let Some(cluster) = self.objects.of_cluster.iter().position(|&l| l == held.label) else { continue };
            for (i, x, y) in tracks.alive(held.t) {
                if held.pixels.binary_search(&(pixel_index(size, x, y) as u32)).is_ok() {
                    label[i] = cluster as u32;
                }
            }
        }
    }

    /// The superpixels of frame `t` that strokes lie over to a good part of the stroke or of the superpixel, where
    /// these agree on the label.
    fn held_superpixels(&self, t: usize, superpixels: &Superpixels) -> Vec<(u32, u8)> {
        let (label, area) = (superpixels.label(), superpixels.areas());
        let mut under: Vec<(u32, u8)> = Vec::new();
        for held in self.held.iter().filter(|h| h.t == t) {
            let mut of_stroke: Vec<u32> = held.pixels.iter().map(|&p| label.data()[p as usize]).collect();
            sort_by_key(&mut of_stroke, |&s| s.into());
            let good = |pixels: &&[u32]| {
                let count = pixels.len() as f32;
                count >= STROKE_SHARE * held.pixels.len() as f32
                    || count >= SUPERPIXEL_SHARE * area[pixels[0] as usize] as f32
            };
            under.extend(of_stroke.chunk_by(|a, b| a == b).filter(good).map(|pixels| (pixels[0], held.label)));
        }
        sort_by_key(&mut under, |&(s, l)| pair(s, l.into()));
        under.dedup();
        under.chunk_by(|a, b| a.0 == b.0).filter(|labels| labels.len() == 1).map(|labels| labels[0]).collect()
    }
}

/// Which clusters are objects, and what the pixels of the frames say to that, frame by frame.
#[derive(Debug, Clone)]
struct Judging {
    is_object: Vec<bool>,
    /// The labels of the denser trajectories; `None` without those.
    voted: Option<Vec<u32>>,
    /// Of the frames so far.
    accounts: Vec<ReprojectionErrors>,
    /// Number of frames with accounts; 0 where the camera stands still or there is nothing to tell.
    wanted: usize,
}

impl Judging {
    /// Clusters may be made anew.
    fn new(outputs: &mut Outputs, clip: &Clip) -> Self {
        let judged = outputs.background.as_ref().map(|background| {
            let known = outputs.known(&clip.params.affinity);
            let observations = observations(outputs, &known, clip);
            classify_clusters(background, &outputs.clusters, &observations, &clip.params.background)
        });
        let (is_object, voted) = match judged {
            Some(figure) => {
                (outputs.clusters, outputs.doubts) = (figure.clusters, figure.penalties);
                (figure.is_object, Some(figure.label))
            }
            None => {
                let objects = find_objects(&outputs.tracked.tracks, &outputs.clusters);
                (objects.of_cluster.iter().map(|&label| label > 0).collect(), voted(outputs, clip))
            }
        };
        let wanted = outputs.background.as_ref().map_or(0, |background| background.num_error_frames(&is_object));
        Self { is_object, voted, accounts: Vec::new(), wanted }
    }

    fn reprojection_input(&self, t: usize, outputs: &Outputs) -> Option<ReprojectionInput> {
        let (tracks, label) = (outputs.tracked.denser.as_ref()?, self.voted.as_deref()?);
        let segmented = SegmentedTracks { tracks, label, is_object: &self.is_object };
        outputs.background.as_ref()?.reprojection_input(t, segmented)
    }

    /// The accounts of the next frame.
    fn step(&mut self, outputs: &Outputs, clip: &mut Clip) {
        let t = self.accounts.len();
        let make = || self.reprojection_input(t, outputs).map(|input| input.errors()).unwrap_or_default();
        let made = match clip.ledger.collect(PieceKind::Accounts, t) {
            Some(Made::Accounts(made)) => made,
            _ => make(),
        };
        self.accounts.push(made);
    }

    /// The objects, and the labels of the denser trajectories.
    fn finish(&mut self, outputs: &mut Outputs, clip: &Clip) -> (Objects, Option<Vec<u32>>) {
        let (voted, accounts) = (self.voted.take(), std::mem::take(&mut self.accounts));
        let Outputs { background, tracked, .. } = &mut *outputs;
        if let (Some(background), Some(tracks), Some(label)) = (background, &tracked.denser, &voted) {
            background.set_reprojection_errors(accounts, SegmentedTracks { tracks, label, is_object: &self.is_object });
        }
        (objects_of(outputs, &self.is_object, clip), voted)
    }
}

/// The labels of the denser trajectories, by those that were clustered.
fn voted(outputs: &Outputs, clip: &Clip) -> Option<Vec<u32>> {
    outputs.tracked.denser.as_ref()?;
    let known = outputs.known(&clip.params.affinity);
    Some(observations(outputs, &known, clip).propagate_labels(&outputs.clusters))
}

/// What clusters are judged by.
fn observations<'a>(outputs: &'a Outputs, known: &'a EvidenceInput<'a>, clip: &Clip) -> Observations<'a> {
    let (tracked, params) = (&outputs.tracked, &clip.params);
    Observations {
        clustered: known,
        denser: tracked.denser.as_ref().unwrap_or(&tracked.tracks),
        saliency: outputs.salient.as_ref().map_or(&[], |salient| &salient.of_denser),
        saliency_threshold: params.saliency.threshold,
        max_edge: params.connectedness.max_edge * params.spacing(),
        vote_radius: params.vote_radius(),
        spacing: params.trajectory.mask_step,
    }
}

/// The objects, under the labels that they had in the window before.
fn objects_of(outputs: &Outputs, is_object: &[bool], clip: &Clip) -> Objects {
    let (tracked, clusters) = (&outputs.tracked, &outputs.clusters);
    let found = number_objects(&tracked.tracks, clusters, is_object);
    match &clip.windows {
        Some(w) => {
            let looks = portraits(&tracked.tracks, &clusters.label, &found, &clip.frames);
            w.identities.rename(&found, &tracked.tracks, &clusters.label, &tracked.numbers, w.overlap, &looks)
        }
        None => found,
    }
}
