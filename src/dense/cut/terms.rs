//! Energy of the Gabriel cut: unary costs of each label in each superpixel, and pairwise costs of neighbours.
//!
//! Superpixels of all frames have consecutive numbers, frame by frame.
//!
//! 1. Each point of a trajectory lies in one superpixel; points outside the image belong to the nearest pixel.
//! 2. Unary: `λ_r (1 − h_r(label))`. Evidence and appearance are added, beyond the paper; beside appearance, trajectories
//!    count less.
//! 3. Spatial: `exp(−mean Pb / scale)` along the common border, times its relative length.
//! 4. Temporal: common trajectories over the larger number of trajectories.
//!
//! Costs are computed in floating point, one at a time, and rounded to 1/65536. Cost: O(points + borders).

use super::CutParams;
use super::expansion::{MAX_WEIGHT, Potts, STEPS_PER_UNIT, to_steps};
use super::{CutInput, CutLabels, UNKNOWN};
use crate::delaunay::constrained_delaunay;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

/// Bounds of the length of a border, relative to the mean. Chosen by eye.
const MIN_RELATIVE_LENGTH: f32 = 0.05;
const MAX_RELATIVE_LENGTH: f32 = 4.0;

/// Computes the energy that the cut minimizes.
pub(super) fn energy(input: &CutInput, params: &CutParams, nodes: &Nodes) -> Potts {
    let mut problem = Potts {
        num_nodes: nodes.num_nodes(),
        num_labels: input.num_labels,
        unary: unary_costs(input, params, nodes),
        ..Potts::default()
    };
    add_spatial(&mut problem, input, params, nodes);
    add_temporal(&mut problem, input, params, nodes);
    problem
}

/// Index of the pixel nearest to a point, row by row.
pub(crate) fn pixel_index(size: (usize, usize), x: f32, y: f32) -> usize {
    // A float-to-integer cast saturates, at zero from below.
    let x = ((x + 0.5) as usize).min(size.0 - 1);
    let y = ((y + 0.5) as usize).min(size.1 - 1);
    y * size.0 + x
}

/// Node of a point in a frame without superpixels.
const NO_NODE: u32 = u32::MAX;

