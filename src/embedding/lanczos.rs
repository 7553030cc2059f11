//! Block Lanczos with full orthogonalisation and thick restarts, panel by panel.
//!
//! The basis is a row of panels, of which the first `done` have been multiplied by `A`; the others are waiting. A step
//! multiplies the next waiting panel, takes out of the product all that lies along the basis, and appends what remains as
//! a new panel. So `A V_done = V T`, where `T` (all panels × done panels) holds what was taken out:
//!
//! ```text
//!            done     waiting            The block size is the number of waiting vectors: it stays what it was at the
//!   T^T = [   H    |    Eᵀ   ]           start, as every step takes one panel from the queue and appends one.
//! ```
//!
//! Ritz pairs `(θ, y)` of `H` approximate eigenpairs `(θ, V_done y)` with residual `‖E y‖`. When the basis is full, the best
//! Ritz vectors become its first panels and everything else but the waiting panels is dropped (Wu and Simon 2000).

use super::dense::{DenseEigen, symmetric_eigen};
use super::eigen::SymmetricOperator;
use super::panel::{
    Panel, Row, Square, WIDTH, add_combination, combinations, lengths, multiply, orthonormalize, project,
};
use crate::rng::Rng;

/// Parts of the operator's norm below which what remains of a vector is rounding.
const ROUNDING: f64 = 1e-14;
/// When less than this part of a vector remains after orthogonalisation, it is orthogonalised again.
const CANCELLED: f64 = 0.02;

/// The basis `V` and the projected matrix `T`.
pub(super) struct Lanczos<'a> {
    operator: &'a dyn SymmetricOperator,
    rng: Rng,
    basis: Vec<Panel>,
    /// How many panels have been multiplied.
    done: usize,
    /// `t[j][i] = V_iᵀ A V_j` of panel `i` with the multiplied panel `j`; absent at the end means zero.
    t: Vec<Vec<Square>>,
    /// Longest image of a unit vector so far: an estimate of `‖A‖` from below.
    pub(super) norm: f64,
    /// Products with one vector.
    pub(super) products: u32,
}

/// Ritz pairs of the moment: values largest first, vectors in the coordinates of the basis, and their residuals.
pub(super) struct Ritz {
    pub(super) eigen: DenseEigen,
    pub(super) residual: Vec<f64>,
}

impl Ritz {
    /// The coordinates along panel `p` of the basis of the Ritz vectors of panel `q`.
    fn square(&self, p: usize, q: usize) -> Square {
        let m = self.eigen.values.len();
        let mut square = Square::default();
        for (a, row) in square.iter_mut().enumerate() {
            let first = (p * WIDTH + a) * m + q * WIDTH;
            row.copy_from_slice(&self.eigen.vectors[first..first + WIDTH]);
        }
        square
    }
}

impl<'a> Lanczos<'a> {
    /// Starts from `panels` random panels; the operator's dimension must exceed what will be put into the basis.
    pub(super) fn new(operator: &'a dyn SymmetricOperator, panels: usize, seed: u32) -> Self {
        let rng = Rng::for_stage(u64::from(seed), "eigen");
        let mut start = Self { operator, rng, basis: Vec::new(), done: 0, t: Vec::new(), norm: 0.0, products: 0 };
        for _ in 0..panels {
            let mut panel = vec![Row::default(); operator.dimension()];
            panel.as_flattened_mut().iter_mut().for_each(|x| *x = start.rng.range(-1.0, 1.0));
            start.append(panel, 1.0);
        }
        start
    }

    /// Columns of the basis that have been multiplied.
    pub(super) fn size(&self) -> usize {
        self.done * WIDTH
    }

    /// Multiplies the next waiting panel. `None` if the product is not finite.
    pub(super) fn step(&mut self) -> Option<()> {
        let j = self.done;
        let mut w = vec![Row::default(); self.basis[j].len()];
        self.operator.apply(self.basis[j].as_flattened(), WIDTH, w.as_flattened_mut());
        self.products += WIDTH as u32;
        let length = lengths(&w).into_iter().fold(0.0, f64::max);
        // The fold above passes over NaN; a sum does not.
        if !lengths(&w).iter().sum::<f64>().is_finite() {
            return None;
        }
        self.norm = self.norm.max(length);
        // What is known already (T is symmetric), then the part along the waiting panels; both before the full pass, which
        // so has only rounding to remove and needs no second one.
        let mut column: Vec<Square> =
            self.t.iter().map(|known| known.get(j).map_or(Square::default(), transposed)).collect();
        add_combination(&mut w, &self.basis[..j], &column, -1.0);
        let along = project(&self.basis[j..], &w);
        add_combination(&mut w, &self.basis[j..], &along, -1.0);
        column.extend(along);
        column.push(self.append(w, length));
        self.t.push(column);
        self.done += 1;
        Some(())
    }

