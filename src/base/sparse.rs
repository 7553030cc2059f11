//! `SymCsr`: a symmetric sparse matrix, both triangles stored row by row.

use crate::{Error, order};

/// A symmetric `n × n` matrix in compressed rows.
///
/// Invariants: row `i` has the entries `offset[i]..offset[i + 1]`; `offset.len() == n + 1`; the columns of a row increase;
/// every entry `(i, j)` has its mirror `(j, i)` of the same value; all values are finite. Values are stored in single
/// precision, which halves the time of a product (it is bound by memory); sums are in double precision.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SymCsr {
    /// Start of each row; `n + 1` numbers.
    pub offset: Vec<u32>,
    /// Column of each entry.
    pub column: Vec<u32>,
    /// Value of each entry.
    pub value: Vec<f32>,
}

impl SymCsr {
    /// Builds the matrix from its entries above the diagonal (`i < j`, in any order, no duplicates).
    pub fn from_upper(n: usize, entries: &[(u32, u32, f32)]) -> Self {
        let mut offset = vec![0_u32; n + 1];
        for &(i, j, _) in entries {
            offset[i as usize + 1] += 1;
            offset[j as usize + 1] += 1;
        }
        for i in 0..n {
            offset[i + 1] += offset[i];
        }
        let mut next = offset.clone();
        let mut column = vec![0; 2 * entries.len()];
        let mut value = vec![0.0; 2 * entries.len()];
        let mut sorted = std::borrow::Cow::Borrowed(entries);
        if !entries.is_sorted_by_key(|&(i, j, _)| (i, j)) {
            order::sort_by_key(sorted.to_mut(), |&(i, j, _)| order::pair_key(i, j));
        }
        // Lower mirrors first: rows then receive their columns in increasing order.
        for (row, col, w) in sorted.iter().map(|e| (e.1, e.0, e.2)).chain(sorted.iter().map(|e| (e.0, e.1, e.2))) {
            let slot = next[row as usize] as usize;
            (column[slot], value[slot]) = (col, w);
            next[row as usize] += 1;
        }
        Self { offset, column, value }
    }

    /// Returns the number of rows.
    pub fn len(&self) -> usize {
        self.offset.len().saturating_sub(1)
    }

    #[doc(hidden)]
    /// Returns true if the matrix has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns columns and values of row `i`.
    pub fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.offset[i] as usize..self.offset[i + 1] as usize;
        self.column[range.clone()].iter().zip(&self.value[range]).map(|(&j, &w)| (j as usize, f64::from(w)))
    }

    /// Computes `out_r = scale_r Σ_j A_ij x_j` with `i = rows_r`, for `B` vectors at once, `x_j` being their entries `j`.
    ///
    /// Uses the widest instructions of the machine; the order of the sums is the same for all.
    pub(crate) fn multiply<const B: usize>(&self, rows: &[u32], scale: &[f64], x: &[[f64; B]], out: &mut [[f64; B]]) {
        pulp::Arch::new().dispatch(Product { matrix: self, rows, scale, x, out });
    }

    #[doc(hidden)]
    /// Computes the row sums, the degrees `D_ii` of the graph.
    pub fn degrees(&self) -> Vec<f64> {
        (0..self.len()).map(|i| self.row(i).map(|(_, w)| w).sum()).collect()
    }

    /// Labels the connected components: the component of each node, and their number, in the order of their first nodes.
    pub(crate) fn components(&self) -> (Vec<u32>, usize) {
        const UNVISITED: u32 = u32::MAX;
        let mut component = vec![UNVISITED; self.len()];
        let mut count = 0;
        let mut stack = Vec::new();
        for start in 0..self.len() {
            if component[start] != UNVISITED {
                continue;
            }
            component[start] = count;
            stack.push(start);
            while let Some(i) = stack.pop() {
                for (j, _) in self.row(i) {
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

    #[doc(hidden)]
    /// Checks the invariants of the type.
    ///
    /// # Errors
    /// [`Error::Data`] naming the first breach.
    pub fn check(&self) -> Result<(), Error> {
        let breach = |reason: String| Err(Error::Data { reason });
        if self.value.len() != self.column.len() || self.offset.last().is_some_and(|&e| e as usize != self.column.len())
        {
            return breach(format!(
                "{} columns, {} values, offsets to {}",
                self.column.len(),
                self.value.len(),
                self.offset.last().copied().unwrap_or(0)
            ));
        }
        for i in 0..self.len() {
            let columns: Vec<usize> = self.row(i).map(|(j, _)| j).collect();
            if !columns.is_sorted_by(|a, b| a < b) || columns.last().is_some_and(|&j| j >= self.len()) {
                return breach(format!("columns of row {i} do not increase within 0..{}", self.len()));
            }
            for (j, w) in self.row(i) {
                if !w.is_finite() || !self.row(j).any(|(k, m)| k == i && m == w) {
                    return breach(format!("entry ({i}, {j}) = {w} is not finite or has no mirror"));
                }
            }
        }
        Ok(())
    }
}

/// The arguments of [`SymCsr::multiply`].
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_above_the_diagonal_are_mirrored_and_sorted() {
        let m = SymCsr::from_upper(4, &[(1, 2, 2.0), (0, 2, 1.0), (0, 1, 3.0)]);
        m.check().unwrap();
        assert_eq!(m.row(2).collect::<Vec<_>>(), [(0, 1.0), (1, 2.0)]);
        assert_eq!(m.degrees(), [4.0, 5.0, 3.0, 0.0]);
        assert_eq!(m.components(), (vec![0, 0, 0, 1], 2));
    }

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
        matrix.multiply(&rows, &scale, &x, &mut widest);
        let product = Product { matrix: &matrix, rows: &rows, scale: &scale, x: &x, out: &mut scalar };
        pulp::Simd::vectorize(pulp::Scalar, product);
        let bits = |v: &[[f64; 4]]| v.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&widest), bits(&scalar));
        assert!(widest.iter().flatten().any(|&v| v != 0.0));
    }

    #[test]
    fn empty_matrix_is_legal() {
        let m = SymCsr::from_upper(0, &[]);
        m.check().unwrap();
        assert!(m.is_empty());
        assert_eq!(m.components().1, 0);
    }
}
