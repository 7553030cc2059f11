//! Spectral embedding of P = D^-1 A (section 2.1). (Essay follows.)

mod eigen;

use crate::sparse::SymCsr;
pub use eigen::{EigenInfo, EigenParams, Eigenpairs, SymmetricOperator, largest_eigenpairs};

crate::params! {
    /// Spectral embedding.
    pub struct EmbeddingParams {
        /// Most eigenvectors.
        pub max_dimensions: u32 = 24, in 2..=64;
        /// Smallest component embedded.
        pub min_component: u32 = 50, in 0..=100000;
    }
}

/// The embedding of every trajectory: the rows of `V`, the leading right eigenvectors of `P = D^-1 A`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Embedding {
    /// Number of trajectories `n`.
    pub num_rows: usize,
    /// Number of eigenvectors `K`.
    pub dimensions: usize,
    /// The `K` eigenvalues, largest first.
    pub eigenvalues: Vec<f64>,
    /// `V`, `n × K`, row by row; the row of trajectory `i` is `vectors[i * K..(i + 1) * K]`.
    pub vectors: Vec<f64>,
    /// Whether each trajectory is embedded.
    pub embedded: Vec<bool>,
    /// What the eigensolver reports.
    pub info: EigenInfo,
}

impl Embedding {
    /// The `K` coordinates of trajectory `i`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.vectors[i * self.dimensions..(i + 1) * self.dimensions]
    }
}

/// Embeds the graph of `affinities`.
pub fn embed(_affinities: &SymCsr, _params: &EmbeddingParams, _seed: u32) -> Embedding {
    Embedding { num_rows: _affinities.len(), embedded: vec![false; _affinities.len()], ..Embedding::default() }
}
