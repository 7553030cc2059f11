//! Laws of corrections, on synthetic clips.

use crate::Session;
use crate::classify::cluster_penalties;
use crate::correction::{Correction, Stroke};
use crate::image::Plane;
use crate::mask::agreement;
use crate::session::base::Outputs;
use crate::session::run::Phase;
use crate::synth::Scene;
use crate::{Error, Params, Step};

const SIZE: (usize, usize) = (320, 180);
const FRAMES: usize = 10;

fn segmented() -> Session {
    let scene = Scene::sample((SIZE.0, SIZE.1), FRAMES, 2);
    let mut session = Session::new(Params::default()).unwrap();
    for t in 0..FRAMES {
        session.push_frame(scene.frame(t)).unwrap();
    }
    session.run().unwrap();
    session
}

fn masks(session: &Session) -> Vec<Plane<u8>> {
    (0..FRAMES).map(|t| session.labels(t).unwrap()).collect()
}

/// The agreement is that of the present masks.
fn agreement_is_up_to_date(session: &Session) {
    let masks: Vec<_> = (0..FRAMES).map(|t| session.working_labels(t).unwrap().clone()).collect();
    assert_eq!(session.agreement(), Some(&agreement(&masks, &session.clip().unwrap().flows)));
}

fn corrected(session: &mut Session, correction: &Correction) -> Vec<Plane<u8>> {
    session.correct(correction).unwrap();
    session.run().unwrap();
    is_consistent(session);
    masks(session)
}

/// Clusters, objects and masks say the same.
fn is_consistent(session: &Session) {
    let (clusters, objects) = (session.clusters().unwrap(), session.objects().unwrap());
    agreement_is_up_to_date(session);
    assert_eq!(objects.of_cluster.len(), clusters.count);
    assert_eq!(objects.highest_label, usize::from(objects.of_cluster.iter().copied().max().unwrap_or(0)));
    for c in 0..clusters.count as u32 {
        assert!(clusters.label.contains(&c), "cluster {c} has no trajectory");
    }
    for t in 0..FRAMES {
        let of_pixel = session.cluster_labels(t).unwrap().map(|c| objects.of_cluster[c as usize]);
        assert_eq!(of_pixel, session.labels(t).unwrap(), "frame {t}");
    }
}

/// A pixel well inside of what has this label in frame `t`.
fn inside(mask: &Plane<u8>, label: u8) -> (f32, f32) {
    let depth = |x: usize, y: usize| {
        let near = |r: usize| {
            (y.saturating_sub(r)..(y + r + 1).min(mask.height()))
                .all(|v| (x.saturating_sub(r)..(x + r + 1).min(mask.width())).all(|u| mask[(u, v)] == label))
        };
        (0..12).take_while(|&r| near(r)).count()
    };
    let all = (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| (x, y)));
    let (x, y) = all.max_by_key(|&(x, y)| depth(x, y)).unwrap();
    (x as f32, y as f32)
}

fn dot(t: usize, at: (f32, f32)) -> Stroke {
    Stroke { t, points: vec![at], radius: 4.0 }
}

#[test]
fn every_correction_is_consistent_and_undoing_all_restores_every_pixel() {
    let mut session = segmented();
    let found = (masks(&session), session.clusters().cloned(), session.objects().cloned());
    assert!(session.objects().unwrap().highest_label >= 2);
    let place = inside(&found.0[4], 0);
    let mut stages = vec![found.0.clone()];
    let list = [
        Correction::Merge { into: 1, from: 2 },
        Correction::Split { label: 1, at: None },
        Correction::Split { label: 0, at: Some((4, place.0, place.1)) },
        Correction::JoinStrokes(vec![dot(3, inside(&found.0[3], 1)), dot(3, inside(&found.0[3], 2))]),
        Correction::SplitStrokes(vec![dot(5, inside(&found.0[5], 1)), dot(5, inside(&found.0[5], 2))]),
        Correction::Merge { into: 0, from: 1 },
    ];
    for (k, correction) in list.iter().enumerate() {
        stages.push(corrected(&mut session, correction));
        assert_eq!(session.num_corrections(), k + 1);
        assert_ne!(stages[k + 1], stages[k], "{correction:?} changes nothing");
    }
    for stage in stages.iter().rev().skip(1) {
        session.undo_correction().unwrap();
        assert_eq!(&masks(&session), stage);
    }
    assert_eq!((masks(&session), session.clusters().cloned(), session.objects().cloned()), found);
    assert_eq!(session.undo_correction().unwrap_err().code(), "state");
    let again: Vec<_> = list.iter().map(|correction| corrected(&mut session, correction)).collect();
    assert_eq!(again, stages[1..], "the same list gives the same masks");
}