/// Numbering of the superpixels of the clip, and the superpixel of each trajectory point.
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
        let mut of_point = vec![NO_NODE; input.tracks.x.len()];
        for (t, s) in input.superpixels.iter().enumerate().filter(|(_, s)| s.count > 0) {
            let label = s.label();
            for (i, x, y) in input.tracks.alive(t) {
                let node = base[t] + label.data()[pixel_index(s.runs().size(), x, y)];
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

/// Unary costs, node by node, label by label (step 2).
pub(super) fn unary_costs(input: &CutInput, params: &CutParams, nodes: &Nodes) -> Vec<i32> {
    let mut costs = trajectory_costs(input, params, nodes).0;
    let at = |values: &[f32], node: usize| values.get(node).copied().unwrap_or_default();
    for (node, costs) in costs.chunks_exact_mut(input.num_labels.max(1)).enumerate() {
        let evidence = at(input.evidence, node) + params.appearance_weight * at(input.appearance, node);
        for (label, cost) in costs.iter_mut().enumerate() {
            let against = if input.objects.get(label) == Some(&true) { -evidence } else { evidence };
            *cost += to_steps(against.max(0.0));
        }
    }
    costs
}

/// Unary costs by trajectories, node by node, label by label; and the λ of each node.
fn trajectory_costs(input: &CutInput, params: &CutParams, nodes: &Nodes) -> (Vec<i32>, Vec<f32>) {
    let num_labels = input.num_labels;
    if num_labels == 0 {
        return Default::default();
    }
    let votes = count_votes(input, nodes);
    let ambiguity_factors = ambiguity_factors(input, params);
    let unary_weight = unary_weight(input, params);
    let mut costs = Vec::with_capacity(votes.len());
    let mut lambdas = Vec::with_capacity(nodes.num_nodes());
    for (node, votes) in votes.chunks_exact(num_labels).enumerate() {
        let total = votes.iter().sum::<u32>() as f32;
        let lambda = unary_weight * total.min(1.0) * ambiguity_factors.get(node).copied().unwrap_or(1.0);
        lambdas.push(lambda);
        let share = |v: u32| if total > 0.0 { v as f32 / total } else { 0.0 };
        costs.extend(votes.iter().map(|&v| to_steps(lambda * (1.0 - share(v)))));
    }
    (costs, lambdas)
}

/// Weight of trajectories; they count less beside what appearance says.
fn unary_weight(input: &CutInput, params: &CutParams) -> f32 {
    params.unary_weight * if input.appearance.is_empty() { 1.0 } else { params.appearance_unary_factor }
}

/// Counts the trajectory points of each label in each superpixel, node by node.
fn count_votes(input: &CutInput, nodes: &Nodes) -> Vec<u32> {
    let num_labels = input.num_labels;
    let mut votes = vec![0; nodes.num_nodes() * num_labels];
    for (i, &label) in input.label.iter().enumerate().take(input.tracks.len()) {
        for &node in nodes.of_point[input.tracks.points(i)].iter().filter(|&&node| node != NO_NODE) {
            if (label as usize) < num_labels {
                votes[node as usize * num_labels + label as usize] += 1;
            }
        }
    }
    votes
}

/// Factor on the λ of each superpixel, 0 if it is ambiguous; empty if the rule is off.
fn ambiguity_factors(input: &CutInput, params: &CutParams) -> Vec<f32> {
    if params.ambiguous_share >= 1.0 {
        return Vec::new();
    }
    let shares = |(t, s)| ambiguous_shares(s, input.tracks, input.label, t);
    let shares = input.superpixels.iter().enumerate().flat_map(shares);
    shares.map(|share| if share > params.ambiguous_share { 0.0 } else { 1.0 }).collect()
}

/// Adds the borders within frames (step 3).
fn add_spatial(problem: &mut Potts, input: &CutInput, params: &CutParams, nodes: &Nodes) {
    let borders = || input.superpixels.iter().flat_map(|s| &s.borders);
    let mean = (borders().map(|b| f64::from(b.length)).sum::<f64>() / borders().count().max(1) as f64) as f32;
    for (s, &base) in input.superpixels.iter().zip(&nodes.base) {
        for border in &s.borders {
            let mut cost = params.spatial_weight * libm::expf(-border.pb / params.pb_scale);
            if params.weight_by_length && mean > 0.0 {
                cost *= (border.length / mean).clamp(MIN_RELATIVE_LENGTH, MAX_RELATIVE_LENGTH);
            }
            problem.edges.push((base + border.a, base + border.b));
            problem.weights.push(to_steps(cost));
        }
    }
}

/// A superpixel of the next frame, and the number of trajectories to it.
#[derive(Debug, Clone, Copy, Default)]
struct Successor {
    to: u32,
    tracks: u32,
}

/// Adds the links between consecutive frames (step 4).
fn add_temporal(problem: &mut Potts, input: &CutInput, params: &CutParams, nodes: &Nodes) {
    let mut steps: Vec<(u32, Successor)> = Vec::new();
    for (t, pair) in input.superpixels.windows(2).enumerate() {
        steps.clear();
        for i in 0..input.tracks.len() {
            let frames = input.tracks.frames(i);
            if frames.contains(&t) && frames.contains(&(t + 1)) {
                let p = input.tracks.point(i, t);
                let (from, to) = (nodes.of_point[p], nodes.of_point[p + 1]);
                steps.push((from - nodes.base[t], Successor { to: to - nodes.base[t + 1], tracks: 1 }));
            }
        }
        for (from, link) in sum_links(&steps, pair[0].count) {
            let (p, q) = (nodes.base[t] + from, nodes.base[t + 1] + link.to);
            let larger = nodes.num_tracks[p as usize].max(nodes.num_tracks[q as usize]).max(1);
            let weight = to_steps(params.temporal_weight * link.tracks as f32 / larger as f32);
            if weight > 0 {
                problem.edges.push((p, q));
                problem.weights.push(weight);
            }
        }
    }
}

/// Adds up the links between the same two superpixels. They are ordered by superpixel, then by first occurrence.
fn sum_links(steps: &[(u32, Successor)], count: usize) -> Vec<(u32, Successor)> {
    let mut begin = vec![0_u32; count + 1];
    for &(from, _) in steps {
        begin[from as usize + 1] += 1;
    }
    for p in 0..count {
        begin[p + 1] += begin[p];
    }
    let mut next = begin.clone();
    let mut sorted = vec![Successor::default(); steps.len()];
    for &(from, link) in steps {
        sorted[next[from as usize] as usize] = link;
        next[from as usize] += 1;
    }
    let mut links: Vec<(u32, Successor)> = Vec::new();
    for p in 0..count {
        let first = links.len();
        for link in &sorted[begin[p] as usize..begin[p + 1] as usize] {
            match links[first..].iter_mut().find(|(_, sum)| sum.to == link.to) {
                Some((_, sum)) => sum.tracks += link.tracks,
                None => links.push((p as u32, *link)),
            }
        }
    }
    links
}

/// Initial labels of the expansion: the cheapest label of each superpixel. One with equal costs takes the label of the
/// neighbour of the strongest edge, ring by ring.
pub(super) fn initial_labels(problem: &Potts) -> Vec<u32> {
    let mut label = problem.cheapest();
    let num_labels = problem.num_labels.max(1);
    let has_preference = |c: &[i32]| c.iter().any(|&cost| cost != c[0]);
    let mut is_labelled: Vec<bool> = problem.unary.chunks_exact(num_labels).map(has_preference).collect();
    is_labelled.resize(problem.num_nodes, false);
    loop {
        let mut best = vec![(0, 0_u32); problem.num_nodes];
        for (&(p, q), &weight) in problem.edges.iter().zip(&problem.weights) {
            for (from, to) in [(p as usize, q as usize), (q as usize, p as usize)] {
                if is_labelled[from] && !is_labelled[to] && weight > best[to].0 {
                    best[to] = (weight, label[from]);
                }
            }
        }
        let mut is_changed = false;
        for (p, &(weight, neighbour_label)) in best.iter().enumerate() {
            if weight > 0 {
                (label[p], is_labelled[p], is_changed) = (neighbour_label, true, true);
            }
        }
        if !is_changed {
            return label;
        }
    }
}

// Ambiguous superpixels (section 4.2). Trajectories at the boundary of an object may be dragged along by it, or drag
// others; where labels change between neighbours, a superpixel's own trajectories are unreliable.

/// Share of each superpixel of frame `t` that ambiguous Delaunay triangles cover, 0 to 1.
///
/// The points of the frame with a known label are triangulated; a triangle is ambiguous unless its three labels are equal.
/// A pixel belongs to a triangle if its centre lies inside or on an edge.
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
    for corners in constrained_delaunay(&points, &[]).triangles {
        let [a, b, c] = corners.map(|corner| labels[corner as usize]);
        if a != b || a != c {
            fill(corners.map(|corner| points[corner as usize]), width, &mut covered);
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
        let (mut min_x, mut max_x) = (f64::INFINITY, f64::NEG_INFINITY);
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
                min_x = min_x.min(x);
                max_x = max_x.max(x);
            }
        }
        if max_x >= 0.0 && min_x <= max_x {
            let begin = min_x.ceil().max(0.0) as usize;
            let end = (max_x.floor() as usize + 1).min(width);
            if begin < end {
                covered[y * width + begin..y * width + end].fill(true);
            }
        }
    }
}

