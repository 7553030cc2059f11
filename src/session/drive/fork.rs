//! Forks: runs of one clip with different parameters that share the stages before the first difference. They measure the
//! effect of a parameter in a fraction of the time.

use crate::Error;
use crate::params::ParamGroup;
use crate::session::base::{Params, Stage};
use crate::session::jobs::JobKind;
use crate::session::run::{AffinityWork, Clip, Phase, Run, Session, State};
use std::collections::BTreeSet;

/// A run of a clip saved at its begin, after its trajectories and after its clusters.
#[derive(Debug)]
pub struct Forks {
    params: Params,
    begin: Clip,
    tracked: Session,
    labelled: Session,
}

/// Parameter groups that are read from the superpixels on.
const MASK_GROUPS: [&str; 5] = ["contour", "superpixel", "cut", "background", "refine"];
/// Parameter groups that are read from the affinities on.
const CLUSTER_GROUPS: [&str; 6] = ["affinity", "embedding", "discontinuity", "saliency", "connectedness", "discretize"];
/// Parameter groups that superpixels depend on.
const SUPERPIXEL_GROUPS: [&str; 2] = ["contour", "superpixel"];

impl Forks {
    /// Runs a clip up to its clusters, and computes its superpixels.
    ///
    /// # Errors
    /// As [`Session::step`]; [`Error::State`] without frames, in windows, or once stepping has begun.
    pub fn new(mut session: Session) -> Result<Self, Error> {
        let params = session.params.clone();
        let begin = match &session.phase {
            Phase::Frames(clip) if clip.windows.is_none() && clip.external.is_none() => Clip::clone(clip),
            _ => return Err(Error::state("a fork needs a session with frames that has not run")),
        };
        run_past(Stage::Trajectories, &mut session)?;
        while session.run_one_job(0) {}
        let tracked = session.clone();
        run_past(Stage::Clusters, &mut session)?;
        Ok(Self { params, begin, tracked, labelled: session })
    }

    /// Returns a run up to its clusters with other parameters, which shares the stages before the first difference.
    /// [`Session::run`] makes the masks.
    ///
    /// # Errors
    /// As [`Session::step`]; [`Error::Param`] if a parameter is out of range, [`Error::State`] if `clip.maxSide` differs.
    pub fn labelled(&self, params: &Params) -> Result<Session, Error> {
        params.validate()?;
        if params.clip.max_side != self.params.clip.max_side {
            return Err(Error::state("clip.maxSide of a fork has changed: start a new session"));
        }
        let changed = changed_names(&self.params, params);
        let within = |groups: &[&str]| changed.iter().all(|name| groups.iter().any(|group| is_in(name, group)));
        let mut session = if within(&MASK_GROUPS) {
            self.labelled.clone()
        } else if within(&[&MASK_GROUPS[..], &CLUSTER_GROUPS, &["clip.seed"]].concat()) {
            self.tracked.clone()
        } else {
            let mut begin = Box::new(self.begin.clone());
            begin.pending_jobs = self.tracked.clip().map(|clip| clip.pending_jobs.clone()).unwrap_or_default();
            begin.pending_jobs.keep_only(&[JobKind::Superpixels]);
            Session { params: params.clone(), phase: Phase::Frames(begin), epoch: 0 }
        };
        session.params = params.clone();
        if let Some(clip) = session.phase.clip_mut() {
            clip.params = params.scaled_to(clip.scale.working);
            let is_changed = changed.iter().any(|name| SUPERPIXEL_GROUPS.iter().any(|group| is_in(name, group)));
            clip.pending_jobs.keep_only(if is_changed { &[] } else { &[JobKind::Superpixels] });
        }
        if let Phase::Running(run) = &mut session.phase
            && let Run { clip, outputs, state: State::Affinities(work), .. } = &mut **run
        {
            **work = AffinityWork::new(&outputs.track_set, clip);
            clip.saliency_maps = Some(clip.dominant_motions());
        }
        run_past(Stage::Clusters, &mut session)?;
        Ok(session)
    }
}

/// Returns whether a parameter is in a group, or is itself named.
fn is_in(name: &str, group: &str) -> bool {
    name.strip_prefix(group).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Steps until `stage` is finished.
fn run_past(stage: Stage, session: &mut Session) -> Result<(), Error> {
    while session.outputs_after(stage).is_none() {
        session.step()?;
    }
    Ok(())
}

/// Returns the names of the parameters whose values differ.
fn changed_names(a: &Params, b: &Params) -> BTreeSet<String> {
    let values = |params: &Params| {
        let mut values = Vec::new();
        params.clone().visit("", &mut |field| values.push((field.name.clone(), field.get().to_bits())));
        values
    };
    values(a).into_iter().zip(values(b)).filter(|(a, b)| a != b).map(|(a, _)| a.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::Scene;

    #[test]
    fn a_parameter_is_in_its_group_and_in_no_other() {
        assert!(is_in("clip.seed", "clip.seed") && is_in("cut.spatialWeight", "cut"));
        assert!(!is_in("clip.seedling", "clip.seed") && !is_in("clip.seed", "cut") && !is_in("clip", "clip.seed"));
    }

    #[test]
    fn the_masks_of_a_fork_are_those_of_a_new_run() {
        let scene = Scene::sample((96, 64), 6, 3);
        let session = |params: &Params| {
            let mut session = Session::new(params.clone()).unwrap();
            (0..6).for_each(|t| session.push_frame(scene.frame(t)).unwrap());
            session
        };
        let forks = Forks::new(session(&Params::default())).unwrap();
        for (name, value) in [
            ("clip.seed", 3.0),
            ("flow.fixedPoints", 0.0),
            ("affinity.variationWeight", 1.0),
            ("contour.maxLineLength", 50.0),
            ("cut.spatialWeight", 1.0),
            ("refine.band", 0.0),
            ("clip.referenceSide", 0.0),
        ] {
            let mut params = Params::default();
            params.set(name, &crate::params::ParamValue::Number(value)).unwrap();
            let (mut fork, mut new) = (forks.labelled(&params).unwrap(), session(&params));
            fork.run().unwrap();
            new.run().unwrap();
            assert_eq!(fork.clusters(), new.clusters(), "{name}");
            (0..6).for_each(|t| assert_eq!(fork.labels(t).unwrap(), new.labels(t).unwrap(), "{name}"));
        }
        let mut small = Params::default();
        small.clip.max_side = 32;
        assert!(matches!(forks.labelled(&small), Err(Error::State { .. })));
        assert!(matches!(Forks::new(Session::new(Params::default()).unwrap()), Err(Error::State { .. })));
    }
}
