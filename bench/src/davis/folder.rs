//! Where the sequences and their true masks lie.

use crate::batch::sequences;
use crate::measures::davis::scored_frames;
use std::path::{Path, PathBuf};
use tracecut::image::Plane;
use tracecut_cli::failure::{Failure, Result};
use tracecut_cli::images;
use tracecut_cli::input::decode;

const EXPECTED: &str = "NAME/JPEGImages and NAME/Annotations, or JPEGImages/480p/NAME and Annotations/480p/NAME";

/// A sequence's folders.
#[derive(Debug)]
pub(crate) struct Sequence {
    pub(crate) name: String,
    pub(crate) images: PathBuf,
    pub(crate) annotations: PathBuf,
}

/// The sequences of `folder` by name, or those that `only` names.
pub(crate) fn find_sequences(folder: &Path, only: &[String]) -> Result<Vec<Sequence>> {
    let all = folder.join("JPEGImages").join("480p");
    let is_davis = all.is_dir();
    sequences(if is_davis { &all } else { folder }, only, EXPECTED, |path, name| {
        let (images, annotations) = if is_davis {
            (path.to_owned(), folder.join("Annotations").join("480p").join(name))
        } else {
            (path.join("JPEGImages"), path.join("Annotations"))
        };
        Ok(images.is_dir().then(|| Sequence { name: name.to_owned(), images, annotations }))
    })
}

impl Sequence {
    /// The true masks of the first `frames` frames, or of all.
    pub(crate) fn truth(&self, frames: Option<u32>) -> Result<Vec<Plane<bool>>> {
        let mut images = images::in_folder(&self.images)?;
        images.truncate(frames.map_or(usize::MAX, |n| n as usize));
        if scored_frames(images.len()).is_empty() {
            let reason =
                format!("holds {} images (expected at least 3, as the first and last do not count)", images.len());
            return Err(Failure::about(self.images.display(), reason));
        }
        let first = decode(&images[0])?;
        images.iter().map(|image| self.mask_of(image, (first.width(), first.height()))).collect()
    }

    /// What is not black in the annotation of the same name.
    fn mask_of(&self, image: &Path, size: (usize, usize)) -> Result<Plane<bool>> {
        let path = self.annotations.join(image.file_name().unwrap_or_default()).with_extension("png");
        if !path.is_file() {
            let reason = format!("is missing (expected the true mask of {})", image.display());
            return Err(Failure::about(path.display(), reason));
        }
        let mask = decode(&path)?;
        let (width, height) = (mask.width(), mask.height());
        if (width, height) != size {
            let reason = format!("is {width}x{height} (expected {}x{}, as the frames are)", size.0, size.1);
            return Err(Failure::about(path.display(), reason));
        }
        let data = mask.rgb().chunks_exact(3).map(|p| p != [0, 0, 0]).collect();
        Ok(Plane::from_vec(width, height, data).unwrap_or_default())
    }
}
