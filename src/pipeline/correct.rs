//! Corrections: what a session does with them, and how they are undone.
//!
//! A correction decides at once which label each trajectory has; clusters follow. Merging renames masks too, and that is all. After the
//! others the cut and the masks are made anew, step by step, where labels are concerned that the correction speaks of (`recut`). What was
//! before each correction is kept, masks as runs, so that undoing takes no computing.

use super::recut::{Before, Recut};
use super::session::{Session, State, state_error};
use crate::Error;
use crate::correction::{Correction, Held, Runs, halves, near_affinities, part_at, regroup};
use crate::cut::{CutLabels, Objects};
use crate::discretize::Clusters;
use crate::trajectory::Trajectories;

/// The corrections in force.
#[derive(Debug, Default)]
pub(super) struct Corrections {
    /// What was before each of them, the first correction first.
    before: Vec<Snapshot>,
    /// What strokes hold.
    held: Vec<Held>,
}

#[derive(Debug)]
struct Snapshot {
    clusters: Clusters,
    objects: Objects,
    cut: CutLabels,
    masks: Vec<Runs>,
    held: Vec<Held>,
}

/// What a correction wants of the trajectories.
struct Wanted {
    /// The mask label of each.
    label: Vec<u8>,
    /// Which labels are concerned.
    open: Vec<bool>,
}

impl Session {
    /// Number of corrections in force.
    pub fn num_corrections(&self) -> usize {
        self.corrections.before.len()
    }

    /// Applies a correction to finished masks. After a merge everything can be read at once; after the others [`Session::step`] goes on,
    /// with the cut, until it returns [`crate::Step::Done`] again.
    ///
    /// Law: the labels that the correction does not speak of have the same pixels as before; clusters and [`Objects::of_cluster`] agree
    /// with the masks as ever; the same corrections in the same order give the same masks. Objects keep their numbers, so that
    /// these may have gaps; a new one takes the lowest that is free.
    ///
    /// # Errors
    /// [`Error::State`] unless the session is done and has masks; [`Error::Param`] for labels, frames and places that do not exist;
    /// [`Error::Data`] where there is nothing to split. Nothing changes after an error.
    pub fn correct(&mut self, correction: &Correction) -> Result<(), Error> {
        if !matches!(self.state, State::Done) {
            return Err(state_error(
                "a correction was made before the run was finished: run the session first, or undo the last correction",
            ));
        }
        if self.dense.masks.is_empty() {
            return Err(state_error(
                "corrections need masks (frames, not trajectories from outside, and clip.dense = true)",
            ));
        }
        match correction {
            Correction::Merge { into, from } => self.merge(*into, *from),
            Correction::Split { label, at } => {
                let wanted = self.split(*label, *at)?;
                self.recut(wanted);
                Ok(())
            }
        }
    }

    /// Takes the last correction back: everything is again as it was before, also while its masks are still being made.
    ///
    /// # Errors
    /// [`Error::State`] without a correction in force.
    pub fn undo_correction(&mut self) -> Result<(), Error> {
        let Some(before) = self.corrections.before.pop() else {
            return Err(state_error("there is no correction to undo"));
        };
        self.clusters = Some(before.clusters);
        self.corrections.held = before.held;
        self.dense.restore(before.cut, before.objects, before.masks.iter().map(Runs::mask).collect());
        self.state = State::Done;
        Ok(())
    }

    /// What is found now, to be restored later.
    fn snapshot(&self) -> Snapshot {
        Snapshot {
            clusters: self.clusters.clone().unwrap_or_default(),
            objects: self.dense.objects.clone(),
            cut: self.dense.cut.clone(),
            masks: self.dense.masks.iter().map(Runs::of).collect(),
            held: self.corrections.held.clone(),
        }
    }

    fn merge(&mut self, into: u8, from: u8) -> Result<(), Error> {
        self.require_label("into", into)?;
        self.require_label("from", from)?;
        if from == 0 {
            return Err(param("from", "0", "an object: the background cannot be merged into one"));
        }
        if into == from {
            return Err(param("from", &from.to_string(), "another label than into"));
        }
        self.corrections.before.push(self.snapshot());
        let rename = |l: &mut u8| *l = if *l == from { into } else { *l };
        self.dense.objects.of_cluster.iter_mut().for_each(rename);
        self.dense.objects.count = highest(&self.dense.objects.of_cluster);
        self.dense.masks.iter_mut().for_each(|mask| mask.data_mut().iter_mut().for_each(rename));
        self.corrections.held.iter_mut().for_each(|held| rename(&mut held.label));
        Ok(())
    }

