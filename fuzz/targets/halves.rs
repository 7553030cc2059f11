//! A run in two halves, on some threads.

#![no_main]

use tracecut_fuzz::made::{choices::Choices, sessions};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sessions::two_ways(&mut Choices::of_bytes(bytes, "halves")));
