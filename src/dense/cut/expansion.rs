//! Energy minimization by alpha-expansion.
//!
//! In: [`Potts`], an energy over the labels of nodes, `E(f) = Σ_p unary(p, f_p) + Σ_pq weight_pq [f_p ≠ f_q]`. Out: a
//! label for each node. A move offers one label α to all nodes and finds the best set to take it by a minimum cut
//! (Boykov, Veksler and Zabih, "Fast approximate energy minimization via graph cuts", PAMI 2001). Moves cycle through the
//! labels until a whole cycle has no gain: then the energy exceeds the least one by at most the pairwise part of that. Two
//! labels need one cut only, and the result is the optimum. [`minimize`] does so for each connected part of the graph with the
//! labels that can be the best there, often two.
//!
//! All moves share one [`Network`]. The source's side keeps its labels and the sink's side takes α; an edge between two
//! nodes without α has the capacities
//!
//! ```text
//! f_p = f_q:  w in both directions                     (cut if one of them takes α)
//! f_p ≠ f_q:  w for keeping p, and w from q to p       (free only if both take α)
//! ```
//!
//! and an edge to a node that has α already costs `w` for keeping. Cost: a minimum cut for each move, near linear in
//! practice.

use super::maxflow::Network;
use crate::sets::DisjointSets;

/// A Potts energy in whole numbers.
///
/// Law: `unary.len() == num_nodes * num_labels`, node by node; `weights.len() == edges.len()`; ends of edges are
/// different nodes; `0 <= weight <= MAX_WEIGHT`, and unary costs lie in the same range.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Potts {
    /// Number of nodes.
    pub num_nodes: usize,
    /// Number of labels.
    pub num_labels: usize,
    /// Cost of each label at each node.
    pub unary: Vec<i32>,
    /// Pairs of neighbouring nodes.
    pub edges: Vec<(u32, u32)>,
    /// Cost of different labels at the ends of each edge.
    pub weights: Vec<i32>,
}

/// Largest cost: capacities of an arc and its sister add up below `i32::MAX`.
pub(super) const MAX_WEIGHT: i32 = 1 << 29;
/// Integer steps in a unit of cost: fine enough for any weight, and sums over a clip stay far below 2^63.
pub(crate) const STEPS_PER_UNIT: i32 = 1 << 16;

/// Rounds a cost to steps.
pub(crate) fn to_steps(cost: f32) -> i32 {
    ((cost * STEPS_PER_UNIT as f32 + 0.5) as i32).clamp(0, MAX_WEIGHT)
}

impl Potts {
    /// Computes the energy of `label`.
    pub fn energy(&self, label: &[u32]) -> i64 {
        let unary: i64 = (0..self.num_nodes).map(|p| self.cost(p, label[p])).sum();
        let pairs = self.edges.iter().zip(&self.weights);
        let cut = pairs.filter(|((p, q), _)| label[*p as usize] != label[*q as usize]).map(|(_, &w)| i64::from(w));
        unary + cut.sum::<i64>()
    }

    /// Returns the label of least unary cost of each node, the lowest of equals.
    pub fn cheapest(&self) -> Vec<u32> {
        let costs = self.unary.chunks_exact(self.num_labels.max(1));
        let best = |c: &[i32]| (0..c.len()).min_by_key(|&l| c[l]).unwrap_or(0) as u32;
        let mut label: Vec<u32> = costs.map(best).collect();
        label.resize(self.num_nodes, 0);
        label
    }

    fn cost(&self, p: usize, label: u32) -> i64 {
        self.unary.get(p * self.num_labels + label as usize).map_or(0, |&c| i64::from(c))
    }

    /// Splits off parts: `part_of` has a part or [`NO_PART`] for each node, and `labels` the labels of each part. Nodes keep their
    /// order; edges between parts are left out.
    pub(super) fn split(&self, part_of: &[u32], labels: &[Vec<u32>]) -> Vec<Self> {
        let mut parts: Vec<Self> =
            labels.iter().map(|labels| Self { num_labels: labels.len(), ..Self::default() }).collect();
        let mut index = vec![0; self.num_nodes];
        for (p, &k) in part_of.iter().enumerate().filter(|&(_, &k)| k != NO_PART) {
            let part = &mut parts[k as usize];
            index[p] = part.num_nodes as u32;
            part.num_nodes += 1;
            let costs = &self.unary[p * self.num_labels..];
            part.unary.extend(labels[k as usize].iter().map(|&l| costs[l as usize]));
        }
        for (&(p, q), &weight) in self.edges.iter().zip(&self.weights) {
            let (p, q) = (p as usize, q as usize);
            if part_of[p] == part_of[q] && part_of[p] != NO_PART {
                let part = &mut parts[part_of[p] as usize];
                part.edges.push((index[p], index[q]));
                part.weights.push(weight);
            }
        }
        parts
    }

