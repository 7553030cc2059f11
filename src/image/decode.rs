//! Image files to RGB: PNG and JPEG by the decoders themselves, so that a page need not fetch the code of a format converter.
//!
//! In: the bytes of one file. Out: three bytes a pixel. PNG: palettes and bits are expanded, sixteen bits become eight, alpha is
//! ignored, colour profiles too. JPEG: converted from whatever it stores; orientation marks are ignored.

use super::frame::check_size;
use crate::Error;
use png::{ColorType, Transformations};
use std::io::Cursor;
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_MAGIC: &[u8] = b"\xff\xd8\xff";

/// RGB bytes, width and height of a PNG or JPEG file. Sizes are checked before memory is taken.
pub(super) fn decode(bytes: &[u8]) -> Result<(Vec<u8>, usize, usize), Error> {
    if bytes.starts_with(PNG_MAGIC) {
        decode_png(bytes)
    } else if bytes.starts_with(JPEG_MAGIC) {
        decode_jpeg(bytes)
    } else {
        Err(failure(&format_args!("{} bytes that begin like neither", bytes.len())))
    }
}

fn decode_png(bytes: &[u8]) -> Result<(Vec<u8>, usize, usize), Error> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(Transformations::normalize_to_color8());
    let header = decoder.read_header_info().map_err(|e| failure(&e))?;
    let (width, height) = (header.width as usize, header.height as usize);
    check_size(width, height)?;
    let mut reader = decoder.read_info().map_err(|e| failure(&e))?;
    let size = reader.output_buffer_size().ok_or(Error::FrameSize { width, height })?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(|e| failure(&e))?;
    let rgb = match info.color_type {
        ColorType::Grayscale => pixels.iter().flat_map(|&v| [v; 3]).collect(),
        ColorType::GrayscaleAlpha => pixels.chunks_exact(2).flat_map(|p| [p[0]; 3]).collect(),
        ColorType::Rgba => pixels.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect(),
        ColorType::Rgb => pixels,
        ColorType::Indexed => return Err(failure(&"its palette was not expanded")),
    };
    Ok((rgb, width, height))
}

fn decode_jpeg(bytes: &[u8]) -> Result<(Vec<u8>, usize, usize), Error> {
    if !jpeg_is_whole(bytes) {
        return Err(failure(&"the JPEG data are truncated"));
    }
    let options = DecoderOptions::default()
        .set_strict_mode(false)
        .set_max_width(usize::MAX)
        .set_max_height(usize::MAX)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|e| failure(&e))?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    check_size(width, height)?;
    let rgb = decoder.decode().map_err(|e| failure(&e))?;
    Ok((rgb, width, height))
}

/// Whether the end-of-image marker follows the first scan. The decoder paints what is missing of a truncated file grey instead
/// of failing, and grey areas that come and go would pass for motion.
fn jpeg_is_whole(bytes: &[u8]) -> bool {
    const START_OF_SCAN: u8 = 0xda;
    const END_OF_IMAGE: [u8; 2] = [0xff, 0xd9];
    // Walk over the header's segments by their lengths: a thumbnail in one of them has an end marker of its own.
    let mut rest = bytes.get(2..).unwrap_or(&[]);
    while let [0xff, marker, high, low, ..] = *rest {
        if marker == START_OF_SCAN {
            return rest.windows(2).any(|w| w == END_OF_IMAGE);
        }
        // A fill byte stands before some markers.
        let length = if marker == 0xff { 1 } else { 2 + usize::from(u16::from_be_bytes([high, low])) };
        rest = rest.get(length..).unwrap_or(&[]);
    }
    false
}

fn failure(reason: &dyn std::fmt::Display) -> Error {
    Error::Decode { reason: reason.to_string() }
}
