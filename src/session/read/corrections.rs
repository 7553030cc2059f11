//! Corrections of finished masks, and undoing them.
//!
//! A correction relabels trajectories and regroups clusters at once. Merging also renames masks, and is done. After the other
//! corrections the cut and the masks of affected labels are computed again, step by step (`recut`). A snapshot from before each
//! correction, with run-length coded masks, makes undoing immediate.

use crate::Error;
use crate::correction::{
    Correction, NO_FREE_LABEL, Stroke, StrokeConstraint, StrokeInput, bisect, core_pixels, distinct, free_labels,
    join_strokes, part_containing, proximity_graph, split_strokes, strokes_over_tracks,
};
use crate::session::base::Outputs;
use crate::session::run::{Clip, Phase, Run, Session, State, TargetLabels, objects_from_labels};
use crate::trajectory::Trajectories;

/// Largest number of strokes of a correction: one for each label.
const MAX_STROKES: usize = 255;

impl Session {
    /// Returns the number of corrections in force.
    #[doc(hidden)] // For the Python package.
    pub fn num_corrections(&self) -> usize {
        self.running().map_or(0, |run| run.outputs.corrections.count())
    }

    /// Applies a correction to finished masks. After a merge all results can be read at once; after the other corrections
    /// [`Session::step`] continues with the cut until it returns [`crate::Step::Done`] again.
    ///
    /// Invariants: labels that the correction does not affect keep their pixels; clusters and
    /// [`of_cluster`](crate::mask::Objects::of_cluster) agree with the masks; the same corrections in the same order give the
    /// same masks. Objects keep their numbers, which may leave gaps; a new object takes the lowest free number.
    ///
    /// # Errors
    /// [`Error::State`] unless the session is done and has masks; [`Error::Param`] for labels, frames and positions that do
    /// not exist; [`Error::Data`] if there is nothing to split. Nothing changes then.
    pub fn correct(&mut self, correction: &Correction) -> Result<(), Error> {
        let run = self.finished()?;
        let input = CorrectionInput { clip: &run.clip, outputs: &run.outputs };
        let target = match correction {
            Correction::Merge { into, from } => return merge(&mut run.outputs, *into, *from),
            Correction::Split { label, at } => input.split(*label, *at)?,
            Correction::JoinStrokes(strokes) => input.strokes(strokes, 1)?,
            Correction::SplitStrokes(strokes) => input.strokes(strokes, 2)?,
        };
        run.cut_again(target);
        Ok(())
    }

    /// Undoes the last correction, also while its masks are still being made.
    ///
    /// # Errors
    /// [`Error::State`] without a correction in force.
    pub fn undo_correction(&mut self) -> Result<(), Error> {
        let is_undone = if let Phase::Running(run) = &mut self.phase { run.undo_correction() } else { false };
        if is_undone { Ok(()) } else { Err(Error::state("there is no correction to undo")) }
    }

    /// Returns the run if it can be corrected.
    fn finished(&mut self) -> Result<&mut Run, Error> {
        match &mut self.phase {
            Phase::Running(run) if matches!(run.state, State::Done) && run.outputs.masks.is_empty() => {
                Err(Error::state("corrections need masks: push frames, and set clip.dense = true"))
            }
            Phase::Running(run) if matches!(run.state, State::Done) => Ok(run),
            _ => Err(Error::state(
                "a correction was made before the run had finished: run the session first, or undo the last correction",
            )),
        }
    }
}

/// Renames label `from` in clusters, masks and strokes.
fn merge(outputs: &mut Outputs, into: u8, from: u8) -> Result<(), Error> {
    require_label(outputs, "into", into)?;
    require_label(outputs, "from", from)?;
    if from == 0 {
        return Err(param("from", "0", "an object, 1..=255: the background cannot be merged into an object"));
    }
    if into == from {
        return Err(param("from", &from.to_string(), "a label that differs from into"));
    }
    outputs.push_snapshot();
    let rename = |l: &mut u8| *l = if *l == from { into } else { *l };
    let mut of_cluster = std::mem::take(&mut outputs.cut.objects.of_cluster);
    of_cluster.iter_mut().for_each(rename);
    outputs.cut.objects = objects_from_labels(of_cluster);
    outputs.cut.agreement.take();
    outputs.masks.iter_mut().for_each(|mask| mask.data_mut().iter_mut().for_each(rename));
    outputs.corrections.constraints.iter_mut().for_each(|constraint| rename(&mut constraint.label));
    Ok(())
}

/// Checks that a label is in use or 0, the background.
fn require_label(outputs: &Outputs, name: &str, label: u8) -> Result<(), Error> {
    let labels = &outputs.cut.objects.of_cluster;
    if label == 0 || labels.contains(&label) {
        return Ok(());
    }
    let mut list = String::from("0");
    for l in distinct(labels).into_iter().filter(|l| *l > 0) {
        list.push_str(&format!(", {l}"));
    }
    Err(param(name, &label.to_string(), &format!("one of the labels in use: {list}")))
}