    fn split(&self, label: u8, at: Option<(usize, f32, f32)>) -> Result<Wanted, Error> {
        self.require_label("label", label)?;
        if label == 0 && at.is_none() {
            return Err(param("label", "0", "an object, or a point: {t, x, y} of what is no background"));
        }
        let (tracks, clusters) = self.clustered()?;
        let mut labels = self.trajectory_labels();
        let members: Vec<u32> = (0..labels.len() as u32).filter(|&i| labels[i as usize] == label).collect();
        let at = at.map(|(t, x, y)| self.member_at(&members, label, t, (x, y))).transpose()?;
        let new = free_label(&self.dense.objects)?;
        let affinities = self.affinities.as_ref().ok_or_else(|| state_error("there are no affinities"))?;
        let seed = self.params.clip.seed;
        let graph = |members: &[u32]| near_affinities(affinities, tracks, members, self.spacing);
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
        Ok(Wanted { label: labels, open: opened([label, new]) })
    }

    /// Clusters by the wanted labels; then the cut begins anew where these are concerned.
    fn recut(&mut self, wanted: Wanted) {
        let before = self.snapshot();
        let Some(tracks) = &self.working else { return };
        let found = regroup(tracks, &before.clusters, &before.objects.of_cluster, &wanted.label);
        self.corrections.before.push(before);
        self.clusters = Some(found.clusters);
        let objects = Objects { count: highest(&found.of_cluster), of_cluster: found.of_cluster };
        let held = self.corrections.held.clone();
        self.dense.begin_again(objects, |before: Before| Recut::new(before, &found.heir, wanted.open, held));
        self.state = State::Dense;
    }

    fn clustered(&self) -> Result<(&Trajectories, &Clusters), Error> {
        match (&self.working, &self.clusters) {
            (Some(tracks), Some(clusters)) => Ok((tracks, clusters)),
            _ => Err(state_error("there are no clusters to correct")),
        }
    }

    /// The mask label of each trajectory.
    fn trajectory_labels(&self) -> Vec<u8> {
        let of_cluster = &self.dense.objects.of_cluster;
        let clusters = self.clusters.as_ref().map_or(&[][..], |c| &c.label);
        clusters.iter().map(|&c| of_cluster.get(c as usize).copied().unwrap_or(0)).collect()
    }

    fn require_label(&self, name: &str, label: u8) -> Result<(), Error> {
        let known = &self.dense.objects.of_cluster;
        if label == 0 || known.contains(&label) {
            return Ok(());
        }
        let mut list: Vec<u8> = known.clone();
        list.push(0);
        crate::order::sort_by_key(&mut list, |&l| l.into());
        list.dedup();
        let list: Vec<String> = list.iter().map(u8::to_string).collect();
        Err(param(name, &label.to_string(), &format!("one of the labels in use: {}", list.join(", "))))
    }

    /// Place in `members` of the trajectory nearest to a point of frame `t`, in input pixels.
    fn member_at(&self, members: &[u32], label: u8, t: usize, (x, y): (f32, f32)) -> Result<usize, Error> {
        self.require_place(t, (x, y))?;
        let tracks = self.trajectories.as_ref().ok_or_else(|| state_error("there are no trajectories"))?;
        let distance = |i: u32| tracks.at(i as usize, t).map(|(px, py)| (px - x).powi(2) + (py - y).powi(2));
        let near = members.iter().enumerate().filter_map(|(k, &i)| distance(i).map(|d| (d, k)));
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, k)| k).ok_or_else(|| Error::Data {
            reason: format!("label {label} has no trajectories in frame {t}: choose a point in another frame"),
        })
    }

    fn require_place(&self, t: usize, (x, y): (f32, f32)) -> Result<(), Error> {
        let frames = self.num_frames();
        if t >= frames {
            return Err(param("t", &t.to_string(), &format!("a frame, 0..{frames}")));
        }
        let (width, height) = self.input_size().unwrap_or_default();
        for (name, value, side) in [("x", x, width), ("y", y, height)] {
            // Pixel centres are at whole numbers.
            if !(value >= -0.5 && value <= side as f32 - 0.5) {
                let expected = format!("a place in the frame, -0.5..={}", side as f32 - 0.5);
                return Err(param(name, &value.to_string(), &expected));
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

/// The lowest label that no object has.
fn free_label(objects: &Objects) -> Result<u8, Error> {
    (1..=255)
        .find(|l| !objects.of_cluster.contains(l))
        .ok_or_else(|| Error::Data { reason: "all 255 labels are in use: merge some first".to_owned() })
}

fn highest(of_cluster: &[u8]) -> usize {
    of_cluster.iter().max().map_or(0, |&l| l.into())
}

fn opened<const N: usize>(labels: [u8; N]) -> Vec<bool> {
    let mut open = vec![false; 256];
    labels.iter().for_each(|&l| open[usize::from(l)] = true);
    open
}

/// The half that holds fewer points of trajectories; the second of equal ones.
fn fewer_points(tracks: &Trajectories, members: &[u32], half: &[bool]) -> bool {
    let points = |side: bool| -> usize {
        let of_side = members.iter().zip(half).filter(|(_, h)| **h == side);
        of_side.map(|(&i, _)| tracks.points(i as usize).len()).sum()
    };
    points(true) <= points(false)
}
