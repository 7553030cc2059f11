//! Corrections: what a session does with them, and how they are undone.
//!
//! A correction decides at once which label each trajectory has; clusters follow. Merging renames masks too, and that
//! is all. After the others the cut and the masks are made anew, step by step, where labels are concerned that the
//! correction speaks of (`recut`). What was before each correction is kept, masks as runs, so that undoing takes no
//! computing.

use crate::Error;
use crate::correction::{
    Correction, Held, Painted, Stroke, apart, cores, distinct, free_labels, halves, near_affinities, part_at, together,
    under_strokes,
};
use crate::session::base::Outputs;
use crate::session::run::{Clip, Phase, Run, Session, State, Wanted, objects_with};
use crate::trajectory::Trajectories;

/// Most strokes of a correction.
const MOST_STROKES: usize = 255;

impl Session {
    /// Number of corrections in force.
    pub fn num_corrections(&self) -> usize {
        self.begun().map_or(0, |run| run.outputs.corrections.count())
    }

    /// Applies a correction to finished masks. After a merge everything can be read at once; after the others
    /// [`Session::step`] goes on, with the cut, until it returns [`crate::Step::Done`] again.
    ///
    /// Law: the labels that the correction does not speak of have the same pixels as before; clusters and
    /// [`of_cluster`](crate::mask::Objects::of_cluster) agree with the masks as ever; the same corrections in the same
    /// order give the same masks. Objects keep their numbers, so that these may have gaps; a new one takes the lowest
    /// that is free.
    ///
    /// # Errors
    /// [`Error::State`] unless the session is done and has masks; [`Error::Param`] for labels, frames and places that
    /// do not exist; [`Error::Data`] where there is nothing to split. Nothing changes after an error.
    pub fn correct(&mut self, correction: &Correction) -> Result<(), Error> {
        let run = self.finished()?;
        let ground = Ground { clip: &run.clip, outputs: &run.outputs };
        let wanted = match correction {
            Correction::Merge { into, from } => return merge(&mut run.outputs, *into, *from),
            Correction::Split { label, at } => ground.split(*label, *at)?,
            Correction::Together(strokes) => ground.strokes(strokes, 1)?,
            Correction::Apart(strokes) => ground.strokes(strokes, 2)?,
        };
        run.cut_again(wanted);
        Ok(())
    }

    /// Takes the last correction back: everything is again as it was before, also while its masks are still being made.
    ///
    /// # Errors
    /// [`Error::State`] without a correction in force.
    pub fn undo_correction(&mut self) -> Result<(), Error> {
        let is_undone = if let Phase::Begun(run) = &mut self.phase { run.undo_correction() } else { false };
        if is_undone { Ok(()) } else { Err(Error::state("there is no correction to undo")) }
    }

    /// What can be corrected.
    fn finished(&mut self) -> Result<&mut Run, Error> {
        match &mut self.phase {
            Phase::Begun(run) if matches!(run.state, State::Done) && run.outputs.masks.is_empty() => Err(Error::state(
                "corrections need masks (frames, not trajectories from outside, and clip.dense = true)",
            )),
            Phase::Begun(run) if matches!(run.state, State::Done) => Ok(run),
            _ => Err(Error::state(
                "a correction was made before the run was finished: run the session first, or undo the last correction",
            )),
        }
    }
}

/// Renames `from`, in clusters, masks and under strokes.
fn merge(outputs: &mut Outputs, into: u8, from: u8) -> Result<(), Error> {
    require_label(outputs, "into", into)?;
    require_label(outputs, "from", from)?;
    if from == 0 {
        return Err(param("from", "0", "an object: the background cannot be merged into one"));
    }
    if into == from {
        return Err(param("from", &from.to_string(), "another label than into"));
    }
    outputs.remember();
    let rename = |l: &mut u8| *l = if *l == from { into } else { *l };
    let mut of_cluster = std::mem::take(&mut outputs.cut.objects.of_cluster);
    of_cluster.iter_mut().for_each(rename);
    outputs.cut.objects = objects_with(of_cluster);
    outputs.cut.sureness.take();
    outputs.masks.iter_mut().for_each(|mask| mask.data_mut().iter_mut().for_each(rename));
    outputs.corrections.held.iter_mut().for_each(|held| rename(&mut held.label));
    Ok(())
}

