//! A long clip that stops and resumes.

#![no_main]

use tracecut_fuzz::made::{choices::Choices, sessions};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sessions::windows(&mut Choices::of_bytes(bytes, "windows")));
