//! Why a superpixel has its label: the terms of the energy that this superpixel takes part in, made again.
//!
//! Terms are whole numbers of steps, as the solver has them. All other superpixels keep their labels: what a label
//! costs here is its own cost and what the links to superpixels of other labels cost.

use super::expansion::{MAX_WEIGHT, Potts, SCALE};
use super::input::{CutInput, CutLabels};
use super::params::CutParams;
use super::terms::{Nodes, energy, heard, votes};

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
            self.votes.iter().sum::<u32>() as f64 + f64::from(params.stranger_weight) * f64::from(self.strangers);
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
