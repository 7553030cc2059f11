//! Small files that readers accept: the first inputs of fuzzing and property tests.

use super::choices::{Choices, mutate};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::ops::Range;

/// A small file for a fuzz target: target, name, bytes.
pub type Seed = (&'static str, String, Vec<u8>);

/// Targets that take choices, not files.
const CHOICE_TARGETS: [&str; 6] = ["session", "outside_tracks", "corrections", "halves", "windows", "image"];

/// A fuzz target, and the function that reads its input.
pub type Reader = (&'static str, fn(&[u8]));

/// Returns the seeds of a target: name and bytes.
pub fn of_target(target: &str) -> Vec<(String, Vec<u8>)> {
    all().into_iter().filter(|seed| seed.0 == target).map(|(_, name, bytes)| (name, bytes)).collect()
}

/// Has each reader read its seeds, then these seeds with faults.
pub fn read_with_faults(readers: &[Reader], faults: Range<u64>) {
    for &(target, reader) in readers {
        let files = of_target(target);
        assert!(!files.is_empty(), "{target}");
        files.iter().for_each(|(_, file)| reader(file));
        for seed in faults.clone() {
            let mut choices = Choices::from_seed(seed, target);
            let (file, other) = (choices.below(files.len()), choices.below(files.len()));
            let bytes = mutate(&mut choices, &files[file].1, &files[other].1);
            let outcome = std::panic::catch_unwind(|| reader(&bytes));
            assert!(outcome.is_ok(), "{target}, seed {seed}: {bytes:?}");
        }
    }
}

/// Returns the seeds of all targets.
pub fn all() -> Vec<Seed> {
    fn named(target: &'static str, files: Vec<(&'static str, Vec<u8>)>) -> impl Iterator<Item = Seed> {
        files.into_iter().map(move |(name, bytes)| (target, name.to_owned(), bytes))
    }
    let mut seeds: Vec<Seed> = named("image_file", [pngs(), jpegs(), ppms()].concat()).collect();
    seeds.extend(named("animation", animations()));
    seeds.extend(named("y4m", y4ms()));
    seeds.extend(named("bmf", vec![("list.bmf", b"2 1\nframe_1.ppm\nframe_2.ppm\n".to_vec())]));
    seeds.extend(named("tracks_dat", track_files()));
    seeds.extend(named("flo", vec![("known.flo", flo(3, 2)), ("one.flo", flo(1, 1))]));
    seeds.extend(named("pgm", pgms()));
    seeds.extend(named("definition", vec![("Def.dat", DEFINITION.as_bytes().to_vec())]));
    seeds.extend(named("parameters", parameters()));
    seeds.extend(named("setting", vec![("one", b"flow.patchStride=5".to_vec()), ("two", b"preset=paper".to_vec())]));
    for target in CHOICE_TARGETS {
        seeds.extend((0..8).map(|k| (target, format!("choices-{k}"), choices(k))));
    }
    seeds
}

/// Bytes for some tens of choices.
fn choices(k: u64) -> Vec<u8> {
    let mut rng = Choices::from_seed(k, "seeds");
    let length = 8 + (24 << (k / 2));
    (0..length).map(|_| rng.below(256) as u8).collect()
}

/// Deflate without compression, as zlib holds it.
fn zlib(data: &[u8]) -> Vec<u8> {
    let (mut a, mut b) = (1_u32, 0_u32);
    for &byte in data {
        a = (a + u32::from(byte)) % 65_521;
        b = (b + a) % 65_521;
    }
    let length = data.len() as u16;
    let head = [[0x78, 0x01, 0x01].as_slice(), &length.to_le_bytes(), &(!length).to_le_bytes()].concat();
    [head, data.to_vec(), (b << 16 | a).to_be_bytes().to_vec()].concat()
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1)))
    })
}

