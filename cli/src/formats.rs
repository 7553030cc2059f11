//! The forms in which masks are written, beside pictures.

use crate::failure::{Failure, Result, cannot_write};
use crate::output::Place;
use crate::pictures::read_labels;
use clap::ValueEnum;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Format {
    /// masks/00000.png ...: labels as palette images
    Png,
    /// masks.json: COCO's JSON for videos, with compressed run lengths
    Rle,
    /// masks.npz: one NumPy array of frames, rows and columns
    Npz,
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
}

impl Masks<'_> {
    fn labels(&self, t: usize) -> Result<Vec<u8>> {
        let (labels, width, height) = read_labels(self.folder, t)?;
        let same = (width, height) == self.size;
        same.then_some(labels).ok_or_else(|| Failure::new(format!("mask {t} is {width}x{height}: please report this")))
    }

    /// Writes `masks.npz`: the array `masks`, bytes, frame by frame and row by row.
    pub(crate) fn write_npz(&self, place: &Place) -> Result<()> {
        let path = place.file("masks.npz");
        let bad = |e: zip::result::ZipError| cannot_write(&path, &e.into());
        let mut zip = ZipWriter::new(BufWriter::new(File::create(&path).map_err(|e| cannot_write(&path, &e))?));
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Deflated).large_file(true);
        zip.start_file("masks.npy", options).map_err(bad)?;
        zip.write_all(&npy_header(self.frames, self.size)).map_err(|e| cannot_write(&path, &e))?;
        for t in 0..self.frames {
            zip.write_all(&self.labels(t)?).map_err(|e| cannot_write(&path, &e))?;
        }
        let mut file = zip.finish().map_err(bad)?;
        file.flush().map_err(|e| cannot_write(&path, &e))
    }

    /// Writes `masks.json` as the package does; `names` are the files of the frames.
    pub(crate) fn write_coco(&self, place: &Place, video: &str, names: Option<&[String]>) -> Result<()> {
        let (path, (width, height)) = (place.file("masks.json"), self.size);
        let file_name = |t: usize| names.and_then(|n| n.get(t).cloned()).unwrap_or_else(|| format!("{t:05}.png"));
        let image = |t: usize| {
            json!({ "id": t + 1, "video_id": 1, "frame_index": t, "width": width, "height": height,
                "file_name": file_name(t) })
        };
        let (mut all, mut seen) = (Vec::new(), [false; 256]);
        for t in 0..self.frames {
            let labels = self.labels(t)?;
            labels.iter().for_each(|&label| seen[usize::from(label)] = true);
            all.extend(annotations(&labels, t, self.size));
        }
        let labels = (1..256).filter(|&label| seen[label]);
        let coco = json!({
            "info": { "description": "Masks of moving objects by TraceCut", "version": env!("CARGO_PKG_VERSION") },
            "videos": [{ "id": 1, "name": video, "width": width, "height": height }],
            "images": (0..self.frames).map(image).collect::<Vec<Value>>(),
            "tracks": labels.map(|id| json!({ "id": id, "category_id": 1, "video_id": 1 })).collect::<Vec<Value>>(),
            "categories": [{ "id": 1, "name": "object" }],
            "annotations": all,
        });
        crate::failure::write(&path, coco.to_string() + "\n")
    }
}

/// The head of a file for NumPy that holds bytes, frame by frame and row by row. Version 1.0 of the format: the data begin
/// at a multiple of 64 bytes.
pub(crate) fn npy_header(frames: usize, (width, height): (usize, usize)) -> Vec<u8> {
    let mut words = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({frames}, {height}, {width}), }}");
    while (10 + words.len() + 1) % 64 != 0 {
        words.push(' ');
    }
    words.push('\n');
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend((words.len() as u16).to_le_bytes());
    header.extend(words.as_bytes());
    header
}

/// What COCO says of each label of frame `t` but 0.
pub(crate) fn annotations(labels: &[u8], t: usize, size: (usize, usize)) -> Vec<Value> {
    runs_of(labels, size.0, size.1).iter().filter(|runs| runs.label > 0).map(|runs| runs.annotation(t, size)).collect()
}

