//! The graph's nodes that are embedded, and its normalised matrix `N = D^-1/2 A D^-1/2` on them, scaled on the fly.

use super::eigen::SymmetricOperator;
use crate::sparse::SymCsr;
use std::cell::RefCell;

/// `N = D^-1/2 A D^-1/2` on the nodes of whole connected components; no copy of the matrix is made.
pub(super) struct NormalizedGraph<'a> {
    affinities: &'a SymCsr,
    /// The nodes, in increasing order; row `r` of the operator is node `nodes[r]`.
    pub(super) nodes: Vec<u32>,
    /// `d^-1/2` of each of them.
    pub(super) scale: Vec<f64>,
    /// Number of connected components among them: the multiplicity of eigenvalue 1.
    pub(super) num_components: u32,
    /// Scratch: the input block, scaled and spread over all nodes, zero on those outside.
    spread: RefCell<Vec<f64>>,
}

impl<'a> NormalizedGraph<'a> {
    /// The components with at least `min_component` nodes; where there is none, the largest ones. Nodes without positive
    /// degree never belong.
    pub(super) fn new(affinities: &'a SymCsr, min_component: usize) -> Self {
        let degrees = affinities.degrees();
        let (component, count) = affinities.components();
        let mut size = vec![0_usize; count];
        for (&c, &d) in component.iter().zip(&degrees) {
            size[c as usize] += usize::from(d > 0.0);
        }
        let least = min_component.min(size.iter().copied().max().unwrap_or(0));
        let chosen = |i: usize| degrees[i] > 0.0 && size[component[i] as usize] >= least;
        let nodes: Vec<u32> = (0..degrees.len()).filter(|&i| chosen(i)).map(|i| i as u32).collect();
        let num_components = size.iter().filter(|&&s| s > 0 && s >= least).count() as u32;
        let scale = nodes.iter().map(|&i| 1.0 / degrees[i as usize].sqrt()).collect();
        Self { affinities, nodes, scale, num_components, spread: RefCell::default() }
    }

    fn multiply<const B: usize>(&self, x: &[f64], out: &mut [f64]) {
        let (offset, column, value) = (&self.affinities.offset, &self.affinities.column, &self.affinities.value);
        for ((&node, &s), sums) in self.nodes.iter().zip(&self.scale).zip(out.chunks_exact_mut(B)) {
            let row = offset[node as usize] as usize..offset[node as usize + 1] as usize;
            let mut sum = [0.0; B];
            for (&j, &w) in column[row.clone()].iter().zip(&value[row]) {
                let entry = &x[j as usize * B..j as usize * B + B];
                for c in 0..B {
                    sum[c] += w * entry[c];
                }
            }
            for c in 0..B {
                sums[c] = s * sum[c];
            }
        }
    }

    /// The columns `first..first + B` of the block.
    fn apply_panel<const B: usize>(&self, x: &[f64], columns: usize, first: usize, out: &mut [f64]) {
        let mut spread = self.spread.borrow_mut();
        spread.clear();
        spread.resize(self.affinities.len() * B, 0.0);
        for ((&node, &s), row) in self.nodes.iter().zip(&self.scale).zip(x.chunks_exact(columns)) {
            for c in 0..B {
                spread[node as usize * B + c] = s * row[first + c];
            }
        }
        if columns == B {
            return self.multiply::<B>(&spread, out);
        }
        let mut panel = vec![0.0; self.nodes.len() * B];
        self.multiply::<B>(&spread, &mut panel);
        for (row, new) in out.chunks_exact_mut(columns).zip(panel.chunks_exact(B)) {
            row[first..first + B].copy_from_slice(new);
        }
    }
}

impl SymmetricOperator for NormalizedGraph<'_> {
    fn dimension(&self) -> usize {
        self.nodes.len()
    }

    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]) {
        let mut first = 0;
        while first < columns {
            first += match columns - first {
                8.. => {
                    self.apply_panel::<8>(x, columns, first, out);
                    8
                }
                4.. => {
                    self.apply_panel::<4>(x, columns, first, out);
                    4
                }
                _ => {
                    self.apply_panel::<1>(x, columns, first, out);
                    1
                }
            };
        }
    }
}
