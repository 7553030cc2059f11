//! How well the agreement of masks and their expected J predict J, and how well doubts find failures.
//!
//! **In:** for each frame of a run that has a truth, the agreement of its mask and its J. **Out:** [`AgreementQuality`]:
//! Spearman's rank correlation of the two, and the share of the frames with a drop that the agreement finds.
//!
//! A drop is a frame whose J lies [`FAILURE_DROP`] or more below the median of its run. It is found if its agreement lies
//! further below that run's median than it does in all but [`FALSE_SHARE`] of the other frames of all runs.
//!
//! [`DoubtQuality`] counts the failures that lie in a doubt, and the doubts without a failure. A failure is a drop, or a frame
//! whose J is below [`FAILURE_J`].

use serde::Serialize;
use std::ops::Range;

/// How far J lies below its median in a drop; chosen by eye.
pub const FAILURE_DROP: f64 = 0.3;
/// Frames of a lower J are failures; chosen by eye.
pub const FAILURE_J: f64 = 0.5;
/// Share of the frames without a failure that may lie below the threshold; chosen by eye.
pub const FALSE_SHARE: f64 = 0.01;

/// A frame of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameAgreement {
    /// Agreement of its mask with those of nearby frames, or its expected J, `0.0..=1.0`.
    pub agreement: f64,
    /// Region similarity with the true mask, `0.0..=1.0`.
    pub j: f64,
}

/// How well agreement predicts J.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct AgreementQuality {
    /// Mean over the runs of the rank correlation over their frames, without runs that have no differences.
    pub correlation_in_runs: Option<f64>,
    /// Rank correlation over the frames of all runs.
    pub correlation: Option<f64>,
    /// Number of frames.
    pub frames: usize,
    /// Number of drops.
    pub failures: usize,
    /// Share of the drops that are found.
    pub found: Option<f64>,
}

impl AgreementQuality {
    /// Compares the frames of some runs.
    pub fn of_runs(runs: &[Vec<FrameAgreement>]) -> Self {
        let all: Vec<FrameAgreement> = runs.concat();
        let in_runs: Vec<f64> = runs.iter().filter_map(|frames| rank_correlation(frames)).collect();
        let drops: Vec<Drop> = runs.iter().flat_map(|frames| drops(frames)).collect();
        let (failed, others): (Vec<Drop>, Vec<Drop>) = drops.into_iter().partition(|drop| drop.j >= FAILURE_DROP);
        let mut other_drops: Vec<f64> = others.iter().map(|drop| drop.agreement).collect();
        other_drops.sort_by(|a, b| b.total_cmp(a));
        let num_false_alarms = (FALSE_SHARE * other_drops.len() as f64) as usize;
        let threshold = other_drops.get(num_false_alarms).copied().unwrap_or(f64::NEG_INFINITY);
        let (failures, found) = (failed.len(), failed.iter().filter(|drop| drop.agreement > threshold).count());
        Self {
            correlation_in_runs: (!in_runs.is_empty()).then(|| in_runs.iter().sum::<f64>() / in_runs.len() as f64),
            correlation: rank_correlation(&all),
            frames: all.len(),
            failures,
            found: (failures > 0).then(|| found as f64 / failures as f64),
        }
    }
}

/// The doubts of a run, and J where there is a truth.
#[derive(Debug, Clone, Default)]
pub struct RunDoubts {
    /// Frames whose masks should be looked at.
    pub doubts: Vec<Range<usize>>,
    /// Frames and their J.
    pub j: Vec<(usize, f64)>,
    /// Frames that are not judged.
    pub unjudged: Vec<usize>,
}

/// How well doubts find failures.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct DoubtQuality {
    /// Number of failures.
    pub failures: usize,
    /// How many of them lie in a doubt.
    pub found: usize,
    /// How many of the others are not judged.
    pub unjudged: usize,
    /// Number of doubts that have frames with a J, but no failure.
    pub false_doubts: usize,
    /// Number of frames in doubts that are no failures.
    pub false_frames: usize,
    /// Number of frames with a J.
    pub frames: usize,
}

impl DoubtQuality {
    /// Compares the doubts of some runs with their failures.
    pub fn of_runs(runs: &[RunDoubts]) -> Self {
        let mut sum = Self::default();
        for RunDoubts { doubts, j, unjudged } in runs {
            let middle = median(j.iter().map(|&(_, j)| j).collect());
            let is_failure = |&&(_, j): &&(usize, f64)| j < FAILURE_J || middle - j >= FAILURE_DROP;
            let scored_in = |doubt: &Range<usize>| j.iter().filter(|(t, _)| doubt.contains(t)).collect::<Vec<_>>();
            sum.frames += j.len();
            sum.failures += j.iter().filter(is_failure).count();
            let is_unjudged = |t: usize| unjudged.contains(&t) && !doubts.iter().any(|doubt| doubt.contains(&t));
            sum.unjudged += j.iter().filter(|frame| is_failure(frame) && is_unjudged(frame.0)).count();
            for scored in doubts.iter().map(scored_in) {
                let failures = scored.iter().copied().filter(is_failure).count();
                sum.found += failures;
                sum.false_frames += scored.len() - failures;
                sum.false_doubts += usize::from(failures == 0 && !scored.is_empty());
            }
        }
        sum
    }
}

/// How far a frame lies below the medians of its run.
#[derive(Debug, Clone, Copy)]
struct Drop {
    agreement: f64,
    j: f64,
}

