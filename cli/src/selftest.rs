//! `selftest`: whether this machine computes what every other does. `npm/selftest/run.ts` is the same program: same clips, same
//! bytes, same order.

use crate::failure::{Failure, Result, print};
use crate::formats::{annotations, npy_header};
use crate::pictures::{Pixels, encode_png};
use clap::Args;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::env::consts::{ARCH, OS};
use std::fmt::Write as _;
use tracecut::contour::boundary_map;
use tracecut::flow::{FlowPyramid, flow_between};
use tracecut::image::Frame;
use tracecut::mask::{object_rows, object_table};
use tracecut::still::image_discontinuities;
use tracecut::superpixel::superpixels_of;
use tracecut::synth::Scene;
use tracecut::tracks::write;
use tracecut::{Error, Params, Session, Windows};

/// What every machine and engine should give; the npm package is built with the same file.
const EXPECTED: &str = include_str!("selftest/expected.json");
const VERSION: &str = env!("CARGO_PKG_VERSION");
const REPORT: &str = "please report this machine and this list at https://github.com/tracecut/tracecut/issues";

#[derive(Args, Debug)]
pub(crate) struct SelftestArgs {
    /// Threads to work on; the hashes are the same for any number
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
}

#[derive(Deserialize, Debug)]
struct Expected {
    version: String,
    hashes: BTreeMap<String, String>,
}

/// How many of the checks that were told are as expected.
#[derive(Debug)]
struct Tally {
    expected: Expected,
    same: usize,
    different: usize,
}

impl Tally {
    fn of(expected: &str) -> Result<Self> {
        let expected = serde_json::from_str(expected).map_err(|e| Failure::new(format!("the expected hashes: {e}")))?;
        Ok(Self { expected, same: 0, different: 0 })
    }

    /// Counts a check, and gives what is printed of it.
    fn count(&mut self, Check { name, what, hash }: &Check) -> String {
        let wanted = self.expected.hashes.get(*name).map_or("nothing", String::as_str);
        if wanted == hash {
            self.same += 1;
            return format!("{name:16} {hash}  same  ({what})");
        }
        self.different += 1;
        format!("{name:16} {hash}  DIFFERENT from {wanted}  ({what})")
    }

    /// The last line.
    fn verdict(&self) -> Result<String> {
        let (all, version) = (self.expected.hashes.len(), &self.expected.version);
        if version != VERSION {
            return Err(Failure::new(format!(
                "the hashes are those of version {version}, this is {VERSION}: {REPORT}"
            )));
        }
        if self.same == all && self.different == 0 {
            return Ok(format!("All {all} hashes are those of every other machine and engine."));
        }
        Err(Failure::new(format!("{} of {all} hashes differ: {REPORT}", all - self.same)))
    }
}

/// Prints each hash and whether it is the expected one.
pub(crate) fn selftest(args: &SelftestArgs) -> Result<()> {
    let mut tally = Tally::of(EXPECTED)?;
    print(format_args!("tracecut {VERSION}, native on {OS} {ARCH}"))?;
    Checks::new(args.threads.into()).all(|check| print(tally.count(&check)))?;
    print(tally.verdict()?)
}

/// Width, height and number of frames of the clip.
const CLIP: (usize, usize, usize) = (160, 90, 12);
/// Of each of the two shots that run window by window.
const SHOT: (usize, usize, usize) = (96, 64, 10);
const WINDOW: usize = 7;
const OVERLAP: usize = 3;
const SEEDS: [u64; 2] = [1, 7];
/// Frames whose maps are looked at.
const FRAMES: [usize; 3] = [0, 6, 11];

/// One result, hashed.
#[derive(Debug)]
pub(crate) struct Check {
    pub(crate) name: &'static str,
    pub(crate) what: &'static str,
    /// The first 64 bits of SHA-256, in hexadecimal digits.
    pub(crate) hash: String,
}

/// Bytes of results, one after the other; numbers lowest byte first.
#[derive(Default)]
struct Bytes(Sha256);

impl Bytes {
    fn bytes(mut self, bytes: impl AsRef<[u8]>) -> Self {
        self.0.update(bytes);
        self
    }

    fn words(self, words: impl IntoIterator<Item = u32>) -> Self {
        words.into_iter().fold(self, |to, word| to.bytes(word.to_le_bytes()))
    }

    fn floats(self, floats: &[f32]) -> Self {
        floats.iter().fold(self, |to, value| to.bytes(value.to_le_bytes()))
    }

    fn check(self, name: &'static str, what: &'static str) -> Check {
        let hash = self.0.finalize().iter().take(8).fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        Check { name, what, hash }
    }
}

