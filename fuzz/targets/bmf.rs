//! A `.bmf` list.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::checks::bmf(bytes));
