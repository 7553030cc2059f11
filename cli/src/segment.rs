//! `tracecut segment`: clips in; masks, labelled trajectories, pictures and reports out.

use crate::dump;
use crate::ending::{self, uninterrupted};
use crate::failure::{Failure, Result, create_folder, read_text, write};
use crate::formats::{Format, Masks};
use crate::input::{Input, KINDS};
use crate::log::{Log, LogArgs};
use crate::masks::{self, MaskFolders};
use crate::output::{Existing, OutputFolder};
use crate::pictures;
use crate::provenance::{Options, Origin, Provenance, Recipe, SavedRun};
use crate::report::{Report, Truncated, WindowPart, rows};
use crate::run::Clock;
use crate::settings::Settings;
use crate::window::{ClipRun, ClipSummary, WindowResult, too_few};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use tracecut::params::ParamValue;
use tracecut::tracks;
use tracecut::trajectory::Trajectories;
use tracecut::{Params, Window};

#[derive(Args, Debug)]
#[command(after_help = RESULTS)]
pub(crate) struct SegmentArgs {
    #[arg(required = true, value_name = "INPUT", help = KINDS)]
    inputs: Vec<PathBuf>,
    /// Folder for the results, created when the run is done; for several inputs, a folder in it for each
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Formats to write, one or more
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', default_value = "png,tracks")]
    format: Vec<Format>,
    /// Replace existing results
    #[arg(long)]
    overwrite: bool,
    /// Continue an unfinished run after its last finished window
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    #[command(flatten)]
    log: LogArgs,
    /// Frames of a window; a longer clip is segmented window by window, with 10 frames in common
    #[arg(long, value_name = "N", default_value_t = Window::FRAMES as u16,
        value_parser = clap::value_parser!(u16).range(2..=Window::MAX_FRAMES as i64))]
    window: u16,
    /// Take the first N frames, 2 or more
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    frames: Option<u32>,
    /// Spacing of the trajectories, in pixels; short for --set trajectory.gridStep=PX
    #[arg(long, value_name = "PX")]
    track_step: Option<f64>,
    /// Use the trajectories of another tracker, in the format of tracks.dat; labels are ignored, and all frames are one
    /// window
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    tracks: Option<PathBuf>,
    /// Only label trajectories, without masks; short for --set clip.dense=false
    #[arg(long)]
    no_dense: bool,
    /// Also write the scene without the objects, frame by frame, at the working size
    #[arg(long, conflicts_with = "no_dense")]
    background: bool,
    /// Also write affinities, eigenpairs, neighbour pairs and saliency as text
    #[arg(long)]
    dump: bool,
    /// Number of threads, which does not change results [default: all that the machine has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=256))]
    threads: Option<u32>,
    #[command(flatten)]
    settings: Settings,
}

const RESULTS: &str = "\
Results in the folder:
  masks/00000.png ...          png: label of each pixel, 0 for the background, at the size of the frames
  masks.json                   rle: the same as COCO's JSON for videos
  masks.npz                    npz: the same as an array of frames, rows and columns, with the times of the frames
  prompts.json                 prompts: a frame, box, points and mask of each object, for models like SAM 2
  tracks.dat                   tracks: labelled trajectories; with several windows tracks/00000.dat ...
  overlay/00000.png ...        overlay: frames with the trajectories, coloured by label
  overlay-masks/00000.png ...  overlay: frames with the objects tinted and outlined
  objects.csv                  box, area, centre and mean motion of each object in each frame, and where to check
  result.json                  sizes, objects, windows, shots, names and times of the frames, options, parameters,
                               seconds of work; damage of the input
  background/00000.png ...     with --background: RGBA, transparent where no frame shows the scene
  dump/                        with --dump; with several windows dump/00000/ ...

Results are written to DIR.partial, which is renamed at the end.";

pub(crate) fn segment(args: &SegmentArgs) -> Result<()> {
    let params = params_of(args)?;
    let recipe = recipe_of(args, &params);
    let targets = targets_of(args)?;
    let log = args.log.open();
    let mut failed = Vec::new();
    for (input, target) in args.inputs.iter().zip(&targets) {
        let Err(failure) = segment_one(args, &recipe, input, target, &log) else { continue };
        if targets.len() == 1 {
            return Err(failure);
        }
        log.failure(&input.display().to_string(), &failure);
        failed.push(failure.kind);
    }
    let reason = format!("{} of {} inputs failed", failed.len(), targets.len());
    failed.into_iter().min().map_or(Ok(()), |kind| Err(Failure { kind, reason, damage: None }))
}

/// Returns whether failures are logged as lines of JSON.
pub(crate) fn logs_events(args: &SegmentArgs) -> bool {
    args.log.open().logs_events()
}

fn params_of(args: &SegmentArgs) -> Result<Params> {
    let mut params = args.settings.params()?;
    if let Some(step) = args.track_step {
        params.set("trajectory.gridStep", &ParamValue::Number(step))?;
    }
    if args.no_dense {
        params.clip.dense = false;
    }
    Ok(params)
}