    /// Returns the sum of the weights of each node's edges.
    fn edge_costs(&self) -> Vec<i64> {
        let mut costs = vec![0; self.num_nodes];
        for (&(p, q), &weight) in self.edges.iter().zip(&self.weights) {
            costs[p as usize] += i64::from(weight);
            costs[q as usize] += i64::from(weight);
        }
        costs
    }
}

/// No part: [`Potts::split`] leaves the node out.
pub(super) const NO_PART: u32 = u32::MAX;

/// Minimizes an energy from the labels `initial`, each connected part of the graph by itself, with the labels that can be the best
/// of some node there: any other costs more than the cheapest and all edges together.
pub(crate) fn minimize(problem: &Potts, initial: &[u32]) -> Vec<u32> {
    let mut sets = DisjointSets::new(problem.num_nodes);
    for (&(p, q), _) in problem.edges.iter().zip(&problem.weights).filter(|&(_, &weight)| weight > 0) {
        sets.join(p as usize, q as usize);
    }
    let (mut part_of, mut is_useful) = (vec![NO_PART; problem.num_nodes], Vec::<Vec<bool>>::new());
    for (p, edge_cost) in problem.edge_costs().into_iter().enumerate() {
        // The smallest node of each part comes first.
        let root = sets.root(p);
        if root == p {
            part_of[p] = is_useful.len() as u32;
            is_useful.push(vec![false; problem.num_labels]);
        }
        part_of[p] = part_of[root];
        let costs = &problem.unary[p * problem.num_labels..][..problem.num_labels];
        let limit = costs.iter().copied().min().map_or(0, i64::from) + edge_cost;
        let is_useful = is_useful[part_of[p] as usize].iter_mut().zip(costs);
        is_useful.for_each(|(is_useful, &cost)| *is_useful |= i64::from(cost) <= limit);
    }
    let useful =
        |is_useful: Vec<bool>| (0..).zip(is_useful).filter(|&(_, is_useful)| is_useful).map(|(l, _)| l).collect();
    let labels: Vec<Vec<u32>> = is_useful.into_iter().map(useful).collect();
    let mut starts = vec![Vec::new(); labels.len()];
    for (&k, l) in part_of.iter().zip(initial) {
        starts[k as usize].push(labels[k as usize].binary_search(l).unwrap_or(0) as u32);
    }
    let parts = problem.split(&part_of, &labels).into_iter().zip(starts);
    let mut minimized: Vec<_> = parts.map(|(part, start)| Expansion::new(part, start).finish().into_iter()).collect();
    let label = |&k: &u32| minimized[k as usize].next().map_or(0, |l| labels[k as usize][l as usize]);
    part_of.iter().map(label).collect()
}

/// Alpha-expansion, one move a step.
#[derive(Debug, Clone)]
pub struct Expansion {
    problem: Potts,
    network: Network,
    label: Vec<u32>,
    /// Moves made.
    moves: u32,
    /// Moves since the last gain, that one included.
    moves_since_gain: usize,
}

impl Expansion {
    /// Starts from the labels `initial`, one below `num_labels` for each node. With two labels the start does not matter.
    pub fn new(problem: Potts, initial: Vec<u32>) -> Self {
        let network = Network::new(problem.num_nodes, &problem.edges);
        let mut expansion = Self { network, label: Vec::new(), moves: 0, moves_since_gain: 0, problem };
        expansion.restart(initial);
        expansion
    }

    fn restart(&mut self, initial: Vec<u32>) {
        (self.label, self.moves, self.moves_since_gain) = (initial, 0, 0);
        match self.problem.num_labels {
            0 | 1 => self.moves_since_gain = 1,
            // With one label everywhere, offering the other decides between all labellings.
            2 => self.label.fill(0),
            _ => {}
        }
    }

    /// Restarts with other unary costs and the same edges, from the labels of `initial`.
    pub(crate) fn restart_with(&mut self, unary: Vec<i32>, initial: impl FnOnce(&Potts) -> Vec<u32>) {
        self.problem.unary = unary;
        self.restart(initial(&self.problem));
    }

    /// Returns `true` when no move can lower the energy.
    pub fn is_finished(&self) -> bool {
        self.moves_since_gain >= self.problem.num_labels
    }

    /// Returns the moves made so far, and their total if none of the remaining ones gains anything.
    pub fn progress(&self) -> (u32, u32) {
        let remaining = self.problem.num_labels.saturating_sub(self.moves_since_gain) as u32;
        (self.moves, self.moves + remaining)
    }

