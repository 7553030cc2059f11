//! The whole method, top to bottom, to read beside the paper: `cargo run --locked --release --example method -- FRAMES`.
//!
//! `FRAMES` is a folder of PNG or JPEG files and nothing else, taken in name order. It prints one line per frame:
//! the mask as runs of a label and a number of pixels, row by row; 0 is the background. The labels equal those of
//! [`tracecut::Session`], which does the same step by step, scales large frames down, processes long clips window by
//! window, and tries other clusters where masks change from frame to frame (`discretize.minAgreement`).

use std::error::Error;
use std::{env, fs};
use tracecut::Params;
use tracecut::affinity::affinities;
use tracecut::background::{Background, SegmentedTracks};
use tracecut::camera::{Camera, ForwardMotion};
use tracecut::connectedness::{Separation, components, constrain};
use tracecut::cut::{CutInput, appearance_log_odds, gabriel_cut, paint};
use tracecut::discontinuity::{discontinuities, neighborhoods};
use tracecut::discretize::{EvidenceInput, discretize};
use tracecut::embedding::embed;
use tracecut::flow::{CompactFlow, FlowPyramid, flow_between};
use tracecut::image::{Frame, Plane};
use tracecut::mask::{Observations, attach_loose_parts, classify_clusters, cluster_penalties, number_objects, refine};
use tracecut::saliency::{SaliencyMaps, context_saliency, trajectory_saliency};
use tracecut::superpixel::frame_superpixels;
use tracecut::trajectory::Tracker;

