//! `bench superpixels`: superpixels against human segmentations, at several counts.

use super::mat;
use crate::measures::superpixels::{SuperpixelScores, score_superpixels};
use clap::Args;
use std::path::PathBuf;
use tracecut::contour::boundary_map;
use tracecut::image::Plane;
use tracecut::superpixel::superpixels_in;
use tracecut_cli::failure::{Result, print};
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
    #[command(flatten)]
    settings: Settings,
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
    for path in &paths {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let truth = mat::read(&args.folder.join("groundTruth").join(format!("{name}.mat")))?;
        let map = boundary_map(&decode(path)?);
        let targets = std::iter::once(None).chain(args.counts.iter().map(|&n| Some(n)));
        for (row, target) in rows.iter_mut().zip(targets) {
            let superpixels = superpixels_in(&map, target, &params.contour, &params.superpixel);
            row.add(&superpixels.label(), superpixels.count, &truth)?;
        }
    }
    print(format_args!(
        "{:28} {:>8} {:>8} {:>8} {:>8} {:>8}",
        "superpixels", "count", "recall", "under", "leak", "asa"
    ))?;
    rows.iter().try_for_each(Row::print)?;
    print(format_args!("mean of {} images, annotators of an image averaged first", paths.len()))
}
