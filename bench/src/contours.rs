//! `bench contours`: boundary maps against the outlines that people drew.

use super::batch::write_json;
use super::mat;
use crate::measures::contours::{ImageScore, Matching, Quality, Summary, score, summarize, tolerance};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tracecut::contour::boundary_map;
use tracecut::image::Plane;
use tracecut::still::image_discontinuities;
use tracecut_cli::clock::{Clock, Seconds};
use tracecut_cli::failure::{Failure, Result, print};
use tracecut_cli::images::in_folder;
use tracecut_cli::input::decode;
use tracecut_cli::settings::Settings;

#[derive(Args, Debug)]
pub(crate) struct ContoursArgs {
    /// Folder in the layout of BSDS500: images/*.jpg and groundTruth/*.mat, or both in train, val and test below these
    /// two
    folder: PathBuf,
    /// Also score the discontinuities of the pixel embedding, the gradients of its eigenvectors, and both beside Pb;
    /// slow
    #[arg(long)]
    embedding: bool,
    /// Also write the numbers as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
}

/// Tolerances in pixels beside the benchmark's own.
const FINE_PX: f64 = 2.0;

const RECIPE: &str = "Pb";
/// The maps that `--embedding` adds.
const EMBEDDED: [&str; 3] = ["discontinuities", "spectral gradients", "Pb + discontinuities"];

/// Ways of counting: name, matching, and whether at the fine tolerance.
const COUNTS: [(&str, Matching, bool); 4] = [
    ("one-to-one", Matching::OneToOne, false),
    ("nearest", Matching::Nearest, false),
    ("one-to-one, 2 px", Matching::OneToOne, true),
    ("nearest, 2 px", Matching::Nearest, true),
];

pub(super) fn eval(args: &ContoursArgs) -> Result<()> {
    let params = args.settings.params()?;
    let pairs = find_pairs(&args.folder)?;
    let recipes: Vec<&str> = [RECIPE].into_iter().chain(EMBEDDED.into_iter().filter(|_| args.embedding)).collect();
    let mut scores: Vec<[Vec<ImageScore>; COUNTS.len()]> = recipes.iter().map(|_| Default::default()).collect();
    let mut spent = Seconds::default();
    for (image, truth) in &pairs {
        let frame = decode(image)?;
        let people: Vec<Plane<bool>> = mat::read(truth)?.into_iter().map(|a| a.boundaries).collect();
        let clock = Clock::start();
        let ours = boundary_map(&frame).thin;
        spent.add(clock.seconds());
        let mut maps = vec![ours];
        if args.embedding {
            let boundaries = image_discontinuities(&frame, &params.still, params.clip.seed);
            maps.extend([boundaries.d.thin, boundaries.spectral.thin, boundaries.combined.thin]);
        }
        for (map, lists) in maps.iter().zip(&mut scores) {
            for (&(_, matching, fine), list) in COUNTS.iter().zip(lists) {
                let radius = if fine { FINE_PX } else { tolerance(frame.width(), frame.height()) };
                let score = score(map, &people, radius, matching).map_err(|e| Failure::about(image.display(), e))?;
                list.push(score);
            }
        }
    }
    let ms = 1000.0 * spent.best() / pairs.len() as f64;
    report(&recipes, &scores, pairs.len(), ms, args.json.as_deref())
}

fn report(
    recipes: &[&str],
    scores: &[[Vec<ImageScore>; COUNTS.len()]],
    images: usize,
    ms: f64,
    json_path: Option<&Path>,
) -> Result<()> {
    let mut tables = serde_json::Map::new();
    let width = recipes.iter().map(|r| r.len()).max().unwrap_or(0);
    print(format_args!("matching          {:width$}    ODS   precision recall threshold     OIS", "recipe"))?;
    for (k, (count, ..)) in COUNTS.iter().enumerate() {
        let mut rows = serde_json::Map::new();
        for (recipe, lists) in recipes.iter().zip(scores) {
            let Summary { ods, ois } = summarize(&lists[k]);
            print(format_args!(
                "{count:17} {recipe:width$} {:.4}      {:.4} {:.4}    {:.4}  {:.4}",
                ods.f(),
                ods.precision,
                ods.recall,
                ods.threshold,
                ois.f()
            ))?;
            rows.insert((*recipe).into(), json!({"ods": numbers(ods), "ois": numbers(ois)}));
        }
        tables.insert((*count).into(), Value::Object(rows));
    }
    print(format_args!("{images} images, {ms:.1} ms a boundary map"))?;
    write_json(json_path, &json!({"images": images, "millisecondsAMap": ms, "scores": tables}))
}