/// Returns a label for every pixel of at least two frames of equal size.
fn segment(frames: &[Frame], params: &Params) -> Result<Vec<Plane<u8>>, tracecut::Error> {
    // Lengths are stated for large frames, counts of trajectories for a grid step of 8 pixels there.
    let (width, height) = (frames[0].width(), frames[0].height());
    let size = (width, height);
    let (vote_radius, seed) = (params.vote_radius(size), params.clip.seed);
    let params = params.for_size(size);
    let spacing = params.trajectory.grid_step;

    // 2.1 Trajectories: points that follow the optical flow from frame to frame; denser ones are for the masks.
    let mut tracker = Tracker::new(size, &params.trajectory);
    let mut denser = Tracker::new(size, &params.trajectory.for_masks());
    let mut flows = Vec::new();
    for pair in frames.windows(2) {
        let [from, to] = [&pair[0], &pair[1]].map(|frame| FlowPyramid::reduced(frame, params.flow.max_side));
        let forward = flow_between(&from, &to, &params.flow).at_size(width, height);
        let backward = flow_between(&to, &from, &params.flow).at_size(width, height);
        tracker.track(&pair[0], &forward, &backward);
        denser.track(&pair[0], &forward, &backward);
        flows.push(CompactFlow::new(&forward));
    }
    let (tracks, denser) = (tracker.finish(), denser.finish());

    // 2.1 The embedding: affinities A of motion, eigenvectors V of the normalised A.
    let mut a = affinities(&tracks, spacing, &params.affinity, seed)?;
    let mut v = embed(&a, &params.embedding, seed);

    // 2.2 Discontinuities d of the embedding between Delaunay neighbours.
    let mut d = discontinuities(neighborhoods(&tracks), &v, &params.discontinuity);

    // 3. Saliency: what the flow around a point does not do, averaged over what is near in the embedding.
    let mut maps = SaliencyMaps::new(&params.saliency);
    flows.iter().for_each(|flow| maps.add_flow(&flow.unpack(1.0, 1.0)));
    let map = |(t, flow): (usize, &CompactFlow)| maps.map(t, &flow.unpack(1.0, 1.0));
    let of_frames: Vec<_> = flows.iter().enumerate().map(map).collect();
    let alone = trajectory_saliency(&tracks, &of_frames);
    let foreground = context_saliency(alone, &v, &d, &params.saliency).foreground;

    // 3. Connectedness: pieces of the foreground keep trajectories apart, which changes A, V and d.
    let (longest, fewest) = (params.connectedness.max_edge * spacing, params.connectedness.min_component);
    let pieces = components(&tracks, &d.neighborhoods, &foreground, longest, fewest as usize);
    let separation = Separation::new(&tracks, &pieces, &params.connectedness);
    if let Some((kept, _)) = constrain(&a, &tracks, &separation, &foreground, &params.connectedness) {
        a = kept;
        v = embed(&a, &params.embedding, seed);
        d = discontinuities(d.neighborhoods, &v, &params.discontinuity);
    }

    // 2.3 Labels of the trajectories: V is rotated, and clusters that are likely one object are merged.
    let input = EvidenceInput::new(&tracks, &d, &params.affinity, Some(&maps), Some(&separation));
    let clusters = discretize(&v, &input, &params.discretize, seed);

    // 4.1 Superpixels: faces of the constrained Gabriel graph of each frame's contours.
    let superpixels: Vec<_> =
        frames.iter().map(|frame| frame_superpixels(frame, &params.contour, &params.superpixel)).collect();

    // Which clusters are objects (not in the paper): where the camera stands still, those that differ from a plate of all
    // frames; elsewhere those that hold little of the frame's border and do not move with the camera, or that no rigid
    // scene explains if it goes forward. The denser trajectories take the labels of the clustered ones around them.
    let camera = Camera::new(maps.motions(), frames, ForwardMotion::estimate(&tracks));
    let mut background = Background::new(frames, camera, &denser, params.trajectory.mask_step);
    let observations = Observations {
        clustered: &input,
        denser: &denser,
        saliency: &trajectory_saliency(&denser, &of_frames),
        saliency_threshold: params.saliency.threshold,
        max_edge: longest,
        vote_radius,
    };
    let classes = classify_clusters(&background, &clusters, &observations);
    let objects = number_objects(&tracks, &classes.clusters, &classes.is_object).of_cluster;

    // Evidence for and against objects in each superpixel (not in the paper): its distance from the plate and its flow, or
    // its reprojection errors in other frames by the motion of the scene and by the motion of the objects.
    let segmented = SegmentedTracks { tracks: &denser, label: &classes.label, is_object: &classes.is_object };
    background.compute_reprojection_errors(segmented);
    let penalties = cluster_penalties(&classes.clusters, &classes.penalties, |_| false);
    let evidence = background.evidence(&superpixels, &flows, segmented, &penalties, &params.background);

    // 4.2 The Gabriel cut, from the denser trajectories. It is made again with the appearance of objects and background, as
    // learned from the cut before (not in the paper).
    let num_labels = classes.clusters.count.max(1);
    let SegmentedTracks { tracks: voters, label, is_object } = segmented;
    let input = CutInput {
        superpixels: &superpixels,
        tracks: voters,
        label,
        num_labels,
        objects: is_object,
        evidence: &evidence,
        appearance: &[],
    };
    let (mut cut, mut appearance) = (gabriel_cut(&input, &params.cut), Vec::new());
    for _ in 0..params.cut.appearance_rounds {
        let last = CutInput { appearance: &appearance, ..input };
        appearance = appearance_log_odds(&last, &params.cut, &cut, frames, params.clip.seed);
        cut = gabriel_cut(&CutInput { appearance: &appearance, ..input }, &params.cut);
    }
    // Masks: clusters that are objects, with borders to the pixel and without small parts that lie apart (not in the paper).
    let object = |cluster: u32| objects.get(cluster as usize).copied().unwrap_or(0);
    let masks =
        (superpixels.iter().zip(&cut.labels).zip(frames).enumerate()).map(|(t, ((superpixels, label), frame))| {
            let mut mask = refine(&paint(superpixels, label).map(object), frame, &params.refine);
            attach_loose_parts(&mut mask, t, &input, &objects, params.refine.min_part, |_, _| false);
            mask
        });
    Ok(masks.collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = env::args().nth(1).ok_or("expected a folder of frames")?;
    let mut files = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, std::io::Error>>()?;
    files.sort();
    let frames =
        files.iter().map(|file| Ok(Frame::decode(&fs::read(file)?)?)).collect::<Result<Vec<_>, Box<dyn Error>>>()?;

    let (params, size) = (Params::default(), frames.first().map(|frame| (frame.width(), frame.height())));
    let side = params.clip.max_side as usize;
    if frames.len() < 2 || frames.iter().any(|frame| Some((frame.width(), frame.height())) != size) {
        return Err("expected at least two frames, all of one size".into());
    }
    if size.is_some_and(|(width, height)| width.max(height) > side) {
        return Err(format!("frames are too large (expected sides of at most {side} pixels): reduce them first").into());
    }
    for (t, mask) in segment(&frames, &params)?.iter().enumerate() {
        let runs = mask.data().chunk_by(|a, b| a == b).map(|run| format!(" {}x{}", run[0], run.len()));
        println!("{t:05}{}", runs.collect::<String>());
    }
    Ok(())
}
