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
