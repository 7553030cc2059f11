//! File formats for JavaScript: image files to pixels; masks enlarged to the size of their pictures, as run lengths, prompts and a
//! table; distances of pixels to strokes; see `npm/worker/instance.ts`, `enlarge.ts` and
//! `regions.ts` of `npm/kit/edit`, and `annotations.ts` and `table.ts` of `npm/kit/export`.
//!
//! It compiles these files of the library, a tenth of it, which makes a small wasm file.

#![cfg(target_arch = "wasm32")]
#![allow(dead_code, unused_imports, unreachable_pub, reason = "only parts of the library's files are used here")]
#![allow(clippy::needless_range_loop, reason = "as in the library")]

#[path = "../src/base/error.rs"]
mod error;
#[path = "../src/base/image/mod.rs"]
mod image;
#[path = "../src/base/params/mod.rs"]
mod params;
#[path = "../src/base/sets.rs"]
mod sets;
#[path = "../src/correction/stroke.rs"]
mod stroke;
#[path = "../src/motion/trajectory/trajectories.rs"]
mod trajectory;

/// Colour models and alpha-expansion of `src/dense/cut`, for the refinement of borders.
#[path = "."]
mod cut {
    #[path = "../src/dense/cut/colour.rs"]
    mod colour;
    #[path = "../src/dense/cut/expansion.rs"]
    mod expansion;
    #[path = "../src/dense/cut/maxflow.rs"]
    mod maxflow;

    pub(crate) use colour::{Colour, Corners, Histogram, UNSEEN_SHARE};
    pub(crate) use expansion::{Potts, minimize, to_steps};
}

/// The files of `src/mask` that need nothing of the stages before.
#[path = "."]
mod mask {
    #[path = "../src/mask/coco.rs"]
    mod coco;
    #[path = "../src/mask/enlarge.rs"]
    mod enlarge;
    #[path = "../src/mask/opacity.rs"]
    mod opacity;
    #[path = "../src/mask/prompts.rs"]
    mod prompts;
    #[path = "../src/mask/refine.rs"]
    mod refine;
    #[path = "../src/mask/table.rs"]
    mod table;

    pub(crate) use coco::{CocoRuns, coco_counts, coco_mask, coco_runs, coco_text};
    pub(crate) use enlarge::enlarge_to;
    pub(crate) use prompts::{Prompt, Prompts};
    pub(crate) use refine::RefineParams;
    pub(crate) use table::{ObjectRow, object_rows, object_table};
}

use crate::error::Error;
use crate::image::{Frame, Picture, Plane};
use crate::mask::ObjectRow;
use crate::stroke::Stroke;
use crate::trajectory::Trajectories;
use js_sys::{Array, Reflect, Uint8Array};
use wasm_bindgen::prelude::*;

/// Returns RGBA bytes, width and height of a PNG or JPEG file of at most `max_pixels` pixels.
#[wasm_bindgen]
pub fn decode(bytes: &[u8], max_pixels: usize) -> Result<Array, JsValue> {
    let frame = Frame::decode_within(bytes, max_pixels).map_err(|error| to_js_error(&error))?;
    let mut rgba = Vec::with_capacity(4 * frame.width() * frame.height());
    for pixel in frame.rgb().chunks_exact(3) {
        rgba.extend_from_slice(&[pixel[0], pixel[1], pixel[2], 255]);
    }
    Ok(Array::of3(&Uint8Array::from(rgba.as_slice()).into(), &frame.width().into(), &frame.height().into()))
}

