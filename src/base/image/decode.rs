//! Decodes image files to RGB with the PNG and JPEG decoders of the `image` crate.
//!
//! In: the bytes of one file. Out: three bytes a pixel, turned upright by the file's EXIF orientation. Sixteen bits
//! become eight, grey becomes RGB; alpha and colour profiles are ignored. The decoders are called directly, not through
//! `image::DynamicImage`, whose conversions between all colour types and profiles would double the size of the wasm file.

use crate::Error;
use crate::error::{IS_JAVASCRIPT, MAX_PIXELS, check_size};
use image::codecs::{jpeg::JpegDecoder, png::PngDecoder};
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, Limits};
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// RGB bytes, width and height.
type Pixels = (Vec<u8>, usize, usize);

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_MAGIC: &[u8] = b"\xff\xd8\xff";

/// The parameter that limits the size of a file.
const LIMIT_NAME: &str = if IS_JAVASCRIPT { "clip.maxPixels" } else { "clip.max_pixels" };

/// Decodes a PNG or JPEG file of at most `max_pixels` pixels. The size is checked before memory is allocated.
pub(super) fn decode(bytes: &[u8], max_pixels: usize) -> Result<Pixels, Error> {
    // A decoder's panic on damaged bytes becomes an error, where panics can be caught.
    let result = catch_unwind(AssertUnwindSafe(|| decode_any(bytes, max_pixels)));
    result.unwrap_or_else(|_| Err(failure(&"the decoder stopped on an internal error")))
}

fn decode_any(bytes: &[u8], max_pixels: usize) -> Result<Pixels, Error> {
    if bytes.starts_with(PNG_MAGIC) {
        // Version 0.18 of the decoder panics on such a palette.
        if let Some(palette) = png_chunk(bytes, b"PLTE").filter(|palette| palette.len() % 3 != 0) {
            return Err(failure(&format_args!("its palette has {} bytes, not three for each colour", palette.len())));
        }
        // Limits colour profiles, which may expand a thousandfold.
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(max_pixels.max(MAX_PIXELS) as u64);
        let pixels =
            read_rgb(PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(|e| failure(&e))?, max_pixels)?;
        Ok(turn_upright(pixels, orientation_in(png_chunk(bytes, b"eXIf"))))
    } else if bytes.starts_with(JPEG_MAGIC) {
        if !is_complete_jpeg(bytes) {
            return Err(failure(&"the JPEG data are truncated"));
        }
        let pixels = read_rgb(JpegDecoder::new(Cursor::new(bytes)).map_err(|e| failure(&e))?, max_pixels)?;
        Ok(turn_upright(pixels, orientation_in(jpeg_exif(bytes))))
    } else if let Some(result) = decode_pnm(bytes, max_pixels) {
        result
    } else {
        Err(failure(&format_args!("{} bytes that begin like neither", bytes.len())))
    }
}

/// The original layout of the Moseg benchmark holds PPM files; only the command line reads them.
#[cfg(feature = "pnm")]
fn decode_pnm(bytes: &[u8], max_pixels: usize) -> Option<Result<Pixels, Error>> {
    let decoder = bytes.starts_with(b"P").then(|| image::codecs::pnm::PnmDecoder::new(Cursor::new(bytes)))?;
    Some(decoder.map_err(|e| failure(&e)).and_then(|decoder| read_rgb(decoder, max_pixels)))
}

#[cfg(not(feature = "pnm"))]
fn decode_pnm(_: &[u8], _: usize) -> Option<Result<Pixels, Error>> {
    None
}

