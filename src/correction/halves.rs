//! Parting what is one thing: the weakest place of its own graph.
//!
//! 1. The leading eigenvectors of the graph of these trajectories alone; beyond the trivial one they change fastest
//!    where the graph is weakest (Shi and Malik, "Normalized cuts and image segmentation", PAMI 2000).
//! 2. The trajectories in the order of each eigenvector; where to cut that order is where the normalised cut is least,
//!    `cut(A, B) · (1 / vol A + 1 / vol B)`.
//! 3. The best of all eigenvectors. Where the trajectories come in groups (clusters), whole groups are put in order, by
//!    their means.
//!
//! Trajectories without neighbours go with the larger half.

use crate::discretize::rotate;
use crate::embedding::{Embedding, EmbeddingParams, embed};
use crate::order;
use crate::sparse::SymCsr;

/// Eigenvectors looked at: the second is nearly always the one, unless the graph falls apart into several pieces.
const EIGENVECTORS: u32 = 4;

/// Into how many parts the background comes where a point is to choose one.
const PARTS: u32 = 8;

/// Least trajectories of a half, and least share of all of them: strays are no parts.
const LEAST_PART: usize = 3;
const LEAST_SHARE: usize = 50;

/// Pieces of fewer trajectories than one in this many say nothing of where the rest is to be parted.
const LEAST_PIECE: usize = 20;

/// Which nodes are in the one half (without groups, the smaller); `None` where there are not enough of them. `group` of
/// each node: those of a group stay together.
pub(crate) fn halves(graph: &SymCsr, group: Option<&[u32]>, seed: u32) -> Option<Vec<bool>> {
    let n = graph.len();
    let least = LEAST_PART.max(n / LEAST_SHARE);
    if let Some(group) = group.filter(|g| is_pair(g)) {
        return Some(group.iter().map(|&g| g != group[0]).collect());
    }
    if n < 2 * LEAST_PART {
        return None;
    }
    let params = EmbeddingParams {
        min_dimensions: EIGENVECTORS,
        max_dimensions: EIGENVECTORS,
        min_component: LEAST_PART.max(n / LEAST_PIECE) as u32,
        ..EmbeddingParams::default()
    };
    let embedding = embed(graph, &params, seed);
    let mut best: Option<(f64, Vec<bool>)> = None;
    for c in 0..embedding.dimensions {
        // Whole groups, however small they are.
        let least = if group.is_some() { 1 } else { least };
        if let Some(found) = cut_in_order(graph, &in_order(&embedding, c, group), least)
            && best.as_ref().is_none_or(|known| found.0 < known.0)
        {
            best = Some(found);
        }
    }
    best.map(|(_, half)| half)
}

/// The part of the graph that node `at` is in, when it is parted in as many places as its leading eigenvectors speak
/// of; `None` where there are not enough nodes.
pub(crate) fn part_at(graph: &SymCsr, at: usize, seed: u32) -> Option<Vec<bool>> {
    let n = graph.len();
    let params = EmbeddingParams {
        min_dimensions: PARTS,
        max_dimensions: PARTS,
        min_component: LEAST_PART.max(n / LEAST_SHARE) as u32,
        ..EmbeddingParams::default()
    };
    if n < 2 * LEAST_PART {
        return None;
    }
    let embedding = embed(graph, &params, seed);
    let part = rotate(&embedding, embedding.dimensions);
    let own = *part.get(at)?;
    // A node without neighbours is a part of its own.
    let inside = |i: usize| i == at || (embedding.embedded[at] && part[i] == own);
    Some((0..n).map(inside).collect())
}

/// Whether there are exactly two groups.
fn is_pair(group: &[u32]) -> bool {
    let Some(other) = group.iter().find(|&&g| g != group[0]) else { return false };
    group.iter().all(|g| g == &group[0] || g == other)
}

/// Step 2's order: lists of nodes that stay together, by their mean in eigenvector `c`. A node that is not embedded is
/// in none, unless its group is.
fn in_order(embedding: &Embedding, c: usize, group: Option<&[u32]>) -> Vec<Vec<u32>> {
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

/// The least normalised cut of an order, and who comes after it. Both sides have at least `least` nodes.
fn cut_in_order(graph: &SymCsr, lists: &[Vec<u32>], least: usize) -> Option<(f64, Vec<bool>)> {
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
        if count >= least && nodes - count >= least {
            let cost = cut.max(0.0) * (1.0 / volume + 1.0 / (total - volume));
            if best.is_none_or(|(known, _)| cost < known) {
                best = Some((cost, k));
            }
        }
    }
    let (cost, last) = best?;
    let (first, second) = lists.split_at(last + 1);
    let size = |lists: &[Vec<u32>]| lists.iter().map(Vec::len).sum::<usize>();
    // Who is in no list is with the larger half.
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
    fn the_weakest_place_parts_and_the_smaller_half_is_named() {
        for (a, b) in [(12, 8), (5, 30)] {
            let expected: Vec<bool> = (0..a + b).map(|i| (i < a) == (a < b)).collect();
            assert_eq!(halves(&dumbbell(a, b), None, 7).unwrap(), expected);
        }
    }

    #[test]
    fn pieces_that_nothing_joins_are_halves_and_strays_go_with_the_larger() {
        let mut upper = Vec::new();
        for (from, to) in [(0, 10), (10, 18)] {
            upper.extend((from..to).flat_map(|i| (i + 1..to).map(move |j| (i, j, 1.0))));
        }
        let half = halves(&SymCsr::from_upper(19, &upper), None, 7).unwrap();
        let expected: Vec<bool> = (0..19).map(|i| (10..18).contains(&i)).collect();
        assert_eq!(half, expected);
    }

    #[test]
    fn groups_stay_whole() {
        let two = [3, 3, 9, 9, 3];
        assert_eq!(halves(&SymCsr::from_upper(5, &[]), Some(&two), 0).unwrap(), [false, false, true, true, false]);
        // The weak edge is between nodes 0 and 12; three groups, of which two lie in the first clique.
        let group: Vec<u32> = (0..20).map(|i| if i < 6 { 5 } else { u32::from(i >= 12) }).collect();
        let expected: Vec<bool> = (0..20).map(|i| i >= 12).collect();
        assert_eq!(halves(&dumbbell(12, 8), Some(&group), 7).unwrap(), expected);
    }

    #[test]
    fn a_handful_of_trajectories_has_no_halves() {
        assert_eq!(halves(&SymCsr::from_upper(5, &[(0, 1, 1.0)]), None, 0), None);
        assert_eq!(halves(&SymCsr::default(), None, 0), None);
        assert_eq!(halves(&SymCsr::from_upper(50, &[]), None, 0), None);
    }
}
