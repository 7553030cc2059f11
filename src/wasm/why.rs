//! Explanations as JavaScript has them, under the names of `lib/session/result.js`, which says what each is.

use crate::cut::{Link, OwnCost, STEPS_PER_UNIT, STRANGER};
use crate::pipeline::{self, Explanation, Source};
use serde::Serialize;

/// Steps of the solver in units of cost.
fn units(steps: i64) -> f64 {
    steps as f64 / f64::from(STEPS_PER_UNIT)
}

/// `Explanation`.
#[derive(Serialize)]
pub(super) struct Told {
    label: u8,
    source: &'static str,
    superpixel: u32,
    cluster: u32,
    weight: f32,
    evidence: Evidence,
    costs: Vec<LabelCost>,
    links: Vec<SuperpixelLink>,
    voters: Vec<Voter>,
    nearest: i64,
    affinities: Vec<Affinity>,
    flip: Option<Flip>,
    border: Option<Border>,
}

#[derive(Serialize)]
struct Evidence {
    background: f32,
    looks: f32,
}

#[derive(Serialize)]
struct LabelCost {
    cluster: u32,
    label: u8,
    votes: u32,
    trajectories: f64,
    colours: f64,
    evidence: f64,
    links: f64,
    forbidden: f64,
    total: f64,
}

#[derive(Serialize)]
struct SuperpixelLink {
    t: usize,
    superpixel: u32,
    cluster: u32,
    tracks: u32,
    cost: f64,
}

#[derive(Serialize)]
struct Voter {
    x: f32,
    y: f32,
    cluster: i64,
    stranger: bool,
}

#[derive(Serialize)]
struct Affinity {
    to: u32,
    affinity: f64,
}

#[derive(Serialize)]
struct Flip {
    cluster: u32,
    margin: f64,
    votes: f64,
}

#[derive(Serialize)]
struct Border {
    edges: u32,
    mean: f64,
    i: u32,
    j: u32,
    /// Narrowed, as the edges of a result are.
    d: f32,
}

impl Told {
    pub(super) fn of(why: &Explanation) -> Self {
        let reasons = &why.reasons;
        let clusters = 0..reasons.own.len() as u32;
        let link = |&Link { t, superpixel, label, cost, tracks }: &Link| SuperpixelLink {
            t,
            superpixel,
            cluster: label,
            tracks,
            cost: units(cost.into()),
        };
        let voter = |voter: &pipeline::Voter| Voter {
            x: voter.at.0,
            y: voter.at.1,
            cluster: if clusters.contains(&voter.cluster) { voter.cluster.into() } else { -1 },
            stranger: voter.cluster == STRANGER,
        };
        Self {
            label: why.label,
            source: match why.source {
                Source::Superpixel => "superpixel",
                Source::Border => "border",
                Source::Stroke => "stroke",
            },
            superpixel: why.superpixel,
            cluster: reasons.label,
            weight: reasons.lambda,
            evidence: Evidence { background: why.cues, looks: why.looks },
            links: reasons.links.iter().map(link).collect(),
            voters: why.voters.iter().map(voter).collect(),
            costs: clusters.map(|cluster| LabelCost::of(why, cluster)).collect(),
            nearest: why.nearest.map_or(-1, i64::from),
            affinities: why.affinities.iter().map(|&(to, affinity)| Affinity { to, affinity }).collect(),
            flip: why.runner_up.map(|other| Flip {
                cluster: other.cluster,
                margin: units(other.margin),
                votes: other.votes.map_or(f64::INFINITY, f64::from),
            }),
            border: why.rim.map(|rim| {
                let (i, j, d) = rim.strongest;
                Border { edges: rim.edges, mean: rim.mean, i, j, d: d as f32 }
            }),
        }
    }
}

impl LabelCost {
    fn of(why: &Explanation, cluster: u32) -> Self {
        let total = why.reasons.cost(cluster);
        let OwnCost { trajectories, colours, evidence, forbidden } = why.reasons.own[cluster as usize];
        let [trajectories, colours, evidence, forbidden] = [trajectories, colours, evidence, forbidden].map(i64::from);
        Self {
            cluster,
            label: why.of_cluster.get(cluster as usize).copied().unwrap_or(0),
            votes: why.reasons.votes[cluster as usize],
            trajectories: units(trajectories),
            colours: units(colours),
            evidence: units(evidence),
            links: units(total - trajectories - colours - evidence - forbidden),
            forbidden: units(forbidden),
            total: units(total),
        }
    }
}