    /// Offers the next label to all nodes. Returns the decrease of the energy.
    pub fn step(&mut self) -> i64 {
        if self.is_finished() {
            return 0;
        }
        let is_binary = self.problem.num_labels == 2;
        let alpha = if is_binary { 1 } else { self.moves % self.problem.num_labels as u32 };
        let gain = self.expand(alpha);
        self.moves += 1;
        self.moves_since_gain = match (is_binary, gain > 0) {
            (true, _) => 2,
            (false, true) => 1,
            (false, false) => self.moves_since_gain + 1,
        };
        gain
    }

    /// Returns the number of moves from the start if none but the first gains anything.
    pub(super) fn min_moves(&self) -> usize {
        match self.problem.num_labels {
            0 | 1 => 0,
            2 => 1,
            labels => labels,
        }
    }

    /// Makes the remaining moves and returns the labels.
    pub fn finish(mut self) -> Vec<u32> {
        while !self.is_finished() {
            self.step();
        }
        self.label
    }

    pub(super) fn problem(&self) -> &Potts {
        &self.problem
    }

    /// Returns the current labels.
    pub fn labels(&self) -> &[u32] {
        &self.label
    }

    fn expand(&mut self, alpha: u32) -> i64 {
        let keep = self.set_edges(alpha);
        // Cost of keeping all labels, above the minimum over each node.
        let mut current = 0;
        for (p, &keep) in keep.iter().enumerate() {
            let excess = if self.label[p] == alpha { 0 } else { self.problem.cost(p, alpha) - keep };
            current += (-excess).max(0);
            self.network.set_terminal(p, excess);
        }
        let gain = current - self.network.solve();
        if gain > 0 {
            for (p, label) in self.label.iter_mut().enumerate() {
                if self.network.is_on_sink_side(p) {
                    *label = alpha;
                }
            }
        }
        gain
    }