fn drops(frames: &[FrameAgreement]) -> Vec<Drop> {
    let median_of = |value: fn(&FrameAgreement) -> f64| median(frames.iter().map(value).collect());
    let medians = FrameAgreement { agreement: median_of(|frame| frame.agreement), j: median_of(|frame| frame.j) };
    let drop = |frame: &FrameAgreement| Drop { agreement: medians.agreement - frame.agreement, j: medians.j - frame.j };
    frames.iter().map(drop).collect()
}

/// Returns the median, the mean of the middle two of an even number; 0 without values.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len().saturating_sub(1);
    let [low, high] = [middle / 2, middle.div_ceil(2)].map(|k| values.get(k).copied().unwrap_or_default());
    (low + high) / 2.0
}

/// Computes Spearman's rank correlation: that of the ranks, where equal values share their mean rank. `None` if all values
/// are equal.
fn rank_correlation(frames: &[FrameAgreement]) -> Option<f64> {
    let centred_ranks = |value: fn(&FrameAgreement) -> f64| {
        let values: Vec<f64> = frames.iter().map(value).collect();
        let rank = |v: &f64| {
            let below = values.iter().filter(|other| *other < v).count();
            let not_above = values.iter().filter(|other| *other <= v).count();
            (below + not_above) as f64 - values.len() as f64
        };
        values.iter().map(rank).collect::<Vec<f64>>()
    };
    let (a, b) = (centred_ranks(|frame| frame.agreement), centred_ranks(|frame| frame.j));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let scale = (product(&a, &a) * product(&b, &b)).sqrt();
    (scale > 0.0).then(|| product(&a, &b) / scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(pairs: &[(f64, f64)]) -> Vec<FrameAgreement> {
        pairs.iter().map(|&(agreement, j)| FrameAgreement { agreement, j }).collect()
    }

    #[test]
    fn ranks_correlate_as_in_the_textbook() {
        // Without ties: 1 - 6 Σd² / (n (n² - 1)).
        let found = rank_correlation(&frames(&[(0.1, 0.2), (0.2, 0.1), (0.5, 0.4), (0.6, 0.9), (0.9, 0.5)]));
        assert!((found.unwrap() - (1.0 - 6.0 * 4.0 / 120.0)).abs() < 1e-12, "{found:?}");
        assert!((rank_correlation(&frames(&[(0.1, 9.0), (0.2, 1.0), (0.3, 0.5)])).unwrap() + 1.0).abs() < 1e-12);
        // Ranks 1.5, 1.5, 3 and 1, 2, 3.
        let tied = rank_correlation(&frames(&[(0.5, 0.1), (0.5, 0.2), (0.7, 0.3)])).unwrap();
        assert!((tied - 0.75_f64.sqrt()).abs() < 1e-12, "{tied}");
        assert_eq!(rank_correlation(&frames(&[(0.5, 0.1), (0.5, 0.2)])), None);
        assert_eq!(rank_correlation(&[]), None);
    }

    #[test]
    fn failures_are_found_below_all_but_one_other_frame_in_100() {
        let sound = |k: usize| (0.9 - 0.001 * k as f64, 0.8);
        let mut pairs: Vec<(f64, f64)> = (0..100).map(sound).collect();
        pairs.extend([(0.5, 0.2), (0.4, 0.5), (0.9, 0.1)]);
        // The second lies exactly at the drop, the third looks sound.
        let quality = AgreementQuality::of_runs(&[frames(&pairs)]);
        assert_eq!((quality.frames, quality.failures), (103, 3));
        assert!((quality.found.unwrap() - 2.0 / 3.0).abs() < 1e-12, "{quality:?}");
        // One frame that falls low costs nothing, a second one does.
        pairs[5].0 = 0.1;
        assert_eq!(AgreementQuality::of_runs(&[frames(&pairs)]).found, quality.found);
        pairs[6].0 = 0.45;
        assert!(AgreementQuality::of_runs(&[frames(&pairs)]).found.unwrap() < 0.4);
    }

    #[test]
    fn doubts_find_the_failures_inside_them() {
        let mut j: Vec<(usize, f64)> = (0..20).map(|t| (t, 0.8)).collect();
        (j[3].1, j[4].1, j[15].1) = (0.1, 0.5, 0.2);
        // One with a failure of two, one without, one without a truth. Frame 4 is not judged, nor is one in a doubt.
        let run = RunDoubts { doubts: vec![2..4, 8..10, 30..33], j, unjudged: vec![3, 4, 11] };
        let quality = DoubtQuality { failures: 3, found: 1, unjudged: 1, false_doubts: 1, false_frames: 3, frames: 20 };
        assert_eq!(DoubtQuality::of_runs(std::slice::from_ref(&run)), quality);
        assert_eq!(DoubtQuality::of_runs(&[run, RunDoubts::default()]), quality);
        // All frames of a low J are failures.
        let low = RunDoubts { j: (0..5).map(|t| (t, 0.4)).collect(), ..RunDoubts::default() };
        assert_eq!(DoubtQuality::of_runs(&[low]), DoubtQuality { failures: 5, frames: 5, ..DoubtQuality::default() });
    }

    #[test]
    fn runs_count_alike_and_without_differences_there_is_no_correlation() {
        let (up, down) = (frames(&[(0.1, 0.1), (0.2, 0.2)]), frames(&[(0.1, 0.6), (0.2, 0.5), (0.3, 0.4)]));
        let quality = AgreementQuality::of_runs(&[up, down, frames(&[(1.0, 0.0), (1.0, 0.0)])]);
        assert_eq!((quality.correlation_in_runs, quality.failures, quality.found), (Some(0.0), 0, None));
        assert_eq!(AgreementQuality::of_runs(&[]), AgreementQuality::default());
    }
}
