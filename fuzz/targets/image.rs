//! A single image.

#![no_main]

use tracecut_fuzz::made::{choices::Choices, images};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| images::any_image(&mut Choices::of_bytes(bytes, "image")));
