//! Execution of sessions: on threads and workers, window by window, and resumed in another process.

mod advance;
#[cfg(test)]
mod advance_tests;
#[cfg(not(target_arch = "wasm32"))]
mod checkpoint;
#[cfg(test)]
mod job_tests;
#[cfg(any(not(target_arch = "wasm32"), feature = "wasm"))]
mod threads;
#[cfg(not(target_arch = "wasm32"))]
mod windows;
#[cfg(test)]
mod windows_tests;

#[cfg(not(target_arch = "wasm32"))]
pub use checkpoint::Checkpoint;
#[cfg(not(target_arch = "wasm32"))]
pub use windows::Windows;
