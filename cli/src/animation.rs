//! Animated images (GIF, PNG, WebP), by the decoders of the `image` crate: every picture with its delay.

use crate::failure::{Failure, Result};
use crate::timeline::{Frames, Picture, StreamEnd, Timeline, check};
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::webp::WebPDecoder;
use image::error::{DecodingError, ImageFormatHint};
use image::metadata::Orientation;
use image::{AnimationDecoder, DynamicImage, ImageDecoder, ImageError, ImageResult, Limits};
use std::fmt::Display;
use std::io::{BufRead, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};
use tracecut::image::Frame;

/// A format of animated images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AnimationKind {
    Gif,
    Png,
    WebP,
}

impl AnimationKind {
    fn name(self) -> &'static str {
        match self {
            Self::Gif => "GIF",
            Self::Png => "PNG",
            Self::WebP => "WebP",
        }
    }
}

/// The decoded pictures of an image, before they are turned upright.
struct Animation {
    pictures: image::Frames<'static>,
    orientation: Orientation,
    /// True if the file is shorter than its header says.
    is_cut_off: bool,
}

/// Returns the pictures of an animated image of at most `max_pixels` pixels; a still one is an error.
pub(crate) fn frames(
    kind: AnimationKind,
    name: &str,
    reader: impl BufRead + Seek + 'static,
    max_pixels: usize,
) -> Result<Frames> {
    let animation = match kind {
        AnimationKind::Gif => open_gif(reader, max_pixels),
        AnimationKind::Png => open_png(reader, max_pixels),
        AnimationKind::WebP => open_webp(reader, max_pixels),
    };
    let animation = animation.map_err(|failure| match failure {
        OpenError::Image(e) => Failure::about(name, format_args!("is not a whole {}: {e}", kind.name())),
        OpenError::Size(e) => Failure::from(e).with_subject(name),
        OpenError::IsStill => Failure::about(name, STILL),
    })?;
    Ok(Box::new(Timeline::new(name, pictures_of(animation))))
}

/// The message for a still image.
pub(crate) const STILL: &str = "is a single picture (expected at least two, for example a folder of pictures)";

enum OpenError {
    Image(ImageError),
    Size(tracecut::Error),
    IsStill,
}

impl From<ImageError> for OpenError {
    fn from(error: ImageError) -> Self {
        Self::Image(error)
    }
}

/// Limits the memory of a decoder to three pictures: the decoded one, its canvas and the result.
fn limits(max_pixels: usize) -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(12 * max_pixels as u64);
    limits
}

/// Checks a size before a decoder allocates memory for it.
fn check_size(decoder: &impl ImageDecoder, max_pixels: usize) -> std::result::Result<(), OpenError> {
    let (width, height) = decoder.dimensions();
    check(width as usize, height as usize, max_pixels).map_err(OpenError::Size)
}

fn open_gif(reader: impl BufRead + Seek + 'static, max_pixels: usize) -> std::result::Result<Animation, OpenError> {
    let mut decoder = GifDecoder::new(reader)?;
    check_size(&decoder, max_pixels)?;
    // A picture may claim to be larger than the image.
    decoder.set_limits(limits(max_pixels))?;
    Ok(Animation { pictures: decoder.into_frames(), orientation: Orientation::NoTransforms, is_cut_off: false })
}

fn open_png(reader: impl BufRead + Seek + 'static, max_pixels: usize) -> std::result::Result<Animation, OpenError> {
    let mut decoder = PngDecoder::with_limits(reader, limits(max_pixels))?;
    check_size(&decoder, max_pixels)?;
    if !decoder.is_apng()? {
        return Err(OpenError::IsStill);
    }
    let orientation = decoder.orientation()?;
    Ok(Animation { pictures: decoder.apng()?.into_frames(), orientation, is_cut_off: false })
}

fn open_webp(
    mut reader: impl BufRead + Seek + 'static,
    max_pixels: usize,
) -> std::result::Result<Animation, OpenError> {
    let is_cut_off = is_webp_cut_off(&mut reader).map_err(ImageError::IoError)?;
    let mut decoder = WebPDecoder::new(reader)?;
    check_size(&decoder, max_pixels)?;
    if !decoder.has_animation() {
        return Err(OpenError::IsStill);
    }
    let orientation = decoder.orientation()?;
    Ok(Animation { pictures: decoder.into_frames(), orientation, is_cut_off })
}

/// Compares the length of a file with the one in its header, `RIFF` and a number of bytes to come.
fn is_webp_cut_off(reader: &mut (impl BufRead + Seek)) -> std::io::Result<bool> {
    let mut head = [0; 8];
    reader.read_exact(&mut head)?;
    let length = reader.seek(SeekFrom::End(0))?;
    reader.rewind()?;
    let [.., a, b, c, d] = head;
    Ok(length < 8 + u64::from(u32::from_le_bytes([a, b, c, d])))
}

fn pictures_of(animation: Animation) -> impl Iterator<Item = std::result::Result<Picture, StreamEnd>> {
    let Animation { mut pictures, orientation, is_cut_off } = animation;
    let (mut index, mut milliseconds) = (0_usize, 0.0);
    std::iter::from_fn(move || {
        let Some(decoded) = next_picture(&mut pictures) else {
            return is_cut_off.then(|| Err(damage(index, &"the file is cut off")));
        };
        let outcome = decoded.map_err(|e| damage(index, &e)).and_then(|decoded| {
            let (numerator, denominator) = decoded.delay().numer_denom_ms();
            let (time, delay) = (milliseconds / 1000.0, f64::from(numerator) / f64::from(denominator.max(1)));
            milliseconds += delay;
            let frame = upright_frame(decoded.into_buffer(), orientation)?;
            Ok(Picture { frame, time: Some(time), duration: Some(delay / 1000.0) })
        });
        index += 1;
        Some(outcome)
    })
}

/// Decodes a picture. A panic of the decoder on damaged bytes becomes an error.
fn next_picture(pictures: &mut image::Frames<'static>) -> Option<ImageResult<image::Frame>> {
    let panicked = |_| {
        let message = "the decoder stopped on an internal error".to_owned();
        Some(Err(ImageError::Decoding(DecodingError::new(ImageFormatHint::Unknown, message))))
    };
    catch_unwind(AssertUnwindSafe(|| pictures.next())).unwrap_or_else(panicked)
}

fn upright_frame(picture: image::RgbaImage, orientation: Orientation) -> std::result::Result<Frame, StreamEnd> {
    let mut picture = DynamicImage::ImageRgba8(picture);
    picture.apply_orientation(orientation);
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Frame::from_rgba(picture.as_bytes(), width, height).map_err(|e| StreamEnd::Failure(Failure::from(e)))
}

fn damage(index: usize, error: &dyn Display) -> StreamEnd {
    StreamEnd::Damage(format!("frame {index} cannot be decoded: {error}"))
}
