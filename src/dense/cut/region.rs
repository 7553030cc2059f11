//! The cut anew in a part of the clip: superpixels of some labels choose among these labels again; all others keep
//! theirs.
//!
//! What a superpixel beyond the region has can be no choice of those inside, so that an edge between them costs the
//! same whatever is chosen, and falls away. What is left is a problem of its own, smaller in nodes and labels; where
//! two labels are concerned, one cut solves it.

use super::expansion::{MAX_WEIGHT, Potts};
use super::input::CutInput;
use super::params::CutParams;
use super::terms::energy;

/// Which superpixels may change, and how.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Region<'a> {
    /// The label of each superpixel, frame by frame, as it is.
    pub present: &'a [Vec<u32>],
    /// Which labels can be given and taken.
    pub open: &'a [bool],
    /// Superpixels that must have one of some labels: frame, superpixel, and whether each label is legal. Of those
    /// without a legal label that is open nothing is asked.
    pub held: &'a [(usize, u32, Vec<bool>)],
}

/// A part of a problem.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub(super) problem: Potts,
    /// The label of every node of the whole, as it is.
    pub(super) all: Vec<u32>,
    /// Node and label of the whole for each of the part.
    pub(super) nodes: Vec<u32>,
    pub(super) labels: Vec<u32>,
}

impl Part {
    pub(super) fn new(input: &CutInput, params: &CutParams, region: &Region) -> Self {
        let whole = energy(input, params);
        let is_open = |label: u32| region.open.get(label as usize) == Some(&true);
        let mut all = region.present.concat();
        all.resize(whole.num_nodes, 0);
        let nodes: Vec<u32> = (0..whole.num_nodes as u32).filter(|&p| is_open(all[p as usize])).collect();
        let labels: Vec<u32> = (0..whole.num_labels as u32).filter(|&l| is_open(l)).collect();
        let mut problem = restricted(&whole, &nodes, &labels);
        let mut base = vec![0];
        for frame in region.present {
            base.push(base[base.len() - 1] + frame.len() as u32);
        }
        for (t, superpixel, legal) in region.held {
            let Ok(node) = nodes.binary_search(&(base[*t] + superpixel)) else { continue };
            let is_legal = |l: &u32| legal.get(*l as usize) == Some(&true);
            if labels.iter().any(is_legal) {
                let costs = &mut problem.unary[node * labels.len()..][..labels.len()];
                for (cost, _) in costs.iter_mut().zip(&labels).filter(|(_, l)| !is_legal(l)) {
                    *cost = MAX_WEIGHT;
                }
            }
        }
        Self { problem, all, nodes, labels }
    }

    /// The labels of the part as they are.
    pub(super) fn present(&self) -> Vec<u32> {
        let place = |&p: &u32| self.labels.binary_search(&self.all[p as usize]).unwrap_or(0) as u32;
        self.nodes.iter().map(place).collect()
    }

    /// The labels of the whole, with those of the part.
    pub(super) fn merged(mut all: Vec<u32>, nodes: &[u32], labels: &[u32], found: &[u32]) -> Vec<u32> {
        for (&p, &l) in nodes.iter().zip(found) {
            all[p as usize] = labels[l as usize];
        }
        all
    }
}

/// The problem on `nodes` and `labels` (both increasing).
fn restricted(whole: &Potts, nodes: &[u32], labels: &[u32]) -> Potts {
    let mut place = vec![u32::MAX; whole.num_nodes];
    for (k, &p) in (0..).zip(nodes) {
        place[p as usize] = k;
    }
    let cost = |p: u32, l: u32| whole.unary[p as usize * whole.num_labels + l as usize];
    let mut part = Potts {
        num_nodes: nodes.len(),
        num_labels: labels.len(),
        unary: nodes.iter().flat_map(|&p| labels.iter().map(move |&l| cost(p, l))).collect(),
        ..Potts::default()
    };
    for (&(p, q), &weight) in whole.edges.iter().zip(&whole.weights) {
        let ends = (place[p as usize], place[q as usize]);
        if ends.0 != u32::MAX && ends.1 != u32::MAX {
            part.edges.push(ends);
            part.weights.push(weight);
        }
    }
    part
}
