//! Milliseconds of one pyramid and one flow field on smoothed noise that moves by (-3, 2) pixels:
//! `cargo bench -p tracecut-bench --bench flow`.
//!
//! Each figure is the least of several runs. For the error against true flow see `bench flow`.

use std::time::Instant;
use tracecut::flow::{FlowParams, FlowPyramid, FlowScratch, flow_between_with};
use tracecut::image::{Plane, gaussian_blur};
use tracecut::rng::Rng;

const RUNS: usize = 12;
const MARGIN: usize = 8;

fn main() {
    let params = FlowParams::default();
    println!("{:>9}  {:>10}  {:>8}  {:>9}", "size", "pyramid ms", "field ms", "error px");
    for (width, height) in [(320, 180), (480, 270), (640, 360), (640, 480), (854, 480)] {
        let [from, to] = frames(width, height);
        let (pyramid_ms, from) = least(|| FlowPyramid::new(&from));
        let to = FlowPyramid::new(&to);
        let mut scratch = FlowScratch::default();
        let (field_ms, flow) = least(|| flow_between_with(&from, &to, &params, &mut scratch));
        let inside =
            (2 * MARGIN..height - 2 * MARGIN).flat_map(|y| (2 * MARGIN..width - 2 * MARGIN).map(move |x| (x, y)));
        let errors: Vec<f32> = inside.map(|p| (flow.u[p] + 3.0).hypot(flow.v[p] - 2.0)).collect();
        let error = errors.iter().sum::<f32>() / errors.len() as f32;
        println!("{width:>5}x{height:<3}  {pyramid_ms:>10.2}  {field_ms:>8.2}  {error:>9.4}");
    }
}

/// Two windows into the same smoothed noise.
fn frames(width: usize, height: usize) -> [Plane<f32>; 2] {
    let mut rng = Rng::for_stage(0, "flow bench");
    let noise = Plane::from_fn(width + 2 * MARGIN, height + 2 * MARGIN, |_, _| rng.range(-1.0, 1.0) as f32);
    let scene = gaussian_blur(&noise, 1.5).map(|v| (128.0 + 300.0 * v).clamp(0.0, 255.0).round());
    [(MARGIN, MARGIN), (MARGIN + 3, MARGIN - 2)]
        .map(|(left, top)| Plane::from_fn(width, height, |x, y| scene[(x + left, y + top)]))
}

/// Least milliseconds of several runs, and the last result.
fn least<T>(mut run: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let begin = Instant::now();
        let result = run();
        (1000.0 * begin.elapsed().as_secs_f64(), result)
    };
    let mut best = timed();
    for _ in 1..RUNS {
        let next = timed();
        best = (best.0.min(next.0), next.1);
    }
    best
}
