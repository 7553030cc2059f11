//! File formats of masks other than pictures.

use crate::failure::{Failure, Result, cannot_write};
use crate::output::OutputFolder;
use crate::pictures::read_labels;
use crate::timeline::FrameTimes;
use clap::ValueEnum;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use tracecut::image::Plane;
use tracecut::mask::{CocoRuns, Prompt, Prompts, coco_runs, coco_text};
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Format {
    /// masks/00000.png ...: labels as palette images
    Png,
    /// masks.json: COCO's JSON for videos, with compressed run lengths
    Rle,
    /// masks.npz: a NumPy array of frames, rows and columns, and arrays of their times and durations in seconds
    Npz,
    /// prompts.json: a frame, box, points and mask of each object, for models like SAM 2
    Prompts,
    /// tracks.dat: the labelled trajectories
    Tracks,
    /// overlay/00000.png ... and overlay-masks/00000.png ...: frames with points, and tinted
    Overlay,
}

/// A clip's masks as pictures in `folder`, `frames` of them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Masks<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) frames: usize,
    pub(crate) size: (usize, usize),
    pub(crate) times: Option<&'a FrameTimes>,
}

impl Masks<'_> {
    fn mask(&self, t: usize) -> Result<Plane<u8>> {
        let (labels, width, height) = read_labels(self.folder, t)?;
        let mask = Plane::from_vec(width, height, labels).filter(|_| (width, height) == self.size);
        mask.ok_or_else(|| Failure::new(format!("mask {t} is {width}x{height}: please report this")))
    }

    /// Writes `masks.npz`: the array `masks`, bytes, frame by frame and row by row; `times` and `durations` in seconds,
    /// where frames have any.
    pub(crate) fn write_npz(&self, place: &OutputFolder) -> Result<()> {
        let path = place.file("masks.npz");
        let bad = |e: zip::result::ZipError| cannot_write(&path, &e.into());
        let mut zip = ZipWriter::new(BufWriter::new(File::create(&path).map_err(|e| cannot_write(&path, &e))?));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(true);
        zip.start_file("masks.npy", options).map_err(bad)?;
        let (width, height) = self.size;
        zip.write_all(&npy_header("|u1", &[self.frames, height, width])).map_err(|e| cannot_write(&path, &e))?;
        for t in 0..self.frames {
            zip.write_all(self.mask(t)?.data()).map_err(|e| cannot_write(&path, &e))?;
        }
        for (name, seconds) in
            self.times.iter().flat_map(|t| [("times.npy", &t.times), ("durations.npy", &t.durations)])
        {
            zip.start_file(name, options).map_err(bad)?;
            let bytes = seconds.iter().flat_map(|value| value.to_le_bytes());
            let file: Vec<u8> = npy_header("<f8", &[seconds.len()]).into_iter().chain(bytes).collect();
            zip.write_all(&file).map_err(|e| cannot_write(&path, &e))?;
        }
        let mut file = zip.finish().map_err(bad)?;
        file.flush().map_err(|e| cannot_write(&path, &e))
    }

    /// Writes `prompts.json` as the package does.
    pub(crate) fn write_prompts(&self, place: &OutputFolder) -> Result<()> {
        let mut prompts = Prompts::default();
        for t in 0..self.frames {
            prompts.add(t, &self.mask(t)?);
        }
        let mut json = json!({
            "info": { "description": "Prompts for objects that TraceCut found", "version": env!("CARGO_PKG_VERSION") },
            "width": self.size.0,
            "height": self.size.1,
            "prompts": prompts.finish().iter().map(prompt).collect::<Vec<Value>>(),
        });
        if let Some(FrameTimes { times, .. }) = self.times {
            json["times"] = json!(times);
        }
        crate::failure::write(&place.file("prompts.json"), json.to_string() + "\n")
    }

    /// Writes `masks.json` as the package does; `names` are the files of the frames.
    pub(crate) fn write_coco(&self, place: &OutputFolder, video: &str, names: Option<&[String]>) -> Result<()> {
        let (path, (width, height)) = (place.file("masks.json"), self.size);
        let file_name = |t: usize| names.and_then(|n| n.get(t).cloned()).unwrap_or_else(|| format!("{t:05}.png"));
        let mut video = json!({ "id": 1, "name": video, "width": width, "height": height });
        if let Some(FrameTimes { times, .. }) = self.times {
            video["frame_times"] = json!(times);
        }
        let image = |t: usize| {
            let mut image = json!({ "id": t + 1, "video_id": 1, "frame_index": t, "width": width, "height": height,
                "file_name": file_name(t) });
            if let Some(FrameTimes { times, .. }) = self.times {
                image["timestamp"] = json!(times[t]);
            }
            image
        };
        let (mut annotations, mut is_used) = (Vec::new(), [false; 256]);
        for t in 0..self.frames {
            let mask = self.mask(t)?;
            mask.data().iter().for_each(|&label| is_used[usize::from(label)] = true);
            annotations.extend(mask_annotations(&mask, t));
        }
        let labels = (1..256).filter(|&label| is_used[label]);
        let coco = json!({
            "info": { "description": "Masks of moving objects by TraceCut", "version": env!("CARGO_PKG_VERSION") },
            "videos": [video],
            "images": (0..self.frames).map(image).collect::<Vec<Value>>(),
            "tracks": labels.map(|id| json!({ "id": id, "category_id": 1, "video_id": 1 })).collect::<Vec<Value>>(),
            "categories": [{ "id": 1, "name": "object" }],
            "annotations": annotations,
        });
        crate::failure::write(&path, coco.to_string() + "\n")
    }
}