fn numbers(quality: Quality) -> Value {
    let Quality { threshold, precision, recall } = quality;
    json!({"f": quality.f(), "precision": precision, "recall": recall, "threshold": threshold})
}

/// Images and their ground truth, of the folder itself or of its three parts.
pub(super) fn find_pairs(folder: &Path) -> Result<Vec<(PathBuf, PathBuf)>> {
    let (images, truths) = (folder.join("images"), folder.join("groundTruth"));
    if !images.is_dir() || !truths.is_dir() {
        let reason = "is not in the layout of BSDS500 (expected the folders `images` and `groundTruth` in it)";
        return Err(Failure::about(folder.display(), reason));
    }
    let mut pairs = Vec::new();
    for part in ["", "train", "val", "test"] {
        let folder = images.join(part);
        let holds_images = folder.is_dir() && (!part.is_empty() || !images.join("train").is_dir());
        for image in if holds_images { in_folder(&folder)? } else { Vec::new() } {
            let name = image.file_stem().unwrap_or_default();
            let truth = truths.join(part).join(name).with_extension("mat");
            pairs.push((image, truth));
        }
    }
    Ok(pairs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracecut::image::Frame;
    use tracecut::still::StillParams;

    /// F at the best threshold of each of the maps of every `step`-th image. Runs where the benchmark lies beside the
    /// checkout; it cannot be part of the repository.
    fn best_f<const N: usize>(step: usize, maps_of: impl Fn(&Frame) -> [Plane<f32>; N]) -> Option<[f64; N]> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/bsds");
        let Ok(pairs) = find_pairs(&folder) else {
            println!("skipped: no Berkeley images in {}", folder.display());
            return None;
        };
        let mut scores = [const { Vec::new() }; N];
        for (image, truth) in pairs.iter().step_by(step) {
            let frame = decode(image).unwrap();
            let people: Vec<_> = mat::read(truth).unwrap().into_iter().map(|a| a.boundaries).collect();
            let radius = tolerance(frame.width(), frame.height());
            for (map, list) in maps_of(&frame).iter().zip(&mut scores) {
                list.push(score(map, &people, radius, Matching::OneToOne).unwrap());
            }
        }
        Some(scores.map(|list| summarize(&list).ods.f()))
    }

    #[test]
    fn boundaries_agree_with_people() {
        let Some([pb]) = best_f(10, |frame| [boundary_map(frame).thin]) else { return };
        assert!(pb > 0.66, "{pb}");
    }

    #[test]
    #[ignore = "18 seconds; part of npm run test:long"]
    fn discontinuities_help_pb_and_come_near_the_gradients_of_their_eigenvectors() {
        let maps_of = |frame: &Frame| {
            let found = image_discontinuities(frame, &StillParams::default(), 0);
            [found.pb.thin, found.combined.thin, found.d.thin, found.spectral.thin]
        };
        let Some([pb, combined, d, spectral]) = best_f(4, maps_of) else { return };
        assert!(combined > pb, "combined {combined}, Pb {pb}, discontinuities {d}, gradients {spectral}");
        assert!(d > spectral - 0.02, "discontinuities {d}, gradients {spectral}");
    }

    #[test]
    fn other_folders_are_an_error() {
        let failure = find_pairs(Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_err();
        assert!(failure.reason.contains("BSDS500"), "{}", failure.reason);
    }
}