// Explanation of a label: the terms of the energy that one superpixel takes part in, computed again, in integer steps. All
// other superpixels keep their labels.

/// Unary cost of a label in a superpixel, in steps of 1/65536.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct UnaryCost {
    /// λ (1 − h) of the trajectories in it.
    pub trajectories: i32,
    /// Evidence against the label: by background and appearance.
    pub evidence: i32,
    /// Cost of a label that the strokes of a correction forbid.
    pub forbidden: i32,
}

/// A neighbouring superpixel, in the same frame or the next or previous one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Link {
    /// Frame.
    pub t: usize,
    /// Its number in that frame.
    pub superpixel: u32,
    /// Its label.
    pub label: u32,
    /// Cost of a different label, in steps of 1/65536.
    pub cost: i32,
    /// Common trajectories, between consecutive frames.
    pub tracks: u32,
}

/// Terms of the energy at a superpixel.
///
/// Law: the difference of [`SuperpixelTerms::cost`] of two labels is the difference of the energy of the whole clip.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SuperpixelTerms {
    /// Its label by the cut.
    pub label: u32,
    /// λ: weight of its trajectories, 0 if they do not count.
    pub lambda: f32,
    /// Weight of trajectories in this cut.
    pub unary_weight: f32,
    /// Number of its trajectories of each label.
    pub votes: Vec<u32>,
    /// All its trajectories, as indices of [`CutInput::tracks`].
    pub voters: Vec<u32>,
    /// Unary cost of each label.
    pub unary: Vec<UnaryCost>,
    /// Its neighbours.
    pub links: Vec<Link>,
}

