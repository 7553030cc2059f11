//! A mask of the Moseg benchmark.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::truth::pgm(bytes));
