//! `tracecut segment`: a clip in; masks, labelled trajectories, pictures and a report out.

use crate::clock::peak_memory_bytes;
use crate::dump;
use crate::failure::{Failure, Result, create_folder, print, read_text, write};
use crate::input::Input;
use crate::masks::{self, MaskReport};
use crate::overlay;
use crate::run::{Timing, progress_bar, run_with_tracks};
use crate::settings::Settings;
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use tracecut::discretize::Clusters;
use tracecut::embedding::{EigenInfo, Embedding};
use tracecut::eval::tracks;
use tracecut::params::ParamValue;
use tracecut::trajectory::Trajectories;
use tracecut::{Params, Session};

#[derive(Args, Debug)]
#[command(after_help = RESULTS)]
pub(crate) struct SegmentArgs {
    /// Folder of images in name order, .bmf list, animated GIF, .y4m file, or - for Y4M on standard input
    input: PathBuf,
    /// Folder for the results; made if needed
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Take the first N frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Spacing of the trajectories, in pixels; short for --set trajectory.gridStep=PX
    #[arg(long, value_name = "PX")]
    track_step: Option<f64>,
    /// Trajectories of any tracker, in the form of tracks.dat, in the place of those that tracking would find; their
    /// labels are not looked at
    #[arg(long, value_name = "FILE")]
    tracks: Option<PathBuf>,
    /// End with the labels of the trajectories, without masks; short for --set clip.dense=false
    #[arg(long)]
    no_dense: bool,
    /// Also write the scene without the objects, frame by frame, at the size that frames are processed at
    #[arg(long, conflicts_with = "no_dense")]
    background: bool,
    /// Also write how sure the label of each pixel is, frame by frame, at the size that frames are processed at
    #[arg(long, conflicts_with = "no_dense")]
    confidence: bool,
    /// Also write the affinities, the eigenpairs, the neighbour pairs and the saliency as text
    #[arg(long)]
    dump: bool,
    /// Threads to work on; results are the same for any number [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: Option<u32>,
    #[command(flatten)]
    settings: Settings,
}

const RESULTS: &str = "\
Results in the folder:
  masks/00000.png ...          label of each pixel, 0 for the background, as a palette image at the size of the frames
  overlay-masks/00000.png ...  frames with the objects tinted and outlined
  tracks.dat                   labelled trajectories
  overlay/00000.png ...        frames with the trajectories, coloured by label
  objects.csv                  box, area, centre and mean motion of each object in each frame
  result.json                  sizes, objects, parameters, times
  background/00000.png ...     with --background: RGBA, transparent where no frame shows the scene
  confidence/00000.png ...     with --confidence: grey, 0 to 255 for a probability of 0 to 1 that the label is right
  dump/                        with --dump";

/// What goes into `result.json`.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Report<'a> {
    version: &'static str,
    input: String,
    width: usize,
    height: usize,
    working_width: usize,
    working_height: usize,
    frames: usize,
    trajectories: usize,
    points: usize,
    clusters: usize,
    labels: Vec<LabelSize>,
    /// Background, objects and superpixels; left out where there are no masks.
    #[serde(flatten)]
    masks: Option<&'a MaskReport>,
    eigenvalues: &'a [f64],
    eigen: &'a EigenInfo,
    params: &'a Params,
    seconds: BTreeMap<&'static str, f64>,
    /// The same of the first thread on a processor, which other programs do not lengthen; `null` where the system does
    /// not say.
    cpu_seconds: BTreeMap<&'static str, Option<f64>>,
    peak_memory_bytes: Option<u64>,
}

#[derive(Debug, Default, Clone, Serialize)]
struct LabelSize {
    label: usize,
    trajectories: usize,
    points: usize,
}