    /// Sets the capacities of all edges. Returns each node's cost of keeping its label.
    fn set_edges(&mut self, alpha: u32) -> Vec<i64> {
        let mut keep: Vec<i64> = self.label.iter().enumerate().map(|(p, &l)| self.problem.cost(p, l)).collect();
        for (e, (&(p, q), &w)) in self.problem.edges.iter().zip(&self.problem.weights).enumerate() {
            let (p, q) = (p as usize, q as usize);
            let (label_p, label_q) = (self.label[p], self.label[q]);
            let (forward, backward) = match (label_p == alpha, label_q == alpha) {
                (false, false) if label_p == label_q => (w, w),
                (false, false) => {
                    keep[p] += i64::from(w);
                    (0, w)
                }
                (true, true) => (0, 0),
                (first_has, _) => {
                    keep[if first_has { q } else { p }] += i64::from(w);
                    (0, 0)
                }
            };
            self.network.set_edge(e, forward, backward);
        }
        keep
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// A problem with `num_edges` random edges, some of them several times, costs in `0..100`.
    fn random_problem(rng: &mut Rng, num_nodes: usize, num_labels: usize, num_edges: usize) -> Potts {
        let unary = (0..num_nodes * num_labels).map(|_| rng.below(100) as i32).collect();
        let edges: Vec<_> = (0..num_edges)
            .map(|_| {
                let p = rng.below(num_nodes);
                (p as u32, ((p + 1 + rng.below(num_nodes - 1)) % num_nodes) as u32)
            })
            .collect();
        let weights = (0..num_edges).map(|_| rng.below(60) as i32).collect();
        Potts { num_nodes, num_labels, unary, edges, weights }
    }

    /// The labelling of least energy of all there are.
    fn best_of_all(problem: &Potts) -> Vec<u32> {
        let base = problem.num_labels;
        let labelling = |mut code: usize| -> Vec<u32> {
            (0..problem.num_nodes).map(|_| (code % base, code /= base).0 as u32).collect()
        };
        (0..base.pow(problem.num_nodes as u32)).map(labelling).min_by_key(|l| problem.energy(l)).unwrap()
    }

    #[test]
    fn two_labels_give_the_optimum() {
        let mut rng = Rng::for_stage(1, "expansion");
        for _ in 0..200 {
            let n = 2 + rng.below(9);
            let edges = rng.below(3 * n);
            let problem = random_problem(&mut rng, n, 2, edges);
            let best = problem.energy(&best_of_all(&problem));
            assert_eq!(problem.energy(&Expansion::new(problem.clone(), vec![1; n]).finish()), best);
        }
    }

    #[test]
    fn more_labels_stay_within_the_bound_and_nearly_always_give_the_optimum() {
        let mut rng = Rng::for_stage(2, "expansion");
        let mut optimal = 0;
        for _ in 0..200 {
            let (n, labels) = (2 + rng.below(5), 3 + rng.below(2));
            let edges = rng.below(3 * n);
            let problem = random_problem(&mut rng, n, labels, edges);
            let best = best_of_all(&problem);
            let least = problem.energy(&best);
            let energy = problem.energy(&Expansion::new(problem.clone(), problem.cheapest()).finish());
            let pairwise = least - (0..n).map(|p| problem.cost(p, best[p])).sum::<i64>();
            assert!(energy <= least + pairwise, "{energy} above the bound of {least} + {pairwise}");
            optimal += usize::from(energy == least);
        }
        assert!(optimal >= 195, "{optimal} of 200 are optimal");
    }

    #[test]
    fn every_move_lowers_the_energy_by_what_it_says() {
        let mut rng = Rng::for_stage(3, "expansion");
        for labels in 2..7 {
            let problem = random_problem(&mut rng, 300, labels, 1500);
            let mut expansion = Expansion::new(problem.clone(), problem.cheapest());
            let mut energy = problem.energy(expansion.labels());
            while !expansion.is_finished() {
                let (done, total) = expansion.progress();
                assert!(done < total);
                let gain = expansion.step();
                assert!(gain >= 0);
                energy -= gain;
                assert_eq!(problem.energy(expansion.labels()), energy);
            }
            let (done, total) = expansion.progress();
            assert_eq!(done, total);
            assert!(labels == 2 || energy < problem.energy(&problem.cheapest()), "{labels} labels: nothing gained");
        }
    }

    #[test]
    fn no_single_move_improves_a_finished_labelling() {
        let mut rng = Rng::for_stage(4, "expansion");
        for _ in 0..50 {
            let problem = random_problem(&mut rng, 8, 4, 16);
            let label = Expansion::new(problem.clone(), vec![3; 8]).finish();
            let energy = problem.energy(&label);
            for alpha in 0..4 {
                for takers in 0..1_u32 << 8 {
                    let moved: Vec<u32> = (0..8).map(|p| if takers >> p & 1 == 1 { alpha } else { label[p] }).collect();
                    assert!(problem.energy(&moved) >= energy);
                }
            }
        }
    }

    #[test]
    fn parts_with_two_useful_labels_get_the_optimum_and_others_no_more_energy_than_by_moves_of_all() {
        let mut rng = Rng::for_stage(5, "expansion");
        let mut is_lower = 0;
        for round in 0..100 {
            let mut problem = random_problem(&mut rng, 9, 3, 12);
            if round % 2 == 0 {
                // Nodes 0 to 4 and 5 to 8 are parts of their own, each without one of the labels.
                let part = |p: u32| u32::from(p > 4);
                (problem.edges, problem.weights) =
                    problem.edges.iter().zip(&problem.weights).filter(|((p, q), _)| part(*p) == part(*q)).unzip();
                (0..9).for_each(|p| problem.unary[3 * p + 1 + usize::from(p > 4)] = MAX_WEIGHT);
            }
            let initial = problem.cheapest();
            let label = minimize(&problem, &initial);
            let energy = problem.energy(&label);
            let of_all = problem.energy(&Expansion::new(problem.clone(), initial).finish());
            if round % 2 == 0 {
                assert_eq!(energy, problem.energy(&best_of_all(&problem)));
                assert!(energy <= of_all);
            } else {
                is_lower += i32::from(energy < of_all) - i32::from(energy > of_all);
            }
        }
        assert!(is_lower >= 0, "{is_lower}");
        assert!(minimize(&Potts::default(), &[]).is_empty());
    }

    #[test]
    fn ties_go_to_the_first_label_and_nothing_at_all_is_a_problem_too() {
        let tie = Potts { num_nodes: 2, num_labels: 2, unary: vec![5; 4], edges: vec![(0, 1)], weights: vec![9] };
        assert_eq!(Expansion::new(tie, vec![1, 1]).finish(), [0, 0]);
        let single = Potts { num_nodes: 3, num_labels: 1, unary: vec![1, 2, 3], ..Potts::default() };
        assert_eq!(Expansion::new(single.clone(), single.cheapest()).finish(), [0, 0, 0]);
        let unlabelled = Potts { num_nodes: 2, ..Potts::default() };
        assert_eq!(Expansion::new(unlabelled.clone(), unlabelled.cheapest()).finish(), [0, 0]);
        assert!(Expansion::new(Potts::default(), Vec::new()).finish().is_empty());
    }
}
