//! Trajectories from outside.

#![no_main]

use tracecut_fuzz::made::{choices::Choices, sessions};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| sessions::outside_tracks(&mut Choices::of_bytes(bytes, "tracks")));
