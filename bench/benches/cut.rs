//! Times alpha-expansion on problems like those of real clips: `cargo bench -p tracecut-bench --bench cut`.
//!
//! Nodes are a grid in each of 30 frames, joined to three neighbours in the frame and three in the next; each favours
//! the label of the blob that it lies in, a fifth of them a wrong one, and a third have no opinion. In the hard problem
//! more are wrong and edges are dearer. Times are the least of five runs, in processor time where the system tells it.

#[path = "support/clock.rs"]
mod clock;

use clock::seconds;
use tracecut::cut::{Expansion, Potts};
use tracecut::rng::Rng;

/// Frames of the clip.
const FRAMES: usize = 30;

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
    let mut problem = Potts { num_nodes: FRAMES * columns * rows, num_labels, ..Potts::default() };
    for t in 0..FRAMES {
        for y in 0..rows {
            for x in 0..columns {
                let truth = blob(x as f64 + 0.2 * t as f64, y as f64);
                let favoured = if rng.uniform() < wrong { rng.below(num_labels) } else { truth };
                let sure = if rng.uniform() < 0.33 { 0.0 } else { rng.range(0.3, 1.0) };
                problem.unary.extend((0..num_labels).map(|l| if l == favoured { 0 } else { (UNIT * sure) as i32 }));
                let p = (t * rows + y) * columns + x;
                let mut join = |there: bool, q: usize| {
                    if there {
                        problem.edges.push((p as u32, q as u32));
                        problem.weights.push((UNIT * dear * rng.uniform()) as i32);
                    }
                };
                let (right, down, later) = (x + 1 < columns, y + 1 < rows, t + 1 < FRAMES);
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

fn main() {
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
        let mut best = f64::MAX;
        let mut found = (0, 0);
        for _ in 0..5 {
            let fresh = problem.clone();
            let begin = seconds();
            let mut expansion = Expansion::new(fresh, start.clone());
            while !expansion.is_finished() {
                expansion.step();
            }
            best = best.min(seconds() - begin);
            found = (expansion.progress().0, problem.energy(expansion.labels()));
        }
        println!(
            "{} nodes, {} edges, {num_labels} labels{}: {:.0} ms, {} moves, energy {} of {} at the start",
            problem.num_nodes,
            problem.edges.len(),
            if hard { ", hard" } else { "" },
            1e3 * best,
            found.0,
            found.1,
            problem.energy(&start)
        );
    }
}