fn read_rgb(decoder: impl ImageDecoder, max_pixels: usize) -> Result<Pixels, Error> {
    let (width, height) = (decoder.dimensions().0 as usize, decoder.dimensions().1 as usize);
    check_size(width, height)?;
    if width * height > max_pixels {
        return Err(Error::TooLarge {
            what: "pixels in an image file",
            actual: width * height,
            limit: max_pixels,
            name: LIMIT_NAME.to_owned(),
        });
    }
    let color = decoder.color_type();
    let mut pixels = vec![0; width * height * usize::from(color.bytes_per_pixel())];
    decoder.read_image(&mut pixels).map_err(|e| failure(&e))?;
    let rgb = match color {
        ColorType::L8 => pixels.iter().flat_map(|&v| [v; 3]).collect(),
        ColorType::La8 => pixels.chunks_exact(2).flat_map(|p| [p[0]; 3]).collect(),
        ColorType::Rgb8 => pixels,
        ColorType::Rgba8 => pixels.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect(),
        ColorType::L16 => high_bytes(&pixels, 1, [0, 0, 0]),
        ColorType::La16 => high_bytes(&pixels, 2, [0, 0, 0]),
        ColorType::Rgb16 => high_bytes(&pixels, 3, [0, 1, 2]),
        ColorType::Rgba16 => high_bytes(&pixels, 4, [0, 1, 2]),
        unsupported => return Err(failure(&format_args!("its colour type {unsupported:?} is not supported"))),
    };
    Ok((rgb, width, height))
}

/// Applies an EXIF orientation, a transposition followed by mirroring.
fn turn_upright(pixels: Pixels, orientation: Orientation) -> Pixels {
    let (is_transposed, is_mirrored, is_flipped) = match orientation {
        Orientation::NoTransforms => return pixels,
        Orientation::FlipHorizontal => (false, true, false),
        Orientation::Rotate180 => (false, true, true),
        Orientation::FlipVertical => (false, false, true),
        Orientation::Rotate90FlipH => (true, false, false),
        Orientation::Rotate90 => (true, false, true),
        Orientation::Rotate270FlipH => (true, true, true),
        Orientation::Rotate270 => (true, true, false),
    };
    let (rgb, width, height) = pixels;
    let size = if is_transposed { (height, width) } else { (width, height) };
    let mut upright = Vec::with_capacity(rgb.len());
    for y in 0..size.1 {
        for x in 0..size.0 {
            let (x, y) = if is_transposed { (y, x) } else { (x, y) };
            let x = if is_mirrored { width - 1 - x } else { x };
            let y = if is_flipped { height - 1 - y } else { y };
            upright.extend_from_slice(&rgb[3 * (y * width + x)..][..3]);
        }
    }
    (upright, size.0, size.1)
}

/// Returns the high bytes of three channels of pixels that have `channels` 16-bit numbers in native byte order.
fn high_bytes(pixels: &[u8], channels: usize, pick: [usize; 3]) -> Vec<u8> {
    let byte = |pixel: &[u8], c: usize| (u16::from_ne_bytes([pixel[2 * c], pixel[2 * c + 1]]) >> 8) as u8;
    pixels.chunks_exact(2 * channels).flat_map(|pixel| pick.map(|c| byte(pixel, c))).collect()
}

/// Returns the data of a PNG's first chunk of this name.
fn png_chunk<'a>(bytes: &'a [u8], name: &[u8; 4]) -> Option<&'a [u8]> {
    let mut rest = bytes.get(PNG_MAGIC.len()..)?;
    while let [a, b, c, d, chunk @ ..] = rest {
        let end = (u32::from_be_bytes([*a, *b, *c, *d]) as usize).checked_add(4)?;
        if chunk.starts_with(name) {
            return chunk.get(4..end.min(chunk.len()));
        }
        // Skips the checksum.
        rest = chunk.get(end.checked_add(4)?..)?;
    }
    None
}

const START_OF_SCAN: u8 = 0xda;

/// Splits a JPEG file into its header segments, each with its marker. The last one is the start of scan with the rest of
/// the file.
fn jpeg_segments(bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    let mut rest = bytes.get(2..).unwrap_or(&[]);
    std::iter::from_fn(move || {
        // Skips fill bytes before a marker.
        while let [0xff, 0xff, ..] = rest {
            rest = &rest[1..];
        }
        let [0xff, marker, data @ ..] = rest else { return None };
        let length = match data {
            [high, low, ..] if *marker != START_OF_SCAN => usize::from(u16::from_be_bytes([*high, *low])),
            _ => data.len(),
        };
        let segment;
        (segment, rest) = data.split_at_checked(length)?;
        Some((*marker, segment))
    })
}

