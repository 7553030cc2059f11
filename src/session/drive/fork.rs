//! One run, and what others with other parameters can take over of it: what a parameter is worth is measured in a fraction of
//! the time.

use crate::Error;
use crate::params::ParamGroup;
use crate::session::base::{Params, Stage};
use crate::session::jobs::PieceKind;
use crate::session::run::{AffinityWork, Clip, Phase, Run, Session, State};
use std::collections::BTreeSet;

/// A run, as it was at its begin, once its trajectories were known, and once they had labels.
#[derive(Debug)]
pub struct Forks {
    params: Params,
    begin: Clip,
    tracked: Session,
    labelled: Session,
}

/// Groups that nothing reads before there are superpixels.
const OF_MASKS: [&str; 5] = ["contour", "superpixel", "cut", "background", "refine"];
/// The same before there are trajectories.
const OF_LABELS: [&str; 6] = ["affinity", "embedding", "discontinuity", "saliency", "connectedness", "discretize"];
/// What superpixels depend on.
const OF_SUPERPIXELS: [&str; 2] = ["contour", "superpixel"];

impl Forks {
    /// Runs a clip up to its labelled trajectories, and makes its superpixels.
    ///
    /// # Errors
    /// As [`Session::step`]; [`Error::State`] without frames, in windows, or once stepping has begun.
    pub fn new(mut session: Session) -> Result<Self, Error> {
        let params = session.params.clone();
        let begin = match &session.phase {
            Phase::Frames(clip) if clip.windows.is_none() && clip.given.is_none() => Clip::clone(clip),
            _ => return Err(Error::state("a fork needs a clip of frames that has not begun")),
        };
        run_past(Stage::Trajectories, &mut session)?;
        while session.make_piece(0) {}
        let tracked = session.clone();
        run_past(Stage::Clusters, &mut session)?;
        Ok(Self { params, begin, tracked, labelled: session })
    }

    /// The run up to labelled trajectories with other parameters, from where they begin to count. [`Session::run`] makes the
    /// masks.
    ///
    /// # Errors
    /// As [`Session::step`]; [`Error::Param`] when a parameter is out of range, [`Error::State`] when frames would be of
    /// another size.
    pub fn labelled(&self, params: &Params) -> Result<Session, Error> {
        params.validate()?;
        if params.clip.max_side != self.params.clip.max_side {
            return Err(Error::state("frames of a fork have the size that they had"));
        }
        let changed = changed_names(&self.params, params);
        let within =
            |groups: &[&str]| changed.iter().all(|name| groups.iter().any(|g| name.starts_with(&format!("{g}."))));
        let mut session = if within(&OF_MASKS) {
            self.labelled.clone()
        } else if within(&[&OF_MASKS[..], &OF_LABELS, &["clip.seed"]].concat()) {
            self.tracked.clone()
        } else {
            let mut begin = Box::new(self.begin.clone());
            begin.ledger = self.tracked.clip().map(|clip| clip.ledger.clone()).unwrap_or_default();
            begin.ledger.keep_only(&[PieceKind::Superpixels]);
            Session { params: params.clone(), phase: Phase::Frames(begin), epoch: 0 }
        };
        session.params = params.clone();
        if let Some(clip) = session.phase.clip_mut() {
            clip.params = params.for_size(clip.scale.working);
            let are_others = changed.iter().any(|name| OF_SUPERPIXELS.iter().any(|g| name.starts_with(g)));
            clip.ledger.keep_only(if are_others { &[] } else { &[PieceKind::Superpixels] });
        }
        if let Phase::Begun(run) = &mut session.phase
            && let Run { clip, outputs, state: State::Affinities(work) } = &mut **run
        {
            **work = AffinityWork::new(&outputs.tracked, clip);
        }
        run_past(Stage::Clusters, &mut session)?;
        Ok(session)
    }
}

/// Steps until `stage` is over.
fn run_past(stage: Stage, session: &mut Session) -> Result<(), Error> {
    while session.after(stage).is_none() {
        session.step()?;
    }
    Ok(())
}

/// The names of parameters whose values differ.
fn changed_names(a: &Params, b: &Params) -> BTreeSet<String> {
    let values = |params: &Params| {
        let mut all = Vec::new();
        params.clone().visit("", &mut |field| all.push((field.name.clone(), field.get().to_bits())));
        all
    };
    values(a).into_iter().zip(values(b)).filter(|(a, b)| a != b).map(|(a, _)| a.0).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::Scene;

    /// Whatever a fork takes over: its masks are those of a run of its own.
    #[test]
    fn a_fork_finds_what_a_run_of_its_own_finds() {
        let scene = Scene::sample(96, 64, 6, 3);
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
            let (mut fork, mut own) = (forks.labelled(&params).unwrap(), session(&params));
            fork.run().unwrap();
            own.run().unwrap();
            assert_eq!(fork.clusters(), own.clusters(), "{name}");
            (0..6).for_each(|t| assert_eq!(fork.labels(t).unwrap(), own.labels(t).unwrap(), "{name}"));
        }
        let mut small = Params::default();
        small.clip.max_side = 32;
        assert!(matches!(forks.labelled(&small), Err(Error::State { .. })));
        assert!(matches!(Forks::new(Session::new(Params::default()).unwrap()), Err(Error::State { .. })));
    }
}
