//! Invariant of jobs: the run is the same on any worker.

use crate::flow::FlowScratch;
use crate::image::Plane;
use crate::rng::Rng;
use crate::session::jobs::{Job, JobId, JobKind, JobResult};
use crate::synth::Scene;
use crate::{Params, Session, Step};

const FRAMES: usize = 9;

fn session() -> Session {
    let mut session = Session::new(Params::default()).unwrap();
    push(&mut session);
    session
}

fn push(session: &mut Session) {
    let scene = Scene::sample((96, 64), FRAMES, 3);
    (0..FRAMES).for_each(|t| session.push_frame(scene.frame(t)).unwrap());
}

type Outcome = (crate::trajectory::Trajectories, Vec<u32>, Vec<Plane<u8>>);

fn outcome(session: &Session) -> Outcome {
    let masks = (0..FRAMES).map(|t| session.labels(t).unwrap()).collect();
    (session.trajectories().unwrap().clone(), session.clusters().unwrap().label.clone(), masks)
}

fn alone() -> Outcome {
    let mut session = session();
    session.run().unwrap();
    outcome(&session)
}

/// As another worker does it: everything goes over the wire.
fn elsewhere(piece: &Job) -> Vec<u32> {
    let words = piece.encode();
    let there = Job::decode(&words).unwrap();
    assert!(&there == piece);
    there.run(&Params::default(), &mut FlowScratch::default()).encode(there.id)
}

fn give_back(session: &mut Session, words: &[u32]) {
    let (id, made) = JobResult::decode(words).unwrap();
    session.store_result(id, Some(made));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let expected = alone();
    for threads in [0, 1, 2, 3, 6] {
        let mut session = session();
        let mut steps = 0;
        session.run_on(threads, |_| steps += 1).unwrap();
        assert_eq!(outcome(&session), expected, "{threads} threads");
        assert!(steps > 3 * FRAMES);
    }
}

#[test]
fn pieces_in_any_order_late_lost_or_twice_give_the_same_bits() {
    let expected = alone();
    let mut kinds = std::collections::BTreeSet::new();
    for seed in 0..4 {
        let mut rng = Rng::for_stage(seed, "pieces");
        let (mut session, mut back): (_, Vec<Vec<u32>>) = (session(), Vec::new());
        loop {
            for _ in 0..rng.below(12) {
                if let Some(piece) = session.take_job(4) {
                    kinds.insert(piece.id.kind as u32);
                    match rng.below(4) {
                        0 => session.store_result(piece.id, None),
                        1 => {}
                        _ => back.push(elsewhere(&piece)),
                    }
                }
            }
            if !back.is_empty() && rng.below(2) == 0 {
                let words = back.swap_remove(rng.below(back.len()));
                give_back(&mut session, &words);
                give_back(&mut session, &words);
            }
            if session.step().unwrap() == Step::Done {
                break;
            }
        }
        assert_eq!(outcome(&session), expected, "seed {seed}");
    }
    assert_eq!(kinds.len(), JobKind::ALL.len(), "pieces of all kinds were given away: {kinds:?}");
}

#[test]
fn steps_wait_for_what_is_out_until_it_is_back() {
    let mut session = session();
    let piece = session.take_job(4).unwrap();
    session.step().unwrap();
    let mut session = self::session();
    assert!(!session.is_waiting(), "a run that has not begun waits for nothing");
    let first = session.take_job(1).unwrap();
    assert!(first == piece);
    // Nothing but superpixels is left so near, and after these nothing.
    let rest: Vec<Job> = std::iter::from_fn(|| session.take_job(1)).collect();
    assert_eq!(rest.len(), FRAMES);
    session.step().unwrap();
    assert!(!session.is_waiting(), "what was taken is being made");
    session.store_result(first.id, Some(first.run(&Params::default(), &mut FlowScratch::default())));
    let second = session.take_job(2).unwrap();
    while !session.is_waiting() {
        session.step().unwrap();
    }
    session.store_result(second.id, None);
    assert!(!session.is_waiting(), "what is lost is made here");
    assert!(std::iter::from_fn(|| session.take_job(2)).all(|piece| piece.id != second.id));
}

#[test]
fn what_was_taken_before_a_clear_is_dropped() {
    let mut session = session();
    let piece = session.take_job(4).unwrap();
    session.clear();
    push(&mut session);
    let still = JobResult::decode(&elsewhere(&piece)).unwrap();
    let again = session.take_job(4).unwrap();
    assert_ne!(again.id, piece.id);
    session.store_result(still.0, Some(still.1));
    session.run().unwrap();
    assert_eq!(outcome(&session), alone());
}

#[test]
fn words_that_are_cut_short_are_nothing() {
    let mut session = session();
    let pieces: Vec<Job> = std::iter::from_fn(|| session.take_job(1)).take(2).collect();
    for piece in pieces {
        let (sent, made) = (piece.encode(), elsewhere(&piece));
        for length in [0, 2, 4, 5, 6, sent.len() / 2, sent.len() - 1] {
            assert!(Job::decode(&sent[..length]).is_none(), "{length}");
        }
        for length in [0, 4, 5, made.len() / 4] {
            assert!(JobResult::decode(&made[..length]).is_none(), "{length}");
        }
        assert_eq!(JobId::decode(&[0, 9, 0]), None);
    }
}

#[test]
fn a_run_that_is_stopped_goes_on_and_ends_the_same() {
    let expected = alone();
    for (threads, stop) in [(1, 3), (2, 1), (3, 7), (2, 40)] {
        let mut session = session();
        let mut steps = 0;
        let early = |_| {
            steps += 1;
            steps < stop
        };
        assert_eq!(session.run_while(threads, early), Ok(false), "{threads} threads, stopped at {stop}");
        assert_eq!(steps, stop);
        assert_eq!(session.run_while(threads, |_| true), Ok(true));
        assert_eq!(outcome(&session), expected, "{threads} threads, stopped at {stop}");
    }
}
