//! An animated GIF, PNG or WebP.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::checks::animation(bytes));
