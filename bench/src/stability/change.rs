//! Changes of a clip that do not matter.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::fmt;
use std::str::FromStr;
use tracecut::image::{Frame, Plane};
use tracecut_cli::failure::{Failure, Result};

/// Quality of a JPEG file that a frame goes through.
const JPEG_QUALITY: u8 = 80;
/// What is left of the light.
const DARK: f32 = 0.95;

/// What is done to a clip before it is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Change {
    /// Nothing.
    Base,
    /// Another seed.
    Seed(u32),
    /// Without this many first columns and rows.
    Crop(usize),
    /// Left and right swapped.
    Mirror,
    /// A twentieth darker.
    Dark,
    /// Through a JPEG file.
    Jpeg,
    /// From the second frame on.
    Later,
}

pub(super) const ALL: &str = "base,seed1,seed2,crop1,crop4,mirror,dark,jpeg,later";

impl FromStr for Change {
    type Err = String;

    fn from_str(name: &str) -> std::result::Result<Self, String> {
        let unknown = || format!("expected some of {ALL}; seed and crop with any number");
        match name {
            "base" => Ok(Self::Base),
            "mirror" => Ok(Self::Mirror),
            "dark" => Ok(Self::Dark),
            "jpeg" => Ok(Self::Jpeg),
            "later" => Ok(Self::Later),
            other => {
                let number = |prefix| other.strip_prefix(prefix).and_then(|n: &str| n.parse::<u32>().ok());
                let crop = || number("crop").map(|n| Self::Crop(n as usize));
                number("seed").map(Self::Seed).or_else(crop).ok_or_else(unknown)
            }
        }
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base => f.write_str("base"),
            Self::Seed(seed) => write!(f, "seed{seed}"),
            Self::Crop(pixels) => write!(f, "crop{pixels}"),
            Self::Mirror => f.write_str("mirror"),
            Self::Dark => f.write_str("dark"),
            Self::Jpeg => f.write_str("jpeg"),
            Self::Later => f.write_str("later"),
        }
    }
}

impl Change {
    /// How many frames are left out at the start.
    pub(super) fn skipped(self) -> usize {
        usize::from(self == Self::Later)
    }

    /// The frame so changed.
    pub(super) fn of_frame(self, frame: Frame) -> Result<Frame> {
        let (width, height) = (frame.width(), frame.height());
        match self {
            Self::Base | Self::Seed(_) | Self::Later => Ok(frame),
            Self::Dark => {
                let darker = |&value: &u8| (f32::from(value) * DARK + 0.5) as u8;
                Ok(Frame::from_rgb(frame.rgb().iter().map(darker).collect(), width, height)?)
            }
            Self::Jpeg => through_jpeg(&frame),
            Self::Crop(_) | Self::Mirror => {
                let pixels = frame.rgb().chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
                let moved = self.of_plane(&Plane::from_vec(width, height, pixels).unwrap_or_default())?;
                Ok(Frame::from_rgb(moved.data().concat(), moved.width(), moved.height())?)
            }
        }
    }

    /// Where the pixels of a frame go, those of its true mask go too.
    pub(super) fn of_plane<T: Copy>(self, plane: &Plane<T>) -> Result<Plane<T>> {
        let (width, height) = (plane.width(), plane.height());
        match self {
            Self::Crop(n) if n >= width.min(height) => {
                Err(Failure::new(format!("crop{n} leaves nothing of frames of {width}x{height}")))
            }
            Self::Crop(n) => Ok(Plane::from_fn(width - n, height - n, |x, y| plane[(x + n, y + n)])),
            Self::Mirror => Ok(Plane::from_fn(width, height, |x, y| plane[(width - 1 - x, y)])),
            _ => Ok(plane.clone()),
        }
    }
}

fn through_jpeg(frame: &Frame) -> Result<Frame> {
    let (width, height) = (frame.width() as u32, frame.height() as u32);
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY)
        .write_image(frame.rgb(), width, height, ExtendedColorType::Rgb8)
        .map_err(|e| Failure::about("cannot be made a JPEG file", e))?;
    Ok(Frame::decode(&bytes)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: &[u8], width: usize) -> Frame {
        let rgb = values.iter().flat_map(|&v| [v, v, v]).collect();
        Frame::from_rgb(rgb, width, values.len() / width).unwrap()
    }

    fn values(frame: &Frame) -> Vec<u8> {
        frame.rgb().iter().step_by(3).copied().collect()
    }

    #[test]
    fn names_are_read_as_they_are_written() {
        for name in ALL.split(',').chain(["seed17", "crop32"]) {
            assert_eq!(name.parse::<Change>().unwrap().to_string(), name);
        }
        for wrong in ["", "crop", "seed-1", "bright"] {
            assert!(wrong.parse::<Change>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn frames_and_masks_are_changed_alike() {
        let picture = [10, 20, 30, 40, 50, 60];
        let changed = |change: Change| values(&change.of_frame(grey(&picture, 3)).unwrap());
        let plane = Plane::from_vec(3, 2, picture.to_vec()).unwrap();
        for (change, expected) in [(Change::Crop(1), vec![50, 60]), (Change::Mirror, vec![30, 20, 10, 60, 50, 40])] {
            assert_eq!(changed(change), expected);
            assert_eq!(change.of_plane(&plane).unwrap().data(), expected);
        }
        assert_eq!(changed(Change::Dark), [10, 19, 29, 38, 48, 57]);
        assert_eq!(Change::Dark.of_plane(&plane).unwrap(), plane);
        assert!(Change::Crop(2).of_plane(&plane).is_err());
        assert_eq!((Change::Later.skipped(), changed(Change::Later)), (1, picture.to_vec()));
    }

    #[test]
    fn a_jpeg_is_near_its_original_and_not_it() {
        let original: Vec<u8> = (0..64 * 64_u32).map(|i| (i * 37 % 251) as u8 / 2 + (i % 64) as u8).collect();
        let changed = values(&Change::Jpeg.of_frame(grey(&original, 64)).unwrap());
        let worst = original.iter().zip(&changed).map(|(a, b)| a.abs_diff(*b)).max();
        assert!(changed != original && worst < Some(100), "{worst:?}");
    }
}
