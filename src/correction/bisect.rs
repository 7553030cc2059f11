//! Bisection of an object along the least normalised cut of its own graph.
//!
//! 1. The leading eigenvectors of the graph of its trajectories; beyond the trivial one they change fastest where the graph
//!    is weakest (Shi and Malik, "Normalized cuts and image segmentation", PAMI 2000).
//! 2. The trajectories sorted by each eigenvector, cut where `cut(A, B) · (1 / vol A + 1 / vol B)` is least.
//! 3. The best cut over all eigenvectors. If the trajectories come in groups (clusters), whole groups are sorted, by their
//!    means.
//!
//! Trajectories without neighbours go to the larger half. It fails where no cut of the graph follows the object's parts: a
//! rigid object of even density is split anywhere.

use crate::discretize::rotate;
use crate::embedding::{Embedding, EmbeddingParams, embed};
use crate::order;
use crate::sparse::SymCsr;

// All chosen by eye.
/// Number of eigenvectors tried: the second is nearly always the best, unless the graph has several components.
const NUM_EIGENVECTORS: u32 = 4;
/// Number of parts of the background from which a point chooses one.
const NUM_BACKGROUND_PARTS: u32 = 8;
/// Least number of trajectories of a half.
const MIN_HALF: usize = 3;
/// Least share of all trajectories in a half: one in this many.
const MIN_HALF_DENOMINATOR: usize = 50;
/// Components of fewer than one in this many trajectories are not embedded.
const MIN_COMPONENT_DENOMINATOR: usize = 20;

/// Bisects a graph. Returns the nodes of one half (without groups, the smaller one); `None` if there are too few. Nodes of the
/// same `group` stay together.
pub(crate) fn bisect(graph: &SymCsr, group: Option<&[u32]>, seed: u32) -> Option<Vec<bool>> {
    let n = graph.len();
    let min_size = MIN_HALF.max(n / MIN_HALF_DENOMINATOR);
    if let Some(group) = group.filter(|g| is_pair(g)) {
        return Some(group.iter().map(|&g| g != group[0]).collect());
    }
    if n < 2 * MIN_HALF {
        return None;
    }
    let params = EmbeddingParams {
        min_dimensions: NUM_EIGENVECTORS,
        max_dimensions: NUM_EIGENVECTORS,
        min_component: MIN_HALF.max(n / MIN_COMPONENT_DENOMINATOR) as u32,
        ..EmbeddingParams::default()
    };
    let embedding = embed(graph, &params, seed);
    let mut best: Option<(f64, Vec<bool>)> = None;
    for c in 0..embedding.dimensions {
        // Groups may be of any size.
        let min_size = if group.is_some() { 1 } else { min_size };
        if let Some(cut) = least_cut(graph, &sorted_groups(&embedding, c, group), min_size)
            && best.as_ref().is_none_or(|best| cut.0 < best.0)
        {
            best = Some(cut);
        }
    }
    best.map(|(_, half)| half)
}

/// Divides a graph into parts and returns the nodes in the part of one node; `None` if there are too few.
pub(crate) fn part_containing(graph: &SymCsr, node: usize, seed: u32) -> Option<Vec<bool>> {
    let n = graph.len();
    let params = EmbeddingParams {
        min_dimensions: NUM_BACKGROUND_PARTS,
        max_dimensions: NUM_BACKGROUND_PARTS,
        min_component: MIN_HALF.max(n / MIN_HALF_DENOMINATOR) as u32,
        ..EmbeddingParams::default()
    };
    if n < 2 * MIN_HALF {
        return None;
    }
    let embedding = embed(graph, &params, seed);
    let part = rotate(&embedding, embedding.dimensions);
    let node_part = *part.get(node)?;
    // A node without neighbours is a part of its own.
    let is_inside = |i: usize| i == node || (embedding.embedded[node] && part[i] == node_part);
    Some((0..n).map(is_inside).collect())
}

/// Returns whether there are exactly two groups.
fn is_pair(group: &[u32]) -> bool {
    let Some(second) = group.iter().find(|&&g| g != group[0]) else { return false };
    group.iter().all(|g| g == &group[0] || g == second)
}

