//! A MATLAB file of human segmentations.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::truth::mat(bytes));
