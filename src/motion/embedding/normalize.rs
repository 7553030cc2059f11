//! The nodes to embed, and the normalised matrix `N = D^-1/2 A D^-1/2` on them, scaled on the fly.

use super::SymmetricOperator;
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
        let (component, count) = connected_components(affinities);
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

/// Labels the connected components: the component of each node, and their number, in the order of their first nodes.
fn connected_components(matrix: &SymCsr) -> (Vec<u32>, usize) {
    const UNVISITED: u32 = u32::MAX;
    let mut component = vec![UNVISITED; matrix.len()];
    let mut count = 0;
    let mut stack = Vec::new();
    for start in 0..matrix.len() {
        if component[start] != UNVISITED {
            continue;
        }
        component[start] = count;
        stack.push(start);
        while let Some(i) = stack.pop() {
            for (j, _) in matrix.row(i) {
                if component[j] == UNVISITED {
                    component[j] = count;
                    stack.push(j);
                }
            }
        }
        count += 1;
    }
    (component, count as usize)
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
            pulp::Arch::new().dispatch(Product { matrix, rows, scale, x: entries, out: out.as_chunks_mut::<B>().0 });
            return B;
        }
        let mut panel = vec![[0.0; B]; rows.len()];
        pulp::Arch::new().dispatch(Product { matrix, rows, scale, x: entries, out: &mut panel });
        for (row, new) in out.chunks_exact_mut(columns).zip(&panel) {
            row[first..first + B].copy_from_slice(new);
        }
        B
    }
}

/// The product `out_r = scale_r Σ_j A_ij x_j` with `i = rows_r`, for `B` vectors at once, `x_j` being their entries `j`.
///
/// Runs with the widest instructions of the machine; the order of the sums is the same for all.
struct Product<'a, const B: usize> {
    matrix: &'a SymCsr,
    rows: &'a [u32],
    scale: &'a [f64],
    x: &'a [[f64; B]],
    out: &'a mut [[f64; B]],
}

impl<const B: usize> pulp::WithSimd for Product<'_, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let SymCsr { offset, column, value } = self.matrix;
        for ((&i, &s), out) in self.rows.iter().zip(self.scale).zip(self.out) {
            let row = offset[i as usize] as usize..offset[i as usize + 1] as usize;
            // Two entries at a time into two sums, as additions to one sum wait for each other. Measured to be slower on
            // wasm32, where one entry fills several registers.
            let paired = if cfg!(target_arch = "wasm32") { 0 } else { row.len() & !1 };
            let (columns, last_column) = column[row.clone()].split_at(paired);
            let (values, last_value) = value[row].split_at(paired);
            let (columns, values) = (columns.as_chunks::<2>().0, values.as_chunks::<2>().0);
            let (mut even, mut odd) = ([0.0; B], [0.0; B]);
            for (j, w) in columns.iter().zip(values) {
                let (x, y) = (&self.x[j[0] as usize], &self.x[j[1] as usize]);
                let (w, v) = (f64::from(w[0]), f64::from(w[1]));
                (0..B).for_each(|c| even[c] += w * x[c]);
                (0..B).for_each(|c| odd[c] += v * y[c]);
            }
            for (&j, &w) in last_column.iter().zip(last_value) {
                (0..B).for_each(|c| even[c] += f64::from(w) * self.x[j as usize][c]);
            }
            (0..B).for_each(|c| out[c] = s * (even[c] + odd[c]));
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scalar_and_widest_instructions_give_the_same_bits() {
        let mut rng = crate::rng::Rng::for_stage(3, "test");
        let n = 61;
        let pairs = (0..n as u32).flat_map(|i| (i + 1..n as u32).map(move |j| (i, j)));
        let chosen: Vec<_> = pairs.filter(|_| rng.below(3) == 0).collect();
        let entries: Vec<_> = chosen.into_iter().map(|(i, j)| (i, j, rng.range(-1.0, 1.0) as f32)).collect();
        let matrix = SymCsr::from_upper(n, &entries);
        let rows: Vec<u32> = (0..n as u32).collect();
        let scale: Vec<f64> = (0..n).map(|_| rng.range(0.0, 1e3)).collect();
        let x: Vec<[f64; 4]> = (0..n).map(|_| std::array::from_fn(|_| rng.range(-1e3, 1e3))).collect();
        let (mut widest, mut scalar) = (vec![[0.0; 4]; n], vec![[0.0; 4]; n]);
        pulp::Arch::new().dispatch(Product { matrix: &matrix, rows: &rows, scale: &scale, x: &x, out: &mut widest });
        let product = Product { matrix: &matrix, rows: &rows, scale: &scale, x: &x, out: &mut scalar };
        pulp::Simd::vectorize(pulp::Scalar, product);
        let bits = |v: &[[f64; 4]]| v.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&widest), bits(&scalar));
        assert!(widest.iter().flatten().any(|&v| v != 0.0));
    }

    #[test]
    fn components_are_numbered_by_their_first_nodes() {
        let m = SymCsr::from_upper(4, &[(1, 2, 2.0), (0, 2, 1.0), (0, 1, 3.0)]);
        assert_eq!(connected_components(&m), (vec![0, 0, 0, 1], 2));
        assert_eq!(connected_components(&SymCsr::from_upper(0, &[])).1, 0);
    }
}