/// Returns a chunk of a PNG file.
pub fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [name.as_slice(), data].concat();
    [(data.len() as u32).to_be_bytes().to_vec(), named.clone(), crc(&named).to_be_bytes().to_vec()].concat()
}

/// A PNG of 5 by 3 pixels with `bits` for each of `channels` numbers; extra chunks stand before the pixels.
fn png(colour: u8, bits: u8, channels: usize, interlaced: bool, extra: &[Vec<u8>]) -> Vec<u8> {
    let head = [&5_u32.to_be_bytes()[..], &3_u32.to_be_bytes(), &[bits, colour, 0, 0, u8::from(interlaced)]].concat();
    let row = |width: usize, filter: u8| {
        let bytes = (width * channels * usize::from(bits)).div_ceil(8);
        [vec![filter], (0..bytes).map(|k| (k * 37) as u8).collect()].concat()
    };
    // Adam7 of five by three pixels has these rows with pixels in them; whole rows use each filter in turn.
    let widths: &[usize] = if interlaced { &[1, 1, 1, 3, 2, 2, 5] } else { &[5, 5, 5] };
    let rows: Vec<u8> = widths.iter().enumerate().flat_map(|(k, &w)| row(w, (k % 5) as u8)).collect();
    let chunks = [chunk(b"IHDR", &head), extra.concat(), chunk(b"IDAT", &zlib(&rows)), chunk(b"IEND", &[])];
    [b"\x89PNG\r\n\x1a\n".to_vec(), chunks.concat()].concat()
}

fn pngs() -> Vec<(&'static str, Vec<u8>)> {
    let palette = [chunk(b"PLTE", &[0, 0, 0, 255, 255, 255, 9, 99, 199, 50, 60, 70]), chunk(b"tRNS", &[0, 128])];
    let profile = [chunk(b"iCCP", &[b"name\0\0".to_vec(), zlib(&[7; 40])].concat()), chunk(b"gAMA", &[0, 0, 177, 143])];
    let words = [chunk(b"tEXt", b"Title\0text"), chunk(b"zTXt", &[b"Note\0\0".to_vec(), zlib(b"text")].concat())];
    vec![
        ("grey1.png", png(0, 1, 1, false, &[])),
        ("grey8.png", png(0, 8, 1, false, &words)),
        ("grey16.png", png(0, 16, 1, true, &[])),
        ("rgb8.png", png(2, 8, 3, false, &profile)),
        ("rgb16.png", png(2, 16, 3, false, &[])),
        ("palette2.png", png(3, 2, 1, false, &palette)),
        ("greya8.png", png(4, 8, 2, true, &[])),
        ("rgba8.png", png(6, 8, 4, true, &[])),
        ("rgba16.png", png(6, 16, 4, false, &[])),
        (
            "turned.png",
            png(2, 8, 3, false, &[chunk(b"eXIf", b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0")]),
        ),
        // The first finding: a palette of four bytes.
        ("palette-of-4.png", png(3, 8, 1, false, &[chunk(b"PLTE", &[1, 2, 3, 4])])),
    ]
}

fn jpegs() -> Vec<(&'static str, Vec<u8>)> {
    let encoded = |width: u32, height: u32, channels: u32, colour| {
        let pixels: Vec<u8> = (0..width * height * channels).map(|k| (k * k) as u8).collect();
        let mut bytes = Vec::new();
        JpegEncoder::new_with_quality(&mut bytes, 60).write_image(&pixels, width, height, colour).unwrap();
        bytes
    };
    let (rgb, grey) = (ExtendedColorType::Rgb8, ExtendedColorType::L8);
    vec![("rgb.jpg", encoded(17, 9, 3, rgb)), ("grey.jpg", encoded(8, 8, 1, grey))]
}

fn ppms() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("binary.ppm", b"P6\n# text\n2 2\n255\nabcdefghijkl".to_vec()),
        ("text.ppm", b"P3 2 1 255 1 2 3 40 50 60\n".to_vec()),
        ("bits.pbm", b"P1 3 2\n1 0 1 0 1 0\n".to_vec()),
        ("grey16.pgm", b"P5 2 1 65535\nabcd".to_vec()),
        ("map.pam", b"P7\nWIDTH 2\nHEIGHT 1\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\nabcdef".to_vec()),
    ]
}

fn animations() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("two.gif", gif(2, false)),
        ("parts.gif", gif(3, true)),
        ("two.png", animated_png()),
        ("two.webp", animated_webp()),
    ]
}

