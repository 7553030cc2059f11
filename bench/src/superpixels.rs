//! `bench superpixels`: superpixels against human segmentations, at several counts, compared with other programs.

use super::mat;
use crate::measures::superpixels::{SuperpixelScores, score_superpixels};
use clap::Args;
use image::ImageDecoder;
use image::codecs::png::PngDecoder;
use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use tracecut::Params;
use tracecut::contour::{BoundaryMap, boundary_map};
use tracecut::image::Plane;
use tracecut::superpixel::superpixels_in;
use tracecut_cli::failure::{Failure, Result, print, read};
use tracecut_cli::images;
use tracecut_cli::input::decode;
use tracecut_cli::settings::Settings;

#[derive(Args, Debug)]
pub(crate) struct SuperpixelArgs {
    /// Folder in the layout of the Berkeley benchmark: images/NAME.jpg and groundTruth/NAME.mat
    folder: PathBuf,
    /// Numbers of superpixels
    #[arg(long, value_name = "N,N,...", value_delimiter = ',', default_values_t = [100, 200, 400, 700, 1000, 1500])]
    counts: Vec<usize>,
    /// Label maps of another program, FOLDER/NAME_COUNT.png (8 or 16-bit grey, a number for each superpixel), scored
    /// beside ours at the number of superpixels that each has; may be repeated. bench/slic.py writes such maps
    #[arg(long, value_name = "PROGRAM=FOLDER", value_parser = parse_program)]
    compare: Vec<(String, PathBuf)>,
    #[command(flatten)]
    settings: Settings,
}

fn parse_program(text: &str) -> std::result::Result<(String, PathBuf), String> {
    let (name, folder) = text.split_once('=').ok_or_else(|| "expected PROGRAM=FOLDER, such as slic=maps".to_owned())?;
    Ok((name.to_owned(), PathBuf::from(folder)))
}

/// One line of the table: scores and counts of each image.
struct Row {
    name: String,
    scores: Vec<SuperpixelScores>,
    counts: Vec<usize>,
}

impl Row {
    fn new(name: String) -> Self {
        Self { name, scores: Vec::new(), counts: Vec::new() }
    }

    fn add(&mut self, label: &Plane<u32>, count: usize, truth: &[mat::Annotation]) -> Result<()> {
        let scores: std::result::Result<Vec<_>, _> =
            truth.iter().map(|annotation| score_superpixels(label, &annotation.segmentation)).collect();
        self.scores.push(SuperpixelScores::mean(&scores?));
        self.counts.push(count);
        Ok(())
    }

    fn print(&self) -> Result<()> {
        let mean = SuperpixelScores::mean(&self.scores);
        let count = self.counts.iter().sum::<usize>() as f64 / self.counts.len().max(1) as f64;
        print(format_args!(
            "{:28} {count:8.1} {:8.4} {:8.4} {:8.4} {:8.4}",
            self.name, mean.recall, mean.under, mean.leak, mean.accuracy
        ))
    }
}

pub(super) fn eval(args: &SuperpixelArgs) -> Result<()> {
    let params = args.settings.params()?;
    let paths = images::in_folder(&args.folder.join("images"))?;
    let mut rows: Vec<Row> = std::iter::once("by threshold".to_owned())
        .chain(args.counts.iter().map(|n| format!("{n} wanted")))
        .map(Row::new)
        .collect();
    let mut compared = Vec::new();
    for (program, _) in &args.compare {
        for n in &args.counts {
            compared.push([Row::new(format!("{program} {n}")), Row::new(format!("ours, as many as {program}"))]);
        }
    }
    for path in &paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let truth = mat::read(&args.folder.join("groundTruth").join(format!("{name}.mat")))?;
        let map = boundary_map(&decode(path)?);
        let targets = std::iter::once(None).chain(args.counts.iter().map(|&n| Some(n)));
        for (row, target) in rows.iter_mut().zip(targets) {
            add_own(row, &map, target, &params, &truth)?;
        }
        let programs = args.compare.iter().flat_map(|(_, folder)| args.counts.iter().map(move |n| (folder, n)));
        for (rows, (folder, n)) in compared.iter_mut().zip(programs) {
            let label = read_labels(&folder.join(format!("{name}_{n}.png")))?;
            let count = label.data().iter().collect::<BTreeSet<_>>().len();
            rows[0].add(&label, count, &truth)?;
            add_own(&mut rows[1], &map, Some(count), &params, &truth)?;
        }
    }
    print(format_args!(
        "{:28} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "superpixels", "count", "recall", "under", "leak", "asa"
    ))?;
    rows.iter().chain(compared.iter().flatten()).try_for_each(Row::print)?;
    print(format_args!("mean of {} images, annotators of an image averaged first", paths.len()))
}

fn add_own(
    row: &mut Row,
    map: &BoundaryMap,
    count: Option<usize>,
    params: &Params,
    truth: &[mat::Annotation],
) -> Result<()> {
    let ours = superpixels_in(map, count, &params.contour, &params.superpixel);
    row.add(&ours.label(), ours.count, truth)
}

/// A label map from a grey PNG file.
fn read_labels(path: &Path) -> Result<Plane<u32>> {
    let bytes = read(path)?;
    let broken = |e: &dyn std::fmt::Display| Failure::about(path.display(), format_args!("is not a label map: {e}"));
    let decoder = PngDecoder::new(Cursor::new(&bytes)).map_err(|e| broken(&e))?;
    let (width, height) = (decoder.dimensions().0 as usize, decoder.dimensions().1 as usize);
    let color = decoder.color_type();
    let mut pixels = vec![0; decoder.total_bytes() as usize];
    decoder.read_image(&mut pixels).map_err(|e| broken(&e))?;
    let label = match color {
        image::ColorType::L8 => pixels.iter().map(|&v| u32::from(v)).collect(),
        image::ColorType::L16 => {
            pixels.as_chunks::<2>().0.iter().map(|&pair| u32::from(u16::from_ne_bytes(pair))).collect()
        }
        other => return Err(broken(&format_args!("its colour type is {other:?} (expected grey)"))),
    };
    Plane::from_vec(width, height, label).ok_or_else(|| broken(&"its size does not match its data"))
}