/// Returns the folder of each input's results: `--out`, or for several inputs a folder in it with the name of the input.
fn targets_of(args: &SegmentArgs) -> Result<Vec<PathBuf>> {
    if args.inputs.len() == 1 {
        return Ok(vec![args.out.clone()]);
    }
    let mut users: BTreeMap<PathBuf, &Path> = BTreeMap::new();
    let mut targets = Vec::new();
    for input in &args.inputs {
        let name = if input == Path::new("-") {
            Some("stdin".as_ref())
        } else if input.is_dir() {
            input.file_name()
        } else {
            input.file_stem()
        };
        let name = name.ok_or_else(|| Failure::usage("has no name for its results").with_subject(input.display()))?;
        let target = args.out.join(name);
        if let Some(first) = users.insert(target.clone(), input) {
            let reason = format!("its results would overwrite those of {} (run it separately)", first.display());
            return Err(Failure::usage(reason).with_subject(input.display()));
        }
        targets.push(target);
    }
    Ok(targets)
}

fn recipe_of<'a>(args: &SegmentArgs, params: &'a Params) -> Recipe<'a> {
    let mut formats = args.format.clone();
    formats.sort_unstable();
    formats.dedup();
    let name = |format: &Format| format.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned());
    let options = Options {
        window: args.window,
        frames: args.frames,
        formats: formats.iter().map(name).collect(),
        background: args.background,
        dump: args.dump,
        tracks: args.tracks.is_some(),
    };
    Recipe { version: env!("CARGO_PKG_VERSION"), options, params }
}

fn segment_one(args: &SegmentArgs, recipe: &Recipe<'_>, path: &Path, target: &Path, log: &Log) -> Result<()> {
    let (clock, place) = (Clock::start(), OutputFolder::new(target)?);
    // Checks the input before the folder is touched.
    let input = Input::open(path, args.frames)?.with_limits(recipe.params);
    let job = ClipJob { args, recipe, place: &place, path, name: &path.display().to_string() };
    let (event, result) = if args.resume && place.is_complete() {
        ("complete", job.check_complete(&input)?)
    } else {
        ("done", job.claim_and_run(&input, clock, log)?)
    };
    log.event(event, json!({ "input": job.name, "out": target, "frames": result.frames }));
    log.finish_input(&result.report, &result.summary)?;
    let Some(truncated) = result.truncated else { return Ok(()) };
    log.event("truncated", json!({ "input": job.name, "frames": truncated.frames, "reason": truncated.reason }));
    Err(truncated.failure(job.name))
}

/// Reads a track file. The session checks that trajectories fit the frames.
fn read_tracks(path: &Path) -> Result<Trajectories> {
    tracks::parse(&read_text(path)?).map(|(tracks, _)| tracks).map_err(|e| Failure::about(path.display(), e))
}

/// A clip and the folder of its results.
struct ClipJob<'a> {
    args: &'a SegmentArgs,
    recipe: &'a Recipe<'a>,
    place: &'a OutputFolder,
    path: &'a Path,
    name: &'a str,
}

/// The outcome of a clip whose results are written.
struct ClipOutcome {
    /// Number of frames.
    frames: Value,
    /// The report on one line.
    report: String,
    summary: String,
    truncated: Option<Truncated>,
}

