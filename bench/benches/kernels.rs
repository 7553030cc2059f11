//! Milliseconds of the library's kernels: `cargo bench -p tracecut-bench --bench kernels -- NAME`, with one of
//!
//! - `flow`: one pyramid and one flow field, on smoothed noise that moves by (-3, 2) pixels. For the error against true
//!   flow see `bench flow`.
//! - `cut`: alpha-expansion on problems that resemble real clips. Nodes are a grid in each of 30 frames, joined to three
//!   neighbours in the frame and three in the next; each favours the label of the blob that it lies in, a fifth of them a
//!   wrong one, and a third have no opinion. In the hard problem more are wrong and edges are dearer.
//! - `eigen`: the eigensolver on graphs that resemble real clips.
//! - `stages`: every other kernel, on the sample scene. A kernel of a frame is timed on one frame, a kernel of the clip on
//!   all.
//!
//! Each figure is the least of several runs, in processor time where the system tells it.

use std::sync::OnceLock;
use std::time::{Duration, Instant};
use tracecut::Params;
use tracecut::affinity::affinities;
use tracecut::connectedness::{Separation, components};
use tracecut::contour::{boundary_map, contour_segments};
use tracecut::cut::{Expansion, Potts};
use tracecut::discontinuity::{discontinuities, neighborhoods};
use tracecut::discretize::{EvidenceInput, discretize};
use tracecut::embedding::{EigenInfo, EmbeddingParams, embed, embed_with_tolerance};
use tracecut::flow::{
    CompactFlow, FlowParams, FlowPyramid, FlowScratch, flow_between, flow_between_with, local_flow_variation,
};
use tracecut::image::{Frame, Plane, gaussian_blur};
use tracecut::mask::refine;
use tracecut::rng::{Rng, mix};
use tracecut::saliency::{SaliencyMaps, context_saliency, trajectory_saliency};
use tracecut::sparse::SymCsr;
use tracecut::superpixel::{gabriel_superpixels, superpixels_of};
use tracecut::synth::Scene;
use tracecut::trajectory::{Tracker, structure};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    match arguments.split_first() {
        Some((name, _)) if name == "flow" => time_flow(),
        Some((name, _)) if name == "cut" => time_cut(),
        Some((name, _)) if name == "eigen" => time_eigen(),
        Some((name, _)) if name == "stages" => time_stages(),
        _ => panic!("expected flow, cut, eigen or stages after --"),
    }
}

/// Processor time of this process where the system tells it (Linux), else elapsed time.
fn seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    // The system brings its account up to date when a process gives way.
    std::thread::sleep(Duration::from_millis(1));
    let elapsed = START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let schedule = std::fs::read_to_string("/proc/self/schedstat").unwrap_or_default();
    schedule.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or(elapsed, |ns| 1e-9 * ns)
}

/// Least milliseconds of several runs, and the last result.
fn least<T>(runs: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let begin = seconds();
        let result = run();
        (1000.0 * (seconds() - begin), result)
    };
    let mut best = timed();
    for _ in 1..runs {
        let next = timed();
        best = (best.0.min(next.0), next.1);
    }
    best
}

/// Pixels around the windows into the noise.
const MARGIN: usize = 8;

fn time_flow() {
    let params = FlowParams::default();
    println!("{:>9}  {:>10}  {:>8}  {:>9}", "size", "pyramid ms", "field ms", "error px");
    for (width, height) in [(320, 180), (480, 270), (640, 360), (640, 480), (854, 480)] {
        let [from, to] = noise_frames(width, height);
        let (pyramid_ms, from) = least(12, || FlowPyramid::from_luma(&from));
        let to = FlowPyramid::from_luma(&to);
        let mut scratch = FlowScratch::default();
        let (field_ms, flow) = least(12, || flow_between_with(&from, &to, &params, &mut scratch));
        let inside =
            (2 * MARGIN..height - 2 * MARGIN).flat_map(|y| (2 * MARGIN..width - 2 * MARGIN).map(move |x| (x, y)));
        let errors: Vec<f32> = inside.map(|p| (flow.u[p] + 3.0).hypot(flow.v[p] - 2.0)).collect();
        let error = errors.iter().sum::<f32>() / errors.len() as f32;
        println!("{width:>5}x{height:<3}  {pyramid_ms:>10.2}  {field_ms:>8.2}  {error:>9.4}");
    }
}

/// Two windows into the same smoothed noise.
fn noise_frames(width: usize, height: usize) -> [Plane<f32>; 2] {
    let mut rng = Rng::for_stage(0, "flow bench");
    let noise = Plane::from_fn(width + 2 * MARGIN, height + 2 * MARGIN, |_, _| rng.range(-1.0, 1.0) as f32);
    let scene = gaussian_blur(&noise, 1.5).map(|v| (128.0 + 300.0 * v).clamp(0.0, 255.0).round());
    [(MARGIN, MARGIN), (MARGIN + 3, MARGIN - 2)]
        .map(|(x0, y0)| Plane::from_fn(width, height, |x, y| scene[(x + x0, y + y0)]))
}

