//! Single images: superpixels and boundaries.

use super::{assert_done, assert_refused, folder, names_in, png, text, tracecut};
use std::fs;
use std::path::Path;

/// A dark disc on a light ground, 48 by 40 pixels.
fn disc(x: i32, y: i32) -> u8 {
    if (x - 22).pow(2) + (y - 19).pow(2) < 144 { 40 } else { 210 }
}

fn picture(root: &Path) -> String {
    let path = root.join("disc.png");
    png(&path, 48, 40, &disc);
    path.to_str().unwrap().to_owned()
}

#[test]
fn superpixels_are_written_as_numbers_and_as_a_picture() {
    let root = folder("image-superpixels");
    let (image, out) = (picture(&root), root.join("out"));
    let output = tracecut(["superpixels", &image, "--out", out.to_str().unwrap(), "--count", "6"]);
    assert_done(&output);
    assert_eq!(text(&output.stdout).trim(), "6 superpixels");
    assert_eq!(names_in(&out), ["disc_edges.png", "disc_superpixels.png"]);
    let labels = image::open(out.join("disc_superpixels.png")).unwrap().into_luma16();
    assert_eq!(labels.dimensions(), (48, 40));
    let mut seen = [false; 6];
    labels.pixels().for_each(|p| seen[usize::from(p.0[0])] = true);
    assert_eq!(seen, [true; 6]);
    assert_ne!(labels.get_pixel(22, 19), labels.get_pixel(1, 1), "the disc is apart from its ground");
}

#[test]
fn boundaries_lie_on_the_outline_and_nowhere_else() {
    let root = folder("image-boundaries");
    let (image, out) = (picture(&root), root.join("out"));
    assert_done(&tracecut(["boundaries", &image, "--out", out.to_str().unwrap()]));
    assert_eq!(names_in(&out), ["pb.png", "thin.png"]);
    let thin = image::open(out.join("thin.png")).unwrap().into_luma8();
    let strong: Vec<f64> = thin
        .enumerate_pixels()
        .filter(|(_, _, p)| p.0[0] > 64)
        .map(|(x, y, _)| ((f64::from(x) - 22.0).powi(2) + (f64::from(y) - 19.0).powi(2)).sqrt())
        .collect();
    assert!(strong.len() > 40, "{} pixels", strong.len());
    assert!(strong.iter().all(|r| (r - 12.0).abs() < 2.5), "{strong:?}");
}

#[test]
fn with_embedding_the_maps_of_the_pixel_embedding_are_beside_pb() {
    let root = folder("image-embedding");
    let (image, out) = (picture(&root), root.join("out"));
    assert_done(&tracecut(["boundaries", &image, "--embedding", "--out", out.to_str().unwrap()]));
    let names = ["combined.png", "combined_thin.png", "discontinuity.png", "pb.png", "spectral.png", "thin.png"];
    assert_eq!(names_in(&out), names);
    for name in ["discontinuity.png", "combined.png"] {
        let map = image::open(out.join(name)).unwrap().into_luma8();
        assert_eq!(map.dimensions(), (48, 40));
        let (outline, inside) =
            (map.get_pixel(34, 19).0[0].max(map.get_pixel(33, 19).0[0]), map.get_pixel(22, 19).0[0]);
        assert!(outline > 100 && inside < 50, "{name}: {outline} on the outline, {inside} inside");
    }
    let file = root.join("one.png");
    assert_done(&tracecut(["boundaries", &image, "--embedding", "--out", file.to_str().unwrap()]));
    let combined = image::open(out.join("combined_thin.png")).unwrap().into_luma8();
    assert_eq!(image::open(file).unwrap().into_luma8(), combined);
    let message = ["still.radius = 0", "1..=10"];
    let set = ["boundaries", &image, "--embedding", "--out", out.to_str().unwrap(), "--set", "still.radius=0"];
    assert_refused(&tracecut(set), 2, &message);
}

#[test]
fn what_cannot_be_used_is_named() {
    let root = folder("image-refused");
    let (image, out) = (picture(&root), root.join("out"));
    let out = out.to_str().unwrap();
    assert_refused(&tracecut(["superpixels", &image, "--out", out, "--count", "0"]), 2, &["--count", "0"]);
    let broken = root.join("broken.png");
    fs::write(&broken, &fs::read(&image).unwrap()[..60]).unwrap();
    for command in ["superpixels", "boundaries"] {
        assert_refused(&tracecut([command, broken.to_str().unwrap(), "--out", out]), 3, &["broken.png"]);
    }
    let output = tracecut(["superpixels", &image, "--out", out, "--set", "contour.lowThreshold=7"]);
    assert_refused(&output, 2, &["contour.lowThreshold = 7", "0..=1"]);
}

