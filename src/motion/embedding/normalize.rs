//! The nodes to embed, and the normalised matrix `N = D^-1/2 A D^-1/2` on them, scaled on the fly.

use super::operator::SymmetricOperator;
use crate::sparse::SymCsr;
use std::cell::RefCell;

/// The operator `N = D^-1/2 A D^-1/2` on the nodes of some connected components; the matrix is not copied.
pub(super) struct NormalizedGraph<'a> {
    affinities: &'a SymCsr,
    /// The nodes, in increasing order; row `r` of the operator is node `nodes[r]`.
    pub(super) nodes: Vec<u32>,
    /// `d^-1/2` of each of these nodes.
    pub(super) scale: Vec<f64>,
    /// Number of their connected components: the multiplicity of eigenvalue 1.
    pub(super) num_components: u32,
    /// Scratch: the input block, scaled and spread over all nodes, zero on those outside.
    spread: RefCell<Vec<f64>>,
}

impl<'a> NormalizedGraph<'a> {
    /// Selects the components with at least `min_component` nodes, or the largest ones if there are none. Nodes without
    /// positive degree are left out.
    pub(super) fn new(affinities: &'a SymCsr, min_component: usize) -> Self {
        let degrees = affinities.degrees();
        let (component, count) = affinities.components();
        let mut size = vec![0_usize; count];
        for (&c, &d) in component.iter().zip(&degrees) {
            size[c as usize] += usize::from(d > 0.0);
        }
        let min_size = min_component.min(size.iter().copied().max().unwrap_or(0));
        let is_embedded = |i: usize| degrees[i] > 0.0 && size[component[i] as usize] >= min_size;
        let nodes: Vec<u32> = (0..degrees.len()).filter(|&i| is_embedded(i)).map(|i| i as u32).collect();
        let num_components = size.iter().filter(|&&s| s > 0 && s >= min_size).count() as u32;
        let scale = nodes.iter().map(|&i| 1.0 / degrees[i as usize].sqrt()).collect();
        Self { affinities, nodes, scale, num_components, spread: RefCell::default() }
    }
}

/// The operator `S A S` on the rows and columns `rows` of `matrix`, with the diagonal `S = scale`.
struct ScaledMatrix<'a> {
    matrix: &'a SymCsr,
    rows: &'a [u32],
    scale: &'a [f64],
}

impl ScaledMatrix<'_> {
    /// Computes `out = S A S x` for a block of vectors stored row by row: four columns at a time, then one. `spread` is
    /// scratch.
    fn multiply(&self, x: &[f64], columns: usize, out: &mut [f64], spread: &mut Vec<f64>) {
        let mut first = 0;
        while first < columns {
            first += if columns - first >= 4 {
                self.multiply_panel::<4>(x, columns, first, out, spread)
            } else {
                self.multiply_panel::<1>(x, columns, first, out, spread)
            };
        }
    }

    /// Computes the columns `first..first + B` of [`ScaledMatrix::multiply`]; returns `B`.
    fn multiply_panel<const B: usize>(
        &self,
        x: &[f64],
        columns: usize,
        first: usize,
        out: &mut [f64],
        spread: &mut Vec<f64>,
    ) -> usize {
        let Self { matrix, rows, scale } = self;
        spread.clear();
        spread.resize(matrix.len() * B, 0.0);
        let entries = spread.as_chunks_mut::<B>().0;
        for ((&i, &s), row) in rows.iter().zip(*scale).zip(x.chunks_exact(columns)) {
            (0..B).for_each(|c| entries[i as usize][c] = s * row[first + c]);
        }
        if columns == B {
            matrix.multiply(rows, scale, entries, out.as_chunks_mut::<B>().0);
            return B;
        }
        let mut panel = vec![[0.0; B]; rows.len()];
        matrix.multiply(rows, scale, entries, &mut panel);
        for (row, new) in out.chunks_exact_mut(columns).zip(&panel) {
            row[first..first + B].copy_from_slice(new);
        }
        B
    }
}

impl SymmetricOperator for NormalizedGraph<'_> {
    fn dimension(&self) -> usize {
        self.nodes.len()
    }

    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]) {
        let scaled = ScaledMatrix { matrix: self.affinities, rows: &self.nodes, scale: &self.scale };
        scaled.multiply(x, columns, out, &mut self.spread.borrow_mut());
    }
}

/// The matrix itself, not normalised.
impl SymmetricOperator for SymCsr {
    fn dimension(&self) -> usize {
        self.len()
    }

    fn apply(&self, x: &[f64], columns: usize, out: &mut [f64]) {
        let rows: Vec<u32> = (0..self.len() as u32).collect();
        let unscaled = ScaledMatrix { matrix: self, rows: &rows, scale: &vec![1.0; rows.len()] };
        unscaled.multiply(x, columns, out, &mut Vec::new());
    }
}