impl ClipJob<'_> {
    fn wants(&self, format: Format) -> bool {
        self.args.format.contains(&format)
    }

    /// Reads the report of complete results. Fails if this run would give others.
    fn check_complete(&self, input: &Input) -> Result<ClipOutcome> {
        let target = self.place.target();
        let first = input.frames()?.next().ok_or_else(|| too_few(self.path, 0))??;
        let source = Origin::new(self.path, input.num_frames(), &first.frame);
        let report: Value = serde_json::from_str(&read_text(&target.join("result.json"))?).unwrap_or_default();
        Provenance { recipe: self.recipe, source }.check(target, &report)?;
        let truncated = serde_json::from_value(report["truncated"].clone()).unwrap_or_default();
        let summary = format!("{} is complete already", target.display());
        Ok(ClipOutcome { frames: report["frames"].clone(), report: report.to_string(), summary, truncated })
    }

    /// Claims the folder and runs the clip. Removes the folder again if the run fails before its first checkpoint.
    fn claim_and_run(&self, input: &Input, clock: Clock, log: &Log) -> Result<ClipOutcome> {
        let tracks = self.args.tracks.as_deref().map(read_tracks).transpose()?;
        let (place, &SegmentArgs { overwrite, resume, .. }) = (self.place, self.args);
        let guard = ending::clean_up_on_signal(place);
        uninterrupted(|| place.claim(Existing { overwrite, resume }))?;
        log.event("begin", json!({ "input": self.name, "out": place.target(), "frames": input.num_frames() }));
        let outcome = self.run(input, tracks, clock, log);
        if outcome.is_err() {
            uninterrupted(|| place.give_up());
        }
        drop(guard);
        outcome
    }

    fn run(&self, input: &Input, tracks: Option<Trajectories>, mut clock: Clock, log: &Log) -> Result<ClipOutcome> {
        let saved_run = if self.args.resume { SavedRun::read(self.place)? } else { None };
        let default = || std::thread::available_parallelism().map_or(1, usize::from);
        let run = ClipRun {
            path: self.path,
            recipe: self.recipe,
            window: usize::from(self.args.window),
            threads: self.args.threads.map_or_else(default, |threads| threads as usize),
            tracks,
            needs_frames: self.wants(Format::Overlay),
        };
        let summary = run.run(input, self.place, saved_run, log, |window, mut timing| {
            let writing = Clock::start();
            let masks = masks::write_window(window, &self.mask_folders())?;
            self.write_window(window)?;
            timing.close(writing.seconds(), clock.lap());
            WindowPart::new(window, masks, &timing)?.write(self.place)
        })?;
        log.end();
        let parts = WindowPart::read_all(self.place, summary.windows)?;
        uninterrupted(|| self.finish(input, &summary, &parts, clock))
    }

    fn mask_folders(&self) -> MaskFolders {
        let folder = |name: &str, is_requested: bool| is_requested.then(|| self.place.file(name));
        let needs_masks = [Format::Rle, Format::Npz, Format::Prompts].into_iter().any(|format| self.wants(format));
        MaskFolders {
            masks: folder("masks", self.wants(Format::Png))
                .or_else(|| needs_masks.then(|| self.place.work().join("masks"))),
            tints: folder("overlay-masks", self.wants(Format::Overlay)),
            backgrounds: folder("background", self.args.background),
        }
    }

    /// Writes the trajectories of a window.
    fn write_window(&self, window: &WindowResult<'_>) -> Result<()> {
        let (place, results) = (self.place, window.results()?);
        if self.wants(Format::Tracks) {
            create_folder(&place.file("tracks"))?;
            let text = tracks::write(results.tracks, results.clusters)?;
            write(&place.file(format!("tracks/{:05}.dat", window.index)), text)?;
        }
        if self.wants(Format::Overlay) {
            pictures::write_points(window, place.file("overlay"))?;
        }
        if self.args.dump {
            dump::write_all(&place.file(format!("dump/{:05}", window.index)), window.session)?;
        }
        Ok(())
    }

    /// Writes the results of the whole clip, the report last, and renames the folder.
    fn finish(
        &self,
        input: &Input,
        summary: &ClipSummary<'_>,
        parts: &[WindowPart],
        clock: Clock,
    ) -> Result<ClipOutcome> {
        let report = Report::new(self.name.to_owned(), input.names(), summary, parts);
        let mut report = report.ok_or_else(|| Failure::new("there is no window: please report this"))?;
        if parts.len() == 1 {
            self.rename_single_window()?;
        }
        if let Some(rows) = rows(parts) {
            write(&self.place.file("objects.csv"), masks::table_heading() + &rows)?;
            self.write_masks(&report)?;
        }
        report.set_costs(parts, clock.seconds());
        let bad = |e: serde_json::Error| Failure::new(format!("result.json: {e}"));
        write(&self.place.file("result.json"), serde_json::to_string_pretty(&report).map_err(bad)? + "\n")?;
        let line = serde_json::to_string(&report).map_err(bad)?;
        self.place.finish()?;
        let (frames, summary) = (report.frames.into(), report.summary(self.place));
        Ok(ClipOutcome { frames, report: line, summary, truncated: report.truncated })
    }

    fn write_masks(&self, report: &Report<'_>) -> Result<()> {
        let Some(folder) = self.mask_folders().masks else { return Ok(()) };
        let times = report.times.as_ref();
        let masks = Masks { folder: &folder, frames: report.frames, size: report.size(), times };
        if self.wants(Format::Rle) {
            masks.write_coco(self.place, self.name, report.frame_names.as_deref())?;
        }
        if self.wants(Format::Npz) {
            masks.write_npz(self.place)?;
        }
        if self.wants(Format::Prompts) {
            masks.write_prompts(self.place)?;
        }
        Ok(())
    }

    /// Removes the number from the files of a single window.
    fn rename_single_window(&self) -> Result<()> {
        let file = |name: &str| self.place.file(name);
        let rename = |from: &Path, to: &Path| fs::rename(from, to).map_err(|e| crate::failure::cannot_write(to, &e));
        if self.wants(Format::Tracks) {
            rename(&file("tracks/00000.dat"), &file("tracks.dat"))?;
            fs::remove_dir(file("tracks")).map_err(|e| crate::failure::cannot_write(&file("tracks"), &e))?;
        }
        if self.args.dump {
            rename(&file("dump/00000"), &file("dump.only"))?;
            fs::remove_dir(file("dump")).map_err(|e| crate::failure::cannot_write(&file("dump"), &e))?;
            rename(&file("dump.only"), &file("dump"))?;
        }
        Ok(())
    }
}