/// The mask of one label in one frame, column by column: a run of 0, which may be empty, then of 1, and so on.
#[derive(Debug, Default)]
struct Runs {
    label: u8,
    counts: Vec<usize>,
    area: usize,
    /// Left, top, right and bottom; the latter two beyond the last pixel.
    bounds: (usize, usize, usize, usize),
    end: usize,
}

/// The runs of every label that is there, ascending.
fn runs_of(labels: &[u8], width: usize, height: usize) -> Vec<Runs> {
    let mut found: Vec<Runs> = (0..=255).map(|label| Runs { label, ..Runs::default() }).collect();
    let column = |k: usize| labels[k % height * width + k / height];
    let mut start = 0;
    while start < labels.len() {
        let label = column(start);
        let end = (start + 1..labels.len()).find(|&k| column(k) != label).unwrap_or(labels.len());
        found[usize::from(label)].add(start, end, height);
        start = end;
    }
    found.retain(|runs| runs.area > 0);
    for runs in found.iter_mut().filter(|runs| runs.end < labels.len()) {
        runs.counts.push(labels.len() - runs.end);
    }
    found
}

impl Runs {
    fn add(&mut self, start: usize, end: usize, height: usize) {
        let (left, right) = (start / height, (end - 1) / height);
        // A run that goes on in the next column touches both edges.
        let (top, bottom) = if left == right { (start % height, (end - 1) % height + 1) } else { (0, height) };
        let (l, t, r, b) = if self.area == 0 { (left, top, 0, 0) } else { self.bounds };
        self.bounds = (l.min(left), t.min(top), r.max(right + 1), b.max(bottom));
        self.counts.extend([start - self.end, end - start]);
        self.area += end - start;
        self.end = end;
    }

    fn annotation(&self, t: usize, (width, height): (usize, usize)) -> Value {
        let (label, (left, top, right, bottom)) = (self.label, self.bounds);
        json!({
            "id": t * 256 + usize::from(label) + 1, "image_id": t + 1, "video_id": 1, "track_id": label,
            "category_id": 1, "attributes": { "track_id": label }, "area": self.area,
            "bbox": [left, top, right - left, bottom - top], "iscrowd": 0,
            "segmentation": { "size": [height, width], "counts": compressed(&self.counts) },
        })
    }
}

/// Run lengths as pycocotools writes them: from the fourth on as the difference from the last but one, five bits a
/// character.
fn compressed(counts: &[usize]) -> String {
    let mut text = String::new();
    for (i, &count) in counts.iter().enumerate() {
        let mut rest = count as i64 - if i > 2 { counts[i - 2] as i64 } else { 0 };
        loop {
            let five = (rest & 31) as u8;
            rest >>= 5;
            // The fifth bit is the sign: what is left is over when it is nothing but that.
            let more = rest != if five & 16 > 0 { -1 } else { 0 };
            text.push(char::from(48 + five + if more { 32 } else { 0 }));
            if !more {
                break;
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_go_down_the_columns_and_have_a_box() {
        // Two columns of three rows: 0 1 / 1 1 / 1 0.
        let runs = runs_of(&[0, 1, 1, 1, 1, 0], 2, 3);
        assert_eq!((runs[1].label, &runs[1].counts[..], runs[1].area), (1, &[1, 4, 1][..], 4));
        assert_eq!((runs[0].label, &runs[0].counts[..]), (0, &[0, 1, 4, 1][..]));
        assert_eq!(runs[1].annotation(2, (2, 3))["bbox"], json!([0, 0, 2, 3]));
        assert_eq!(runs_of(&[0, 0, 0, 7, 0, 0], 3, 2)[1].annotation(0, (3, 2))["bbox"], json!([0, 1, 1, 1]));
    }

    /// Known strings of pycocotools.
    #[test]
    fn lengths_are_compressed_as_pycocotools_does() {
        for (counts, text) in
            [(&[6, 1, 40, 4, 5, 4, 5, 4, 21][..], "61X13mN000`0"), (&[0, 64], "0P2"), (&[15, 16], "?`0")]
        {
            assert_eq!(compressed(counts), text, "{counts:?}");
        }
    }
}
