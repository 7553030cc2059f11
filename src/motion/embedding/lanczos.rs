//! Block Lanczos with full orthogonalisation and thick restarts, panel by panel.
//!
//! The basis is a row of panels of four vectors, of which the first `done` vectors have been multiplied by `A`; the
//! others are waiting. A step multiplies the next waiting panel, takes out of the product all that lies along the
//! basis, and appends what remains as a new panel. So `A V_done = V T`, where `T` (all panels × done panels) holds what
//! was taken out:
//!
//! ```text
//!            done     waiting            The block size is the number of waiting vectors: it stays what it was at the
//!   T^T = [   H    |    Eᵀ   ]           start, as every step takes one panel from the queue and appends one.
//! ```
//!
//! Ritz pairs `(θ, y)` of `H` approximate eigenpairs `(θ, V_done y)` with residual `‖E y‖`. When the basis is full, the
//! best Ritz vectors become its first panels and everything else but the waiting panels is dropped (Wu and Simon 2000).

use super::dense::{DenseEigen, add_combination, project, symmetric_eigen};
use super::operator::SymmetricOperator;
use super::panel::{IDENTITY, Square, WIDTH, lengths, multiply, orthonormalize, to_columns, to_rows};
use crate::rng::Rng;

/// Parts of the operator's norm below which what remains of a vector is rounding.
const ROUNDING: f64 = 1e-14;
/// When less than this part of a vector remains after orthogonalisation, it is orthogonalised again.
const CANCELLED: f64 = 0.02;

/// The basis `V` and the projected matrix `T`; both column-major.
pub(super) struct Lanczos<'a> {
    operator: &'a dyn SymmetricOperator,
    rng: Rng,
    /// Rows of the basis.
    pub(super) n: usize,
    basis: Vec<f64>,
    /// How many columns have been multiplied.
    done: usize,
    /// `T`, with room for `side` rows and columns; zero where nothing is known.
    t: Vec<f64>,
    side: usize,
    /// Longest image of a unit vector so far: an estimate of `‖A‖` from below.
    pub(super) norm: f64,
    /// Products with one vector.
    pub(super) products: u32,
}

/// Ritz pairs of the moment: values largest first, vectors in the coordinates of the basis.
pub(super) struct Ritz {
    pub(super) eigen: DenseEigen,
    /// `E Y`: what the waiting vectors get of the image of each Ritz vector.
    coupling: Vec<f64>,
    pub(super) residual: Vec<f64>,
}

impl<'a> Lanczos<'a> {
    /// Starts from `block` random vectors; `capacity` more can be appended, and the operator's dimension must exceed
    /// both together. All sizes are multiples of a panel's width.
    pub(super) fn new(operator: &'a dyn SymmetricOperator, block: usize, capacity: usize, seed: u32) -> Self {
        let (n, side) = (operator.dimension(), capacity + block);
        let mut start = Self {
            operator,
            rng: Rng::for_stage(u64::from(seed), "eigen"),
            n,
            basis: Vec::with_capacity(n * side),
            done: 0,
            t: vec![0.0; side * side],
            side,
            norm: 0.0,
            products: 0,
        };
        for _ in 0..block / WIDTH {
            let panel = (0..n * WIDTH).map(|_| start.rng.range(-1.0, 1.0)).collect();
            start.append(panel, 1.0);
        }
        start
    }

    /// Columns of the basis that have been multiplied.
    pub(super) fn size(&self) -> usize {
        self.done
    }

    /// All columns of the basis.
    fn total(&self) -> usize {
        self.basis.len() / self.n
    }

    /// Multiplies the next waiting panel. `None` if the product is not finite.
    pub(super) fn step(&mut self) -> Option<()> {
        let (n, j, total) = (self.n, self.done, self.total());
        let mut w = self.product(j);
        let before = lengths(&w, n);
        // A maximum passes over NaN; a sum does not.
        if !before.iter().sum::<f64>().is_finite() {
            return None;
        }
        let length = before.into_iter().fold(0.0, f64::max);
        self.norm = self.norm.max(length);
        // What is known already (T is symmetric), then the part along the waiting panels; both before the full pass,
        // which so has only rounding to remove and needs no second one.
        let first = (0..j).find(|&i| (0..WIDTH).any(|c| self.t[i * self.side + j + c] != 0.0)).unwrap_or(j);
        let known: Vec<f64> = (j..j + WIDTH)
            .flat_map(|c| (first..j).map(move |i| (i, c)))
            .map(|(i, c)| self.t[i * self.side + c])
            .collect();
        if first < j {
            add_combination(&mut w, &self.basis[first * n..j * n], &known, -1.0, n);
        }
        let along = project(&self.basis[j * n..], &w, n);
        add_combination(&mut w, &self.basis[j * n..], &along, -1.0, n);
        let next = self.append(w, length);
        for c in 0..WIDTH {
            let column = &mut self.t[(j + c) * self.side..][..self.side];
            column[first..j].copy_from_slice(&known[c * (j - first)..(c + 1) * (j - first)]);
            column[j..total].copy_from_slice(&along[c * (total - j)..(c + 1) * (total - j)]);
            column[total..total + WIDTH].copy_from_slice(&next[c]);
        }
        self.done += WIDTH;
        Some(())
    }

