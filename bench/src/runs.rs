//! The runs of a clip: from several first frames, mirrored, and under several seeds.

use super::clips::{Clip, list};
use crate::measures::davis::scored_frames;
use crate::measures::masks::Truth;
use clap::Args;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;
use tracecut::image::{Frame, Plane};
use tracecut::{Params, Session};
use tracecut_cli::failure::{Failure, Result};
use tracecut_cli::input::{ClipFrame, decode};
use tracecut_cli::run::{Clock, Seconds};

/// Fewest frames of a run from a later first frame, unless fewer are asked for. Chosen by eye.
const MIN_FRAMES: usize = 10;

/// Seeds of commands whose figures go into the project, unless others are asked for.
pub(super) const SEEDS: [u32; 3] = [0, 1, 2];

/// The runs of each clip: all combinations.
#[derive(Args, Debug)]
pub(super) struct RunOptions {
    /// Run each clip from N first frames: 0, 1/N, 2/N, ... of its number of frames
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100))]
    starts: u32,
    /// Run each clip mirrored left-right, too
    #[arg(long)]
    mirror: bool,
    /// Run each clip under each of these seeds
    #[arg(long, value_name = "SEED,...", value_delimiter = ',')]
    seeds: Vec<u32>,
}

impl RunOptions {
    /// Returns the seeds, or `default` if none is given.
    pub(super) fn seeds(&self, default: &[u32]) -> Vec<u32> {
        if self.seeds.is_empty() { default.to_vec() } else { self.seeds.clone() }
    }

    /// Returns true if a clip can have more than one run.
    pub(super) fn are_several(&self, seeds: &[u32]) -> bool {
        self.starts > 1 || self.mirror || seeds.len() > 1
    }

    /// Returns the options as arguments of the command line.
    pub(super) fn arguments(&self, seeds: &[u32]) -> String {
        let starts = if self.starts > 1 { format!(" --starts {}", self.starts) } else { String::new() };
        let mirror = if self.mirror { " --mirror" } else { "" };
        format!("--seeds {}{starts}{mirror}", list(seeds))
    }

    /// Returns the excerpts of a clip with masks, each of at most `frames` frames: those of later starts that have a mask of
    /// a frame but the first and the last, which do not count.
    pub(super) fn clip_excerpts(&self, clip: &Clip, frames: Option<u32>) -> Result<Vec<Excerpt>> {
        let images = clip.frames(None)?;
        let has_mask = |t: usize| clip.mask_path(&images[t]).is_file();
        let is_scored = |range: Range<usize>| scored_frames(range.len()).any(|t| has_mask(range.start + t));
        Ok(self.excerpts(&images, frames, is_scored))
    }

    /// Returns the excerpts of a clip, each of at most `frames` of its frames. `is_scored` says of a range of frames that
    /// it can be scored; the first start is there in any case.
    pub(super) fn excerpts(
        &self,
        images: &[PathBuf],
        frames: Option<u32>,
        is_scored: impl Fn(Range<usize>) -> bool,
    ) -> Vec<Excerpt> {
        let max_frames = frames.map_or(usize::MAX, |n| n as usize);
        let mut excerpts = Vec::new();
        for start in starts(images.len(), self.starts as usize, max_frames) {
            let range = start..images.len().min(start.saturating_add(max_frames));
            if start > 0 && !is_scored(range.clone()) {
                continue;
            }
            let excerpt = Excerpt { start, images: images[range].to_vec(), mirrored: false };
            let mirrored = self.mirror.then(|| Excerpt { mirrored: true, ..excerpt.clone() });
            excerpts.push(excerpt);
            excerpts.extend(mirrored);
        }
        excerpts
    }
}

/// Returns the first frames of the runs of a clip of `num_frames` frames, without those that leave too few.
fn starts(num_frames: usize, count: usize, max_frames: usize) -> Vec<usize> {
    let mut starts: Vec<usize> = (0..count).map(|k| k * num_frames / count.max(1)).collect();
    starts.dedup();
    starts.retain(|&start| start == 0 || num_frames - start >= MIN_FRAMES.min(max_frames));
    starts
}

/// What distinguishes the runs of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct RunId {
    /// The first frame, in the clip.
    pub(super) start: usize,
    pub(super) mirrored: bool,
    pub(super) seed: u32,
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mirrored = if self.mirrored { ", mirrored" } else { "" };
        write!(f, "from frame {}{mirrored}, seed {}", self.start, self.seed)
    }
}

/// Consecutive frames of a clip, as they are or mirrored left-right.
#[derive(Debug, Clone)]
pub(super) struct Excerpt {
    /// The first frame, in the clip.
    pub(super) start: usize,
    /// The files of its frames.
    pub(super) images: Vec<PathBuf>,
    pub(super) mirrored: bool,
}

impl Excerpt {
    pub(super) fn run_id(&self, seed: u32) -> RunId {
        RunId { start: self.start, mirrored: self.mirrored, seed }
    }

    /// Returns the range of its frames in the clip.
    pub(super) fn range(&self) -> Range<usize> {
        self.start..self.start + self.images.len()
    }

    /// Decodes its frames one by one.
    pub(super) fn frames(&self) -> impl Iterator<Item = Result<ClipFrame>> {
        self.images.iter().map(|path| {
            let frame = decode(path)?;
            let frame = if self.mirrored { map_frame(&frame, |plane| Ok(self.orient(plane)))? } else { frame };
            Ok(ClipFrame { name: path.display().to_string(), frame, timing: None })
        })
    }

