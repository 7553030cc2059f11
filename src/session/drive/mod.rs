//! Execution of sessions: on threads and workers, window by window, resumed in another process, and as forks.

mod advance;
#[cfg(test)]
mod advance_tests;
#[cfg(not(target_arch = "wasm32"))]
mod checkpoint;
#[cfg(not(target_arch = "wasm32"))]
mod fork;
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
pub use fork::Forks;
#[cfg(not(target_arch = "wasm32"))]
pub use windows::Windows;
