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

use super::expansion::{MAX_WEIGHT, Potts, SCALE, rounded};
use super::input::{CutInput, CutLabels, STRANGER, UNKNOWN};
use super::params::CutParams;
use crate::delaunay::constrained_delaunay;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

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
const NOWHERE: u32 = u32::MAX;

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
fn heard(input: &CutInput, params: &CutParams, nodes: &Nodes) -> (Vec<i32>, Vec<f32>) {
    let num_labels = input.num_labels;
    if num_labels == 0 {
        return Default::default();
    }
    let (votes, strangers) = votes(input, nodes);
    let is_object = |label: usize| input.objects.get(label) == Some(&true);
    let outlier_weight = if (0..num_labels).any(is_object) { params.outlier_weight } else { 0.0 };
    let trust = trust(input, params);
    let mut costs = Vec::with_capacity(votes.len());
    let mut lambdas = Vec::with_capacity(strangers.len());
    for (node, votes) in votes.chunks_exact(num_labels).enumerate() {
        let strange = outlier_weight * strangers[node] as f32;
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
fn votes(input: &CutInput, nodes: &Nodes) -> (Vec<u32>, Vec<u32>) {
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
            if params.weight_by_length && mean > 0.0 {
                cost *= (border.length / mean).clamp(LENGTH_RANGE.0, LENGTH_RANGE.1);
            }
            problem.edges.push((base + border.a, base + border.b));
            problem.weights.push(rounded(cost));
        }
    }
}

/// A superpixel of the next frame, with what leads there.
#[derive(Debug, Clone, Copy, Default)]
struct Successor {
    to: u32,
    tracks: u32,
}