/// The whole program.
#[derive(Debug)]
pub(crate) struct Checks {
    threads: usize,
}

impl Checks {
    pub(crate) fn new(threads: usize) -> Self {
        Self { threads }
    }

    /// Tells `found` of each result as soon as it is there.
    pub(crate) fn all(&self, mut found: impl FnMut(Check) -> Result<()>) -> Result<()> {
        let (width, height, count) = CLIP;
        let scene = Scene::sample(width, height, count, SEEDS[0]);
        let frames: Vec<Frame> = (0..count).map(|t| scene.frame(t)).collect();
        images(&frames).into_iter().try_for_each(&mut found)?;
        let session = self.run(&frames)?;
        motion(&session)?.into_iter().try_for_each(&mut found)?;
        masks(&session)?.into_iter().try_for_each(&mut found)?;
        found(self.windows()?)
    }

    fn run(&self, frames: &[Frame]) -> Result<Session> {
        let mut session = Session::new(Params::default())?;
        frames.iter().try_for_each(|frame| session.push_frame(frame.clone()))?;
        session.run_on(self.threads, |_| ())?;
        Ok(session)
    }

    /// Two shots, window by window: which windows there are, and their masks.
    fn windows(&self) -> Result<Check> {
        let (width, height, count) = SHOT;
        let frames = SEEDS.into_iter().flat_map(|seed| {
            let scene = Scene::sample(width, height, count, seed);
            (0..count).map(move |t| Ok::<_, Error>(scene.frame(t)))
        });
        let windows = Windows::new(Params::default(), frames)?.with_window(WINDOW, OVERLAP)?;
        let mut windows = windows.with_threads(self.threads);
        let mut bytes = Bytes::default();
        while let Some(window) = windows.next_window(|_| ()) {
            let window = window?;
            let (from, to) = (window.settled.start, window.settled.end);
            bytes = bytes.words([window.index, window.shot, window.first_frame, from, to].map(|n| n as u32));
            for t in window.settled {
                bytes = bytes.bytes(windows.session().labels(t)?.data());
            }
        }
        Ok(bytes.check("windows", "masks of two shots, window by window"))
    }
}

/// What single images come to.
fn images(frames: &[Frame]) -> Vec<Check> {
    let params = Params::default();
    let seen = |frame: &Frame| FlowPyramid::new(&frame.luma());
    let flow = flow_between(&seen(&frames[0]), &seen(&frames[1]), &params.flow);
    let map = boundary_map(&frames[0]);
    let cells = superpixels_of(&frames[0], None, &params.contour, &params.superpixel);
    let still = image_discontinuities(&frames[0], &params.still, params.clip.seed);
    // Eigenvectors are the same but for their last bits, which are the processor's.
    let halves: Vec<u8> = still.d.strength.data().iter().map(|d| (2.0 * d).round() as u8).collect();
    vec![
        frames
            .iter()
            .fold(Bytes::default(), |to, frame| to.bytes(frame.rgb()))
            .check("frames", "the pixels of a made clip"),
        Bytes::default()
            .floats(flow.u.data())
            .floats(flow.v.data())
            .check("flow", "optical flow of its first two frames"),
        Bytes::default()
            .floats(map.pb.data())
            .floats(map.thin.data())
            .check("boundaries", "boundary probability of an image"),
        Bytes::default().words(cells.label().data().iter().copied()).check("superpixels", "superpixels of an image"),
        Bytes::default().bytes(halves).check("discontinuities", "discontinuities of an image, to the nearest half"),
    ]
}

/// What comes before the masks.
fn motion(session: &Session) -> Result<Vec<Check>> {
    let tracks = session.trajectories().ok_or_else(Failure::lost)?;
    let near = &session.discontinuities().ok_or_else(Failure::lost)?.neighborhoods;
    let clusters = session.clusters().ok_or_else(Failure::lost)?;
    let saliency = session.saliency().ok_or_else(Failure::lost)?;
    let paths = Bytes::default().words(tracks.start_frame.iter().copied()).words(tracks.offset.iter().copied());
    let pairs = Bytes::default().words(near.pairs.iter().map(|p| p.0)).words(near.pairs.iter().map(|p| p.1));
    let pairs = pairs.words(near.frame_offset.iter().copied()).words(near.frame_edges.iter().copied());
    let mut maps = Bytes::default();
    for t in FRAMES {
        maps = maps.floats(session.saliency_map(t)?.data());
    }
    let foreground: Vec<u8> = saliency.foreground.iter().map(|&is| is.into()).collect();
    Ok(vec![
        paths.floats(&tracks.x).floats(&tracks.y).check("tracks", "trajectories of points"),
        pairs.check("neighbours", "which trajectories are neighbours"),
        maps.check("saliency", "saliency of pixels"),
        Bytes::default().bytes(foreground).check("foreground", "which trajectories are salient"),
        Bytes::default().words(clusters.label.iter().copied()).check("labels", "the cluster of each trajectory"),
        Bytes::default()
            .bytes(write(tracks, clusters)?)
            .check("track-file", "trajectories with their clusters as text"),
    ])
}

