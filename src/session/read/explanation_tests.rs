//! Tests of explanations, on synthetic clips.

use super::explanation::LabelSource;
use crate::correction::{Correction, Stroke};
use crate::cut::{GabrielCut, STEPS_PER_UNIT};
use crate::rng::Rng;
use crate::session::run::{Phase, Session, State};
use crate::synth::Scene;
use crate::{Error, Params, Step};

const SIZE: (usize, usize) = (200, 112);
const FRAMES: usize = 8;

fn pushed(seed: u64) -> Session {
    let scene = Scene::sample((SIZE.0, SIZE.1), FRAMES, seed);
    let mut session = Session::new(Params::default()).unwrap();
    for t in 0..FRAMES {
        session.push_frame(scene.frame(t)).unwrap();
    }
    session
}

/// Runs the session to its end; the solver of the last cut as it ended.
fn run_and_watch(session: &mut Session) -> GabrielCut {
    let mut solver = None;
    loop {
        if let Phase::Running(run) = &session.phase
            && let State::Cut(work) = &run.state
            && let Some(moves) = work.moves()
        {
            solver = Some(moves.clone());
        }
        if session.step().unwrap() == Step::Done {
            break;
        }
    }
    // The last move is made in the same step as what follows it.
    let mut solver = solver.unwrap();
    while solver.step() {}
    solver
}

/// Number of a superpixel among all.
fn node(session: &Session, t: usize, superpixel: u32) -> u32 {
    (0..t).map(|t| session.superpixels(t).unwrap().count as u32).sum::<u32>() + superpixel
}

/// Asks about random pixels and compares with the solver. Returns how many superpixels it could compare.
fn agrees(session: &Session, solver: &GabrielCut, pixels: usize, seed: u64) -> usize {
    let mut rng = Rng::for_stage(seed, "why");
    let mut compared = 0;
    for _ in 0..pixels {
        let (t, x, y) = (rng.below(FRAMES), rng.below(SIZE.0), rng.below(SIZE.1));
        let why = session.explain(t, (x, y)).unwrap();
        let own = why.cluster;
        let node = node(session, t, why.superpixel);
        let Some(present) = solver.energy_if(node, own) else { continue };
        for (label, cost) in (0..).zip(&why.costs) {
            if let Some(energy) = solver.energy_if(node, label) {
                let shown = cost.total - why.costs[own as usize].total;
                let steps = (energy - present) as f64 / f64::from(STEPS_PER_UNIT);
                assert_eq!(shown, steps, "frame {t}, pixel {x}, {y}, label {label}");
                assert!(shown >= 0.0, "a single superpixel would gain by another label");
                compared += usize::from(label != own);
            }
        }
    }
    compared
}

#[test]
fn the_terms_shown_are_the_energies_that_the_solver_sees() {
    for seed in [2, 5] {
        let mut session = pushed(seed);
        let solver = run_and_watch(&mut session);
        assert!(agrees(&session, &solver, 500, seed) >= 500);
    }
}

#[test]
fn after_strokes_the_terms_are_those_of_the_cut_made_anew() {
    let mut session = pushed(2);
    session.run().unwrap();
    let mask = session.labels(3).unwrap();
    let of_object: Vec<_> =
        (0..SIZE.0 * SIZE.1).map(|p| (p % SIZE.0, p / SIZE.0)).filter(|&at| mask[at] == 1).collect();
    let [(x0, y0), (x1, y1)] = [of_object[0], of_object[of_object.len() - 1]];
    let stroke = |x: usize, y: usize| {
        let (x, y) = (x as f32, y as f32);
        Stroke { t: 3, points: vec![(x, y), (x + 1.0, y + 1.0)], radius: 4.0 }
    };
    // Three things, since two would be parted in a single move, before anybody could look.
    let strokes = vec![stroke(x0, y0 + 4), stroke(x1, y1 - 4), stroke(2, 2)];
    session.correct(&Correction::SplitStrokes(strokes)).unwrap();
    let solver = run_and_watch(&mut session);
    assert!(agrees(&session, &solver, 150, 7) > 50);
    let why = session.explain(3, (2, 2)).unwrap();
    assert_eq!(why.source, LabelSource::Stroke);
    assert!(why.costs.iter().any(|cost| cost.forbidden > 0.0), "{:?}", why.costs);
    session.undo_correction().unwrap();
    let before = session.explain(3, (2, 2)).unwrap();
    assert!(before.source != LabelSource::Stroke && before.costs.iter().all(|cost| cost.forbidden == 0.0));
}