/// Step 4.
fn add_temporal(problem: &mut Potts, input: &CutInput, params: &CutParams, nodes: &Nodes) {
    let mut found: Vec<(u32, Successor)> = Vec::new();
    for (t, pair) in input.superpixels.windows(2).enumerate() {
        found.clear();
        for i in 0..input.tracks.len() {
            let frames = input.tracks.frames(i);
            if frames.contains(&t) && frames.contains(&(t + 1)) {
                let p = input.tracks.point(i, t);
                let (from, to) = (nodes.of_point[p], nodes.of_point[p + 1]);
                found.push((from - nodes.base[t], Successor { to: to - nodes.base[t + 1], tracks: 1 }));
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
fn gathered(found: &[(u32, Successor)], count: usize) -> Vec<(u32, Successor)> {
    let mut begin = vec![0_u32; count + 1];
    for &(from, _) in found {
        begin[from as usize + 1] += 1;
    }
    for p in 0..count {
        begin[p + 1] += begin[p];
    }
    let mut next = begin.clone();
    let mut sorted = vec![Successor::default(); found.len()];
    for &(from, link) in found {
        sorted[next[from as usize] as usize] = link;
        next[from as usize] += 1;
    }
    let mut links: Vec<(u32, Successor)> = Vec::new();
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

// Ambiguous places (section 4.2): triangles between trajectories of different labels.
//
// Trajectories near the rim of an object may be dragged along by it, or drag; where labels change from one trajectory
// to its neighbours, a superpixel's own trajectories are no sure witnesses.

/// The share of each superpixel of frame `t` that ambiguous Delaunay triangles cover, 0 to 1.
///
/// Triangulated are the points of the trajectories alive in that frame whose label is known; a triangle is ambiguous if
/// not all three labels are the same. A pixel belongs to a triangle if its centre lies inside or on the triangle's rim.
pub(super) fn ambiguous_shares(superpixels: &Superpixels, tracks: &Trajectories, label: &[u32], t: usize) -> Vec<f32> {
    let mut points = Vec::new();
    let mut labels = Vec::new();
    for (i, x, y) in tracks.alive(t) {
        if let Some(&l) = label.get(i).filter(|&&l| l != UNKNOWN) {
            points.push((x, y));
            labels.push(l);
        }
    }
    let (width, height) = superpixels.runs().size();
    let mut covered = vec![false; width * height];
    for [a, b, c] in constrained_delaunay(&points, &[]).triangles {
        let of = |corner: u32| labels[corner as usize];
        if of(a) != of(b) || of(a) != of(c) {
            let corners = [a, b, c].map(|corner| points[corner as usize]);
            fill(corners, width, &mut covered);
        }
    }
    let mut counts = vec![0_u32; superpixels.count];
    for (&p, _) in superpixels.label().data().iter().zip(&covered).filter(|(_, covered)| **covered) {
        counts[p as usize] += 1;
    }
    counts.iter().zip(superpixels.areas()).map(|(&count, area)| count as f32 / area.max(1) as f32).collect()
}

/// Marks the pixels whose centres lie in the triangle, row by row.
fn fill(corners: [(f32, f32); 3], width: usize, covered: &mut [bool]) {
    let corners = corners.map(|(x, y)| (f64::from(x), f64::from(y)));
    let height = covered.len() / width.max(1);
    let top = corners.iter().fold(f64::INFINITY, |m, c| m.min(c.1)).ceil().max(0.0) as usize;
    let bottom = corners.iter().fold(f64::NEG_INFINITY, |m, c| m.max(c.1)).floor();
    if bottom < 0.0 {
        return;
    }
    for y in top..(bottom as usize + 1).min(height) {
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for k in 0..3 {
            let (mut from, mut to) = (corners[k], corners[(k + 1) % 3]);
            if from.1 > to.1 {
                (from, to) = (to, from);
            }
            let row = y as f64;
            if from.1 > row || to.1 < row {
                continue;
            }
            let ends = match to.1 > from.1 {
                true => [from.0 + (to.0 - from.0) * ((row - from.1) / (to.1 - from.1)); 2],
                false => [from.0, to.0],
            };
            for x in ends {
                left = left.min(x);
                right = right.max(x);
            }
        }
        if right >= 0.0 && left <= right {
            let begin = left.ceil().max(0.0) as usize;
            let end = (right.floor() as usize + 1).min(width);
            if begin < end {
                covered[y * width + begin..y * width + end].fill(true);
            }
        }
    }
}

// Why a superpixel has its label: the terms of the energy that this superpixel takes part in, made again.
//
// Terms are whole numbers of steps, as the solver has them. All other superpixels keep their labels: what a label
// costs here is its own cost and what the links to superpixels of other labels cost.

/// Steps of the solver in a unit of cost.
pub(crate) const STEPS_PER_UNIT: i32 = SCALE as i32;

/// What a label costs a superpixel by itself, in steps of 1/65536.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct OwnCost {
    /// λ (1 − h) of the trajectories in it.
    pub trajectories: i32,
    /// Its colours, where no trajectory has a say.
    pub colours: i32,
    /// What else speaks against the label: the background and the looks of the objects.
    pub evidence: i32,
    /// What the strokes of a correction forbid.
    pub forbidden: i32,
}

/// A superpixel that shares a border, or follows in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Link {
    /// Frame.
    pub t: usize,
    /// Its number in that frame.
    pub superpixel: u32,
    /// Its label.
    pub label: u32,
    /// What a different label costs, in steps of 1/65536.
    pub cost: i32,
    /// Common trajectories, between consecutive frames.
    pub tracks: u32,
}

/// The terms of a superpixel.
///
/// Law: for any two labels, [`Reasons::cost`] differs by as much as the energy of the whole clip does with the
/// superpixel under the one and the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reasons {
    /// Its label by the cut.
    pub label: u32,
    /// λ: how much its trajectories count, 0 where none has a say.
    pub lambda: f32,
    /// Its trajectories of each label.
    pub votes: Vec<u32>,
    /// Its trajectories that move like nothing around them and count for all objects.
    pub strangers: u32,
    /// All its trajectories, by their places in [`CutInput::tracks`].
    pub voters: Vec<u32>,
    /// What each label costs by itself.
    pub own: Vec<OwnCost>,
    /// What binds it to others.
    pub links: Vec<Link>,
}

impl Reasons {
    /// The terms of a superpixel of frame `t` under the labels `cut`.
    pub(crate) fn of(input: &CutInput, params: &CutParams, cut: &CutLabels, t: usize, superpixel: u32) -> Self {
        let nodes = Nodes::new(input);
        let node = nodes.base[t] + superpixel;
        let place = node as usize * input.num_labels;
        let mine = place..place + input.num_labels;
        let (heard, lambda) = heard(input, params, &nodes);
        let (votes, strangers) = votes(input, &nodes);
        let problem = energy(input, params);
        let is_heard = lambda[node as usize] > 0.0;
        let own = |(&all, &heard): (&i32, &i32)| OwnCost {
            trajectories: if is_heard { heard } else { 0 },
            colours: if is_heard { 0 } else { heard },
            evidence: all - heard,
            forbidden: 0,
        };
        let own = problem.unary[mine.clone()].iter().zip(&heard[mine.clone()]).map(own).collect();
        let has_objects = input.objects.iter().take(input.num_labels).any(|&object| object);
        let (voters, common) = crossing(input, &nodes, node, t);
        Self {
            label: cut.labels[t][superpixel as usize],
            lambda: lambda[node as usize],
            votes: votes[mine].to_vec(),
            strangers: if has_objects { strangers[node as usize] } else { 0 },
            voters,
            own,
            links: links(&problem, &nodes, cut, node, &common),
        }
    }

    /// Only the labels that are `legal` may be chosen, as [`super::Region`] has it.
    pub(crate) fn hold(&mut self, legal: &[bool]) {
        for (own, _) in self.own.iter_mut().zip(legal).filter(|(_, legal)| !**legal) {
            *own = OwnCost { forbidden: MAX_WEIGHT, ..OwnCost::default() };
        }
    }

    /// What `label` costs here, in steps of 1/65536: by itself, and by the links that it would cut.
    pub(crate) fn cost(&self, label: u32) -> i64 {
        let own = self.own[label as usize];
        let cut = self.links.iter().filter(|link| link.label != label).map(|link| i64::from(link.cost));
        [own.trajectories, own.colours, own.evidence, own.forbidden].into_iter().map(i64::from).chain(cut).sum()
    }

    /// The cheapest label among others, and what it costs more than the present one: below that nothing changes.
    pub(crate) fn runner_up(&self, is_other: impl Fn(u32) -> bool) -> Option<(u32, i64)> {
        let others = (0..self.own.len() as u32).filter(|&label| label != self.label && is_other(label));
        others.map(|label| (label, self.cost(label) - self.cost(self.label))).min_by_key(|&(_, margin)| margin)
    }

    /// How many more trajectories of `label` here would bring its cost down to the present one's, all else as it is;
    /// `None` where no number would.
    pub(crate) fn votes_to_flip(&self, label: u32, params: &CutParams) -> Option<u32> {
        let (own, other) = (self.own[self.label as usize], self.own[label as usize]);
        let heard = |own: OwnCost| i64::from(own.trajectories) + i64::from(own.colours);
        let rest = (self.cost(label) - heard(other)) - (self.cost(self.label) - heard(own));
        let units = |steps: i64| steps as f64 / f64::from(SCALE) / f64::from(params.unary_weight);
        let total =
            self.votes.iter().sum::<u32>() as f64 + f64::from(params.outlier_weight) * f64::from(self.strangers);
        let ahead = units(i64::from(other.trajectories) - i64::from(own.trajectories)) * total;
        // n more of them part the costs by (ahead − n) / (total + n), at most by −1.
        let needed = (ahead + units(rest) * total) / (1.0 - units(rest));
        let is_deaf = self.lambda == 0.0 && total > 0.0;
        (!is_deaf && units(rest) < 1.0).then(|| needed.ceil().max(1.0) as u32)
    }
}

/// The trajectories in `node` of frame `t`, and the nodes that they come from and go to.
fn crossing(input: &CutInput, nodes: &Nodes, node: u32, t: usize) -> (Vec<u32>, Vec<u32>) {
    let (mut voters, mut common) = (Vec::new(), Vec::new());
    for i in (0..input.tracks.len()).filter(|&i| input.tracks.frames(i).contains(&t)) {
        let (point, points) = (input.tracks.point(i, t), input.tracks.points(i));
        if nodes.of_point[point] == node {
            voters.push(i as u32);
            // Their neighbours are of the frames before and after: never this node.
            common.extend_from_slice(
                &nodes.of_point[points.start.max(point.saturating_sub(1))..points.end.min(point + 2)],
            );
        }
    }
    (voters, common)
}

/// The links of `node`.
fn links(problem: &Potts, nodes: &Nodes, cut: &CutLabels, node: u32, common: &[u32]) -> Vec<Link> {
    let mut links = Vec::new();
    for (&(p, q), &cost) in problem.edges.iter().zip(&problem.weights) {
        if p == node || q == node {
            let other = if p == node { q } else { p };
            let t = nodes.base.partition_point(|&base| base <= other) - 1;
            let superpixel = other - nodes.base[t];
            let tracks = common.iter().filter(|&&c| c == other).count() as u32;
            links.push(Link { t, superpixel, label: cut.labels[t][superpixel as usize], cost, tracks });
        }
    }
    links
}

/// How much dearer the cheapest label of another kind is for each superpixel than its own, all others as they are; in
/// units of cost, numbered frame by frame. `kind` has one for each label.
pub(crate) fn margins(input: &CutInput, params: &CutParams, cut: &CutLabels, kind: &[u8]) -> Vec<f32> {
    let Potts { mut unary, edges, weights, num_labels, .. } = energy(input, params);
    let label = cut.labels.concat();
    for (&(p, q), &weight) in edges.iter().zip(&weights) {
        for (node, other) in [(p, q), (q, p)] {
            unary[node as usize * num_labels + label[other as usize] as usize] -= weight;
        }
    }
    let margin = |(costs, &own): (&[i32], &u32)| {
        let is_other = |l: &usize| kind.get(*l) != kind.get(own as usize);
        let best = (0..costs.len()).filter(is_other).map(|l| costs[l]).min();
        best.map_or(f32::INFINITY, |best| (best - costs[own as usize]) as f32 / SCALE)
    };
    unary.chunks_exact(num_labels.max(1)).zip(&label).map(margin).collect()
}
