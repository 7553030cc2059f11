//! Why a pixel has its label, as dictionaries and tuples; `package/tracecut/_why.py` makes classes of them.

use crate::error::Result;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tracecut::cut::{Link, OwnCost, STEPS_PER_UNIT, STRANGER};
use tracecut::{Explanation, Source};

/// Steps of the solver in units of the energy.
fn units(steps: i64) -> f64 {
    steps as f64 / f64::from(STEPS_PER_UNIT)
}

/// The fields of `tracecut.Explanation` by their names; of lists of classes the fields in order.
pub(crate) fn explanation<'py>(py: Python<'py>, why: &Explanation) -> Result<Bound<'py, PyDict>> {
    let reasons = &why.reasons;
    let fields = PyDict::new(py);
    fields.set_item("label", why.label)?;
    fields.set_item("source", source(why.source))?;
    fields.set_item("superpixel", why.superpixel)?;
    fields.set_item("cluster", reasons.label)?;
    fields.set_item("weight", reasons.lambda)?;
    fields.set_item("evidence", (why.cues, why.looks))?;
    fields.set_item("costs", (0..reasons.own.len() as u32).map(|c| cost(why, c)).collect::<Vec<_>>())?;
    let link = |l: &Link| (l.t, l.superpixel, l.label, l.tracks, units(l.cost.into()));
    fields.set_item("links", reasons.links.iter().map(link).collect::<Vec<_>>())?;
    fields.set_item("voters", voters(why))?;
    fields.set_item("nearest", why.nearest)?;
    fields.set_item("affinities", why.affinities.clone())?;
    fields.set_item("flip", why.runner_up.map(|other| (other.cluster, units(other.margin), other.votes)))?;
    fields.set_item("border", why.rim.map(|rim| (rim.edges, rim.mean, rim.strongest)))?;
    Ok(fields)
}

fn source(source: Source) -> &'static str {
    match source {
        Source::Superpixel => "superpixel",
        Source::Border => "border",
        Source::Stroke => "stroke",
    }
}

/// Cluster, its mask label, its trajectories here; what it costs by them, by colours, by evidence, by links and where it
/// is forbidden; and in all.
fn cost(why: &Explanation, cluster: u32) -> (u32, u8, u32, [f64; 6]) {
    let (own, total) = (why.reasons.own[cluster as usize], why.reasons.cost(cluster));
    let OwnCost { trajectories, colours, evidence, forbidden } = own;
    let [trajectories, colours, evidence, forbidden] = [trajectories, colours, evidence, forbidden].map(i64::from);
    let links = total - trajectories - colours - evidence - forbidden;
    let label = why.of_cluster.get(cluster as usize).copied().unwrap_or(0);
    let votes = why.reasons.votes[cluster as usize];
    (cluster, label, votes, [trajectories, colours, evidence, links, forbidden, total].map(units))
}

/// Where each is, its cluster or -1, and whether it is a stranger.
fn voters(why: &Explanation) -> Vec<(f32, f32, i64, bool)> {
    let known = |cluster: u32| if (cluster as usize) < why.reasons.own.len() { i64::from(cluster) } else { -1 };
    why.voters.iter().map(|v| (v.at.0, v.at.1, known(v.cluster), v.cluster == STRANGER)).collect()
}