/// A PNG of 5 by 3 pixels, on which a second picture of 2 by 2 is laid.
fn animated_png() -> Vec<u8> {
    // Number, width, height, left, top, delay in hundredths of a second, disposal and blending.
    let control = |number: u32, [width, height, left, top]: [u32; 4]| {
        let size = [number, width, height, left, top].map(u32::to_be_bytes).concat();
        chunk(b"fcTL", &[size, vec![0, 4, 0, 100, 1, 1]].concat())
    };
    let first = [chunk(b"acTL", &[0, 0, 0, 2, 0, 0, 0, 0]), control(0, [5, 3, 0, 0])].concat();
    let rows = zlib(&[0, 9, 99, 199, 128, 1, 2, 3, 255, 2, 40, 50, 60, 10, 7, 7, 7, 70]);
    let second = [control(1, [2, 2, 2, 1]), chunk(b"fdAT", &[vec![0, 0, 0, 2], rows].concat())].concat();
    let mut bytes = png(6, 8, 4, false, &[first]);
    let end = bytes.len() - 12;
    bytes.splice(end..end, second);
    bytes
}

/// A WebP of 2 by 2 pixels and two lossless pictures.
fn animated_webp() -> Vec<u8> {
    let part = |name: &[u8; 4], data: &[u8]| {
        let padding = vec![0; data.len() % 2];
        [name.to_vec(), (data.len() as u32).to_le_bytes().to_vec(), data.to_vec(), padding].concat()
    };
    let pictures = [
        &b"\x2f\x01\x40\0\0\x1f\x20\x10\x48\xda\x1f\x7a\x8d\xf9\x8f\xf9\x0f\x8e\x02\x4a\x02\x04\x40\x51\x46\x22\xfa\x1f\x03"[..],
        b"\x2f\x01\x40\0\0\x1f\x20\x10\x48\xda\x1f\x7a\x8d\xf9\x1f\xad\xf9\x0f\x1e\x12\xa0\x24\x40\0\x14\x65\x24\xa2\xff\x31",
    ];
    // Left, top, width and height less one, 40 milliseconds, no blending.
    let place = [0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 40, 0, 0, 2];
    let shown = |data: &&[u8]| part(b"ANMF", &[place.to_vec(), part(b"VP8L", data)].concat());
    let parts = [
        b"WEBP".to_vec(),
        part(b"VP8X", &[2, 0, 0, 0, 1, 0, 0, 1, 0, 0]),
        part(b"ANIM", &[0; 6]),
        pictures.iter().flat_map(shown).collect(),
    ];
    part(b"RIFF", &parts.concat())
}

/// A GIF of 4 by 3 pixels, whose codes have four bits all the time, as each row begins with a clear code.
fn gif(frames: u8, parts: bool) -> Vec<u8> {
    let mut bytes = b"GIF89a\x04\0\x03\0\x81\0\0".to_vec();
    bytes.extend([0, 0, 0, 255, 0, 0, 0, 255, 0, 0, 0, 255]);
    bytes.extend(b"\x21\xff\x0bNETSCAPE2.0\x03\x01\0\0\0");
    for t in 0..frames {
        bytes.extend([0x21, 0xf9, 4, if parts { 4 * t + 1 } else { 0 }, 5, 0, 3, 0]);
        let (left, width, height) = if parts && t > 0 { (t, 2_u8, 2_u8) } else { (0, 4, 3) };
        bytes.extend([0x2c, left, 0, 0, 0, width, 0, height, 0, if parts { 0x40 } else { 0 }, 3]);
        let mut codes: Vec<u8> = Vec::new();
        for y in 0..height {
            codes.push(8);
            codes.extend((0..width).map(|x| (x + y + t) % 4));
        }
        codes.push(9);
        let packed: Vec<u8> = codes.chunks(2).map(|two| two[0] | two.get(1).unwrap_or(&0) << 4).collect();
        bytes.push(packed.len() as u8);
        bytes.extend(packed);
        bytes.push(0);
    }
    bytes.push(0x3b);
    bytes
}