/// Frames of the problem.
const CUT_FRAMES: usize = 30;
/// One unit of cost.
const UNIT: f64 = 65536.0;

/// A clip of `columns × rows` nodes a frame.
fn problem(columns: usize, rows: usize, num_labels: usize, hard: bool) -> Potts {
    let mut rng = Rng::for_stage(1, "bench");
    let (wrong, dear) = if hard { (0.45, 0.6) } else { (0.2, 0.3) };
    let centres: Vec<[f64; 3]> = (0..num_labels)
        .map(|_| [columns as f64, rows as f64, rows as f64 / 3.0].map(|range| rng.range(0.0, range)))
        .collect();
    let blob = |x: f64, y: f64| {
        let inside = |c: &[f64; 3]| (x - c[0]).powi(2) + (y - c[1]).powi(2) < c[2] * c[2];
        centres.iter().skip(1).position(inside).map_or(0, |k| k + 1)
    };
    let mut problem = Potts { num_nodes: CUT_FRAMES * columns * rows, num_labels, ..Potts::default() };
    for t in 0..CUT_FRAMES {
        for y in 0..rows {
            for x in 0..columns {
                let truth = blob(x as f64 + 0.2 * t as f64, y as f64);
                let favoured = if rng.uniform() < wrong { rng.below(num_labels) } else { truth };
                let sure = if rng.uniform() < 0.33 { 0.0 } else { rng.range(0.3, 1.0) };
                problem.unary.extend((0..num_labels).map(|l| if l == favoured { 0 } else { (UNIT * sure) as i32 }));
                let p = (t * rows + y) * columns + x;
                let mut join = |is_inside: bool, q: usize| {
                    if is_inside {
                        problem.edges.push((p as u32, q as u32));
                        problem.weights.push((UNIT * dear * rng.uniform()) as i32);
                    }
                };
                let (right, down, later) = (x + 1 < columns, y + 1 < rows, t + 1 < CUT_FRAMES);
                join(right, p + 1);
                join(down, p + columns);
                join(right && down, p + columns + 1);
                join(later, p + rows * columns);
                join(later && right, p + rows * columns + 1);
                join(later && down, p + rows * columns + columns);
            }
        }
    }
    problem
}

fn time_cut() {
    for (columns, rows, num_labels, hard) in [
        (26, 19, 5, false),
        (50, 30, 2, false),
        (50, 30, 5, false),
        (50, 30, 5, true),
        (50, 30, 10, false),
        (83, 60, 5, false),
    ] {
        let problem = problem(columns, rows, num_labels, hard);
        let start = problem.cheapest();
        let (ms, result) = least(5, || {
            let mut expansion = Expansion::new(problem.clone(), start.clone());
            while !expansion.is_finished() {
                expansion.step();
            }
            (expansion.progress().0, problem.energy(expansion.labels()))
        });
        println!(
            "{} nodes, {} edges, {num_labels} labels{}: {ms:.0} ms, {} moves, energy {} of {} at the start",
            problem.num_nodes,
            problem.edges.len(),
            if hard { ", hard" } else { "" },
            result.0,
            result.1,
            problem.energy(&start)
        );
    }
}

/// Eigenpairs asked for.
const K: u32 = 24;

/// A trajectory as far as its affinities go: where it is, how it moves, how much the flow varies around it.
struct Point {
    x: f64,
    y: f64,
    u: f64,
    v: f64,
    sigma: f64,
}

/// Points scattered over 640x480, in the order of a tracker (by frame of birth, then by row), that move with a panning,
/// zooming background or one of `objects` turning discs.
fn scattered(n: usize, objects: usize, seed: u64) -> Vec<Point> {
    let mut rng = Rng::for_stage(seed, "bench");
    let discs: Vec<[f64; 6]> = (0..objects)
        .map(|_| {
            let (x, y) = (rng.range(60.0, 580.0), rng.range(60.0, 420.0));
            [x, y, rng.range(30.0, 90.0), rng.range(-2.0, 2.0), rng.range(-2.0, 2.0), rng.range(-0.01, 0.01)]
        })
        .collect();
    let mut places: Vec<(u32, u32, f64, f64)> = (0..n)
        .map(|_| {
            let born = rng.range(-30.0, 44.0).max(0.0) as u32;
            let (x, y) = (rng.range(0.0, 640.0), rng.range(0.0, 480.0));
            (born, (y / 8.0) as u32, x, y)
        })
        .collect();
    places.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    places
        .into_iter()
        .map(|(_, _, x, y)| {
            let mut point = Point { x, y, u: 1.0 + 0.004 * (x - 320.0), v: 0.004 * (y - 240.0), sigma: 0.3 };
            for &[cx, cy, r, u, v, spin] in &discs {
                let distance = (x - cx).hypot(y - cy);
                point.sigma += 0.5 * (-((distance - r) / 6.0).powi(2)).exp();
                if distance < r {
                    (point.u, point.v) = (u - spin * (y - cy), v + spin * (x - cx));
                }
            }
            point.u += 0.15 * (rng.uniform() + rng.uniform() - 1.0);
            point.v += 0.15 * (rng.uniform() + rng.uniform() - 1.0);
            point
        })
        .collect()
}

