//! Other clusterings of a clip whose masks change from frame to frame.
//!
//! The agreement of masks along the flow ([`crate::mask::Agreement`]) needs no true masks. If it is low after the first cut,
//! the clusters are merged more easily, then less; each time objects are selected and cut again. The search ends as soon as
//! masks agree. The masks that agree most are kept, if their objects are about as salient: still things agree best of all.
//! Clusters that equal earlier ones are not cut again. Not in the paper. Cost: up to two more clusterings and cuts, for few
//! clips. It fails where wrong masks agree, as those of a road that follows a car in all frames.

use super::clip::Clip;
use crate::background::Background;
use crate::discretize::Clusters;
use crate::mask::clip_agreement;
use crate::session::base::{Cut, Outputs, Progress, Stage};
use crate::session::jobs::JobKind;

// All constants of this file are chosen by eye.

/// Factors on the log-odds above which clusters are merged.
const FACTORS: [f64; 2] = [0.7, 1.4];
/// Another clustering is kept if its masks agree at least this much.
const MIN_AGREEMENT: f32 = 0.5;
/// And by this much more than those of the best so far.
const MIN_GAIN: f32 = 0.1;
/// And if the mean saliency of its objects is lower by at most this.
const MAX_SALIENCY_LOSS: f32 = 0.2;

/// The clusterings of a clip so far.
#[derive(Debug, Clone, Default)]
pub(crate) struct Alternatives {
    /// The best of them, while others are made.
    best: Option<Box<Candidate>>,
    /// The clusters of each, before objects were selected.
    clusters: Vec<Clusters>,
    /// The log-odds of the first; 0 before.
    first_log_odds: f64,
    /// Factors that were tried.
    num_tried: usize,
    /// Progress of the cut, in which all further clusterings are steps.
    done: u32,
    total: u32,
}

/// A clustering and what follows from it.
#[derive(Debug, Clone)]
struct Candidate {
    /// Agreement of the masks before their borders are refined.
    agreement: f32,
    /// Mean saliency of the objects.
    saliency: f32,
    merge_log_odds: f64,
    clusters: Clusters,
    background: Option<Background>,
    penalties: Vec<f32>,
    cut: Cut,
}

impl Alternatives {
    /// Returns whether clusters other than the first ones are being made.
    pub(super) fn is_trying(&self) -> bool {
        self.best.is_some()
    }

    /// Notes clusters before objects are selected. Returns whether they were not there before.
    pub(super) fn note(&mut self, clusters: &Clusters) -> bool {
        let is_new = !self.clusters.contains(clusters);
        if is_new {
            self.clusters.push(clusters.clone());
        }
        is_new
    }

    /// Compares the cut with the best one so far. Then as [`Alternatives::next`].
    pub(super) fn judge(&mut self, outputs: &mut Outputs, clip: &mut Clip) -> bool {
        let min_agreement = clip.params.discretize.min_agreement;
        if min_agreement == 0.0 || clip.flows.is_empty() {
            return false;
        }
        let cut = &outputs.cut;
        let masks: Vec<_> = (0..).zip(&outputs.superpixels).map(|(t, s)| cut.coarse_mask(s, t)).collect();
        let agreement = clip_agreement(&masks, &clip.flows).unwrap_or(0.0);
        if self.best.is_none() && agreement >= min_agreement {
            return false;
        }
        let saliency = saliency_of_objects(outputs);
        let is_better = |best: &Candidate| {
            agreement >= MIN_AGREEMENT.max(best.agreement + MIN_GAIN) && saliency >= best.saliency - MAX_SALIENCY_LOSS
        };
        if self.best.as_deref().is_none_or(is_better) {
            self.best = Some(Box::new(Candidate {
                agreement,
                saliency,
                merge_log_odds: clip.params.discretize.merge_log_odds,
                clusters: outputs.clusters.clone(),
                background: outputs.background.clone(),
                penalties: outputs.penalties.clone(),
                cut: outputs.cut.clone(),
            }));
        }
        self.next(outputs, clip)
    }

    /// Sets the parameters of the next clustering and returns true; false if no more are tried: then the outputs and the
    /// parameters are those of the best one.
    pub(super) fn next(&mut self, outputs: &mut Outputs, clip: &mut Clip) -> bool {
        let Some(best) = self.best.take() else { return false };
        if self.num_tried == 0 {
            self.first_log_odds = clip.params.discretize.merge_log_odds;
        }
        let is_enough = best.agreement >= clip.params.discretize.min_agreement;
        let next = FACTORS.get(self.num_tried).filter(|_| !is_enough);
        let merge_log_odds = next.map_or(best.merge_log_odds, |factor| factor * self.first_log_odds);
        clip.params.set_merge_log_odds(merge_log_odds);
        if next.is_some() {
            self.num_tried += 1;
            clip.pending_jobs.forget(&[JobKind::Rotation, JobKind::Reprojection]);
            self.best = Some(best);
        } else {
            let Candidate { clusters, background, penalties, cut, .. } = *best;
            (outputs.clusters, outputs.background) = (clusters, background);
            (outputs.penalties, outputs.cut) = (penalties, cut);
        }
        next.is_some()
    }

    /// Returns the progress after a step: further clusterings are steps of the cut. `was_trying` is from before the step.
    pub(super) fn progress(&mut self, progress: Progress, was_trying: bool) -> Progress {
        if !was_trying && progress.stage != Stage::Cut {
            return progress;
        }
        self.done = if was_trying { self.done + 1 } else { progress.done };
        let rest = progress.total - progress.done + u32::from(self.is_trying());
        self.total = if was_trying { self.total.max(self.done + rest) } else { self.done + rest };
        if was_trying && !self.is_trying() {
            self.done = self.total;
        }
        Progress { stage: Stage::Cut, done: self.done, total: self.total }
    }
}

