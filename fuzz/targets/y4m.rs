//! A Y4M stream.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::checks::y4m(bytes));
