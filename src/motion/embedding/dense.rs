//! Dense linear algebra for the eigensolver: faer in native builds, a few functions of our own in wasm, where faer would be
//! a fifth of the file. Tests compare the two.

pub(super) use super::DenseEigen;
#[cfg(target_arch = "wasm32")]
pub(super) use super::portable::{add_combination, project, symmetric_eigen};
#[cfg(not(target_arch = "wasm32"))]
pub(super) use super::with_faer::{add_combination, project, symmetric_eigen};