    /// Appends `w`, orthonormalised against the basis and within, and returns its factor `s`: what was orthogonal to the
    /// basis in `w` is `panel · s`. Directions that vanish are replaced by random ones: the Krylov space is exhausted
    /// there, and only a new direction can lead on. `length` is that of `w` before anything was taken out of it.
    fn append(&mut self, mut w: Panel, length: f64) -> Square {
        let mut s = Square::default();
        (0..WIDTH).for_each(|c| s[c][c] = 1.0);
        let (mut least, mut negligible) = (CANCELLED * length, ROUNDING * self.norm);
        // Twice is enough, and once more for random replacements.
        for _ in 0..4 {
            let along = project(&self.basis, &w);
            add_combination(&mut w, &self.basis, &along, -1.0);
            let rng = &mut self.rng;
            let factor = orthonormalize(&mut w, negligible, &mut || rng.range(-1.0, 1.0));
            s = multiply(&factor, &s);
            if (0..WIDTH).all(|c| factor[c][c] > least) {
                break;
            }
            // From here on the vectors have length one, or more where they are new.
            (least, negligible) = (0.5, ROUNDING);
        }
        self.basis.push(w);
        s
    }

    /// The Ritz pairs of the multiplied part of the basis.
    pub(super) fn ritz(&self) -> Option<Ritz> {
        let m = self.size();
        let entry = |row: usize, column: usize| {
            self.t[column / WIDTH].get(row / WIDTH).map_or(0.0, |block| block[row % WIDTH][column % WIDTH])
        };
        // The lower triangle is the one computed at full length for every pair of panels.
        let projected: Vec<f64> = (0..m * m).map(|e| entry((e / m).max(e % m), (e / m).min(e % m))).collect();
        let eigen = symmetric_eigen(&projected, m)?;
        let mut sums = vec![0.0; m];
        for row in m..self.basis.len() * WIDTH {
            let mut coupling = vec![0.0; m];
            for column in 0..m {
                let e = entry(row, column);
                if e != 0.0 {
                    let y = &eigen.vectors[column * m..(column + 1) * m];
                    coupling.iter_mut().zip(y).for_each(|(sum, y)| *sum += e * y);
                }
            }
            sums.iter_mut().zip(coupling).for_each(|(sum, x)| *sum += x * x);
        }
        Some(Ritz { eigen, residual: sums.into_iter().map(f64::sqrt).collect() })
    }

    /// The first `panels` panels of Ritz vectors.
    pub(super) fn vectors(&self, ritz: &Ritz, panels: usize) -> Vec<Panel> {
        let coordinates: Vec<Vec<Square>> =
            (0..panels).map(|q| (0..self.done).map(|p| ritz.square(p, q)).collect()).collect();
        combinations(&self.basis[..self.done], &coordinates)
    }

    /// Shrinks the basis to the first `panels` panels of Ritz vectors and the waiting panels.
    pub(super) fn restart(&mut self, ritz: &Ritz, panels: usize) {
        let kept = self.vectors(ritz, panels);
        let waiting = self.basis.len() - self.done;
        let mut t = vec![vec![Square::default(); panels + waiting]; panels];
        for (q, column) in t.iter_mut().enumerate() {
            for c in 0..WIDTH {
                column[q][c][c] = ritz.eigen.values[q * WIDTH + c];
            }
            for (j, old) in self.t.iter().enumerate() {
                for (i, e) in old.iter().enumerate().skip(self.done) {
                    let product = multiply(e, &ritz.square(j, q));
                    let sum = column[panels + i - self.done].as_flattened_mut();
                    sum.iter_mut().zip(product.as_flattened()).for_each(|(s, x)| *s += x);
                }
            }
        }
        self.basis.splice(..self.done, kept);
        self.t = t;
        self.done = panels;
    }
}

fn transposed(a: &Square) -> Square {
    let mut t = Square::default();
    for i in 0..WIDTH {
        for j in 0..WIDTH {
            t[j][i] = a[i][j];
        }
    }
    t
}