/// The clip and the outputs before a correction.
#[derive(Clone, Copy)]
struct CorrectionInput<'a> {
    clip: &'a Clip,
    outputs: &'a Outputs,
}

impl CorrectionInput<'_> {
    fn split(&self, label: u8, at: Option<(usize, f32, f32)>) -> Result<TargetLabels, Error> {
        require_label(self.outputs, "label", label)?;
        if label == 0 && at.is_none() {
            return Err(param("label", "0", "an object, or 0 with a point {t, x, y} on what is no background"));
        }
        let (tracks, clusters) = (&self.outputs.track_set.tracks, &self.outputs.clusters);
        let mut labels = self.trajectory_labels();
        let members: Vec<u32> = (0..labels.len() as u32).filter(|&i| labels[i as usize] == label).collect();
        let at = at.map(|(t, x, y)| self.member_at(&members, label, t, x, y)).transpose()?;
        let mut free = free_labels(&self.outputs.cut.objects.of_cluster);
        let Some(new) = free.next() else {
            return Err(Error::Data { reason: NO_FREE_LABEL.to_owned() });
        };
        let (params, affinities) = (&self.clip.params, &self.outputs.affinities);
        let seed = params.clip.seed;
        let graph = |members: &[u32]| proximity_graph(affinities, tracks, members, params.spacing());
        let cluster = |i: &u32| clusters.label[*i as usize];
        let part: Vec<u32> = match (label, at) {
            (0, Some(at)) => {
                // The largest cluster of the background is the scene.
                let scene = members.iter().map(cluster).min();
                let clicked = cluster(&members[at]);
                let in_cluster: Vec<u32> = members.iter().copied().filter(|i| cluster(i) == clicked).collect();
                if Some(clicked) != scene {
                    in_cluster
                } else {
                    let node = in_cluster.iter().position(|&i| i == members[at]).unwrap_or(0);
                    let part =
                        part_containing(&graph(&in_cluster), node, seed).ok_or_else(|| nothing_to_split(label))?;
                    in_cluster.iter().zip(part).filter(|(_, is_inside)| *is_inside).map(|(&i, _)| i).collect()
                }
            }
            _ => {
                let groups: Vec<u32> = members.iter().map(cluster).collect();
                let has_groups = groups.iter().any(|g| g != &groups[0]);
                let half = bisect(&graph(&members), has_groups.then_some(&groups), seed)
                    .ok_or_else(|| nothing_to_split(label))?;
                let new_half = at.map_or_else(|| smaller_half(tracks, &members, &half), |at| half[at]);
                members.iter().zip(half).filter(|(_, half)| *half == new_half).map(|(&i, _)| i).collect()
            }
        };
        part.iter().for_each(|&i| labels[i as usize] = new);
        let constraints = self.renew_constraints(&labels, &[label]);
        Ok(TargetLabels { labels, affected: vec![label, new], constraints })
    }

    /// Joins strokes if one is enough, or splits them if at least two are needed.
    fn strokes(&self, strokes: &[Stroke], min_strokes: usize) -> Result<TargetLabels, Error> {
        if !(min_strokes..=MAX_STROKES).contains(&strokes.len()) {
            let expected = format!("{min_strokes}..={MAX_STROKES} of them");
            return Err(param("strokes", &format!("{} strokes", strokes.len()), &expected));
        }
        let (scale, spacing) = (self.clip.scale, self.clip.params.spacing());
        for (k, stroke) in strokes.iter().enumerate() {
            stroke.check(&format!("strokes[{k}]"), self.clip.frames.len(), scale.input)?;
        }
        let labels = self.trajectory_labels();
        let reach = f64::from(spacing) * scale.x().max(scale.y());
        let stroke_of_track = strokes_over_tracks(&self.outputs.track_set.input, strokes, reach);
        let cores = core_pixels(strokes, scale.input, scale.working);
        let labels_in_core = |(core, stroke): (&Vec<u32>, &Stroke)| -> Vec<u8> {
            core.iter().map(|&p| self.outputs.masks[stroke.t].data()[p as usize]).collect()
        };
        let core_labels: Vec<Vec<u8>> = cores.iter().zip(strokes).map(labels_in_core).collect();
        let mut is_fixed = vec![false; labels.len()];
        for constraint in &self.outputs.corrections.constraints {
            constraint.tracks.iter().for_each(|&i| is_fixed[i as usize] |= labels[i as usize] == constraint.label);
        }
        let input = StrokeInput {
            tracks: &self.outputs.track_set.tracks,
            spacing,
            affinities: &self.outputs.affinities,
            label: &labels,
            used_labels: &self.outputs.cut.objects.of_cluster,
            is_fixed: &is_fixed,
            stroke: &stroke_of_track,
            core_labels: &core_labels,
        };
        let decision = if min_strokes == 1 { join_strokes(&input)? } else { split_strokes(&input)? };
        let mut constraints = self.renew_constraints(&decision.label, &decision.affected);
        for (k, (stroke, pixels)) in strokes.iter().zip(cores).enumerate() {
            for older in constraints.iter_mut().filter(|constraint| constraint.t == stroke.t) {
                older.pixels.retain(|p| pixels.binary_search(p).is_err());
            }
            let in_stroke = (0..).zip(&stroke_of_track).filter(|(_, s)| s.is_some_and(|s| usize::from(s) == k));
            let tracks = in_stroke.map(|(i, _)| i).collect();
            constraints.push(StrokeConstraint { t: stroke.t, pixels, tracks, label: decision.stroke_labels[k] });
        }
        Ok(TargetLabels { labels: decision.label, affected: decision.affected, constraints })
    }

    /// Returns the constraints of earlier strokes for new labels of the trajectories. A constraint to an affected label takes the
    /// new label of the trajectories under the stroke; if they differ, it is dropped.
    fn renew_constraints(&self, labels: &[u8], affected: &[u8]) -> Vec<StrokeConstraint> {
        let renew = |constraint: &StrokeConstraint| {
            let mut new_labels = constraint.tracks.iter().map(|&i| labels[i as usize]);
            let label = match new_labels.next() {
                _ if !affected.contains(&constraint.label) => Some(constraint.label),
                Some(first) => new_labels.all(|l| l == first).then_some(first),
                None => labels.contains(&constraint.label).then_some(constraint.label),
            };
            label.map(|label| StrokeConstraint { label, ..constraint.clone() })
        };
        self.outputs.corrections.constraints.iter().filter_map(renew).collect()
    }

    /// Returns the mask label of each trajectory.
    fn trajectory_labels(&self) -> Vec<u8> {
        self.outputs.clusters.label.iter().map(|&cluster| self.outputs.mask_label(cluster)).collect()
    }

    /// Returns the index in `members` of the trajectory nearest to a point of frame `t`, in input pixels.
    fn member_at(&self, members: &[u32], label: u8, t: usize, x: f32, y: f32) -> Result<usize, Error> {
        self.require_position(t, x, y)?;
        let tracks = &self.outputs.track_set.input;
        let distance = |i: u32| tracks.at(i as usize, t).map(|(px, py)| (px - x).powi(2) + (py - y).powi(2));
        let distances = members.iter().enumerate().filter_map(|(k, &i)| distance(i).map(|d| (d, k)));
        distances.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| k).ok_or_else(|| Error::Data {
            reason: format!("label {label} has no trajectories in frame {t}: choose a point in another frame"),
        })
    }

    fn require_position(&self, t: usize, x: f32, y: f32) -> Result<(), Error> {
        let frames = self.clip.frames.len();
        if t >= frames {
            return Err(param("t", &t.to_string(), &format!("a frame, 0..{frames}")));
        }
        let (width, height) = self.clip.scale.input;
        for (name, value, side) in [("x", x, width), ("y", y, height)] {
            if !(value >= -0.5 && value <= side as f32 - 0.5) {
                let expected = format!("a position in the frame, -0.5..={}", side as f64 - 0.5);
                return Err(param(name, &f64::from(value).to_string(), &expected));
            }
        }
        Ok(())
    }
}

fn param(name: &str, value: &str, expected: &str) -> Error {
    Error::Param { name: name.to_owned(), value: value.to_owned(), expected: expected.to_owned() }
}

fn nothing_to_split(label: u8) -> Error {
    Error::Data { reason: format!("label {label} has too few trajectories to be split (expected at least 6)") }
}

/// Returns the half with fewer points of trajectories, the second of equal ones.
fn smaller_half(tracks: &Trajectories, members: &[u32], half: &[bool]) -> bool {
    let num_points = |side: bool| -> usize {
        let on_side = members.iter().zip(half).filter(|(_, h)| **h == side);
        on_side.map(|(&i, _)| tracks.points(i as usize).len()).sum()
    };
    num_points(true) <= num_points(false)
}

#[cfg(test)]
mod tests {
    use crate::Session;
    use crate::classify::cluster_penalties;
    use crate::correction::{Correction, Stroke};
    use crate::image::Plane;
    use crate::mask::{Agreement, agreement};
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
        let found = session.agreement().unwrap();
        let expected_j = found.expected_j.clone();
        assert_eq!(*found, Agreement { expected_j, ..agreement(&masks, &session.clip().unwrap().flows) });
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
}