impl SuperpixelTerms {
    /// Computes the terms of a superpixel of frame `t` under the labels `cut`.
    pub(crate) fn new(input: &CutInput, params: &CutParams, cut: &CutLabels, t: usize, superpixel: u32) -> Self {
        let nodes = Nodes::new(input);
        let node = nodes.base[t] + superpixel;
        let first = node as usize * input.num_labels;
        let costs = first..first + input.num_labels;
        let (trajectory_costs, lambda) = trajectory_costs(input, params, &nodes);
        let votes = count_votes(input, &nodes);
        let problem = energy(input, params, &nodes);
        let unary = |(&cost, &trajectories): (&i32, &i32)| UnaryCost {
            trajectories,
            evidence: cost - trajectories,
            forbidden: 0,
        };
        let unary = problem.unary[costs.clone()].iter().zip(&trajectory_costs[costs.clone()]).map(unary).collect();
        let (voters, common) = crossing(input, &nodes, node, t);
        Self {
            label: cut.labels[t][superpixel as usize],
            lambda: lambda[node as usize],
            unary_weight: unary_weight(input, params),
            votes: votes[costs].to_vec(),
            voters,
            unary,
            links: links(&problem, &nodes, cut, node, &common),
        }
    }

    /// Forbids all labels but the `legal` ones ([`super::Region::constraints`]).
    pub(crate) fn restrict(&mut self, legal: &[bool]) {
        for (cost, _) in self.unary.iter_mut().zip(legal).filter(|(_, legal)| !**legal) {
            *cost = UnaryCost { forbidden: MAX_WEIGHT, ..UnaryCost::default() };
        }
    }

    /// Returns the cost of `label` here, unary and by the links that it would cut, in steps of 1/65536.
    pub(crate) fn cost(&self, label: u32) -> i64 {
        let unary = self.unary[label as usize];
        let cut = self.links.iter().filter(|link| link.label != label).map(|link| i64::from(link.cost));
        let unary = [unary.trajectories, unary.evidence, unary.forbidden];
        unary.into_iter().map(i64::from).chain(cut).sum()
    }

    /// Returns the cheapest label among `candidates` and its cost above the current label's.
    pub(crate) fn runner_up(&self, is_candidate: impl Fn(u32) -> bool) -> Option<(u32, i64)> {
        let labels = (0..self.unary.len() as u32).filter(|&label| label != self.label && is_candidate(label));
        labels.map(|label| (label, self.cost(label) - self.cost(self.label))).min_by_key(|&(_, margin)| margin)
    }

