//! Figure and ground: which clusters are objects.
//!
//! The background or the frame's rim (`objects`) says it of the clusters, pixels doubt it, and where none is left what
//! stands out is tried (`background`). Objects take the labels that they had in the window before (`window`).

use super::clip::Clip;
use crate::background::{Accounts, Background, Clustering, Parted, Sought, part_rigid};
use crate::cut::{forget_strangers, labels_for};
use crate::evidence::Signs;
use crate::objects::{Objects, find_objects, number_objects, signs};
use crate::session::base::{Clustered, Parts};
use crate::session::jobs::Ledger;
use crate::session::jobs::{Made, PieceKind, Work};
use crate::session::window::portraits;

/// Least log-odds of an object: what is doubted may still be one, and its pixels decide.
const LEAST: f64 = -1.5;

/// Which clusters are objects, and what the pixels of the frames say to that, frame by frame.
#[derive(Debug, Clone)]
pub(crate) struct Figure {
    is_object: Vec<bool>,
    /// The labels of the denser trajectories; `None` without those.
    voted: Option<Vec<u32>>,
    /// Of the frames so far.
    accounts: Vec<Accounts>,
    /// Of how many frames there will be accounts; 0 where the camera stands still or there is nothing to tell.
    pub(crate) wanted: usize,
}

impl Figure {
    /// Clusters may be made anew.
    pub(crate) fn new(parts: &mut Parts, clip: &Clip) -> Self {
        let mut is_object = part_clusters(parts, clip);
        let mut voted = voted(parts, clip);
        let has_none = !is_object.contains(&true);
        if let Some((labels, objects)) = has_none.then(|| stand_out(parts, voted.as_deref(), clip)).flatten() {
            (voted, is_object) = (Some(labels), objects);
        }
        let is_told = voted.is_some() && parts.clustered.embedded.tracked.denser.is_some();
        let wanted = parts.background.as_ref().filter(|_| is_told).map_or(0, |b| b.num_accounts(&is_object));
        Self { is_object, voted, accounts: Vec::new(), wanted }
    }

    /// Of how many frames there are accounts.
    pub(crate) fn made(&self) -> usize {
        self.accounts.len()
    }

    fn sought(&self, t: usize, parts: &Parts) -> Option<Sought> {
        let labelled = (parts.clustered.embedded.tracked.denser.as_ref()?, self.voted.as_deref()?);
        Some(parts.background.as_ref()?.sought(t, labelled, &self.is_object))
    }

    pub(crate) fn take(&self, parts: &Parts, clip: &mut Clip) -> Option<(PieceKind, usize, Work)> {
        let t = clip.ledger.take(PieceKind::Accounts, self.made()..self.wanted)?;
        Some((PieceKind::Accounts, t, Work::Accounts(self.sought(t, parts)?)))
    }

    pub(crate) fn awaits(&self, ledger: &Ledger) -> bool {
        self.made() < self.wanted && ledger.is_out(PieceKind::Accounts, self.made())
    }

    /// The accounts of the next frame.
    pub(crate) fn step(&mut self, parts: &Parts, clip: &mut Clip) {
        let t = self.made();
        let make = || self.sought(t, parts).map(|sought| sought.accounts()).unwrap_or_default();
        let made = match clip.ledger.collect(PieceKind::Accounts, t) {
            Some(Made::Accounts(made)) => made,
            _ => make(),
        };
        self.accounts.push(made);
    }

    /// The objects, and the labels of the denser trajectories.
    pub(crate) fn finish(self, parts: &mut Parts, clip: &Clip) -> (Objects, Option<Vec<u32>>) {
        let Self { is_object, voted, accounts, .. } = self;
        let Parts { clustered, background, .. } = parts;
        let moving = background.as_mut().filter(|background| !background.is_still());
        if let (Some(background), Some(denser), Some(voted)) = (moving, &clustered.embedded.tracked.denser, &voted) {
            background.account(accounts, (denser, voted), &is_object);
        }
        (objects_of(parts, &is_object, clip), voted)
    }
}