pub(crate) fn segment(args: &SegmentArgs) -> Result<()> {
    let mut params = args.settings.params()?;
    if let Some(step) = args.track_step {
        params.set("trajectory.gridStep", &ParamValue::Number(step))?;
    }
    if args.no_dense {
        params.clip.dense = false;
    }
    create_folder(&args.out)?;
    let input = Input::open(&args.input, args.frames, &args.out.join("stdin.y4m.part"))?;
    let bar = progress_bar();
    let all = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = args.threads.map_or_else(all, |threads| threads as usize);
    let tracks = args.tracks.as_deref().map(read_tracks).transpose()?;
    let (session, timing) = run_with_tracks(&input, tracks, params, threads, &bar)?;
    let results = Results::of(&session)?;
    write(&args.out.join("tracks.dat"), tracks::write(results.tracks, results.clusters)?)?;
    let masks = masks::write_all(&args.out, &input, &session)?;
    write_report(args, &session, &results, masks.as_ref(), &timing)?;
    masks::write_backgrounds(args.out.join("background"), &session, args.background)?;
    masks::write_confidences(args.out.join("confidence"), &session, args.confidence)?;
    if args.dump {
        dump::write_all(&args.out.join("dump"), &session)?;
    }
    overlay::write_all(&args.out, &input, results.tracks, results.clusters, &bar)?;
    print(summary(&session, &results, masks.as_ref(), &timing, &args.out))
}

/// The trajectories of a track file. What does not fit the frames is an error of the session.
fn read_tracks(path: &Path) -> Result<Trajectories> {
    tracks::parse(&read_text(path)?).map(|(tracks, _)| tracks).map_err(|e| Failure::about(path.display(), e))
}

/// What a finished session holds.
struct Results<'a> {
    tracks: &'a Trajectories,
    clusters: &'a Clusters,
    embedding: &'a Embedding,
}

impl<'a> Results<'a> {
    fn of(session: &'a Session) -> Result<Self> {
        let missing = || Failure("the session ended without a result: please report this".to_owned());
        Ok(Self {
            tracks: session.trajectories().ok_or_else(missing)?,
            clusters: session.clusters().ok_or_else(missing)?,
            embedding: session.embedding().ok_or_else(missing)?,
        })
    }
}

fn write_report(
    args: &SegmentArgs,
    session: &Session,
    results: &Results<'_>,
    masks: Option<&MaskReport>,
    timing: &Timing,
) -> Result<()> {
    let (width, height) = session.input_size().unwrap_or_default();
    let (working_width, working_height) = session.working_size().unwrap_or_default();
    let report = Report {
        version: env!("CARGO_PKG_VERSION"),
        input: args.input.display().to_string(),
        width,
        height,
        working_width,
        working_height,
        frames: session.num_frames(),
        trajectories: results.tracks.len(),
        points: results.tracks.x.len(),
        clusters: results.clusters.count,
        labels: label_sizes(results.tracks, results.clusters),
        masks,
        eigenvalues: &results.embedding.eigenvalues,
        eigen: &results.embedding.info,
        params: session.params(),
        seconds: timing.by_name(|s| s.wall),
        cpu_seconds: timing.by_name(|s| s.cpu),
        peak_memory_bytes: peak_memory_bytes(),
    };
    let json = serde_json::to_string_pretty(&report).map_err(|e| Failure::about("result.json", e))?;
    write(&args.out.join("result.json"), json + "\n")
}

fn label_sizes(tracks: &Trajectories, clusters: &Clusters) -> Vec<LabelSize> {
    let mut sizes: Vec<LabelSize> =
        (0..clusters.count).map(|label| LabelSize { label, ..LabelSize::default() }).collect();
    for (i, &label) in clusters.label.iter().enumerate() {
        let size = &mut sizes[label as usize];
        size.trajectories += 1;
        size.points += tracks.points(i).len();
    }
    sizes
}

fn summary(
    session: &Session,
    results: &Results<'_>,
    masks: Option<&MaskReport>,
    timing: &Timing,
    out: &Path,
) -> String {
    let (width, height) = session.input_size().unwrap_or_default();
    format!(
        "{} frames of {width}x{height}: {} trajectories in {} clusters, {}{:.2} s; see {}",
        session.num_frames(),
        results.tracks.len(),
        results.clusters.count,
        masks.map_or_else(String::new, |m| format!("{} object(s), ", m.num_objects())),
        timing.total.wall,
        out.display()
    )
}