    /// Returns the number of further trajectories of `label` that would lower its cost to the current label's, all else
    /// equal; `None` if no number would.
    pub(crate) fn votes_to_flip(&self, label: u32) -> Option<u32> {
        let (current, target) = (self.unary[self.label as usize], self.unary[label as usize]);
        let rest = (self.cost(label) - i64::from(target.trajectories))
            - (self.cost(self.label) - i64::from(current.trajectories));
        let units = |steps: i64| steps as f64 / f64::from(STEPS_PER_UNIT) / f64::from(self.unary_weight);
        let total = self.votes.iter().sum::<u32>() as f64;
        let lead = units(i64::from(target.trajectories) - i64::from(current.trajectories)) * total;
        // With n more of them the costs differ by (lead − n) / (total + n), which is above −1.
        let needed = (lead + units(rest) * total) / (1.0 - units(rest));
        let is_ambiguous = self.lambda == 0.0 && total > 0.0;
        (!is_ambiguous && units(rest) < 1.0).then(|| needed.ceil().max(1.0) as u32)
    }
}

/// Returns the trajectories in `node` of frame `t`, and the nodes that they come from and go to.
fn crossing(input: &CutInput, nodes: &Nodes, node: u32, t: usize) -> (Vec<u32>, Vec<u32>) {
    let (mut voters, mut common) = (Vec::new(), Vec::new());
    for i in (0..input.tracks.len()).filter(|&i| input.tracks.frames(i).contains(&t)) {
        let (point, points) = (input.tracks.point(i, t), input.tracks.points(i));
        if nodes.of_point[point] == node {
            voters.push(i as u32);
            // In the previous, this and the next frame.
            common.extend_from_slice(
                &nodes.of_point[points.start.max(point.saturating_sub(1))..points.end.min(point + 2)],
            );
        }
    }
    (voters, common)
}

/// Links of `node` to its neighbours.
fn links(problem: &Potts, nodes: &Nodes, cut: &CutLabels, node: u32, common: &[u32]) -> Vec<Link> {
    let mut links = Vec::new();
    for (&(p, q), &cost) in problem.edges.iter().zip(&problem.weights) {
        if p == node || q == node {
            let neighbour = if p == node { q } else { p };
            let t = nodes.base.partition_point(|&base| base <= neighbour) - 1;
            let superpixel = neighbour - nodes.base[t];
            let tracks = common.iter().filter(|&&c| c == neighbour).count() as u32;
            links.push(Link { t, superpixel, label: cut.labels[t][superpixel as usize], cost, tracks });
        }
    }
    links
}

/// Margin of each superpixel's label: the least cost of a label of another kind above the current one's, all other
/// superpixels fixed. In units of cost, frame by frame; `kind` has one for each label.
pub(crate) fn margins(input: &CutInput, params: &CutParams, cut: &CutLabels, kind: &[u8]) -> Vec<f32> {
    margins_of(&energy(input, params, &Nodes::new(input)), &cut.labels.concat(), kind)
}

/// As [`margins`], from the energy and the label of each node.
pub(super) fn margins_of(problem: &Potts, label: &[u32], kind: &[u8]) -> Vec<f32> {
    let num_labels = problem.num_labels;
    let mut costs = problem.unary.clone();
    for (&(p, q), &weight) in problem.edges.iter().zip(&problem.weights) {
        for (node, neighbour) in [(p, q), (q, p)] {
            costs[node as usize * num_labels + label[neighbour as usize] as usize] -= weight;
        }
    }
    let margin = |(costs, &label): (&[i32], &u32)| {
        let is_other_kind = |l: &usize| kind.get(*l) != kind.get(label as usize);
        let best = (0..costs.len()).filter(is_other_kind).map(|l| costs[l]).min();
        best.map_or(f32::INFINITY, |best| (best - costs[label as usize]) as f32 / STEPS_PER_UNIT as f32)
    };
    costs.chunks_exact(num_labels.max(1)).zip(label).map(margin).collect()
}
