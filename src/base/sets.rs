//! Disjoint sets of small numbers, joined one pair at a time (union-find).

/// A partition of `0..n`; the root of a set is its smallest member.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// Creates `n` sets of one number each.
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    /// Makes `i` a set of its own again. All members of its former set must be reset.
    pub(crate) fn reset(&mut self, i: usize) {
        self.0[i] = i as u32;
    }

    /// Returns the smallest member of the set of `i`.
    pub fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] as usize != i {
            self.0[i] = self.0[self.0[i] as usize];
            i = self.0[i] as usize;
        }
        i
    }

    /// Merges the sets of `i` and `j`.
    pub fn join(&mut self, i: usize, j: usize) {
        // Neighbours of one set often have the same parent.
        if self.0[i] == self.0[j] {
            return;
        }
        let (a, b) = (self.root(i), self.root(j));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_have_their_smallest_as_root_until_they_are_reset() {
        let mut sets = DisjointSets::new(6);
        for (i, j) in [(4, 5), (2, 4), (5, 1)] {
            sets.join(i, j);
        }
        assert_eq!([0, 1, 2, 3, 4, 5].map(|i| sets.root(i)), [0, 1, 1, 3, 1, 1]);
        (0..6).for_each(|i| sets.reset(i));
        assert_eq!(sets, DisjointSets::new(6));
    }
}