/// Returns true if an end-of-image marker follows the first scan (a thumbnail in the header has its own). The decoder
/// fills the missing part of a truncated file with grey instead of failing, and such areas would pass for motion.
fn is_complete_jpeg(bytes: &[u8]) -> bool {
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    let scans = jpeg_segments(bytes).find(|&(marker, _)| marker == START_OF_SCAN);
    scans.is_some_and(|(_, data)| data.windows(2).any(|two| two == END_OF_IMAGE))
}

/// Returns the EXIF data of a JPEG file.
fn jpeg_exif(bytes: &[u8]) -> Option<&[u8]> {
    const APPLICATION_1: u8 = 0xe1;
    let blocks = jpeg_segments(bytes).filter(|&(marker, _)| marker == APPLICATION_1);
    blocks.filter_map(|(_, block)| block.get(2..)?.strip_prefix(b"Exif\0\0")).next()
}

/// Returns the orientation in EXIF data; unreadable data has none.
fn orientation_in(exif: Option<&[u8]>) -> Orientation {
    exif.and_then(Orientation::from_exif_chunk).unwrap_or(Orientation::NoTransforms)
}

fn failure(reason: &dyn std::fmt::Display) -> Error {
    Error::Decode { reason: reason.to_string() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientations_are_those_of_exif() {
        // 0 1 2
        // 3 4 5
        let stored: Vec<u8> = (0..6).flat_map(|v| [v; 3]).collect();
        for (mark, size, upright) in [
            (1, (3, 2), [0, 1, 2, 3, 4, 5]),
            (2, (3, 2), [2, 1, 0, 5, 4, 3]),
            (3, (3, 2), [5, 4, 3, 2, 1, 0]),
            (4, (3, 2), [3, 4, 5, 0, 1, 2]),
            (5, (2, 3), [0, 3, 1, 4, 2, 5]),
            (6, (2, 3), [3, 0, 4, 1, 5, 2]),
            (7, (2, 3), [5, 2, 4, 1, 3, 0]),
            (8, (2, 3), [2, 5, 1, 4, 0, 3]),
        ] {
            let orientation = Orientation::from_exif(mark).unwrap();
            let (rgb, width, height) = turn_upright((stored.clone(), 3, 2), orientation);
            let first: Vec<u8> = rgb.iter().step_by(3).copied().collect();
            assert_eq!(((width, height), first), (size, upright.to_vec()), "orientation {mark}");
        }
    }

    #[test]
    fn files_with_an_orientation_are_upright() {
        use image::codecs::{jpeg::JpegEncoder, png::PngEncoder};
        use image::{ExtendedColorType, ImageEncoder};
        let exif = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0".to_vec();
        // The left half is dark; turned clockwise it is above.
        let stored: Vec<u8> = (0..16 * 32).map(|i| if i % 32 < 16 { 30 } else { 220 }).collect();
        let (mut png, mut jpeg) = (Vec::new(), Vec::new());
        let mut encoder = PngEncoder::new(&mut png);
        encoder.set_exif_metadata(exif.clone()).unwrap();
        encoder.write_image(&stored, 32, 16, ExtendedColorType::L8).unwrap();
        let mut encoder = JpegEncoder::new(&mut jpeg);
        encoder.set_exif_metadata(exif).unwrap();
        encoder.write_image(&stored, 32, 16, ExtendedColorType::L8).unwrap();
        for (file, name) in [(png, "PNG"), (jpeg, "JPEG")] {
            let (rgb, width, height) = decode(&file, MAX_PIXELS).unwrap();
            assert_eq!((width, height), (16, 32), "{name}");
            let is_dark = |i: usize| rgb[3 * i] < 128;
            assert!((0..16 * 32).all(|i| is_dark(i) == (i < 16 * 16)), "{name}");
        }
    }
}