/// Returns labels and opacity of a mask at the size of its picture, which is RGBA bytes. `chosen` is 1 for each label whose opacity is
/// computed.
#[wasm_bindgen]
pub fn enlarge(
    labels: Vec<u8>,
    width: usize,
    rgba: &[u8],
    picture_width: usize,
    picture_height: usize,
    chosen: &[u8],
) -> Result<Array, JsValue> {
    let picture = Picture::<4>::new(rgba, picture_width, picture_height).map_err(|error| to_js_error(&error))?;
    let mask = mask_of(labels, width);
    let enlarged = mask::enlarge_to(&mask, picture, |label| chosen.get(usize::from(label)) == Some(&1))
        .map_err(|error| to_js_error(&error))?;
    let bytes = |plane: &Plane<u8>| JsValue::from(Uint8Array::from(plane.data()));
    Ok(Array::of2(&bytes(&enlarged.labels), &bytes(&enlarged.alpha)))
}

/// Returns the runs of the labels for which `chosen` is 1: `[label, area, left, top, width, height, counts]` of each, ascending.
#[wasm_bindgen(js_name = cocoRuns)]
pub fn coco_runs(labels: Vec<u8>, width: usize, chosen: &[u8]) -> Array {
    let runs = mask::coco_runs(&mask_of(labels, width));
    let is_chosen = |label: u8| chosen.get(usize::from(label)) == Some(&1);
    let entry = |runs: &mask::CocoRuns| {
        let ((left, top), (width, height)) = (runs.corner, runs.size);
        let numbers = [usize::from(runs.label), runs.area, left, top, width, height];
        let entry: Array = numbers.iter().map(|&number| JsValue::from(number)).collect();
        entry.push(&mask::coco_text(&runs.counts).into());
        entry
    };
    runs.iter().filter(|runs| is_chosen(runs.label)).map(entry).collect()
}

/// Decodes run lengths to a mask of 0 and 1; `text`, in ASCII, is used instead of `counts` if it is not empty.
#[wasm_bindgen(js_name = cocoMask)]
pub fn coco_mask(text: &[u8], counts: &[u32], width: usize, height: usize) -> Result<Vec<u8>, JsValue> {
    let read = |text: &[u8]| mask::coco_counts(&String::from_utf8_lossy(text));
    let counts = if text.is_empty() { Ok(counts.to_vec()) } else { read(text) };
    let mask = counts.and_then(|counts| mask::coco_mask(&counts, (width, height)));
    mask.map(Plane::into_data).map_err(|error| to_js_error(&error))
}

/// Returns the squared distance of each pixel of a frame to the centre line of a stroke with `points` x0, y0, x1, y1, and so on;
/// infinite beyond `reach` pixels.
#[wasm_bindgen(js_name = strokeDistances)]
pub fn stroke_distances(points: &[f32], reach: f64, width: usize, height: usize) -> Vec<f64> {
    let points = points.chunks_exact(2).map(|place| (place[0], place[1])).collect();
    Stroke { t: 0, points, radius: 0.0 }.distances(reach, (width, height), (width, height))
}

/// Numbers of a row of the objects' table: frame, time, object, left, top, width, height, area, x, y, dx, dy, number of
/// trajectories and doubt; missing ones are NaN.
const COLUMNS: usize = 14;

/// Returns the rows of the objects in frames from `t` on. `labels` has the masks of these frames; trajectories are in their pixels.
#[wasm_bindgen(js_name = objectRows)]
#[allow(clippy::too_many_arguments, reason = "flat arrays are what crosses the boundary cheaply")]
pub fn object_rows(
    labels: &[u8],
    width: usize,
    height: usize,
    t: usize,
    start_frame: Vec<u32>,
    offset: Vec<u32>,
    x: Vec<f32>,
    y: Vec<f32>,
) -> Result<Vec<f64>, JsValue> {
    let variation = vec![0.0; x.len()];
    let (num_frames, size) = (usize::MAX, (width, height));
    let tracks = Trajectories { num_frames, size, start_frame, offset, x, y, variation };
    tracks.check().map_err(|error| to_js_error(&error))?;
    let masks = labels.chunks_exact((width * height).max(1)).map(|labels| mask_of(labels.to_vec(), width));
    let rows = masks.enumerate().flat_map(|(k, mask)| mask::object_rows(&mask, &tracks, t + k));
    Ok(rows.flat_map(|row| numbers(&row)).collect())
}

