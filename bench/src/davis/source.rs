//! Masks at the size of the frames: enlarged to the nearest pixel, against enlarged with the pictures.

use crate::measures::davis::{boundary_measure, boundary_measure_within, region_similarity, scored_frames};
use serde::Serialize;
use tracecut::Session;
use tracecut::image::Plane;
use tracecut::mask::enlarge;
use tracecut_cli::clock::Clock;
use tracecut_cli::failure::{Failure, Result};
use tracecut_cli::input::{ClipFrame, Input};

/// Boundaries of the fine measure match within this many pixels: the benchmark's own tolerance is wider than the pixels of
/// a mask at half the size.
const FINE_PX: usize = 1;

pub(super) const HEADING: &str = "  J near   large  F near   large  F1 near  large  ms a frame";

/// Means over the scored frames, of the nearest pixel's label and of enlarged masks.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct AtSource {
    j: Pair,
    f: Pair,
    /// F within one pixel.
    fine_f: Pair,
    /// Milliseconds that enlarging took, a frame.
    milliseconds: f64,
}

#[derive(Debug, Default, Clone, Copy, Serialize)]
struct Pair {
    nearest: f64,
    enlarged: f64,
}

fn fine_measure(mask: &Plane<bool>, truth: &Plane<bool>) -> std::result::Result<f64, tracecut::Error> {
    boundary_measure_within(FINE_PX, mask, truth)
}

impl AtSource {
    pub(super) fn of(session: &Session, input: &Input, truth: &[Plane<bool>]) -> Result<Self> {
        let scored = scored_frames(truth.len());
        let mut sums = [Pair::default(); 3];
        let mut seconds = 0.0;
        for (t, frame) in input.frames()?.enumerate().take(scored.end).skip(scored.start) {
            let ClipFrame { name, frame, .. } = frame?;
            let nearest = session.labels(t)?.map(|label| label != 0);
            let clock = Clock::start();
            let enlarged = enlarge(session.working_labels(t)?, &frame, |label| label != 0);
            seconds += clock.seconds().best();
            let enlarged = enlarged.map_err(|e| Failure::about(name, e))?.labels.map(|label| label != 0);
            let measures = [region_similarity, boundary_measure, fine_measure];
            for (sum, measure) in sums.iter_mut().zip(measures) {
                sum.nearest += measure(&nearest, &truth[t])?;
                sum.enlarged += measure(&enlarged, &truth[t])?;
            }
        }
        let count = scored.len() as f64;
        let [j, f, fine_f] = sums.map(|s| Pair { nearest: s.nearest / count, enlarged: s.enlarged / count });
        Ok(Self { j, f, fine_f, milliseconds: 1000.0 * seconds / count })
    }

    pub(super) fn mean_of(all: &[&Self]) -> Self {
        let mean = |value: &dyn Fn(&Self) -> f64| all.iter().map(|one| value(one)).sum::<f64>() / all.len() as f64;
        let pair = |of: fn(&Self) -> Pair| Pair {
            nearest: mean(&|one| of(one).nearest),
            enlarged: mean(&|one| of(one).enlarged),
        };
        Self {
            j: pair(|one| one.j),
            f: pair(|one| one.f),
            fine_f: pair(|one| one.fine_f),
            milliseconds: mean(&|one| one.milliseconds),
        }
    }

    pub(super) fn columns(&self) -> String {
        let pair = |p: Pair| format!("{:8.4}{:8.4}", p.nearest, p.enlarged);
        format!("{}{}{} {:11.1}", pair(self.j), pair(self.f), pair(self.fine_f), self.milliseconds)
    }
}
