//! Why a pixel has its label, as dictionaries and tuples; `package/tracecut/_types.py` makes classes of them.

use crate::error::Result;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tracecut::explanation::{Explanation, LabelCost, LabelSource, SuperpixelLink, Voter};

/// The fields of `tracecut.Explanation` by their names; of lists of classes the fields in order.
pub(crate) fn explanation<'py>(py: Python<'py>, why: &Explanation) -> Result<Bound<'py, PyDict>> {
    let source = match why.source {
        LabelSource::Superpixel => "superpixel",
        LabelSource::Border => "border",
        LabelSource::Stroke => "stroke",
    };
    let cost = |c: &LabelCost| (c.cluster, c.label, c.votes, c.trajectories, c.evidence, c.links, c.forbidden, c.total);
    let link = |l: &SuperpixelLink| (l.t, l.superpixel, l.cluster, l.tracks, l.cost);
    let voter = |v: &Voter| (v.x, v.y, v.cluster.map_or(-1, i64::from), v.is_outlier);
    let fields = PyDict::new(py);
    fields.set_item("label", why.label)?;
    fields.set_item("source", source)?;
    fields.set_item("superpixel", why.superpixel)?;
    fields.set_item("cluster", why.cluster)?;
    fields.set_item("weight", why.weight)?;
    fields.set_item("evidence", (why.evidence.background, why.evidence.looks))?;
    fields.set_item("costs", why.costs.iter().map(cost).collect::<Vec<_>>())?;
    fields.set_item("links", why.links.iter().map(link).collect::<Vec<_>>())?;
    fields.set_item("voters", why.voters.iter().map(voter).collect::<Vec<_>>())?;
    fields.set_item("nearest", why.nearest)?;
    fields.set_item("affinities", why.affinities.iter().map(|entry| (entry.to, entry.affinity)).collect::<Vec<_>>())?;
    fields.set_item("flip", why.flip.map(|flip| (flip.cluster, flip.margin, flip.votes)))?;
    fields.set_item("border", why.border.map(|border| (border.edges, border.mean, border.i, border.j, border.d)))?;
    Ok(fields)
}