fn y4ms() -> Vec<(&'static str, Vec<u8>)> {
    let stream = |head: &str, size: usize, frames: usize| {
        let frame: Vec<u8> = (0..size).map(|k| (k * 31) as u8).collect();
        let frames: Vec<u8> = (0..frames).flat_map(|_| [b"FRAME\n".to_vec(), frame.clone()].concat()).collect();
        [format!("YUV4MPEG2 {head}\n").into_bytes(), frames].concat()
    };
    vec![
        ("420.y4m", stream("W4 H3 F25:1 Ip A1:1 C420jpeg XYSCSS=420JPEG", 12 + 8, 2)),
        ("422.y4m", stream("W3 H2 C422", 6 + 8, 1)),
        ("444.y4m", stream("W2 H2 C444 XCOLORRANGE=FULL", 12, 3)),
        ("mono.y4m", stream("W2 H1 Cmono", 2, 2)),
    ]
}

fn track_files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("two.dat", b"5\n2\n0 2\n1.500 2.250 0\n2.000 3.000 1\n1 1\n0.125 7.500 3\n".to_vec()),
        ("none.dat", b"2\n0\n".to_vec()),
        ("spaces.dat", b"3\r\n1\r\n\r\n0 3\r\n1e1 2 0\r\n 1e-1 2 1\r\n-1 +2 2\r\n\r\n".to_vec()),
    ]
}

fn flo(width: i32, height: i32) -> Vec<u8> {
    let pixels = 2 * width * height;
    let mut bytes = [202_021.25_f32.to_le_bytes(), width.to_le_bytes(), height.to_le_bytes()].concat();
    bytes.extend((0..pixels).flat_map(|k| if k == 3 { 1.7e9_f32 } else { k as f32 * 0.5 - 1.0 }.to_le_bytes()));
    bytes
}

fn pgms() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("plain.pgm", b"P5\n2 2\n255\n\x0a\x0d\x0a\xc8".to_vec()),
        ("crlf.pgm", b"P5\r\n2 2\r\n255\r\n\x0a\x0d\x0a\xc8".to_vec()),
        ("comment.pgm", b"P5\n# a b\n3 1\n# c\n255\nabc".to_vec()),
    ]
}

const DEFINITION: &str = "Ground truth definition file\n\nTotal number of regions:\n2\nScale of region 0:\n0\n\
    Scale of region 7:\n255\n\nConfusion penality matrix:\n0 0.5 \n1   0\n\nTotal number of frames in this shot:\n30\n\
    Total number of labeled frames for this shot:\n2\nFrame number:\n0\nFile name:\na_01.pgm\nInput file name:\n\
    a_01.ppm\nFrame number:\n9\r\nFile name:\na_10.pgm\nInput file name:\na_10.ppm\n";

fn parameters() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("some.json", br#"{"flow": {"patchStride": 5}, "clip": {"dense": false, "maxSide": 64}}"#.to_vec()),
        ("preset.json", br#"{"preset": "paper", "cut": {"spatialWeight": 0.5}}"#.to_vec()),
        ("odd.json", br#"{"a.b": null, "clip": {"seed": 1e300, "x": [1, "2"], "maxSide": "64"}}"#.to_vec()),
    ]
}
