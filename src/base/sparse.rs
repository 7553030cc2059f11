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
    #[doc(hidden)] // For benchmarks and tests.
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

    #[doc(hidden)]
    /// Computes the row sums, the degrees `D_ii` of the graph.
    pub fn degrees(&self) -> Vec<f64> {
        (0..self.len()).map(|i| self.row(i).map(|(_, w)| w).sum()).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_above_the_diagonal_are_mirrored_and_sorted() {
        let m = SymCsr::from_upper(4, &[(1, 2, 2.0), (0, 2, 1.0), (0, 1, 3.0)]);
        m.check().unwrap();
        assert_eq!(m.row(2).collect::<Vec<_>>(), [(0, 1.0), (1, 2.0)]);
        assert_eq!(m.degrees(), [4.0, 5.0, 3.0, 0.0]);
    }

    #[test]
    fn empty_matrix_is_legal() {
        let m = SymCsr::from_upper(0, &[]);
        m.check().unwrap();
        assert!(m.is_empty());
    }
}
