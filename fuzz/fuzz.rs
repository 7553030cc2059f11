//! All fuzz targets: `TRACECUT_TARGET` names the one that gets the bytes of the fuzzer. `scripts/fuzz.mjs` starts it.

#![no_main]

use std::sync::LazyLock;
use tracecut_fuzz::made::{choices::Choices, images, readers, sessions};
use tracecut_fuzz::{checks, truth};

/// The function that the variable names.
static TARGET: LazyLock<fn(&[u8])> = LazyLock::new(|| {
    let name = std::env::var("TRACECUT_TARGET").expect("TRACECUT_TARGET names a target");
    target(&name).unwrap_or_else(|| panic!("there is no target {name}"))
});

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| TARGET(bytes));

fn target(name: &str) -> Option<fn(&[u8])> {
    Some(match name {
        // What files hold.
        "animation" => checks::animation,
        "bmf" => checks::bmf,
        "definition" => truth::definition,
        "flo" => truth::flo,
        "image_file" => readers::image_file,
        "mat" => truth::mat,
        "parameters" => readers::parameters,
        "pgm" => truth::pgm,
        "setting" => checks::setting,
        "tracks_dat" => readers::tracks_dat,
        "y4m" => checks::y4m,
        // Choices of a generator.
        "corrections" => |bytes| sessions::corrections(&mut Choices::of_bytes(bytes, "corrections")),
        "halves" => |bytes| sessions::two_ways(&mut Choices::of_bytes(bytes, "halves")),
        "image" => |bytes| images::any_image(&mut Choices::of_bytes(bytes, "image")),
        "outside_tracks" => |bytes| sessions::outside_tracks(&mut Choices::of_bytes(bytes, "tracks")),
        "session" => |bytes| sessions::any_calls(&mut Choices::of_bytes(bytes, "random")),
        "windows" => |bytes| sessions::windows(&mut Choices::of_bytes(bytes, "windows")),
        _ => return None,
    })
}
