//! `tracecut selftest`: compares hashes of results with those of other machines. `npm/selftest/run.ts` is the same program: same
//! clips, same bytes, same order.

use crate::failure::{Failure, Result, print};
use crate::formats::{mask_annotations, npy_header};
use crate::masks::doubt_at;
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
use tracecut::mask::{Agreement, ObjectRow, object_rows, object_table};
use tracecut::still::image_discontinuities;
use tracecut::superpixel::superpixels_of;
use tracecut::synth::Scene;
use tracecut::tracks::write;
use tracecut::{Error, Params, Session, Windows};

/// The expected hashes; the npm package is built with the same file.
const EXPECTED: &str = include_str!("selftest/expected.json");
const VERSION: &str = env!("CARGO_PKG_VERSION");
const REPORT: &str = "please report this machine and this list at https://github.com/tracecut/tracecut/issues";

#[derive(Args, Debug)]
pub(crate) struct SelftestArgs {
    /// Number of threads, which does not change hashes
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=64))]
    threads: u8,
}

#[derive(Deserialize, Debug)]
struct Expected {
    version: String,
    hashes: BTreeMap<String, String>,
}

/// Counts of the checks so far.
#[derive(Debug)]
struct Tally {
    expected: Expected,
    same: usize,
    different: usize,
}

impl Tally {
    fn new(expected: &str) -> Result<Self> {
        let expected = serde_json::from_str(expected).map_err(|e| Failure::new(format!("the expected hashes: {e}")))?;
        Ok(Self { expected, same: 0, different: 0 })
    }

    /// Counts a check and returns its line.
    fn count(&mut self, Check { name, description, hash }: &Check) -> String {
        let expected = self.expected.hashes.get(*name).map_or("nothing", String::as_str);
        if expected == hash {
            self.same += 1;
            return format!("{name:16} {hash}  same  ({description})");
        }
        self.different += 1;
        format!("{name:16} {hash}  DIFFERENT from {expected}  ({description})")
    }

    /// Returns the last line.
    fn summary(&self) -> Result<String> {
        let (total, version) = (self.expected.hashes.len(), &self.expected.version);
        if version != VERSION {
            return Err(Failure::new(format!(
                "the expected hashes are of version {version}, this is {VERSION}: {REPORT}"
            )));
        }
        if self.same == total && self.different == 0 {
            return Ok(format!("All {total} hashes are those of every other machine and engine."));
        }
        Err(Failure::new(format!("{} of {total} hashes differ: {REPORT}", total - self.same)))
    }
}

/// Prints each hash and whether it is the expected one.
pub(crate) fn selftest(args: &SelftestArgs) -> Result<()> {
    let mut tally = Tally::new(EXPECTED)?;
    print(format_args!("tracecut {VERSION}, native on {OS} {ARCH}"))?;
    Checks::new(args.threads.into()).run(|check| print(tally.count(&check)))?;
    print(tally.summary()?)
}

/// Size of a synthetic clip.
struct ClipSize {
    width: usize,
    height: usize,
    num_frames: usize,
}

// Chosen by eye, for runs of a few seconds; the expected hashes depend on them.
const CLIP: ClipSize = ClipSize { width: 160, height: 90, num_frames: 12 };
/// Each of the two shots that run window by window.
const SHOT: ClipSize = ClipSize { width: 96, height: 64, num_frames: 10 };
const WINDOW: usize = 7;
const OVERLAP: usize = 3;
const SEEDS: [u64; 2] = [1, 7];
/// Frames whose maps are hashed.
const MAP_FRAMES: [usize; 3] = [0, 6, 11];

/// One result, hashed.
#[derive(Debug)]
pub(crate) struct Check {
    pub(crate) name: &'static str,
    pub(crate) description: &'static str,
    /// The first 64 bits of SHA-256, in hexadecimal digits.
    pub(crate) hash: String,
}

/// The hash of a sequence of bytes; numbers are little-endian.
#[derive(Default)]
struct Hasher(Sha256);

impl Hasher {
    fn bytes(mut self, bytes: impl AsRef<[u8]>) -> Self {
        self.0.update(bytes);
        self
    }

    fn integers(self, integers: impl IntoIterator<Item = u32>) -> Self {
        integers.into_iter().fold(self, |hasher, value| hasher.bytes(value.to_le_bytes()))
    }

    fn floats(self, floats: &[f32]) -> Self {
        floats.iter().fold(self, |hasher, value| hasher.bytes(value.to_le_bytes()))
    }

    fn check(self, name: &'static str, description: &'static str) -> Check {
        let hash = self.0.finalize().iter().take(8).fold(String::new(), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
        Check { name, description, hash }
    }
}

/// All checks.
#[derive(Debug)]
pub(crate) struct Checks {
    threads: usize,
}

impl Checks {
    pub(crate) fn new(threads: usize) -> Self {
        Self { threads }
    }

