//! Animated images (GIF, PNG, WebP), by the decoders of the `image` crate: every picture with its delay.

use crate::clip_frame::{Frames, check};
use crate::failure::{Failure, Result};
use crate::timeline::{Picture, Stop, Timeline};
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

/// A kind of animated image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Gif,
    Png,
    WebP,
}

impl Kind {
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
    /// Whether the file ends before the length that it says of itself.
    is_cut_off: bool,
}

/// Returns the pictures of an animated image of at most `most` pixels; a still one is an error.
pub(crate) fn frames(kind: Kind, name: &str, reader: impl BufRead + Seek + 'static, most: usize) -> Result<Frames> {
    let animation = match kind {
        Kind::Gif => open_gif(reader, most),
        Kind::Png => open_png(reader, most),
        Kind::WebP => open_webp(reader, most),
    };
    let animation = animation.map_err(|failure| match failure {
        OpenError::Image(e) => Failure::about(name, format_args!("is not a whole {}: {e}", kind.name())),
        OpenError::Size(e) => Failure::from(e).of(name),
        OpenError::IsStill => Failure::about(name, STILL),
    })?;
    Ok(Box::new(Timeline::new(name, pictures_of(animation))))
}

/// Says that a file is no clip.
pub(crate) const STILL: &str = "is a single picture (a clip needs two at least; name the folder that holds them)";

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

/// Most memory that a decoder may take: it holds a picture, what that is painted over, and what comes of it.
fn limits(most: usize) -> Limits {
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(12 * most as u64);
    limits
}

/// Refuses a size before a decoder takes memory for it.
fn check_size(decoder: &impl ImageDecoder, most: usize) -> std::result::Result<(), OpenError> {
    let (width, height) = decoder.dimensions();
    check(width as usize, height as usize, most).map_err(OpenError::Size)
}

fn open_gif(reader: impl BufRead + Seek + 'static, most: usize) -> std::result::Result<Animation, OpenError> {
    let mut decoder = GifDecoder::new(reader)?;
    check_size(&decoder, most)?;
    // A picture may claim to be larger than the image.
    decoder.set_limits(limits(most))?;
    Ok(Animation { pictures: decoder.into_frames(), orientation: Orientation::NoTransforms, is_cut_off: false })
}

fn open_png(reader: impl BufRead + Seek + 'static, most: usize) -> std::result::Result<Animation, OpenError> {
    let mut decoder = PngDecoder::with_limits(reader, limits(most))?;
    check_size(&decoder, most)?;
    if !decoder.is_apng()? {
        return Err(OpenError::IsStill);
    }
    let orientation = decoder.orientation()?;
    Ok(Animation { pictures: decoder.apng()?.into_frames(), orientation, is_cut_off: false })
}

fn open_webp(mut reader: impl BufRead + Seek + 'static, most: usize) -> std::result::Result<Animation, OpenError> {
    let is_cut_off = is_webp_cut_off(&mut reader).map_err(ImageError::IoError)?;
    let mut decoder = WebPDecoder::new(reader)?;
    check_size(&decoder, most)?;
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

fn pictures_of(animation: Animation) -> impl Iterator<Item = std::result::Result<Picture, Stop>> {
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

/// Decodes a picture. A decoder that panics on damaged bytes is an error of these.
fn next_picture(pictures: &mut image::Frames<'static>) -> Option<ImageResult<image::Frame>> {
    let panicked = |_| {
        let words = "the decoder stopped on an internal error".to_owned();
        Some(Err(ImageError::Decoding(DecodingError::new(ImageFormatHint::Unknown, words))))
    };
    catch_unwind(AssertUnwindSafe(|| pictures.next())).unwrap_or_else(panicked)
}

fn upright_frame(picture: image::RgbaImage, orientation: Orientation) -> std::result::Result<Frame, Stop> {
    let mut picture = DynamicImage::ImageRgba8(picture);
    picture.apply_orientation(orientation);
    let (width, height) = (picture.width() as usize, picture.height() as usize);
    Frame::from_rgba(picture.as_bytes(), width, height).map_err(|e| Stop::Failure(Failure::from(e)))
}

fn damage(index: usize, error: &dyn Display) -> Stop {
    Stop::Damage(format!("frame {index} cannot be decoded: {error}"))
}
