//! The energy of the Gabriel cut: what each label costs each superpixel, and what it costs to part two.
//!
//! Superpixels of all frames are numbered through, frame by frame.
//!
//! 1. Each point of a trajectory lies in one superpixel; points outside the image belong to the nearest pixel.
//! 2. Unary: `λ_r (1 − h_r(label))`; strangers, beyond the paper, are in the histogram of every object. Where λ_r is
//!    zero, colour may stand in for the histogram, beyond the paper: the probability of the label by the colours of all
//!    superpixels that have witnesses. Evidence from elsewhere is added as it is, beyond the paper.
//! 3. Spatial: `exp(−mean Pb / scale)` along the common border, times its length.
//! 4. Temporal: common trajectories by the larger number of trajectories.
//!
//! Costs are computed in floating point, one at a time, and rounded to 1/65536.

use super::ambiguous::ambiguous_shares;
use super::expansion::{Potts, rounded};
use super::input::{CutInput, STRANGER};
use super::params::CutParams;

/// Length of a border relative to the mean, least and most.
const LENGTH_RANGE: (f32, f32) = (0.05, 4.0);

/// The energy whose least labelling is sought.
pub(crate) fn energy(input: &CutInput, params: &CutParams) -> Potts {
    energy_at(input, params, &Nodes::new(input))
}

/// The same where it is known where superpixels and points are.
pub(super) fn energy_at(input: &CutInput, params: &CutParams, nodes: &Nodes) -> Potts {
    let mut problem = Potts {
        num_nodes: nodes.num_nodes(),
        num_labels: input.num_labels,
        unary: own_costs(input, params, nodes),
        ..Potts::default()
    };
    add_spatial(&mut problem, input, params, nodes);
    add_temporal(&mut problem, input, params, nodes);
    problem
}

/// The pixel nearest to a point.
pub(crate) fn pixel_of((width, height): (usize, usize), x: f32, y: f32) -> usize {
    // A float-to-integer cast saturates, at zero from below.
    let x = ((x + 0.5) as usize).min(width - 1);
    let y = ((y + 0.5) as usize).min(height - 1);
    y * width + x
}

/// No superpixel: a point in a frame that has none.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Where superpixels and points of trajectories are in the clip.
#[derive(Debug, Clone)]
pub(super) struct Nodes {
    /// First superpixel of each frame, and the number of all.
    pub(super) base: Vec<u32>,
    /// Superpixel of each point of a trajectory.
    pub(super) of_point: Vec<u32>,
    /// Number of trajectories in each superpixel.
    num_tracks: Vec<u32>,
}

impl Nodes {
    pub(super) fn new(input: &CutInput) -> Self {
        let mut base = vec![0];
        for s in input.superpixels {
            base.push(base[base.len() - 1] + s.count as u32);
        }
        let mut num_tracks = vec![0; base[base.len() - 1] as usize];
        let mut of_point = vec![NOWHERE; input.tracks.x.len()];
        for (t, s) in input.superpixels.iter().enumerate().filter(|(_, s)| s.count > 0) {
            let label = s.label();
            for (i, x, y) in input.tracks.alive(t) {
                let node = base[t] + label.data()[pixel_of(s.runs().size(), x, y)];
                of_point[input.tracks.point(i, t)] = node;
                num_tracks[node as usize] += 1;
            }
        }
        Self { base, of_point, num_tracks }
    }

    fn num_nodes(&self) -> usize {
        self.num_tracks.len()
    }
}

/// Step 2, node by node, label by label.
pub(super) fn own_costs(input: &CutInput, params: &CutParams, nodes: &Nodes) -> Vec<i32> {
    let mut costs = heard(input, params, nodes).0;
    for (costs, &evidence) in costs.chunks_exact_mut(input.num_labels.max(1)).zip(input.evidence) {
        for (label, cost) in costs.iter_mut().enumerate() {
            let against = if input.objects.get(label) == Some(&true) { -evidence } else { evidence };
            *cost += rounded(against.max(0.0));
        }
    }
    costs
}

/// What trajectories ask of each superpixel for each label; and the λ of each.
pub(super) fn heard(input: &CutInput, params: &CutParams, nodes: &Nodes) -> (Vec<i32>, Vec<f32>) {
    let num_labels = input.num_labels;
    if num_labels == 0 {
        return Default::default();
    }
    let (votes, strangers) = votes(input, nodes);
    let is_object = |label: usize| input.objects.get(label) == Some(&true);
    let stranger_weight = if (0..num_labels).any(is_object) { params.stranger_weight } else { 0.0 };
    let trust = trust(input, params);
    let mut costs = Vec::with_capacity(votes.len());
    let mut lambdas = Vec::with_capacity(strangers.len());
    for (node, votes) in votes.chunks_exact(num_labels).enumerate() {
        let strange = stranger_weight * strangers[node] as f32;
        let total = votes.iter().sum::<u32>() as f32 + strange;
        let lambda = params.unary_weight * total.min(1.0) * trust.get(node).copied().unwrap_or(1.0);
        lambdas.push(lambda);
        let share = |v: u32| if total > 0.0 { v as f32 / total } else { 0.0 };
        let of_strangers = |label| if is_object(label) && total > 0.0 { strange / total } else { 0.0 };
        costs.extend(votes.iter().enumerate().map(|(l, &v)| rounded(lambda * (1.0 - share(v) - of_strangers(l)))));
    }
    (costs, lambdas)
}