#[test]
fn strokes_hold_under_their_centre_line_and_labels_not_spoken_of_keep_their_pixels() {
    let mut session = segmented();
    let before = masks(&session);
    let (x, y) = inside(&before[5], 1);
    let line = |dx: f32| Stroke { t: 5, points: vec![(x + dx, y - 6.0), (x + dx, y + 6.0)], radius: 3.0 };
    let after = corrected(&mut session, &Correction::SplitStrokes(vec![line(-6.0), line(6.0)]));
    let under = |mask: &Plane<u8>, dx: f32| -> Vec<u8> {
        let mut found: Vec<u8> =
            (-6..=6).map(|dy| mask[((x + dx) as usize, (y + dy as f32).round() as usize)]).collect();
        found.dedup();
        found
    };
    let (left, right) = (under(&after[5], -6.0), under(&after[5], 6.0));
    assert!(left.len() == 1 && right.len() == 1 && left != right, "{left:?} {right:?}");
    let touched: Vec<u8> =
        left.iter().chain(&right).copied().chain(under(&before[5], -6.0)).chain(under(&before[5], 6.0)).collect();
    for (new, old) in after.iter().flat_map(|m| m.data()).zip(before.iter().flat_map(|m| m.data())) {
        assert!(new == old || (touched.contains(new) && touched.contains(old)), "{old} became {new}");
    }
    // What held is held also through a correction of something else, and follows a merge.
    let other = session.objects().unwrap().labels().into_iter().find(|l| !touched.contains(l)).unwrap();
    corrected(&mut session, &Correction::Split { label: other, at: None });
    assert_eq!((under(&masks(&session)[5], -6.0), under(&masks(&session)[5], 6.0)), (left.clone(), right.clone()));
    let joined =
        corrected(&mut session, &Correction::Merge { into: left[0].min(right[0]), from: left[0].max(right[0]) });
    assert_eq!(under(&joined[5], -6.0), under(&joined[5], 6.0));
}

#[test]
fn together_over_background_brings_it_to_the_object_in_that_frame() {
    let mut session = segmented();
    let before = masks(&session);
    let (from, to) = (inside(&before[2], 1), inside(&before[2], 0));
    let stroke = Stroke { t: 2, points: vec![from, to], radius: 3.0 };
    let after = corrected(&mut session, &Correction::JoinStrokes(vec![stroke]));
    let steps = 50;
    for k in 0..=steps {
        let part = k as f32 / steps as f32;
        let (x, y) = (from.0 + part * (to.0 - from.0), from.1 + part * (to.1 - from.1));
        assert_eq!(after[2][(x.round() as usize, y.round() as usize)], 1, "at {x}, {y}");
    }
}

#[test]
fn stopping_between_steps_changes_nothing_and_what_is_under_way_can_be_undone() {
    let mut session = segmented();
    let before = masks(&session);
    let split = Correction::Split { label: 1, at: None };
    let whole = corrected(&mut session, &split);
    session.undo_correction().unwrap();
    session.correct(&split).unwrap();
    assert!(matches!(session.step().unwrap(), Step::Working(_)));
    assert_eq!(session.correct(&split).unwrap_err().code(), "state");
    assert_eq!(session.labels(FRAMES - 1).unwrap_err().code(), "state");
    session.undo_correction().unwrap();
    assert_eq!(session.step().unwrap(), Step::Done);
    assert_eq!(masks(&session), before);
    assert_eq!(corrected(&mut session, &split), whole);
}

#[test]
fn what_cannot_be_corrected_is_an_error_and_changes_nothing() {
    let mut session = Session::new(Params::default()).unwrap();
    let merge = Correction::Merge { into: 0, from: 1 };
    assert_eq!(session.correct(&merge).unwrap_err().code(), "state");
    for _ in 0..4 {
        session.push_rgba(&[7; 4 * 40 * 30], 40, 30).unwrap();
    }
    session.run().unwrap();
    // A still clip has masks, and no objects.
    let nowhere = Correction::Split { label: 0, at: Some((0, 3.0, 3.0)) };
    assert_eq!(session.correct(&nowhere).unwrap_err().code(), "data");
    assert_eq!(session.correct(&merge).unwrap_err().code(), "param");
    let strokes = vec![dot(0, (3.0, 3.0)), dot(0, (9.0, 9.0))];
    assert_eq!(session.correct(&Correction::SplitStrokes(strokes.clone())).unwrap_err().code(), "data");
    assert_eq!(session.correct(&Correction::JoinStrokes(strokes)).unwrap_err().code(), "data");
    assert_eq!(session.num_corrections(), 0);

    let mut session = segmented();
    let before = masks(&session);
    let at = |t, x, y| Correction::Split { label: 1, at: Some((t, x, y)) };
    let good = dot(0, (3.0, 3.0));
    let wrong = [
        Correction::Merge { into: 1, from: 0 },
        Correction::Merge { into: 1, from: 1 },
        Correction::Merge { into: 200, from: 1 },
        Correction::Split { label: 0, at: None },
        Correction::Split { label: 99, at: None },
        at(FRAMES, 1.0, 1.0),
        at(0, f32::NAN, 1.0),
        at(0, 1.0, 1e9),
        Correction::JoinStrokes(Vec::new()),
        Correction::SplitStrokes(vec![good.clone()]),
        Correction::SplitStrokes(vec![good.clone(); 256]),
        Correction::JoinStrokes(vec![Stroke { t: FRAMES, ..good.clone() }]),
        Correction::SplitStrokes(vec![good.clone(), Stroke { points: vec![(f32::NAN, 0.0)], ..good.clone() }]),
        Correction::SplitStrokes(vec![good, dot(0, (-50.0, -50.0))]),
    ];
    for correction in &wrong {
        let error = session.correct(correction).unwrap_err();
        assert!(matches!(error, Error::Param { .. }), "{correction:?}: {error}");
    }
    assert_eq!((session.num_corrections(), masks(&session)), (0, before));
}

