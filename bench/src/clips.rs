//! Clips with true masks, in the layouts that people keep them in.

use super::batch::{self, PROGRAM};
use crate::measures::davis::boundary;
use crate::measures::masks::Truth;
use crate::measures::moseg::UNSCORED;
use clap::Args;
use std::path::{Path, PathBuf};
use tracecut::image::Plane;
use tracecut_cli::failure::{Failure, Result};
use tracecut_cli::images;
use tracecut_cli::input::{ClipFrame, decode};
use tracecut_cli::masks::tinted;
use tracecut_cli::pictures::{Pixels, Series};
use tracecut_cli::settings::Settings;

/// Separator between the kind of a clip and its name.
const SEPARATOR: &str = "--";
const EXPECTED: &str = "NAME/frames and NAME/masks, NAME/JPEGImages and NAME/Annotations, or JPEGImages/480p/NAME and \
                        Annotations/480p/NAME";
const EXPECTED_DAVIS: &str = "NAME/JPEGImages and NAME/Annotations, or JPEGImages/480p/NAME and Annotations/480p/NAME";
/// Colour of the true outline in overlays.
const OUTLINE: [u8; 3] = [255, 255, 255];

/// The coding of a true mask.
#[derive(Debug, Clone, Copy)]
enum Code {
    /// White on objects, mid-grey (128) where nothing is scored.
    Grey,
    /// Anything but black on objects, as in DAVIS.
    AnyColour,
}

/// A clip's name, kind and folders.
#[derive(Debug)]
pub(super) struct Clip {
    pub(super) name: String,
    /// The part of its name before `--`, or else the name of its folder.
    pub(super) kind: String,
    pub(super) images: PathBuf,
    masks: PathBuf,
    code: Code,
}

/// The clips of an evaluation, the number of parallel runs, and the parameters.
#[derive(Args, Debug)]
pub(super) struct Suite {
    /// Folders with NAME/frames and NAME/masks, or in a layout of DAVIS; a single clip will do
    #[arg(value_name = "DIR", required = true)]
    pub(super) folders: Vec<PathBuf>,
    /// Only the clips whose names contain one of these
    #[arg(long, value_name = "TEXT,...", value_delimiter = ',')]
    pub(super) only: Vec<String>,
    /// Number of runs to work on at once
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=256))]
    jobs: u32,
    #[command(flatten)]
    pub(super) settings: Settings,
}

impl Suite {
    pub(super) fn jobs(&self) -> usize {
        self.jobs as usize
    }

    /// Returns the command line of `command` with these options, without paths; `more` follows the folders.
    pub(super) fn command(&self, command: &str, more: &str) -> String {
        let folders: Vec<String> = self.folders.iter().map(|folder| file_name(folder)).collect();
        let only = if self.only.is_empty() { String::new() } else { format!(" --only {}", self.only.join(",")) };
        format!("{PROGRAM} {command} {} {more}{only}", folders.join(" "))
    }

