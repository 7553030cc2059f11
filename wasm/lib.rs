//! The wasm file of the engine: what the library exports to JavaScript.

#![cfg(target_arch = "wasm32")]

pub use tracecut::wasm::*;
