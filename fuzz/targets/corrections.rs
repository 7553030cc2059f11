//! Corrections of a result.

#![no_main]

use tracecut_fuzz::made::{choices::Choices, sessions};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sessions::corrections(&mut Choices::of_bytes(bytes, "corrections")));