    /// The clips of all folders.
    pub(super) fn clips(&self) -> Result<Vec<Clip>> {
        let clips = self.folders.iter().map(|folder| find_clips(folder, &self.only));
        Ok(clips.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
    }
}

/// The clips of `folder` by name, or `folder` itself if it is one; with `only` not empty, those whose names contain one
/// of its texts.
pub(super) fn find_clips(folder: &Path, only: &[String]) -> Result<Vec<Clip>> {
    let is_selected = |clip: &Clip| only.is_empty() || only.iter().any(|text| clip.name.contains(text));
    let mut clips = all_clips(folder)?;
    clips.retain(is_selected);
    if clips.is_empty() {
        let reason = format!("holds no clip whose name contains {}", only.join(" or "));
        return Err(Failure::about(folder.display(), reason));
    }
    Ok(clips)
}

fn all_clips(folder: &Path) -> Result<Vec<Clip>> {
    let suite = file_name(folder);
    if folder.join("JPEGImages").join("480p").is_dir() {
        return davis_clips(folder, &[]);
    }
    match Clip::at(folder, &suite, "") {
        Some(clip) => Ok(vec![clip]),
        None => batch::sequences(folder, &[], EXPECTED, |path, name| Ok(Clip::at(path, name, &suite))),
    }
}

/// The clips of `folder` in a layout of DAVIS, by name, or those that `only` names.
pub(super) fn davis_clips(folder: &Path, only: &[String]) -> Result<Vec<Clip>> {
    let (originals, suite) = (folder.join("JPEGImages").join("480p"), file_name(folder));
    let is_original = originals.is_dir();
    batch::sequences(if is_original { &originals } else { folder }, only, EXPECTED_DAVIS, |path, name| {
        let (images, masks) = if is_original {
            (path.to_owned(), folder.join("Annotations").join("480p").join(name))
        } else {
            (path.join("JPEGImages"), path.join("Annotations"))
        };
        let (name, kind) = (name.to_owned(), kind_of(name, &suite));
        Ok(images.is_dir().then_some(Clip { name, kind, images, masks, code: Code::AnyColour }))
    })
}

/// Writes every `step`-th frame of a clip of `count` frames into `folder`: labels in colour, and the outline of the true
/// objects where the mask has the frame's size. `masks_of` gives both of a frame of `frames`.
pub(super) fn write_overlays(
    folder: PathBuf,
    count: usize,
    step: usize,
    frames: impl Iterator<Item = Result<ClipFrame>>,
    masks_of: impl Fn(usize) -> Result<(Plane<u8>, Option<Plane<bool>>)>,
) -> Result<()> {
    let series = Series::create(folder, count)?;
    for (t, frame) in frames.enumerate().step_by(step) {
        let (frame, (labels, truth)) = (frame?.frame, masks_of(t)?);
        let mut rgb = tinted(&frame, &labels);
        if let Some(truth) = truth.filter(|p| (p.width(), p.height()) == (frame.width(), frame.height())) {
            let outline = boundary(&truth);
            let drawn = rgb.chunks_exact_mut(3).zip(outline.data()).filter(|(_, drawn)| **drawn);
            drawn.for_each(|(pixel, _)| pixel.copy_from_slice(&OUTLINE));
        }
        series.write(t, (frame.width(), frame.height()), Pixels::Rgb(&rgb))?;
    }
    Ok(())
}

/// Seeds as an option takes them.
pub(super) fn list(seeds: &[u32]) -> String {
    seeds.iter().map(u32::to_string).collect::<Vec<_>>().join(",")
}

/// The name of a folder, also of `.`.
fn file_name(folder: &Path) -> String {
    let path = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

impl Clip {
    /// The clip of this folder, if it is one.
    fn at(path: &Path, name: &str, suite: &str) -> Option<Self> {
        let layouts = [("frames", "masks", Code::Grey), ("JPEGImages", "Annotations", Code::AnyColour)];
        let (images, masks, code) = layouts.into_iter().find(|l| path.join(l.0).is_dir() && path.join(l.1).is_dir())?;
        let kind = kind_of(name, suite);
        Some(Self { name: name.to_owned(), kind, images: path.join(images), masks: path.join(masks), code })
    }

    /// The image files of the first `count` frames, or of all.
    pub(super) fn frames(&self, count: Option<u32>) -> Result<Vec<PathBuf>> {
        let mut images = images::in_folder(&self.images)?;
        images.truncate(count.map_or(usize::MAX, |n| n as usize));
        Ok(images)
    }

    /// Returns the path of a frame's true mask.
    pub(super) fn mask_path(&self, image: &Path) -> PathBuf {
        self.masks.join(image.file_name().unwrap_or_default()).with_extension("png")
    }

    /// The truth of a frame, from the mask of the same name; `None` where there is none.
    pub(super) fn truth(&self, image: &Path) -> Result<Option<Plane<Truth>>> {
        self.mask(image, |pixel| self.code.truth(pixel))
    }

    /// The region of each pixel of a frame: 0 for the background, and a number for each colour of objects, of which
    /// `colours` are known. `None` where there is no mask.
    pub(super) fn regions(&self, image: &Path, colours: &mut Vec<Vec<u8>>) -> Result<Option<Plane<u8>>> {
        self.mask(image, |pixel| match self.code.truth(pixel) {
            Truth::Background => 0,
            Truth::Ignored => UNSCORED,
            Truth::Object => {
                let index = colours.iter().position(|colour| colour == pixel);
                let place = index.unwrap_or_else(|| {
                    colours.push(pixel.to_vec());
                    colours.len() - 1
                });
                // More than there are numbers for are one.
                (1 + place).min(usize::from(UNSCORED) - 1) as u8
            }
        })
    }

    /// Decodes the mask of a frame.
    fn mask<T: Copy>(&self, image: &Path, meaning: impl FnMut(&[u8]) -> T) -> Result<Option<Plane<T>>> {
        let path = self.mask_path(image);
        if !path.is_file() {
            return Ok(None);
        }
        let mask = decode(&path)?;
        let data = mask.rgb().chunks_exact(3).map(meaning).collect();
        Ok(Plane::from_vec(mask.width(), mask.height(), data))
    }
}

impl Code {
    fn truth(self, pixel: &[u8]) -> Truth {
        match (self, pixel) {
            (Self::Grey, [255, 255, 255]) => Truth::Object,
            (Self::Grey, [128, 128, 128]) => Truth::Ignored,
            (Self::AnyColour, colour) if colour != [0, 0, 0] => Truth::Object,
            _ => Truth::Background,
        }
    }
}

fn kind_of(name: &str, suite: &str) -> String {
    match name.split_once(SEPARATOR) {
        Some((kind, _)) => kind.to_owned(),
        None if suite.is_empty() => name.to_owned(),
        None => suite.to_owned(),
    }
}
