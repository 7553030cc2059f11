//! An image file: PNG, JPEG, PPM.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tracecut_fuzz::made::readers::image_file(bytes));