    /// Mirrors a plane of a frame, such as its true mask, if the frames are mirrored.
    pub(super) fn orient<T: Copy>(&self, plane: Plane<T>) -> Plane<T> {
        let width = plane.width();
        let mirror = |x: usize, y: usize| plane[(width - 1 - x, y)];
        if self.mirrored { Plane::from_fn(width, plane.height(), mirror) } else { plane }
    }

    /// Reads the true mask of each of its frames; `None` where `clip` has none.
    pub(super) fn truth(&self, clip: &Clip) -> Result<Vec<Option<Plane<Truth>>>> {
        self.images.iter().map(|image| Ok(clip.truth(image)?.map(|mask| self.orient(mask)))).collect()
    }

    /// Returns a session with its frames, of which nothing is run yet.
    pub(super) fn session(&self, params: Params) -> Result<Session> {
        let mut session = Session::new(params)?;
        for frame in self.frames() {
            let ClipFrame { name, frame, .. } = frame?;
            session.push_frame(frame).map_err(|e| Failure::about(name, e))?;
        }
        Ok(session)
    }

    /// Runs the frames under each seed, and calls `score` on the finished session, the seed's id and the time.
    pub(super) fn run_seeds<T>(
        &self,
        params: &Params,
        seeds: &[u32],
        mut score: impl FnMut(Session, RunId, Seconds) -> Result<T>,
    ) -> Result<Vec<T>> {
        let run = |&seed: &u32| {
            let mut params = params.clone();
            params.clip.seed = seed;
            let clock = Clock::start();
            let mut session = self.session(params)?;
            session.run()?;
            score(session, self.run_id(seed), clock.seconds())
        };
        seeds.iter().map(run).collect()
    }
}

/// Applies a change of planes to a frame.
pub(super) fn map_frame(frame: &Frame, change: impl Fn(Plane<[u8; 3]>) -> Result<Plane<[u8; 3]>>) -> Result<Frame> {
    let pixels = frame.rgb().chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    let changed = change(Plane::from_vec(frame.width(), frame.height(), pixels).unwrap_or_default())?;
    Ok(Frame::from_rgb(changed.data().concat(), changed.width(), changed.height())?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn excerpts(num_frames: usize, starts: u32, mirror: bool, frames: Option<u32>) -> Vec<(usize, usize, bool)> {
        let images: Vec<PathBuf> = (0..num_frames).map(|t| PathBuf::from(t.to_string())).collect();
        let options = RunOptions { starts, mirror, seeds: Vec::new() };
        let excerpts = options.excerpts(&images, frames, |range| range.start != 30);
        excerpts.iter().for_each(|e| assert_eq!(e.images, images[e.range()]));
        excerpts.iter().map(|e| (e.start, e.images.len(), e.mirrored)).collect()
    }

    #[test]
    fn starts_are_parts_of_the_clip_and_leave_enough_frames() {
        assert_eq!(starts(60, 3, 20), [0, 20, 40]);
        assert_eq!(starts(50, 4, 20), [0, 12, 25, 37]);
        assert_eq!(starts(29, 3, usize::MAX), [0, 9, 19]);
        assert_eq!(starts(28, 3, usize::MAX), [0, 9, 18]);
        assert_eq!(starts(25, 3, 50), [0, 8], "16 leaves 9");
        assert_eq!(starts(25, 3, 5), [0, 8, 16], "no more are asked for");
        assert_eq!((starts(2, 5, 50), starts(0, 2, 50)), (vec![0], vec![0]));
        assert_eq!(excerpts(60, 3, false, Some(25)), [(0, 25, false), (20, 25, false), (40, 20, false)]);
        assert_eq!(excerpts(60, 2, true, None), [(0, 60, false), (0, 60, true)], "30 cannot be scored");
    }

    #[test]
    fn what_is_mirrored_twice_is_as_it_was() {
        let plane = Plane::from_vec(3, 2, vec![1_u8, 2, 3, 4, 5, 6]).unwrap();
        let excerpt = Excerpt { start: 0, images: Vec::new(), mirrored: true };
        assert_eq!(excerpt.orient(plane.clone()).data(), [3, 2, 1, 6, 5, 4]);
        assert_eq!(excerpt.orient(excerpt.orient(plane.clone())), plane);
        assert_eq!(Excerpt { mirrored: false, ..excerpt.clone() }.orient(plane.clone()), plane);
        let mirror = |frame: &Frame| map_frame(frame, |plane| Ok(excerpt.orient(plane))).unwrap();
        let frame = Frame::from_rgb((0..18).collect(), 3, 2).unwrap();
        let once = mirror(&frame);
        assert_eq!(once.rgb()[..9], [6, 7, 8, 3, 4, 5, 0, 1, 2]);
        assert_eq!(mirror(&once).rgb(), frame.rgb());
    }

    #[test]
    fn a_run_is_named_by_its_start_mirror_and_seed() {
        let excerpt = Excerpt { start: 20, images: Vec::new(), mirrored: true };
        assert_eq!(excerpt.run_id(3).to_string(), "from frame 20, mirrored, seed 3");
        assert_eq!(RunId { start: 0, mirrored: false, seed: 1 }.to_string(), "from frame 0, seed 1");
        let options = RunOptions { starts: 3, mirror: true, seeds: vec![4, 5] };
        assert_eq!(options.arguments(&options.seeds(&[0])), "--seeds 4,5 --starts 3 --mirror");
        let default = RunOptions { starts: 1, mirror: false, seeds: Vec::new() };
        assert_eq!(default.arguments(&default.seeds(&[0, 1])), "--seeds 0,1");
    }
}
