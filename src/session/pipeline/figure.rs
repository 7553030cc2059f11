//! Figure and ground: which clusters are objects.
//!
//! The background (`judge`) or the frame's rim (`objects`) says it of the clusters, and pixels doubt it (`background`). Objects take the labels that they had in the window before (`window`).

use super::clip::Clip;
use super::found::{Clustered, Parts};
use super::ledger::Ledger;
use super::piece::{Made, PieceKind, Work};
use crate::background::{Accounts, LabelledTracks, Sought};
use crate::evidence::Known;
use crate::judge::{Observations, judge_clusters};
use crate::objects::{Objects, find_objects, number_objects};
use crate::window::portraits;

/// Which clusters are objects, and what the pixels of the frames say to that, frame by frame.
#[derive(Debug, Clone)]
pub(super) struct Figure {
    is_object: Vec<bool>,
    /// The labels of the denser trajectories; `None` without those.
    voted: Option<Vec<u32>>,
    /// Of the frames so far.
    accounts: Vec<Accounts>,
    /// Of how many frames there will be accounts; 0 where the camera stands still or there is nothing to tell.
    pub(super) wanted: usize,
}

impl Figure {
    /// Clusters may be made anew.
    pub(super) fn new(parts: &mut Parts, clip: &Clip) -> Self {
        let Parts { clustered, background, .. } = &*parts;
        let judged = background.as_ref().and_then(|background| {
            let known = clustered.found().known(&clip.params.affinity)?;
            let observations = observations(clustered, &known, clip);
            Some(judge_clusters(background, &clustered.clusters, &observations, &clip.params.background))
        });
        let (is_object, voted) = match judged {
            Some(figure) => {
                (parts.clustered.clusters, parts.doubts) = (figure.clusters, figure.doubts);
                (figure.is_object, Some(figure.label))
            }
            None => {
                let found = find_objects(&clustered.embedded.tracked.tracks, &clustered.clusters);
                (found.of_cluster.iter().map(|&label| label > 0).collect(), voted(parts, clip))
            }
        };
        let wanted = parts.background.as_ref().map_or(0, |background| background.num_accounts(&is_object));
        Self { is_object, voted, accounts: Vec::new(), wanted }
    }

    /// Of how many frames there are accounts.
    pub(super) fn made(&self) -> usize {
        self.accounts.len()
    }

    fn sought(&self, t: usize, parts: &Parts) -> Option<Sought> {
        let tracks = parts.clustered.embedded.tracked.denser.as_ref()?;
        let labelled = LabelledTracks { tracks, label: self.voted.as_deref()?, is_object: &self.is_object };
        Some(parts.background.as_ref()?.sought(t, labelled))
    }

    pub(super) fn take(&self, parts: &Parts, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        let t = clip.ledger.take(PieceKind::Accounts, self.made()..self.wanted)?;
        Some((PieceKind::Accounts, t, Work::Accounts(self.sought(t, parts)?)))
    }

    pub(super) fn awaits(&self, ledger: &Ledger) -> bool {
        self.made() < self.wanted && ledger.is_out(PieceKind::Accounts, self.made())
    }

    /// The accounts of the next frame.
    pub(super) fn step(&mut self, parts: &Parts, clip: &mut Clip) {
        let t = self.made();
        let make = || self.sought(t, parts).map(|sought| sought.accounts()).unwrap_or_default();
        let made = match clip.ledger.collect(PieceKind::Accounts, t) {
            Some(Made::Accounts(made)) => made,
            _ => make(),
        };
        self.accounts.push(made);
    }

    /// The objects, and the labels of the denser trajectories.
    pub(super) fn finish(self, parts: &mut Parts, clip: &Clip) -> (Objects, Option<Vec<u32>>) {
        let Self { is_object, voted, accounts, .. } = self;
        let Parts { clustered, background, .. } = parts;
        let moving = background.as_mut().filter(|background| !background.is_still());
        if let (Some(background), Some(tracks), Some(label)) = (moving, &clustered.embedded.tracked.denser, &voted) {
            background.account(accounts, LabelledTracks { tracks, label, is_object: &is_object });
        }
        (objects_of(parts, &is_object, clip), voted)
    }
}

/// The labels of the denser trajectories, by those that were clustered.
pub(super) fn voted(parts: &Parts, clip: &Clip) -> Option<Vec<u32>> {
    let clustered = &parts.clustered;
    clustered.embedded.tracked.denser.as_ref()?;
    let known = clustered.found().known(&clip.params.affinity)?;
    Some(observations(clustered, &known, clip).propagate_labels(&clustered.clusters))
}

/// What clusters are judged by.
fn observations<'a>(clustered: &'a Clustered, known: &'a Known<'a>, clip: &Clip) -> Observations<'a> {
    let (tracked, params) = (&clustered.embedded.tracked, &clip.params);
    Observations {
        known,
        denser: tracked.denser.as_ref().unwrap_or(&tracked.tracks),
        saliency: clustered.salience(),
        saliency_threshold: params.saliency.threshold,
        max_edge: params.connectedness.max_edge * params.spacing(),
        vote_radius: params.vote_radius(),
        spacing: params.trajectory.mask_step,
    }
}

/// The objects, under the labels that they had in the window before.
fn objects_of(parts: &Parts, is_object: &[bool], clip: &Clip) -> Objects {
    let Clustered { embedded, clusters, .. } = &parts.clustered;
    let tracked = &embedded.tracked;
    let found = number_objects(&tracked.tracks, clusters, is_object);
    match &clip.windows {
        Some(w) => {
            let looks = portraits(&tracked.tracks, &clusters.label, &found, &clip.frames);
            w.identities.rename(&found, &tracked.tracks, &clusters.label, &tracked.numbers, w.overlap, &looks)
        }
        None => found,
    }
}
