//! Milliseconds of each kernel but flow, cut and eigensolver, which have benchmarks of their own, on the sample scene:
//! `cargo bench -p tracecut-bench --bench stages`.
//!
//! A kernel of a frame is timed on one frame, a kernel of the clip on all. Each figure is the least of several runs, in
//! processor time where the system tells it.

#[path = "support/clock.rs"]
mod clock;

use clock::seconds;
use tracecut::Params;
use tracecut::affinity::affinities;
use tracecut::connectedness::{Separation, components};
use tracecut::contour::{boundary_map, contour_segments};
use tracecut::discontinuity::{discontinuities, neighborhoods};
use tracecut::discretize::{Known, discretize};
use tracecut::embedding::embed;
use tracecut::flow::{FlowPyramid, flow_between, local_flow_variation};
use tracecut::image::Frame;
use tracecut::mask::refine;
use tracecut::saliency::{SaliencyMaps, context_saliency, look_up, trajectory_saliency};
use tracecut::superpixel::{gabriel_superpixels, superpixels_of};
use tracecut::synth::Scene;
use tracecut::trajectory::{Tracker, structure};

const FRAMES: usize = 12;
const RUNS: usize = 5;

fn main() {
    println!("{:<28}{:>12}{:>12}{:>12}", "ms", "320x180", "480x270", "640x360");
    let columns: Vec<_> = [(320, 180), (480, 270), (640, 360)].map(figures).into_iter().collect();
    for (k, (name, _)) in columns[0].iter().enumerate() {
        let [small, middle, large] = [0, 1, 2].map(|c: usize| columns[c][k].1);
        println!("{name:<28}{small:>12.2}{middle:>12.2}{large:>12.2}");
    }
}

/// Each kernel's milliseconds at this size.
fn figures(size: (usize, usize)) -> Vec<(&'static str, f64)> {
    let params = Params::default().for_size(size);
    let seed = params.clip.seed;
    let scene = Scene::sample(size.0, size.1, FRAMES, 1);
    let frames: Vec<Frame> = (0..FRAMES).map(|t| scene.frame(t)).collect();
    let mut all = Vec::new();
    let mut time = |name, run: &mut dyn FnMut()| all.push((name, least(run)));

    let lumas: Vec<_> = frames.iter().map(Frame::luma).collect();
    let pyramids: Vec<_> = lumas.iter().map(FlowPyramid::new).collect();
    let between = |a: usize, b: usize| flow_between(&pyramids[a], &pyramids[b], &params.flow);
    let flows: Vec<_> = (1..FRAMES).map(|t| (between(t - 1, t), between(t, t - 1))).collect();
    let seeds = structure(&lumas[0]);
    let variations: Vec<_> = flows.iter().map(|(forward, _)| local_flow_variation(forward)).collect();
    time("structure, a frame", &mut || drop(structure(&lumas[0])));
    time("flow variation, a pair", &mut || drop(local_flow_variation(&flows[0].0)));
    let track = |settings: &_| {
        let mut tracker = Tracker::new(size, settings);
        for ((forward, backward), variation) in flows.iter().zip(&variations) {
            tracker.seed(&seeds);
            tracker.follow(forward, backward, variation);
        }
        tracker.finish()
    };
    time("tracks, the clip", &mut || drop(track(&params.trajectory)));
    time("tracks of masks, the clip", &mut || drop(track(&params.trajectory.for_masks())));
    let tracks = track(&params.trajectory);

    let related = || affinities(&tracks, params.spacing(), &params.affinity, seed).expect("the scene has trajectories");
    time("affinities, the clip", &mut || drop(related()));
    let a = related();
    time("embedding, the clip", &mut || drop(embed(&a, &params.embedding, seed)));
    let v = embed(&a, &params.embedding, seed);
    time("Delaunay, the clip", &mut || drop(neighborhoods(&tracks)));
    let near = || discontinuities(neighborhoods(&tracks), &v, &params.discontinuity);
    time("the same, discontinuities", &mut || drop(near()));
    let d = near();

    let look = || {
        let mut maps = SaliencyMaps::new(&params.saliency);
        flows.iter().for_each(|(forward, _)| maps.look_at(forward));
        maps
    };
    time("camera motion, the clip", &mut || drop(look()));
    let maps = look();
    time("saliency map, a frame", &mut || drop(maps.map(0, &flows[0].0)));
    let mut of_points = vec![-1.0; tracks.x.len()];
    flows.iter().enumerate().for_each(|(t, (forward, _))| look_up(&maps.map(t, forward), &tracks, t, &mut of_points));
    let alone = trajectory_saliency(&tracks, &of_points);
    let stands_out = || context_saliency(alone.clone(), &v, &d, &params.saliency).foreground;
    time("saliency in context", &mut || drop(stands_out()));
    let foreground = stands_out();
    let (longest, fewest) = (params.connectedness.max_edge * params.spacing(), params.connectedness.min_component);
    let known = Known::new(&tracks, &d, &params.affinity, Some(&maps), None);
    let pieces = || components(&tracks, &d.neighborhoods, &foreground, longest, fewest as usize);
    time("components, the clip", &mut || drop(Separation::new(&tracks, &pieces(), &params.connectedness)));
    time("clusters, the clip", &mut || drop(discretize(&v, &known, &params.discretize, seed)));

    time("boundary map, a frame", &mut || drop(boundary_map(&frames[0])));
    let map = boundary_map(&frames[0]);
    time("contours, a frame", &mut || drop(contour_segments(&map, &params.contour)));
    let segments = contour_segments(&map, &params.contour);
    time("Gabriel graph, a frame", &mut || drop(gabriel_superpixels(&segments, &map, &params.superpixel)));
    time("superpixels in all", &mut || {
        drop(superpixels_of(&frames[0], None, &params.contour, &params.superpixel));
    });
    let coarse = scene.mask(0);
    time("mask's borders, a frame", &mut || drop(refine(&coarse, &frames[0], &params.refine)));
    all
}

/// Least milliseconds of several runs.
fn least(run: &mut dyn FnMut()) -> f64 {
    let mut timed = || {
        let begin = seconds();
        run();
        1000.0 * (seconds() - begin)
    };
    (0..RUNS).map(|_| timed()).fold(f64::INFINITY, f64::min)
}
