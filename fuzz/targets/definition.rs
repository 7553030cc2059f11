//! A shot's `Def.dat`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::truth::definition(bytes));
