//! Masks as files and pictures, and their part of the report.

use crate::failure::{Failure, Result};
use crate::pictures::{PALETTE, Pixels, Series};
use crate::window::WindowResult;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::path::PathBuf;
use tracecut::image::{Frame, Plane};
use tracecut::mask::{Agreement, ObjectRow, Objects, enlarge, object_rows, object_table};

/// Share of the label's colour in a tinted pixel; chosen by eye.
const TINT_SHARE: f32 = 0.5;

/// The masks in `result.json`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct MaskReport {
    background: MaskedObject,
    objects: Vec<MaskedObject>,
    /// Number of superpixels, frame by frame.
    superpixels: Vec<usize>,
}

/// A label of the masks.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
struct MaskedObject {
    label: u8,
    /// Number of pixels in all masks.
    pixels: u64,
    /// First frame with a pixel of it; `null` if there is none.
    first_frame: Option<usize>,
    last_frame: Option<usize>,
    /// Cluster labels of its trajectories; left out for clips of several windows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    clusters: Option<Vec<usize>>,
}

impl MaskedObject {
    fn count(&mut self, frame: usize) {
        self.pixels += 1;
        self.first_frame.get_or_insert(frame);
        self.last_frame = Some(frame);
    }

    /// Adds the pixels of a later window.
    fn add(&mut self, later: &Self) {
        self.pixels += later.pixels;
        self.first_frame = self.first_frame.or(later.first_frame);
        self.last_frame = later.last_frame.or(self.last_frame);
    }
}

impl MaskReport {
    pub(crate) fn num_objects(&self) -> usize {
        self.objects.len()
    }

    /// Returns the clusters of each object with clusters, by label.
    pub(crate) fn clusters_of_objects(&self) -> Vec<(u8, Vec<usize>)> {
        let clusters = |object: &MaskedObject| (object.label, object.clusters.clone().unwrap_or_default());
        self.objects.iter().map(clusters).filter(|(_, clusters)| !clusters.is_empty()).collect()
    }

    pub(crate) fn has_object(&self, label: u8) -> bool {
        self.objects.iter().any(|object| object.label == label)
    }

    /// Merges the reports of all windows of a clip. Leaves out objects without a pixel.
    pub(crate) fn merged(windows: Option<Vec<&Self>>) -> Option<Self> {
        let windows = windows?;
        if let [only] = windows[..] {
            let objects = only.objects.iter().filter(|object| object.pixels > 0).cloned().collect();
            return Some(Self { objects, ..only.clone() });
        }
        let mut labels: Vec<MaskedObject> =
            (0..=255).map(|label| MaskedObject { label, ..Default::default() }).collect();
        for object in windows.iter().flat_map(|window| window.objects.iter().chain([&window.background])) {
            labels[usize::from(object.label)].add(object);
        }
        let objects = labels.split_off(1).into_iter().filter(|object| object.pixels > 0).collect();
        let superpixels = windows.iter().flat_map(|window| &window.superpixels).copied().collect();
        labels.pop().map(|background| Self { background, objects, superpixels })
    }
}

/// The folders of the requested pictures.
#[derive(Debug)]
pub(crate) struct MaskFolders {
    /// Labels, as results or as input of other formats.
    pub(crate) masks: Option<PathBuf>,
    /// Tinted frames.
    pub(crate) tints: Option<PathBuf>,
    /// The scene without the objects.
    pub(crate) backgrounds: Option<PathBuf>,
}