/// How many points of trajectories of each label lie in each superpixel, node by node, and how many of strangers.
pub(super) fn votes(input: &CutInput, nodes: &Nodes) -> (Vec<u32>, Vec<u32>) {
    let num_labels = input.num_labels;
    let mut votes = vec![0; nodes.num_nodes() * num_labels];
    let mut strangers = vec![0; nodes.num_nodes()];
    for (i, &label) in input.label.iter().enumerate().take(input.tracks.len()) {
        for &node in nodes.of_point[input.tracks.points(i)].iter().filter(|&&node| node != NOWHERE) {
            if (label as usize) < num_labels {
                votes[node as usize * num_labels + label as usize] += 1;
            } else if label == STRANGER {
                strangers[node as usize] += 1;
            }
        }
    }
    (votes, strangers)
}

/// What is left of λ in each superpixel by the rule for ambiguous ones; nothing if it is off.
fn trust(input: &CutInput, params: &CutParams) -> Vec<f32> {
    if params.ambiguous_share >= 1.0 {
        return Vec::new();
    }
    let shares = |(t, s)| ambiguous_shares(s, input.tracks, input.label, t);
    let shares = input.superpixels.iter().enumerate().flat_map(shares);
    shares.map(|share| if share > params.ambiguous_share { 0.0 } else { 1.0 }).collect()
}

/// Step 3.
fn add_spatial(problem: &mut Potts, input: &CutInput, params: &CutParams, nodes: &Nodes) {
    let borders = || input.superpixels.iter().flat_map(|s| &s.borders);
    let mean = (borders().map(|b| f64::from(b.length)).sum::<f64>() / borders().count().max(1) as f64) as f32;
    for (s, &base) in input.superpixels.iter().zip(&nodes.base) {
        for border in &s.borders {
            let mut cost = params.spatial_weight * libm::expf(-border.pb / params.pb_scale);
            if params.by_length && mean > 0.0 {
                cost *= (border.length / mean).clamp(LENGTH_RANGE.0, LENGTH_RANGE.1);
            }
            problem.edges.push((base + border.a, base + border.b));
            problem.weights.push(rounded(cost));
        }
    }
}

/// A superpixel of the next frame, with what leads there.
#[derive(Debug, Clone, Copy, Default)]
struct Link {
    to: u32,
    tracks: u32,
}

/// Step 4.
fn add_temporal(problem: &mut Potts, input: &CutInput, params: &CutParams, nodes: &Nodes) {
    let mut found: Vec<(u32, Link)> = Vec::new();
    for (t, pair) in input.superpixels.windows(2).enumerate() {
        found.clear();
        for i in 0..input.tracks.len() {
            let frames = input.tracks.frames(i);
            if frames.contains(&t) && frames.contains(&(t + 1)) {
                let p = input.tracks.point(i, t);
                let (from, to) = (nodes.of_point[p], nodes.of_point[p + 1]);
                found.push((from - nodes.base[t], Link { to: to - nodes.base[t + 1], tracks: 1 }));
            }
        }
        for (from, link) in gathered(&found, pair[0].count) {
            let (p, q) = (nodes.base[t] + from, nodes.base[t + 1] + link.to);
            let most = nodes.num_tracks[p as usize].max(nodes.num_tracks[q as usize]).max(1);
            let weight = rounded(params.temporal_weight * link.tracks as f32 / most as f32);
            if weight > 0 {
                problem.edges.push((p, q));
                problem.weights.push(weight);
            }
        }
    }
}

/// The links of each superpixel, those to the same one added up: by superpixel, then by first occurrence.
fn gathered(found: &[(u32, Link)], count: usize) -> Vec<(u32, Link)> {
    let mut begin = vec![0_u32; count + 1];
    for &(from, _) in found {
        begin[from as usize + 1] += 1;
    }
    for p in 0..count {
        begin[p + 1] += begin[p];
    }
    let mut next = begin.clone();
    let mut sorted = vec![Link::default(); found.len()];
    for &(from, link) in found {
        sorted[next[from as usize] as usize] = link;
        next[from as usize] += 1;
    }
    let mut links: Vec<(u32, Link)> = Vec::new();
    for p in 0..count {
        let own = links.len();
        for link in &sorted[begin[p] as usize..begin[p + 1] as usize] {
            match links[own..].iter_mut().find(|(_, known)| known.to == link.to) {
                Some((_, known)) => known.tracks += link.tracks,
                None => links.push((p as u32, *link)),
            }
        }
    }
    links
}

/// Where to start from: the cheapest label of each superpixel; one without any opinion takes the label of the
/// neighbour it is bound to most strongly, ring by ring.
pub(super) fn first_labels(problem: &Potts) -> Vec<u32> {
    let mut label = problem.cheapest();
    let num_labels = problem.num_labels.max(1);
    let opinion = |c: &[i32]| c.iter().any(|&cost| cost != c[0]);
    let mut known: Vec<bool> = problem.unary.chunks_exact(num_labels).map(opinion).collect();
    known.resize(problem.num_nodes, false);
    loop {
        let mut best = vec![(0, 0_u32); problem.num_nodes];
        for (&(p, q), &weight) in problem.edges.iter().zip(&problem.weights) {
            for (knows, asks) in [(p as usize, q as usize), (q as usize, p as usize)] {
                if known[knows] && !known[asks] && weight > best[asks].0 {
                    best[asks] = (weight, label[knows]);
                }
            }
        }
        let mut more = false;
        for (p, &(weight, taken)) in best.iter().enumerate() {
            if weight > 0 {
                (label[p], known[p], more) = (taken, true, true);
            }
        }
        if !more {
            return label;
        }
    }
}