/// Returns a prompt with the keys of SAM 2's video predictor.
fn prompt(prompt: &Prompt) -> Value {
    let points: Vec<(usize, usize)> = prompt.inside.iter().chain(&prompt.outside).copied().collect();
    let labels: Vec<u8> = (0..points.len()).map(|k| u8::from(k < prompt.inside.len())).collect();
    let runs = coco_runs(&prompt.mask);
    let counts = runs.iter().find(|runs| runs.label == 1).map(|runs| coco_text(&runs.counts));
    let size = [prompt.mask.height(), prompt.mask.width()];
    json!({ "obj_id": prompt.object, "frame_idx": prompt.frame, "box": prompt.bounds, "points": points, "labels": labels,
        "mask": { "size": size, "counts": counts } })
}

/// Returns the header of a NumPy file for an array of this shape and type `descr` in C order. In version 1.0 of the format the
/// data begin at a multiple of 64 bytes.
pub(crate) fn npy_header(descr: &str, shape: &[usize]) -> Vec<u8> {
    // A tuple of one number ends with a comma.
    let sides: String = shape.iter().map(|side| format!("{side}, ")).collect();
    let sides = if shape.len() == 1 { sides.trim_end() } else { sides.trim_end_matches(", ") };
    let mut dict = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({sides}), }}");
    while (10 + dict.len() + 1) % 64 != 0 {
        dict.push(' ');
    }
    dict.push('\n');
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((dict.len() as u16).to_le_bytes());
    header.extend(dict.as_bytes());
    header
}

/// Returns the COCO annotations of frame `t`, one for each label except 0.
pub(crate) fn mask_annotations(mask: &Plane<u8>, t: usize) -> Vec<Value> {
    let size = (mask.width(), mask.height());
    coco_runs(mask).iter().filter(|runs| runs.label > 0).map(|runs| annotation(runs, t, size)).collect()
}

fn annotation(runs: &CocoRuns, t: usize, (width, height): (usize, usize)) -> Value {
    let CocoRuns { label, corner, size, .. } = runs;
    json!({
        "id": t * 256 + usize::from(*label) + 1, "image_id": t + 1, "video_id": 1, "track_id": label,
        "category_id": 1, "attributes": { "track_id": label }, "area": runs.area,
        "bbox": [corner.0, corner.1, size.0, size.1], "iscrowd": 0,
        "segmentation": { "size": [height, width], "counts": coco_text(&runs.counts) },
    })
}
