//! Masks as files and pictures, and what the report says about them.

use crate::failure::{Failure, Result, write};
use crate::input::Input;
use crate::overlay::PALETTE;
use crate::pictures::{Pixels, Series};
use serde::Serialize;
use std::path::{Path, PathBuf};
use tracecut::Session;
use tracecut::image::{Frame, Plane};
use tracecut::mask::{Objects, enlarge, object_rows, object_table};

/// How much of a tinted pixel is the label's colour.
const TINT_SHARE: f32 = 0.5;

/// What `result.json` says about the masks.
#[derive(Debug, Serialize)]
pub(crate) struct MaskReport {
    background: MaskedObject,
    objects: Vec<MaskedObject>,
    /// Number of superpixels, frame by frame.
    superpixels: Vec<usize>,
}

/// A label of the masks.
#[derive(Debug, Default, Serialize)]
#[serde(rename_all = "camelCase")]
struct MaskedObject {
    label: u8,
    /// Pixels of all masks.
    pixels: u64,
    /// Frames in which it has any; `null` if it has none.
    first_frame: Option<usize>,
    last_frame: Option<usize>,
    /// Cluster labels of the trajectories that belong to it.
    clusters: Vec<usize>,
}

impl MaskedObject {
    fn count(&mut self, frame: usize) {
        self.pixels += 1;
        self.first_frame.get_or_insert(frame);
        self.last_frame = Some(frame);
    }
}

impl MaskReport {
    pub(crate) fn num_objects(&self) -> usize {
        self.objects.len()
    }
}

/// Writes the session's masks, at the size of the frames of `input`, into `masks`, and the frames tinted with them into
/// `overlay-masks`, as `%05d.png` in folders of `out`; without masks removes those of an earlier run.
pub(crate) fn write_all(out: &Path, input: &Input, session: &Session) -> Result<Option<MaskReport>> {
    let folders = ["masks", "overlay-masks"].map(|name| out.join(name));
    let table = out.join("objects.csv");
    let (Some(objects), Some(tracks)) = (session.objects(), session.trajectories()) else {
        folders.into_iter().for_each(Series::remove);
        // There may be none from an earlier run.
        let _ = std::fs::remove_file(table);
        return Ok(None);
    };
    let mut labels = labels_of(objects);
    let (mut superpixels, mut rows) = (Vec::new(), Vec::new());
    let [masks, tints] = folders.map(|folder| Series::create(folder, session.num_frames()));
    let (masks, tints) = (masks?, tints?);
    for (t, frame) in input.frames()?.enumerate() {
        let (name, frame) = frame?;
        let mask = at_source(session, t, &frame).map_err(|e| Failure::about(name, e))?;
        mask.data().iter().for_each(|&label| labels[usize::from(label)].count(t));
        rows.extend(object_rows(&mask, tracks, t));
        superpixels.push(session.superpixels(t)?.count);
        let size = (mask.width(), mask.height());
        masks.write(t, size, Pixels::Labels(mask.data()))?;
        tints.write(t, size, Pixels::Rgb(&tinted(&frame, &mask)))?;
    }
    write(&table, object_table(&rows))?;
    let objects = labels.split_off(1);
    Ok(labels.pop().map(|background| MaskReport { background, objects, superpixels }))
}

/// The mask of frame `t` at the size of the frame: where that was reduced, with borders to the pixel of its own.
fn at_source(session: &Session, t: usize, frame: &Frame) -> std::result::Result<Plane<u8>, tracecut::Error> {
    if session.working_size() == session.input_size() {
        return session.labels(t);
    }
    Ok(enlarge(session.working_labels(t)?, frame, |_| false)?.labels)
}

/// Writes the scene of each frame without the objects into `folder`, or removes those of an earlier run.
pub(crate) fn write_backgrounds(folder: PathBuf, session: &Session, wanted: bool) -> Result<()> {
    write_each(folder, session, wanted, |series, t| {
        let plate = session.background(t)?;
        series.write(t, (plate.width(), plate.height()), Pixels::Rgba(plate.data().as_flattened()))
    })
}

/// Writes the confidence of each frame into `folder`, or removes those of an earlier run.
pub(crate) fn write_confidences(folder: PathBuf, session: &Session, wanted: bool) -> Result<()> {
    write_each(folder, session, wanted, |series, t| {
        let sure = session.confidence(t)?.map(|p| (255.0 * p).round() as u8);
        series.write(t, (sure.width(), sure.height()), Pixels::Grey(sure.data()))
    })
}

/// A picture of each frame that has masks, by `write`; nothing, and none of an earlier run, where none is wanted.
fn write_each(
    folder: PathBuf,
    session: &Session,
    wanted: bool,
    write: impl Fn(&Series, usize) -> Result<()>,
) -> Result<()> {
    if !wanted || session.objects().is_none() {
        Series::remove(folder);
        return Ok(());
    }
    let series = Series::create(folder, session.num_frames())?;
    (0..session.num_frames()).try_for_each(|t| write(&series, t))
}

/// An entry for the background and one for each object, nothing counted yet.
fn labels_of(objects: &Objects) -> Vec<MaskedObject> {
    let clusters = |label: u8| (0..objects.of_cluster.len()).filter(|&c| objects.of_cluster[c] == label).collect();
    let entry = |label: u8| MaskedObject { label, clusters: clusters(label), ..MaskedObject::default() };
    (0..=255).take(objects.highest_label + 1).map(entry).collect()
}

/// The frame with the pixels of each label other than 0 tinted, and outlined in the full colour; RGB. `labels` has the
/// frame's size.
pub(crate) fn tinted(frame: &Frame, labels: &Plane<u8>) -> Vec<u8> {
    let mut rgb = frame.rgb().to_vec();
    for y in 0..labels.height() {
        for x in 0..labels.width() {
            let label = labels[(x, y)];
            if label > 0 {
                let share = if is_rim(labels, x, y) { 1.0 } else { TINT_SHARE };
                blend(&mut rgb, y * labels.width() + x, PALETTE[usize::from(label) % PALETTE.len()], share);
            }
        }
    }
    rgb
}

/// Whether one of the four neighbours inside the image has another label.
fn is_rim(labels: &Plane<u8>, x: usize, y: usize) -> bool {
    let here = labels[(x, y)];
    let (right, below) = (x + 1 < labels.width(), y + 1 < labels.height());
    (x > 0 && labels[(x - 1, y)] != here)
        || (y > 0 && labels[(x, y - 1)] != here)
        || (right && labels[(x + 1, y)] != here)
        || (below && labels[(x, y + 1)] != here)
}

/// Paints the true pixels of `lines` over `rgb`.
pub(crate) fn paint_lines(rgb: &mut [u8], lines: &Plane<bool>, colour: [u8; 3]) {
    for (pixel, _) in lines.data().iter().enumerate().filter(|(_, line)| **line) {
        blend(rgb, pixel, colour, 1.0);
    }
}

fn blend(rgb: &mut [u8], pixel: usize, colour: [u8; 3], share: f32) {
    for (value, new) in rgb[3 * pixel..3 * pixel + 3].iter_mut().zip(colour) {
        *value = (f32::from(*value) + share * (f32::from(new) - f32::from(*value)) + 0.5) as u8;
    }
}