/// Affinities exp(-0.02 dist (r / s)^2) of all pairs within `radius` and of one in 32 of the others, at 32 times the
/// weight.
fn graph(points: &[Point], radius: f64) -> SymCsr {
    let mut upper = Vec::new();
    for (i, p) in points.iter().enumerate() {
        for (j, q) in points.iter().enumerate().skip(i + 1) {
            let distance = (p.x - q.x).hypot(p.y - q.y);
            let is_far = distance > radius;
            if is_far && !mix((i as u64) << 32 | j as u64).is_multiple_of(32) {
                continue;
            }
            let ratio = (p.u - q.u).hypot(p.v - q.v) / p.sigma.min(q.sigma);
            let w = (-0.02 * distance * ratio * ratio).exp() * if is_far { 32.0 } else { 1.0 };
            if w > 1e-6 {
                upper.push((i as u32, j as u32, w as f32));
            }
        }
    }
    SymCsr::from_upper(points.len(), &upper)
}

/// Prints how long `solve` takes at two tolerances.
fn report(name: &str, a: &SymCsr, mut solve: impl FnMut(f64) -> (EigenInfo, Vec<f64>)) {
    for tolerance in [1e-4, 1e-6] {
        let (ms, (info, values)) = least(6, || solve(tolerance));
        println!(
            "{name}: n = {}, {} entries, K = {}, tolerance {tolerance:e}: {ms:.0} ms, {info:?}, last value {:.6}",
            a.len(),
            a.column.len(),
            values.len(),
            values.last().copied().unwrap_or_default()
        );
    }
}

fn time_eigen() {
    for (n, objects, radius) in [(2500, 3, 60.0), (10_000, 3, 25.0), (10_000, 3, 45.0)] {
        let a = graph(&scattered(n, objects, 7), radius);
        let solve = |tolerance| {
            let mut params = EmbeddingParams::default();
            params.min_dimensions = K;
            let embedding = embed_with_tolerance(tolerance, &a, &params, 0);
            (embedding.info, embedding.eigenvalues)
        };
        report(&format!("radius {radius}"), &a, solve);
    }
}

/// Frames of the sample scene.
const FRAMES: usize = 12;

fn time_stages() {
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
    let scene = Scene::sample((size.0, size.1), FRAMES, 1);
    let frames: Vec<Frame> = (0..FRAMES).map(|t| scene.frame(t)).collect();
    let mut times = Vec::new();
    let mut time = |name, run: &mut dyn FnMut()| times.push((name, least(5, run).0));

    let lumas: Vec<_> = frames.iter().map(Frame::luma).collect();
    let pyramids: Vec<_> = lumas.iter().map(FlowPyramid::from_luma).collect();
    let between = |a: usize, b: usize| flow_between(&pyramids[a], &pyramids[b], &params.flow);
    let flows: Vec<_> = (1..FRAMES).map(|t| (between(t - 1, t), CompactFlow::new(&between(t, t - 1)))).collect();
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

    let related = || {
        affinities(&tracks, params.trajectory.grid_step, &params.affinity, seed).expect("the scene has trajectories")
    };
    time("affinities, the clip", &mut || drop(related()));
    let a = related();
    time("embedding, the clip", &mut || drop(embed(&a, &params.embedding, seed)));
    let v = embed(&a, &params.embedding, seed);
    time("Delaunay, the clip", &mut || drop(neighborhoods(&tracks)));
    let find_discontinuities = || discontinuities(neighborhoods(&tracks), &v, &params.discontinuity);
    time("the same, discontinuities", &mut || drop(find_discontinuities()));
    let d = find_discontinuities();

    let estimate_motion = || {
        let mut maps = SaliencyMaps::new(&params.saliency);
        flows.iter().for_each(|(forward, _)| maps.add_flow(forward));
        maps
    };
    time("camera motion, the clip", &mut || drop(estimate_motion()));
    let maps = estimate_motion();
    time("saliency map, a frame", &mut || drop(maps.map(0, &flows[0].0)));
    let of_frames: Vec<_> = flows.iter().enumerate().map(|(t, (forward, _))| maps.map(t, forward)).collect();
    let point_saliency = trajectory_saliency(&tracks, &of_frames);
    let stands_out = || context_saliency(point_saliency.clone(), &v, &d, &params.saliency).foreground;
    time("saliency in context", &mut || drop(stands_out()));
    let foreground = stands_out();
    let (longest, fewest) =
        (params.connectedness.max_edge * params.trajectory.grid_step, params.connectedness.min_component);
    let evidence = EvidenceInput::new(&tracks, &d, &params.affinity, Some(&maps), None);
    let pieces = || components(&tracks, &d.neighborhoods, &foreground, longest, fewest as usize);
    time("components, the clip", &mut || drop(Separation::new(&tracks, &pieces(), &params.connectedness)));
    time("clusters, the clip", &mut || drop(discretize(&v, &evidence, &params.discretize, seed)));

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
    times
}