/// Writes the pictures of the masks that a window settles, at the size of the frames. Returns their part of the report and the rows
/// of the objects' table; `None` without masks.
pub(crate) fn write_window(window: &WindowResult<'_>, folders: &MaskFolders) -> Result<Option<(MaskReport, String)>> {
    let session = window.session;
    let (Some(objects), Some(tracks)) = (session.objects(), session.trajectories()) else { return Ok(None) };
    let mut labels = count_labels(objects);
    let (mut superpixels, mut rows) = (Vec::new(), Vec::new());
    let [masks, tints] = [&folders.masks, &folders.tints].map(|folder| folder.clone().map(Series::open).transpose());
    let (masks, tints) = (masks?, tints?);
    let doubts = session.agreement().map(Agreement::doubts);
    for t in window.settled.clone() {
        let doubt = doubt_at(doubts.as_deref(), t);
        let (number, mask) = (window.first + t, source_mask(window, t)?);
        mask.data().iter().for_each(|&label| labels[usize::from(label)].count(number));
        let time = window.timing(t).map(|timing| timing.time);
        let of_frame = |row| ObjectRow { frame: number, time, doubt, ..row };
        rows.extend(object_rows(&mask, tracks, t).into_iter().map(of_frame));
        superpixels.push(session.superpixels(t)?.count);
        let size = (mask.width(), mask.height());
        if let Some(masks) = &masks {
            masks.write(number, size, Pixels::Labels(mask.data()))?;
        }
        if let Some(tints) = &tints {
            tints.write(number, size, Pixels::Rgb(&tinted(window.frame(t)?, &mask)))?;
        }
    }
    write_maps(window, folders)?;
    let table = object_table(&rows);
    let rows = table.split_once('\n').map_or("", |(_, rows)| rows).to_owned();
    let objects = labels.split_off(1);
    Ok(labels.pop().map(|background| (MaskReport { background, objects, superpixels }, rows)))
}

/// Returns whether the masks of frame `t` should be looked at; `None` if unknown.
pub(crate) fn doubt_at(doubts: Option<&[Range<usize>]>, t: usize) -> Option<bool> {
    Some(doubts?.iter().any(|doubt| doubt.contains(&t)))
}

/// Returns the header of the objects' table.
pub(crate) fn table_heading() -> String {
    object_table(&[])
}

/// Returns the mask of frame `t` at input size, with borders to the pixel of the input.
fn source_mask(window: &WindowResult<'_>, t: usize) -> Result<Plane<u8>> {
    let session = window.session;
    if session.working_size() == session.input_size() {
        return Ok(session.labels(t)?);
    }
    let enlarged = enlarge(session.working_labels(t)?, window.frame(t)?, |_| false);
    Ok(enlarged.map_err(|e| Failure::from(e).with_subject(format_args!("frame {}", window.first + t)))?.labels)
}

/// Writes the requested maps of each frame, at working size.
fn write_maps(window: &WindowResult<'_>, folders: &MaskFolders) -> Result<()> {
    let (session, first) = (window.session, window.first);
    if let Some(folder) = &folders.backgrounds {
        let series = Series::open(folder.clone())?;
        for t in window.settled.clone() {
            let plate = session.background(t)?;
            series.write(first + t, (plate.width(), plate.height()), Pixels::Rgba(plate.data().as_flattened()))?;
        }
    }
    Ok(())
}

/// Returns an empty entry for the background and each object.
fn count_labels(objects: &Objects) -> Vec<MaskedObject> {
    let clusters = |label: u8| (0..objects.of_cluster.len()).filter(|&c| objects.of_cluster[c] == label).collect();
    let entry = |label: u8| MaskedObject { label, clusters: Some(clusters(label)), ..MaskedObject::default() };
    (0..=255).take(objects.highest_label + 1).map(entry).collect()
}

/// Returns the frame with the pixels of each label other than 0 tinted, and outlined in the full colour; RGB. `labels` has the
/// frame's size.
pub fn tinted(frame: &Frame, labels: &Plane<u8>) -> Vec<u8> {
    let mut rgb = frame.rgb().to_vec();
    for y in 0..labels.height() {
        for x in 0..labels.width() {
            let label = labels[(x, y)];
            if label > 0 {
                let share = if is_outline(labels, x, y) { 1.0 } else { TINT_SHARE };
                blend(&mut rgb, y * labels.width() + x, PALETTE[usize::from(label) % PALETTE.len()], share);
            }
        }
    }
    rgb
}

/// Returns whether one of the four neighbours inside the image has another label.
fn is_outline(labels: &Plane<u8>, x: usize, y: usize) -> bool {
    let label = labels[(x, y)];
    let (right, below) = (x + 1 < labels.width(), y + 1 < labels.height());
    (x > 0 && labels[(x - 1, y)] != label)
        || (y > 0 && labels[(x, y - 1)] != label)
        || (right && labels[(x + 1, y)] != label)
        || (below && labels[(x, y + 1)] != label)
}

fn blend(rgb: &mut [u8], pixel: usize, colour: [u8; 3], share: f32) {
    for (value, new) in rgb[3 * pixel..3 * pixel + 3].iter_mut().zip(colour) {
        *value = (f32::from(*value) + share * (f32::from(new) - f32::from(*value)) + 0.5) as u8;
    }
}
