//! All fuzz targets: `TRACECUT_TARGET` names the one that gets the bytes of the fuzzer. `scripts/fuzz.mjs` starts it.

#![no_main]

use std::sync::LazyLock;
use tracecut_fuzz::generators::{choices::Choices, invariants, sessions};
use tracecut_fuzz::{checks, truth};

/// The function that the variable names.
static TARGET: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let name = std::env::var("TRACECUT_TARGET").expect("TRACECUT_TARGET names a target");
    function_of(&name).unwrap_or_else(|| panic!("there is no target {name}"))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| TARGET(bytes));

fn function_of(name: &str) -> Option<fn(&[u8])> {
    Some(match name {
        // Files.
        "animation" => checks::animation,
        "bmf" => checks::bmf,
        "definition" => truth::definition,
        "flo" => truth::flo,
        "image_file" => invariants::image_file,
        "parameters" => invariants::parameters,
        "pgm" => truth::pgm,
        "setting" => checks::setting,
        "tracks_dat" => invariants::tracks_dat,
        "y4m" => checks::y4m,
        // Choices of a generator.
        "corrections" => |bytes| sessions::check_undo(&mut Choices::from_bytes(bytes, "corrections")),
        "halves" => |bytes| sessions::check_interrupted_run(&mut Choices::from_bytes(bytes, "halves")),
        "image" => |bytes| sessions::check_image(&mut Choices::from_bytes(bytes, "image")),
        "outside_tracks" => |bytes| sessions::check_given_tracks(&mut Choices::from_bytes(bytes, "tracks")),
        "session" => |bytes| sessions::check_random_calls(&mut Choices::from_bytes(bytes, "random")),
        "windows" => |bytes| sessions::check_resumed_windows(&mut Choices::from_bytes(bytes, "windows")),
        _ => return None,
    })
}