    /// Computes all checks and calls `report` with each.
    pub(crate) fn run(&self, mut report: impl FnMut(Check) -> Result<()>) -> Result<()> {
        let ClipSize { width, height, num_frames } = CLIP;
        let scene = Scene::sample((width, height), num_frames, SEEDS[0]);
        let frames: Vec<Frame> = (0..num_frames).map(|t| scene.frame(t)).collect();
        image_checks(&frames).into_iter().try_for_each(&mut report)?;
        let session = self.run_session(&frames)?;
        motion_checks(&session)?.into_iter().try_for_each(&mut report)?;
        mask_checks(&session)?.into_iter().try_for_each(&mut report)?;
        report(self.window_check()?)
    }

    fn run_session(&self, frames: &[Frame]) -> Result<Session> {
        let mut session = Session::new(Params::default())?;
        frames.iter().try_for_each(|frame| session.push_frame(frame.clone()))?;
        session.run_on(self.threads, |_| ())?;
        Ok(session)
    }

    /// Hashes the windows of two shots and their masks.
    fn window_check(&self) -> Result<Check> {
        let ClipSize { width, height, num_frames } = SHOT;
        let frames = SEEDS.into_iter().flat_map(|seed| {
            let scene = Scene::sample((width, height), num_frames, seed);
            (0..num_frames).map(move |t| Ok::<_, Error>(scene.frame(t)))
        });
        let windows = Windows::new(Params::default(), frames)?.with_window(WINDOW, OVERLAP)?;
        let mut windows = windows.with_threads(self.threads);
        let mut bytes = Hasher::default();
        while let Some(window) = windows.next_window(|_| ()) {
            let window = window?;
            let (from, to) = (window.settled.start, window.settled.end);
            bytes = bytes.integers([window.index, window.shot, window.first_frame, from, to].map(|n| n as u32));
            for t in window.settled {
                bytes = bytes.bytes(windows.session().labels(t)?.data());
            }
        }
        Ok(bytes.check("windows", "masks of two shots, window by window"))
    }
}

/// Hashes results of single images.
fn image_checks(frames: &[Frame]) -> Vec<Check> {
    let params = Params::default();
    let flow = flow_between(&FlowPyramid::new(&frames[0]), &FlowPyramid::new(&frames[1]), &params.flow);
    let map = boundary_map(&frames[0]);
    let cells = superpixels_of(&frames[0], None, &params.contour, &params.superpixel);
    let still = image_discontinuities(&frames[0], &params.still, params.clip.seed);
    // The last bits of eigenvectors depend on the processor.
    let halves: Vec<u8> = still.d.strength.data().iter().map(|d| (2.0 * d).round() as u8).collect();
    vec![
        frames
            .iter()
            .fold(Hasher::default(), |hasher, frame| hasher.bytes(frame.rgb()))
            .check("frames", "the pixels of a made clip"),
        Hasher::default()
            .floats(flow.u.data())
            .floats(flow.v.data())
            .check("flow", "optical flow of its first two frames"),
        Hasher::default()
            .floats(map.pb.data())
            .floats(map.thin.data())
            .check("boundaries", "boundary probability of an image"),
        Hasher::default()
            .integers(cells.label().data().iter().copied())
            .check("superpixels", "superpixels of an image"),
        Hasher::default().bytes(halves).check("discontinuities", "discontinuities of an image, to the nearest half"),
    ]
}

/// Hashes the results of the stages before the masks.
fn motion_checks(session: &Session) -> Result<Vec<Check>> {
    let tracks = session.trajectories().ok_or_else(Failure::missing_result)?;
    let neighborhoods = &session.discontinuities().ok_or_else(Failure::missing_result)?.neighborhoods;
    let clusters = session.clusters().ok_or_else(Failure::missing_result)?;
    let saliency = session.saliency().ok_or_else(Failure::missing_result)?;
    let paths = Hasher::default().integers(tracks.start_frame.iter().copied()).integers(tracks.offset.iter().copied());
    let pairs = Hasher::default()
        .integers(neighborhoods.pairs.iter().map(|p| p.0))
        .integers(neighborhoods.pairs.iter().map(|p| p.1));
    let pairs =
        pairs.integers(neighborhoods.frame_offset.iter().copied()).integers(neighborhoods.frame_edges.iter().copied());
    let mut maps = Hasher::default();
    for t in MAP_FRAMES {
        maps = maps.floats(session.saliency_map(t)?.data());
    }
    let foreground: Vec<u8> = saliency.foreground.iter().map(|&is_salient| is_salient.into()).collect();
    Ok(vec![
        paths.floats(&tracks.x).floats(&tracks.y).check("tracks", "trajectories of points"),
        pairs.check("neighbours", "which trajectories are neighbours"),
        maps.check("saliency", "saliency of pixels"),
        Hasher::default().bytes(foreground).check("foreground", "which trajectories are salient"),
        Hasher::default().integers(clusters.label.iter().copied()).check("labels", "the cluster of each trajectory"),
        Hasher::default()
            .bytes(write(tracks, clusters)?)
            .check("track-file", "trajectories with their clusters as text"),
    ])
}

/// Hashes the masks and the files made from them.
fn mask_checks(session: &Session) -> Result<Vec<Check>> {
    let ClipSize { width, height, num_frames } = CLIP;
    let tracks = session.trajectories().ok_or_else(Failure::missing_result)?;
    let mut plates = Hasher::default();
    for t in MAP_FRAMES {
        plates = plates.bytes(session.background(t)?.data().as_flattened());
    }
    let planes = (0..num_frames).map(|t| session.labels(t)).collect::<std::result::Result<Vec<_>, Error>>()?;
    let labels: Vec<u8> = planes.iter().flat_map(|mask| mask.data()).copied().collect();
    let doubts = session.agreement().map(Agreement::doubts);
    let rows_of = |(t, mask)| {
        let doubt = doubt_at(doubts.as_deref(), t);
        object_rows(mask, tracks, t).into_iter().map(move |row| ObjectRow { doubt, ..row })
    };
    let rows: Vec<_> = planes.iter().enumerate().flat_map(rows_of).collect();
    let runs: Vec<_> = planes.iter().enumerate().flat_map(|(t, mask)| mask_annotations(mask, t)).collect();
    let mut files = Hasher::default();
    for t in MAP_FRAMES {
        let object: Vec<u8> = planes[t].data().iter().map(|&label| if label == 1 { 255 } else { 0 }).collect();
        files = files.bytes(read_back(&object, (width as u32, height as u32))?);
    }
    Ok(vec![
        Hasher::default()
            .bytes(&session.objects().ok_or_else(Failure::missing_result)?.of_cluster)
            .check("objects", "the object of each cluster"),
        Hasher::default().bytes(&labels).check("masks", "masks of all frames"),
        plates.check("background", "frames without the objects"),
        Hasher::default().bytes(object_table(&rows)).check("table", "the table of objects"),
        Hasher::default()
            .bytes(runs.iter().map(annotation_line).collect::<String>())
            .check("coco", "masks as run lengths of COCO"),
        Hasher::default()
            .bytes(npy_header("|u1", &[num_frames, height, width]))
            .bytes(&labels)
            .check("npy", "masks as a file for NumPy"),
        files.check("png", "an object's masks as PNG files, read back"),
    ])
}

/// Encodes grey values as PNG and decodes them again.
fn read_back(grey: &[u8], size: (u32, u32)) -> Result<Vec<u8>> {
    let mut file = Vec::new();
    encode_png(&mut file, size, Pixels::Grey(grey)).map_err(|e| Failure::new(format!("a PNG file: {e}")))?;
    Ok(Frame::decode(&file)?.rgb().to_vec())
}

/// Formats the numbers of a COCO annotation.
fn annotation_line(annotation: &serde_json::Value) -> String {
    let number = |value: &serde_json::Value| value.to_string();
    let list = |value: &serde_json::Value| {
        value.as_array().map_or(String::new(), |items| items.iter().map(number).collect::<Vec<_>>().join(","))
    };
    let run = &annotation["segmentation"];
    let counts = run["counts"].as_str().unwrap_or_default();
    let (image, track, area) = (&annotation["image_id"], &annotation["track_id"], &annotation["area"]);
    format!("{image} {track} {area} {} {} {counts}\n", list(&annotation["bbox"]), list(&run["size"]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tally(hash: &str) -> Tally {
        let expected = format!(r#"{{"version": "{VERSION}", "hashes": {{"masks": "0a", "png": "0b"}}}}"#);
        let mut tally = Tally::new(&expected).unwrap();
        tally.count(&Check { name: "masks", description: "", hash: hash.to_owned() });
        tally
    }

    #[test]
    fn a_hash_that_differs_fails_and_so_does_one_that_is_missing() {
        let png = |hash: &str| Check { name: "png", description: "files", hash: hash.to_owned() };
        let mut good = tally("0a");
        assert!(good.summary().unwrap_err().reason.starts_with("1 of 2 hashes differ: please report"));
        assert!(good.count(&png("0b")).ends_with("0b  same  (files)"));
        assert!(good.summary().is_ok());
        good.expected.version = "0.0.1".to_owned();
        assert!(good.summary().is_err());
        let mut bad = tally("0a");
        assert!(bad.count(&png("0c")).ends_with("0c  DIFFERENT from 0b  (files)"));
        assert_eq!(bad.summary().unwrap_err().kind as u8, 1);
    }
}