/// Checks that something has this label, or that it is the background's.
fn require_label(outputs: &Outputs, name: &str, label: u8) -> Result<(), Error> {
    let known = &outputs.cut.objects.of_cluster;
    if label == 0 || known.contains(&label) {
        return Ok(());
    }
    let mut list = String::from("0");
    for l in distinct(known).into_iter().filter(|l| *l > 0) {
        list.push_str(&format!(", {l}"));
    }
    Err(param(name, &label.to_string(), &format!("one of the labels in use: {list}")))
}

/// What a correction is decided on.
#[derive(Clone, Copy)]
struct Ground<'a> {
    clip: &'a Clip,
    outputs: &'a Outputs,
}

impl Ground<'_> {
    fn split(&self, label: u8, at: Option<(usize, f32, f32)>) -> Result<Wanted, Error> {
        require_label(self.outputs, "label", label)?;
        if label == 0 && at.is_none() {
            return Err(param("label", "0", "an object, or a point: {t, x, y} of what is no background"));
        }
        let (tracks, clusters) = (&self.outputs.tracked.tracks, &self.outputs.clusters);
        let mut labels = self.trajectory_labels();
        let members: Vec<u32> = (0..labels.len() as u32).filter(|&i| labels[i as usize] == label).collect();
        let at = at.map(|(t, x, y)| self.member_at(&members, label, t, (x, y))).transpose()?;
        let mut free = free_labels(&self.outputs.cut.objects.of_cluster);
        let Some(new) = free.next() else {
            return Err(Error::Data { reason: "all 255 labels are in use: merge some first".to_owned() });
        };
        let (params, affinities) = (&self.clip.params, &self.outputs.affinities);
        let seed = params.clip.seed;
        let graph = |members: &[u32]| near_affinities(affinities, tracks, members, params.spacing());
        let cluster = |i: &u32| clusters.label[*i as usize];
        let part: Vec<u32> = match (label, at) {
            (0, Some(at)) => {
                // The largest cluster of the background is what everything else stands before.
                let main = members.iter().map(cluster).min();
                let own = cluster(&members[at]);
                let of_own: Vec<u32> = members.iter().copied().filter(|i| cluster(i) == own).collect();
                if Some(own) != main {
                    of_own
                } else {
                    let place = of_own.iter().position(|&i| i == members[at]).unwrap_or(0);
                    let part = part_at(&graph(&of_own), place, seed).ok_or_else(|| nothing_to_split(label))?;
                    of_own.iter().zip(part).filter(|(_, inside)| *inside).map(|(&i, _)| i).collect()
                }
            }
            _ => {
                let groups: Vec<u32> = members.iter().map(cluster).collect();
                let several = groups.iter().any(|g| g != &groups[0]);
                let half = halves(&graph(&members), several.then_some(&groups), seed)
                    .ok_or_else(|| nothing_to_split(label))?;
                let chosen = at.map_or_else(|| fewer_points(tracks, &members, &half), |at| half[at]);
                members.iter().zip(half).filter(|(_, half)| *half == chosen).map(|(&i, _)| i).collect()
            }
        };
        part.iter().for_each(|&i| labels[i as usize] = new);
        let held = self.held_under(&labels, &[label]);
        Ok(Wanted { label: labels, concerned: vec![label, new], held })
    }

    /// What strokes want: as one thing, or where at least two are asked for, as one each.
    fn strokes(&self, strokes: &[Stroke], least: usize) -> Result<Wanted, Error> {
        if !(least..=MOST_STROKES).contains(&strokes.len()) {
            let expected = format!("{least}..={MOST_STROKES} of them");
            return Err(param("strokes", &format!("{} strokes", strokes.len()), &expected));
        }
        let (scale, spacing) = (self.clip.scale, self.clip.params.spacing());
        for (k, stroke) in strokes.iter().enumerate() {
            stroke.check(&format!("strokes[{k}]"), self.clip.frames.len(), scale.input)?;
        }
        let labels = self.trajectory_labels();
        let reach = f64::from(spacing) * scale.x().max(scale.y());
        let under = under_strokes(&self.outputs.tracked.input, strokes, reach);
        let cores = cores(strokes, scale.input, scale.working);
        let over = |(core, stroke): (&Vec<u32>, &Stroke)| -> Vec<u8> {
            core.iter().map(|&p| self.outputs.masks[stroke.t].data()[p as usize]).collect()
        };
        let over: Vec<Vec<u8>> = cores.iter().zip(strokes).map(over).collect();
        let mut settled = vec![false; labels.len()];
        for held in &self.outputs.corrections.held {
            held.tracks.iter().for_each(|&i| settled[i as usize] |= labels[i as usize] == held.label);
        }
        let painted = Painted {
            tracks: &self.outputs.tracked.tracks,
            spacing,
            affinities: &self.outputs.affinities,
            label: &labels,
            used: &self.outputs.cut.objects.of_cluster,
            settled: &settled,
            under: &under,
            over: &over,
        };
        let decision = if least == 1 { together(&painted)? } else { apart(&painted)? };
        let mut held = self.held_under(&decision.label, &decision.concerned);
        for (k, (stroke, pixels)) in strokes.iter().zip(cores).enumerate() {
            for older in held.iter_mut().filter(|h| h.t == stroke.t) {
                older.pixels.retain(|p| pixels.binary_search(p).is_err());
            }
            let of_stroke = (0..).zip(&under).filter(|(_, u)| u.is_some_and(|u| usize::from(u) == k));
            let tracks = of_stroke.map(|(i, _)| i).collect();
            held.push(Held { t: stroke.t, pixels, tracks, label: decision.of_stroke[k] });
        }
        Ok(Wanted { label: decision.label, concerned: decision.concerned, held })
    }

    /// What earlier strokes hold when trajectories have these labels. Where that was one of the labels concerned, it is
    /// what all trajectories under the stroke have now; if they do not agree, nothing.
    fn held_under(&self, labels: &[u8], concerned: &[u8]) -> Vec<Held> {
        let renewed = |held: &Held| {
            let mut now = held.tracks.iter().map(|&i| labels[i as usize]);
            let label = match now.next() {
                _ if !concerned.contains(&held.label) => Some(held.label),
                Some(first) => now.all(|l| l == first).then_some(first),
                None => labels.contains(&held.label).then_some(held.label),
            };
            label.map(|label| Held { label, ..held.clone() })
        };
        self.outputs.corrections.held.iter().filter_map(renewed).collect()
    }

    /// The mask label of each trajectory.
    fn trajectory_labels(&self) -> Vec<u8> {
        self.outputs.clusters.label.iter().map(|&cluster| self.outputs.label_of(cluster)).collect()
    }

    /// Place in `members` of the trajectory nearest to a point of frame `t`, in input pixels.
    fn member_at(&self, members: &[u32], label: u8, t: usize, (x, y): (f32, f32)) -> Result<usize, Error> {
        self.require_place(t, (x, y))?;
        let tracks = &self.outputs.tracked.input;
        let distance = |i: u32| tracks.at(i as usize, t).map(|(px, py)| (px - x).powi(2) + (py - y).powi(2));
        let near = members.iter().enumerate().filter_map(|(k, &i)| distance(i).map(|d| (d, k)));
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| k).ok_or_else(|| Error::Data {
            reason: format!("label {label} has no trajectories in frame {t}: choose a point in another frame"),
        })
    }

    fn require_place(&self, t: usize, (x, y): (f32, f32)) -> Result<(), Error> {
        let frames = self.clip.frames.len();
        if t >= frames {
            return Err(param("t", &t.to_string(), &format!("a frame, 0..{frames}")));
        }
        let (width, height) = self.clip.scale.input;
        for (name, value, side) in [("x", x, width), ("y", y, height)] {
            // Pixel centres are at whole numbers.
            if !(value >= -0.5 && value <= side as f32 - 0.5) {
                let expected = format!("a place in the frame, -0.5..={}", side as f64 - 0.5);
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

/// The half that holds fewer points of trajectories; the second of equal ones.
fn fewer_points(tracks: &Trajectories, members: &[u32], half: &[bool]) -> bool {
    let points = |side: bool| -> usize {
        let of_side = members.iter().zip(half).filter(|(_, h)| **h == side);
        of_side.map(|(&i, _)| tracks.points(i as usize).len()).sum()
    };
    points(true) <= points(false)
}
