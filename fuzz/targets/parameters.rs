//! Parameters from JSON.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::made::readers::parameters(bytes));