/// Step 2: returns lists of nodes that stay together, sorted by their mean in eigenvector `c`. Nodes that are not embedded are
/// left out, unless their group is embedded.
fn sorted_groups(embedding: &Embedding, c: usize, group: Option<&[u32]>) -> Vec<Vec<u32>> {
    let embedded = |i: &u32| embedding.embedded[*i as usize];
    let nodes = 0..embedding.num_rows as u32;
    let mut lists: Vec<Vec<u32>> = match group {
        None => nodes.filter(embedded).map(|i| vec![i]).collect(),
        Some(group) => {
            let mut sorted: Vec<u32> = nodes.collect();
            order::sort_by_key(&mut sorted, |&i| order::pair_key(group[i as usize], i));
            sorted.chunk_by(|&a, &b| group[a as usize] == group[b as usize]).map(<[u32]>::to_vec).collect()
        }
    };
    let mean = |list: &Vec<u32>| {
        let (sum, count) = list
            .iter()
            .filter(|i| embedded(i))
            .fold((0.0, 0_u32), |(sum, count), &i| (sum + embedding.row(i as usize)[c], count + 1));
        sum / f64::from(count.max(1))
    };
    order::sort_by_key(&mut lists, |list| order::f64_key(mean(list)));
    lists
}

/// Returns the cost of the least normalised cut of sorted lists, and the nodes of the smaller side. Both sides have at least
/// `min_size` nodes.
fn least_cut(graph: &SymCsr, lists: &[Vec<u32>], min_size: usize) -> Option<(f64, Vec<bool>)> {
    let degrees = graph.degrees();
    let nodes: usize = lists.iter().map(Vec::len).sum();
    let total: f64 = lists.iter().flatten().map(|&i| degrees[i as usize]).sum();
    let mut before = vec![false; graph.len()];
    let (mut count, mut cut, mut volume) = (0, 0.0, 0.0);
    let mut best: Option<(f64, usize)> = None;
    for (k, list) in lists.iter().enumerate() {
        for &i in list {
            let inside: f64 = graph.row(i as usize).filter(|&(j, _)| before[j]).map(|e| e.1).sum();
            cut += degrees[i as usize] - 2.0 * inside;
            volume += degrees[i as usize];
            before[i as usize] = true;
        }
        count += list.len();
        if count >= min_size && nodes - count >= min_size {
            let cost = cut.max(0.0) * (1.0 / volume + 1.0 / (total - volume));
            if best.is_none_or(|(best_cost, _)| cost < best_cost) {
                best = Some((cost, k));
            }
        }
    }
    let (cost, last) = best?;
    let (first, second) = lists.split_at(last + 1);
    let size = |lists: &[Vec<u32>]| lists.iter().map(Vec::len).sum::<usize>();
    // Nodes in no list go to the larger half.
    let mut half = vec![false; graph.len()];
    for &i in (if size(first) < size(second) { first } else { second }).iter().flatten() {
        half[i as usize] = true;
    }
    Some((cost, half))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cliques of these sizes, joined by one weak edge.
    fn dumbbell(a: u32, b: u32) -> SymCsr {
        let mut upper = Vec::new();
        for (from, to) in [(0, a), (a, a + b)] {
            upper.extend((from..to).flat_map(|i| (i + 1..to).map(move |j| (i, j, 1.0))));
        }
        upper.push((0, a, 0.1));
        SymCsr::from_upper((a + b) as usize, &upper)
    }

    #[test]
    fn graphs_are_cut_at_their_weakest_edge_and_the_smaller_half_is_returned() {
        for (a, b) in [(12, 8), (5, 30)] {
            let expected: Vec<bool> = (0..a + b).map(|i| (i < a) == (a < b)).collect();
            assert_eq!(bisect(&dumbbell(a, b), None, 7).unwrap(), expected);
        }
    }

    #[test]
    fn components_are_halves_and_isolated_nodes_go_to_the_larger_one() {
        let mut upper = Vec::new();
        for (from, to) in [(0, 10), (10, 18)] {
            upper.extend((from..to).flat_map(|i| (i + 1..to).map(move |j| (i, j, 1.0))));
        }
        let half = bisect(&SymCsr::from_upper(19, &upper), None, 7).unwrap();
        let expected: Vec<bool> = (0..19).map(|i| (10..18).contains(&i)).collect();
        assert_eq!(half, expected);
    }

    #[test]
    fn groups_stay_whole() {
        let two = [3, 3, 9, 9, 3];
        assert_eq!(bisect(&SymCsr::from_upper(5, &[]), Some(&two), 0).unwrap(), [false, false, true, true, false]);
        // The weak edge is between nodes 0 and 12; three groups, of which two lie in the first clique.
        let group: Vec<u32> = (0..20).map(|i| if i < 6 { 5 } else { u32::from(i >= 12) }).collect();
        let expected: Vec<bool> = (0..20).map(|i| i >= 12).collect();
        assert_eq!(bisect(&dumbbell(12, 8), Some(&group), 7).unwrap(), expected);
    }

    #[test]
    fn a_handful_of_trajectories_has_no_halves() {
        assert_eq!(bisect(&SymCsr::from_upper(5, &[(0, 1, 1.0)]), None, 0), None);
        assert_eq!(bisect(&SymCsr::default(), None, 0), None);
        assert_eq!(bisect(&SymCsr::from_upper(50, &[]), None, 0), None);
    }
}