#[test]
fn what_is_behind_the_terms_agrees_with_the_other_results() {
    let mut session = pushed(2);
    session.run().unwrap();
    let (clusters, mut borders) = (session.clusters().unwrap(), 0);
    let mut rng = Rng::for_stage(3, "why");
    for _ in 0..60 {
        let (t, x, y) = (rng.below(FRAMES), rng.below(SIZE.0), rng.below(SIZE.1));
        let why = session.explain(t, (x, y)).unwrap();
        assert_eq!(why.label, session.labels(t).unwrap()[(x, y)]);
        assert_eq!(why.superpixel, session.superpixels(t).unwrap().label()[(x, y)]);
        let of_cluster = &session.objects().unwrap().of_cluster;
        assert_eq!(why.costs.iter().map(|cost| cost.label).collect::<Vec<_>>(), *of_cluster);
        let by_cut = of_cluster[why.cluster as usize];
        assert_eq!(why.source == LabelSource::Superpixel, why.label == by_cut);
        borders += usize::from(why.source == LabelSource::Border);
        let of_own = why.voters.iter().filter(|v| v.cluster == Some(why.cluster)).count();
        assert_eq!(of_own, why.costs[why.cluster as usize].votes as usize);
        assert_ne!(of_cluster[why.flip.unwrap().cluster as usize], by_cut);
        let nearest = why.nearest.unwrap() as usize;
        let a = session.affinities().unwrap();
        let most = a.row(nearest).filter(|&(j, _)| j != nearest).map(|(_, v)| v).fold(0.0, f64::max);
        assert_eq!(why.affinities[0].affinity, most);
        if let Some(border) = why.border {
            let ends = [border.i, border.j].map(|i| of_cluster[clusters.label[i as usize] as usize]);
            assert!(ends[0] != ends[1] && ends.contains(&by_cut), "{ends:?}");
            assert!(border.mean <= border.d && border.d <= 1.0);
        }
    }
    assert!(borders > 0, "no pixel was moved by the border's step: choose other ones");
}

#[test]
fn the_votes_that_flip_do_flip_and_one_less_does_not() {
    use crate::cut::{CutParams, SuperpixelTerms, UnaryCost};
    let unit = STEPS_PER_UNIT;
    // Six trajectories of label 0 and two of label 1, and half a unit of evidence against label 1.
    let own = |trajectories, evidence| UnaryCost { trajectories, evidence, ..UnaryCost::default() };
    let reasons = SuperpixelTerms {
        label: 0,
        lambda: 1.0,
        unary_weight: 1.0,
        votes: vec![6, 2],
        outliers: 0,
        voters: Vec::new(),
        unary: vec![own(unit / 4, 0), own(unit / 4 * 3, unit / 2)],
        links: Vec::new(),
    };
    let needed = reasons.votes_to_flip(1, &CutParams::default()).unwrap();
    // (6 − 2 − n) / (8 + n) + 1/2 is 0 at n = 16.
    assert_eq!(needed, 16);
    let strong = SuperpixelTerms { unary: vec![own(unit / 4, 0), own(unit / 4 * 3, 2 * unit)], ..reasons };
    assert_eq!(strong.votes_to_flip(1, &CutParams::default()), None);
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let mut session = pushed(2);
    assert!(matches!(session.explain(0, (0, 0)), Err(Error::State { .. })));
    session.run().unwrap();
    for (t, x, y, named) in [(FRAMES, 0, 0, "0..8"), (0, SIZE.0, 0, "0..200"), (0, 0, 4000, "4000")] {
        let message = session.explain(t, (x, y)).unwrap_err().to_string();
        assert!(message.contains(named), "{message}");
    }
}