fn numbers(row: &ObjectRow) -> [f64; COLUMNS] {
    let ObjectRow { corner, size, centroid, .. } = row;
    let integer = |number: usize| number as f64;
    let (dx, dy) = row.motion.unwrap_or((f64::NAN, f64::NAN));
    [
        integer(row.frame),
        row.time.unwrap_or(f64::NAN),
        f64::from(row.object),
        integer(corner.0),
        integer(corner.1),
        integer(size.0),
        integer(size.1),
        integer(row.area),
        centroid.0,
        centroid.1,
        dx,
        dy,
        integer(row.trajectories),
        row.doubt.map_or(f64::NAN, |doubt| f64::from(u8::from(doubt))),
    ]
}

/// Formats such rows as comma-separated values.
#[wasm_bindgen(js_name = objectTable)]
pub fn object_table(rows: &[f64]) -> String {
    let optional = |number: f64| Some(number).filter(|number| !number.is_nan());
    let row = |row: &[f64]| ObjectRow {
        frame: row[0] as usize,
        time: optional(row[1]),
        object: row[2] as u8,
        corner: (row[3] as usize, row[4] as usize),
        size: (row[5] as usize, row[6] as usize),
        area: row[7] as usize,
        centroid: (row[8], row[9]),
        motion: optional(row[10]).zip(optional(row[11])),
        trajectories: row[12] as usize,
        doubt: optional(row[13]).map(|doubt| doubt != 0.0),
    };
    mask::object_table(&rows.chunks_exact(COLUMNS).map(row).collect::<Vec<_>>())
}

/// Finds prompts in masks frame by frame.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct Prompts(mask::Prompts);

#[wasm_bindgen]
impl Prompts {
    /// Starts without masks.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the mask of frame `t`, with the labels for which `chosen` is 1.
    pub fn add(&mut self, t: usize, mut labels: Vec<u8>, width: usize, chosen: &[u8]) {
        let is_chosen = |label: u8| chosen.get(usize::from(label)) == Some(&1);
        labels.iter_mut().filter(|label| !is_chosen(**label)).for_each(|label| *label = 0);
        self.0.add(t, &mask_of(labels, width));
    }

    /// Returns `[object, frame, box, points inside, points outside, run lengths]` of each object, with flat lists of coordinates.
    pub fn finish(self) -> Array {
        let flatten = |points: &[(usize, usize)]| -> JsValue {
            points.iter().flat_map(|&(x, y)| [x as u32, y as u32]).collect::<Vec<u32>>().into()
        };
        let entry = |prompt: &mask::Prompt| {
            let corners = [(prompt.bounds[0], prompt.bounds[1]), (prompt.bounds[2], prompt.bounds[3])];
            let runs = mask::coco_runs(&prompt.mask);
            let counts = runs.iter().find(|runs| runs.label == 1).map(|runs| mask::coco_text(&runs.counts));
            let entry = [
                prompt.object.into(),
                prompt.frame.into(),
                flatten(&corners),
                flatten(&prompt.inside),
                flatten(&prompt.outside),
                counts.unwrap_or_default().into(),
            ];
            entry.into_iter().collect::<Array>()
        };
        self.0.finish().iter().map(entry).collect()
    }
}

/// Returns a mask of `width` columns, which must divide the number of labels.
fn mask_of(labels: Vec<u8>, width: usize) -> Plane<u8> {
    let height = labels.len() / width.max(1);
    Plane::from_vec(width, height, labels).unwrap_or_default()
}

fn to_js_error(error: &Error) -> JsValue {
    let value = js_sys::Error::new(&error.to_string());
    // Setting a property of a fresh, extensible object cannot fail.
    let _ = Reflect::set(&value, &"code".into(), &error.code().into());
    value.into()
}