/// Intersection over union of what has a label in the truth and what has another in the masks, over all frames.
fn overlap(truth: &[Plane<u8>], of_truth: u8, found: &[Plane<u8>], of_found: u8) -> f64 {
    let pixels = || truth.iter().flat_map(|m| m.data()).zip(found.iter().flat_map(|m| m.data()));
    let both = pixels().filter(|&(&t, &f)| t == of_truth && f == of_found).count();
    let any = pixels().filter(|&(&t, &f)| t == of_truth || f == of_found).count();
    both as f64 / any.max(1) as f64
}

#[test]
fn two_strokes_in_one_frame_part_players_who_move_alike_in_all_frames() {
    let scene = Scene::entangled((288, 192), 24, 3);
    let mut params = Params::default();
    params.connectedness.mode = crate::connectedness::ConnectednessMode::Off;
    // With as many trajectories as a large frame has, motion alone tells the players apart.
    params.clip.reference_side = 0;
    let mut session = Session::new(params).unwrap();
    for t in 0..24 {
        session.push_frame(scene.frame(t)).unwrap();
    }
    session.run().unwrap();
    let truth: Vec<_> = (0..24).map(|t| scene.mask(t)).collect();
    let found = |session: &Session| -> Vec<Plane<u8>> { (0..24).map(|t| session.labels(t).unwrap()).collect() };
    let best = |masks: &[Plane<u8>], player| {
        (1..=9).map(|l| (overlap(&truth, player, masks, l), l)).max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    };
    assert_eq!(session.objects().unwrap().highest_label, 1, "motion alone takes both for one");
    let strokes = [1, 2].map(|player| {
        let (x, y) = inside(&truth[20], player);
        Stroke { t: 20, points: vec![(x, y - 8.0), (x, y + 8.0)], radius: 4.0 }
    });
    session.correct(&Correction::SplitStrokes(strokes.to_vec())).unwrap();
    session.run().unwrap();
    let after = found(&session);
    let (left, right) = (best(&after, 1), best(&after, 2));
    assert!(left.1 != right.1 && left.0 > 0.75 && right.0 > 0.85, "{left:?} {right:?}");
}

#[test]
fn penalties_stay_with_their_trajectories_when_clusters_are_recomputed() {
    let mut session = segmented();
    fn outputs(session: &mut Session) -> &mut Outputs {
        let Phase::Running(run) = &mut session.phase else { panic!("the run has not begun") };
        &mut run.outputs
    }
    fn current_penalties(session: &mut Session, is_sure: bool) -> Vec<f32> {
        let Outputs { clusters, penalties, .. } = outputs(session);
        cluster_penalties(clusters, penalties, |_| is_sure)
    }
    let of_cluster = session.objects().unwrap().of_cluster.clone();
    let penalty = |l: &u32| f32::from(u8::from(of_cluster[*l as usize] == 2));
    let penalties = session.clusters().unwrap().label.iter().map(penalty).collect();
    outputs(&mut session).penalties = penalties;
    corrected(&mut session, &Correction::Split { label: 1, at: None });
    let of_cluster = session.objects().unwrap().of_cluster.clone();
    let expected: Vec<f32> = of_cluster.iter().map(|&label| f32::from(u8::from(label == 2))).collect();
    assert!(expected.contains(&1.0));
    assert_eq!(current_penalties(&mut session, false), expected);
    assert_eq!(current_penalties(&mut session, true), vec![0.0; of_cluster.len()]);
    session.undo_correction().unwrap();
    assert!(current_penalties(&mut session, false).contains(&1.0));
}