/// A part of a PNG file: length, name, data, checksum.
fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [name, data].concat();
    let mut sum = flate2::Crc::new();
    sum.update(&body);
    [&(data.len() as u32).to_be_bytes()[..], &body, &sum.sum().to_be_bytes()].concat()
}

fn deflated(size: usize) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    std::io::copy(&mut std::io::Read::take(std::io::repeat(0), size as u64), &mut encoder).unwrap();
    encoder.finish().unwrap()
}

/// A picture of one pixel, with more before its data.
fn pixel(colour_type: u8, more: &[u8], bytes: usize) -> Vec<u8> {
    let header = [0, 0, 0, 1, 0, 0, 0, 1, 8, colour_type, 0, 0, 0];
    let parts = [chunk(b"IHDR", &header), more.to_owned(), chunk(b"IDAT", &deflated(1 + bytes)), chunk(b"IEND", &[])];
    [&b"\x89PNG\r\n\x1a\n"[..], &parts.concat()].concat()
}

#[test]
fn a_palette_of_broken_colours_is_bad_input() {
    let root = folder("image-palette");
    fs::write(root.join("palette.png"), pixel(3, &chunk(b"PLTE", &[1, 2, 3, 4]), 1)).unwrap();
    let arguments = ["boundaries", root.join("palette.png").to_str().unwrap(), "--out"].map(str::to_owned);
    let out = root.join("out.png").to_str().unwrap().to_owned();
    assert_refused(&tracecut(arguments.into_iter().chain([out])), 3, &["palette.png", "its palette has 4 bytes"]);
}

#[test]
#[cfg(unix)]
fn files_that_claim_more_than_there_is_take_no_memory_for_it() {
    let root = folder("image-claims");
    let profile = [&b"x\0\0"[..], &deflated(1 << 30)].concat();
    fs::write(root.join("profile.png"), pixel(2, &chunk(b"iCCP", &profile), 3)).unwrap();
    let claim = [&b"GIF89a"[..], &[255; 4], &[0x80, 0, 0], &[0; 6]].concat();
    let frame = [0x2c, 0, 0, 0, 0, 1, 0, 1, 0, 0, 2, 2, 0x44, 1, 0, 0x3b];
    fs::write(root.join("canvas.gif"), [claim, frame.to_vec()].concat()).unwrap();
    // A small picture whose frame claims to be huge.
    let small = [&b"GIF89a"[..], &[1, 0, 1, 0, 0x80, 0, 0], &[0; 6]].concat();
    let huge = [0x2c, 0, 0, 0, 0, 255, 255, 255, 255, 0, 2, 2, 0x44, 1, 0, 0x3b];
    fs::write(root.join("frame.gif"), [small, huge.to_vec()].concat()).unwrap();
    fs::write(root.join("header.y4m"), "YUV4MPEG2 W16384 H16384 C444\nFRAME\n").unwrap();
    let limited = |words: &str| {
        let command = format!("ulimit -v 700000; exec {} {words}", env!("CARGO_BIN_EXE_tracecut"));
        std::process::Command::new("sh").args(["-c", &command]).current_dir(&root).output().unwrap()
    };
    assert_done(&limited("boundaries profile.png --out out.png"));
    assert_refused(&limited("segment canvas.gif --out out"), 4, &["canvas.gif", "frame size 65535x65535"]);
    assert_refused(&limited("segment frame.gif --out out"), 3, &["frame.gif: frame 0 cannot be decoded"]);
    let words = ["header.y4m", "268435456 pixels in a frame (expected at most 67108864; the parameter clip.maxPixels"];
    assert_refused(&limited("segment header.y4m --out out"), 4, &words);
    // Allowed, and then there is nothing: 800 MB that the header claims are not taken.
    let allowed = limited("segment header.y4m --out out --set clip.maxPixels=268435456");
    assert_refused(&allowed, 3, &["header.y4m", "frame 0 has 0 of 805306368 bytes"]);
    assert_refused(&limited("boundaries profile.png --out out.png --set clip.maxPixels=0"), 2, &["clip.maxPixels = 0"]);
}

#[test]
fn a_parameter_that_the_command_does_not_use_is_refused() {
    let root = folder("image-parameters");
    let image = picture(&root);
    let out = root.join("out");
    let run =
        |command: &str, setting: &str| tracecut([command, &image, "--out", out.to_str().unwrap(), "--set", setting]);
    assert_refused(&run("superpixels", "flow.patchStride=5"), 2, &["flow.patchStride = 5", "contour.*, superpixel.*"]);
    assert_refused(&run("superpixels", "Size=4"), 2, &["Size", "contour.*"]);
    assert_refused(&run("boundaries", "contour.high=0.5"), 2, &["contour.high", "still.*"]);
    assert!(!out.exists());
    assert_done(&run("boundaries", "clip.seed=3"));
    assert_done(&run("superpixels", "preset=fast"));
}