/// The masks, and the files that are made of them.
fn masks(session: &Session) -> Result<Vec<Check>> {
    let (width, height, count) = CLIP;
    let tracks = session.trajectories().ok_or_else(Failure::lost)?;
    let mut plates = Bytes::default();
    for t in FRAMES {
        plates = plates.bytes(session.background(t)?.data().as_flattened());
    }
    let planes = (0..count).map(|t| session.labels(t)).collect::<std::result::Result<Vec<_>, Error>>()?;
    let all: Vec<u8> = planes.iter().flat_map(|mask| mask.data()).copied().collect();
    let rows: Vec<_> = planes.iter().enumerate().flat_map(|(t, mask)| object_rows(mask, tracks, t)).collect();
    let runs: Vec<_> = planes.iter().enumerate().flat_map(|(t, mask)| annotations(mask, t)).collect();
    let mut files = Bytes::default();
    for t in FRAMES {
        let object: Vec<u8> = planes[t].data().iter().map(|&label| if label == 1 { 255 } else { 0 }).collect();
        files = files.bytes(read_back(&object, (width as u32, height as u32))?);
    }
    Ok(vec![
        Bytes::default()
            .bytes(&session.objects().ok_or_else(Failure::lost)?.of_cluster)
            .check("objects", "the object of each cluster"),
        Bytes::default().bytes(&all).check("masks", "masks of all frames"),
        plates.check("background", "frames without the objects"),
        Bytes::default().bytes(object_table(&rows)).check("table", "the table of objects"),
        Bytes::default().bytes(runs.iter().map(line).collect::<String>()).check("coco", "masks as run lengths of COCO"),
        Bytes::default()
            .bytes(npy_header("|u1", &[count, height, width]))
            .bytes(&all)
            .check("npy", "masks as a file for NumPy"),
        files.check("png", "an object's masks as PNG files, read back"),
    ])
}

/// The pixels of a PNG file of these.
fn read_back(grey: &[u8], size: (u32, u32)) -> Result<Vec<u8>> {
    let mut file = Vec::new();
    encode_png(&mut file, size, Pixels::Grey(grey)).map_err(|e| Failure::new(format!("a PNG file: {e}")))?;
    Ok(Frame::decode(&file)?.rgb().to_vec())
}

/// An annotation of COCO's, without what is only a name.
fn line(of: &serde_json::Value) -> String {
    let number = |value: &serde_json::Value| value.to_string();
    let list = |value: &serde_json::Value| {
        value.as_array().map_or(String::new(), |all| all.iter().map(number).collect::<Vec<_>>().join(","))
    };
    let run = &of["segmentation"];
    let counts = run["counts"].as_str().unwrap_or_default();
    let (image, track, area) = (&of["image_id"], &of["track_id"], &of["area"]);
    format!("{image} {track} {area} {} {} {counts}\n", list(&of["bbox"]), list(&run["size"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(hash: &str) -> Tally {
        let expected = format!(r#"{{"version": "{VERSION}", "hashes": {{"masks": "0a", "png": "0b"}}}}"#);
        let mut tally = Tally::of(&expected).unwrap();
        tally.count(&Check { name: "masks", what: "", hash: hash.to_owned() });
        tally
    }

    #[test]
    fn a_hash_that_differs_fails_and_so_does_one_that_is_missing() {
        let png = |hash: &str| Check { name: "png", what: "files", hash: hash.to_owned() };
        let mut good = tally("0a");
        assert!(good.verdict().unwrap_err().reason.starts_with("1 of 2 hashes differ: please report"));
        assert!(good.count(&png("0b")).ends_with("0b  same  (files)"));
        assert!(good.verdict().is_ok());
        good.expected.version = "0.0.1".to_owned();
        assert!(good.verdict().is_err());
        let mut bad = tally("0a");
        assert!(bad.count(&png("0c")).ends_with("0c  DIFFERENT from 0b  (files)"));
        assert_eq!(bad.verdict().unwrap_err().kind as u8, 1);
    }
}