/// Objects that no cluster shows, as clusters of their own: the labels of the denser trajectories anew, and which clusters
/// are objects; `None` where there are none.
fn stand_out(parts: &mut Parts, voted: Option<&[u32]>, clip: &Clip) -> Option<(Vec<u32>, Vec<bool>)> {
    let Parts { clustered, background, .. } = parts;
    let (background, params) = (background.as_ref()?, &clip.params);
    let salient: Vec<bool> = clustered.salience().iter().map(|&s| f64::from(s) > params.saliency.threshold).collect();
    let tracked = &clustered.embedded.tracked;
    let before = Clustering { tracks: &tracked.tracks, clusters: &clustered.clusters, radius: params.vote_radius() };
    let denser = (tracked.denser.as_ref()?, voted?);
    let found = background.stand_out(&before, denser, &salient, params.trajectory.mask_step, &params.background)?;
    clustered.clusters = found.clusters;
    Some((found.voted, found.is_object))
}

/// The labels of the denser trajectories, by those that were clustered.
pub(crate) fn voted(parts: &Parts, clip: &Clip) -> Option<Vec<u32>> {
    let Clustered { embedded, clusters, .. } = &parts.clustered;
    let denser = embedded.tracked.denser.as_ref()?;
    let (tracks, params) = (&embedded.tracked.tracks, &clip.params);
    let mut voted = labels_for(denser, tracks, &clusters.label, clusters.count.max(1), params.vote_radius());
    forget_strangers(&mut voted, parts.clustered.salience(), params.saliency.threshold);
    Some(voted)
}

/// Which clusters are objects. Where the camera goes forward, they are made anew.
fn part_clusters(parts: &mut Parts, clip: &Clip) -> Vec<bool> {
    if let Some(Parted { clusters, is_object }) = before_rigid_scene(parts, clip) {
        parts.clustered.clusters = clusters;
        return is_object;
    }
    let Parts { clustered, background, doubts, .. } = parts;
    let Some(background) = background else {
        let found = find_objects(&clustered.embedded.tracked.tracks, &clustered.clusters);
        return found.of_cluster.iter().map(|&label| label > 0).collect();
    };
    let values = log_odds(clustered, background, clip);
    let doubt = |value: f64| if value > LEAST { -value.min(0.0) as f32 } else { 0.0 };
    *doubts = clustered.clusters.label.iter().map(|&l| doubt(values[l as usize])).collect();
    values.iter().map(|&v| v > LEAST).collect()
}

/// Objects that no rigid scene explains; `None` unless the camera goes forward, and where all that was tracked is none
/// of the scene.
fn before_rigid_scene(parts: &Parts, clip: &Clip) -> Option<Parted> {
    let embedded = &parts.clustered.embedded;
    let longest = clip.params.connectedness.max_edge * clip.params.spacing();
    let near = &embedded.discontinuities.neighborhoods;
    let travel = parts.camera.as_ref()?.travel.as_ref()?;
    let parted = part_rigid(travel, &embedded.tracked.tracks, near, longest);
    parted.is_object.contains(&false).then_some(parted)
}

/// What speaks for each cluster that it is an object; above [`LEAST`] it is one.
fn log_odds(clustered: &Clustered, background: &Background, clip: &Clip) -> Vec<f64> {
    let (tracks, clusters) = (&clustered.embedded.tracked.tracks, &clustered.clusters);
    if background.is_still() {
        let unlike = background.unlike_plate(tracks, clusters);
        let values: Vec<f64> = unlike.iter().map(|&unlike| Signs::Still { unlike }.value()).collect();
        // Where nothing that was tracked belongs to the scene, no label is left for it: the rim decides.
        if values.iter().any(|&v| v <= LEAST) {
            return values;
        }
    }
    let value = |signs: &Option<Signs>| signs.map_or(f64::NEG_INFINITY, |signs| signs.value());
    signs(tracks, clusters, &clustered.strangeness(&clip.params.affinity)).iter().map(value).collect()
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
