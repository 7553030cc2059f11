//! An animated GIF.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::checks::gif(bytes));
