//! A setting of the command line.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::checks::setting(bytes));