    /// The image of the panel that begins at column `j`.
    fn product(&mut self, j: usize) -> Vec<f64> {
        let x = to_rows(&self.basis[j * self.n..(j + WIDTH) * self.n], self.n);
        let mut image = vec![0.0; x.len()];
        self.operator.apply(&x, WIDTH, &mut image);
        self.products += WIDTH as u32;
        to_columns(&image, WIDTH)
    }

    /// Appends `w`, orthonormalised against the basis and within, and returns its factor `s`: what was orthogonal to
    /// the basis in `w` is `panel · s`. Directions that vanish are replaced by random ones: the Krylov space is
    /// exhausted there, and only a new direction can lead on. `length` is the length of `w` before anything was taken
    /// out of it.
    fn append(&mut self, mut w: Vec<f64>, length: f64) -> Square {
        let mut s = IDENTITY;
        let (mut least, mut negligible) = (CANCELLED * length, ROUNDING * self.norm);
        // Twice is enough, and once more for random replacements.
        for _ in 0..4 {
            if !self.basis.is_empty() {
                let along = project(&self.basis, &w, self.n);
                add_combination(&mut w, &self.basis, &along, -1.0, self.n);
            }
            let rng = &mut self.rng;
            let factor = orthonormalize(&mut w, self.n, negligible, &mut || rng.range(-1.0, 1.0));
            s = multiply(&factor, &s);
            if (0..WIDTH).all(|c| factor[c][c] > least) {
                break;
            }
            // From here on the vectors have length one, or more where they are new.
            (least, negligible) = (0.5, ROUNDING);
        }
        self.basis.extend(w);
        s
    }

    /// The Ritz pairs of the multiplied part of the basis.
    pub(super) fn ritz(&self) -> Option<Ritz> {
        let (m, waiting) = (self.done, self.total() - self.done);
        // The lower triangle is the one computed at full length for every pair of panels.
        let entry = |i: usize, j: usize| self.t[i.min(j) * self.side + i.max(j)];
        let projected: Vec<f64> = (0..m * m).map(|e| entry(e / m, e % m)).collect();
        let eigen = symmetric_eigen(&projected, m)?;
        let e: Vec<f64> = (0..m).flat_map(|j| &self.t[j * self.side + m..][..waiting]).copied().collect();
        let mut coupling = vec![0.0; waiting * m];
        add_combination(&mut coupling, &e, &eigen.vectors, 1.0, waiting);
        let residual = coupling.chunks_exact(waiting).map(|x| x.iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
        Some(Ritz { eigen, coupling, residual })
    }

    /// The first `count` Ritz vectors, column by column.
    pub(super) fn vectors(&self, ritz: &Ritz, count: usize) -> Vec<f64> {
        // Room for what a restart appends.
        let mut vectors = Vec::with_capacity(self.n * self.side);
        vectors.resize(self.n * count, 0.0);
        let coordinates = &ritz.eigen.vectors[..self.done * count];
        add_combination(&mut vectors, &self.basis[..self.done * self.n], coordinates, 1.0, self.n);
        vectors
    }

    /// Shrinks the basis to the first `keep` Ritz vectors and the waiting ones.
    pub(super) fn restart(&mut self, ritz: &Ritz, keep: usize) {
        let mut basis = self.vectors(ritz, keep);
        basis.extend_from_slice(&self.basis[self.done * self.n..]);
        let waiting = self.total() - self.done;
        self.t.fill(0.0);
        for (q, coupling) in ritz.coupling.chunks_exact(waiting).take(keep).enumerate() {
            let column = &mut self.t[q * self.side..][..self.side];
            column[q] = ritz.eigen.values[q];
            column[keep..keep + waiting].copy_from_slice(coupling);
        }
        self.basis = basis;
        self.done = keep;
    }
}
