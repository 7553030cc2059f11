//! Motion affinities between trajectories. (Essay follows.)

use crate::Error;
use crate::sparse::SymCsr;
use crate::trajectory::Trajectories;

crate::params! {
    /// Motion affinities.
    pub struct AffinityParams {
        /// λ of w = exp(−λ d²) (Brox and Malik 2010). Higher separates weaker motion differences.
        pub lambda: f64 = 0.1, in 0.001..=10.0;
    }
}

/// The affinity matrix A of all trajectories.
pub fn affinities(_tracks: &Trajectories, _params: &AffinityParams, _seed: u32) -> Result<SymCsr, Error> {
    Ok(SymCsr::default())
}
