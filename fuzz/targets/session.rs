//! A whole session, in any order of calls.

#![no_main]

use tracecut_fuzz::made::{choices::Choices, sessions};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sessions::any_calls(&mut Choices::of_bytes(bytes, "random")));