/// Returns the mean saliency of the mask trajectories of objects; 0 without any.
fn saliency_of_objects(outputs: &Outputs) -> f32 {
    let labels = outputs.cut.context.mask_track_labels.as_deref().unwrap_or_default();
    let saliency = outputs.saliency.as_ref().map_or(&[][..], |saliency| &saliency.mask_tracks);
    let (mut sum, mut count) = (0.0_f64, 0_usize);
    for (_, &saliency) in labels.iter().zip(saliency).filter(|(label, _)| outputs.mask_label(**label) > 0) {
        (sum, count) = (sum + f64::from(saliency), count + 1);
    }
    (sum / count.max(1) as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::ParamValue;
    use crate::session::base::{Params, Step};
    use crate::session::run::Session;
    use crate::synth::Scene;

    const FRAMES: usize = 6;
    /// The seed of a scene in which, with all of the flow variation, other clusters are kept.
    const CHANGED_SCENE: u64 = 129;

    fn session(scene: u64, changes: &[(String, f64)]) -> Session {
        let mut params = Params::default();
        for (name, value) in changes {
            params.set(name, &ParamValue::Number(*value)).unwrap();
        }
        let mut session = Session::new(params).unwrap();
        let scene = Scene::sample((96, 64), FRAMES, scene);
        (0..FRAMES).for_each(|t| session.push_frame(scene.frame(t)).unwrap());
        session
    }

    fn given(min_agreement: f64, variation_weight: f64) -> Vec<(String, f64)> {
        [("discretize.minAgreement", min_agreement), ("affinity.variationWeight", variation_weight)]
            .map(|(name, value)| (name.to_owned(), value))
            .to_vec()
    }

    fn assert_same(a: &Session, b: &Session) {
        assert_eq!(a.affinities(), b.affinities());
        assert_eq!(a.embedding(), b.embedding());
        assert_eq!(a.discontinuities(), b.discontinuities());
        assert_eq!(a.clusters(), b.clusters());
        for t in 0..FRAMES {
            assert_eq!(a.labels(t).unwrap(), b.labels(t).unwrap());
        }
    }

    #[test]
    fn the_kept_masks_are_those_of_a_session_with_the_changed_parameters() {
        let mut searched = session(CHANGED_SCENE, &given(1.0, 1.0));
        searched.run().unwrap();
        let merge_log_odds = searched.agreement().unwrap().merge_log_odds.unwrap();
        assert_eq!(merge_log_odds, FACTORS[1] * Params::default().discretize.merge_log_odds);
        let changed = vec![("discretize.mergeLogOdds".to_owned(), merge_log_odds)];
        let mut first = session(CHANGED_SCENE, &given(0.0, 1.0));
        first.run().unwrap();
        assert!(searched.agreement().unwrap().clip > first.agreement().unwrap().clip);
        let mut direct = session(CHANGED_SCENE, &[given(0.0, 1.0), changed].concat());
        direct.run().unwrap();
        assert_same(&searched, &direct);
        // The session's own parameters stay, for the next clip and the next window.
        assert_eq!(*searched.params(), *session(CHANGED_SCENE, &given(1.0, 1.0)).params());
    }

    #[test]
    fn the_paper_makes_one_clustering() {
        assert_eq!(Params::paper().discretize.min_agreement, 0.0);
    }

    #[test]
    fn without_a_better_one_the_first_is_restored_bit_by_bit() {
        let mut searched = session(3, &given(1.0, 0.5));
        searched.run().unwrap();
        let mut first = session(3, &given(0.0, 0.5));
        first.run().unwrap();
        assert_eq!(searched.agreement().unwrap().merge_log_odds, None);
        assert_same(&searched, &first);
    }

    #[test]
    fn any_number_of_threads_finds_the_same() {
        let run = |threads| {
            let mut session = session(CHANGED_SCENE, &given(1.0, 1.0));
            session.run_on(threads, |_| ()).unwrap();
            session
        };
        let alone = run(0);
        [1, 3].into_iter().for_each(|threads| assert_same(&run(threads), &alone));
    }

    #[test]
    fn progress_never_falls_and_results_stay_readable() {
        let mut session = session(CHANGED_SCENE, &given(1.0, 1.0));
        let (mut last, mut tries) = (Progress { stage: Stage::Cut, done: 0, total: 0 }, 0);
        while let Step::Working(progress) = session.step().unwrap() {
            if progress.stage == Stage::Cut {
                assert!(progress.done > last.done && progress.total >= last.total && progress.done <= progress.total);
                last = progress;
                let (clusters, tracks) = (session.clusters().unwrap(), session.trajectories().unwrap());
                assert_eq!(clusters.label.len(), tracks.len());
                tries += usize::from(session.running().is_some_and(|run| run.alternatives.is_trying()));
            }
        }
        assert!(last.done == last.total && tries > FRAMES);
    }

    #[test]
    fn the_next_window_begins_with_the_given_parameters() {
        let mut params = Params::default();
        (params.discretize.min_agreement, params.affinity.variation_weight) = (1.0, 1.0);
        let scene = Scene::sample((96, 64), FRAMES, CHANGED_SCENE);
        let mut session = Session::new(params.clone()).unwrap();
        (0..FRAMES).for_each(|t| assert!(!session.push_in_shot(scene.frame(t)).unwrap()));
        session.run().unwrap();
        assert_ne!(session.clip().unwrap().params.discretize, params.discretize);
        session.advance(2).unwrap();
        let clip = session.clip().unwrap();
        assert_eq!(clip.params, params.scaled_to(clip.scale.working));
    }
}
