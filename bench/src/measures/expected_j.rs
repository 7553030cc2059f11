//! How well J is expected on kinds of clips that were left out, and the weights of its terms.
//!
//! **In:** [`JudgedRun`], the terms of the frames of a run and their J. **Out:** weights fitted on all, by logistic regression
//! ([`super::logistic`]), and the runs of each kind with the J that weights fitted on the other kinds expect.

use super::agreement::{FrameAgreement, RunDoubts};
use super::logistic::{Example, fit, log_odds, probability};
use tracecut::mask::Agreement;

/// The price of a squared weight, in units of the mean loss; chosen by eye.
const RIDGE: f64 = 0.01;

/// A run of a clip, and its frames with a truth.
#[derive(Debug, Clone)]
pub struct JudgedRun {
    /// The kind of the clip.
    pub kind: String,
    /// Agreement and expected J of its masks.
    pub agreement: Agreement,
    /// The terms of each frame; `None` if it is not judged.
    pub terms: Vec<Option<Vec<f64>>>,
    /// Frames and their J.
    pub j: Vec<(usize, f64)>,
}

impl JudgedRun {
    /// Pairs the expected J of its frames with J.
    pub fn expectations(&self) -> Vec<FrameAgreement> {
        let expected = |&(t, j): &(usize, f64)| Some(FrameAgreement { agreement: self.expected_j(t)?, j });
        self.j.iter().filter_map(expected).collect()
    }

    /// Returns its doubts and J.
    pub fn doubts(&self) -> RunDoubts {
        let unjudged = self.j.iter().map(|&(t, _)| t).filter(|&t| self.expected_j(t).is_none()).collect();
        RunDoubts { doubts: self.agreement.doubts(), j: self.j.clone(), unjudged }
    }

    fn expected_j(&self, t: usize) -> Option<f64> {
        self.agreement.expected_j.get(t).copied().flatten().map(f64::from)
    }

    /// Returns its frames with terms and a truth, whose weights add up to one.
    fn examples(&self) -> Vec<Example> {
        let judged = || self.j.iter().filter_map(|&(t, truth)| Some((self.terms.get(t)?.clone()?, truth)));
        let weight = 1.0 / judged().count().max(1) as f64;
        judged().map(|(terms, truth)| Example { terms, truth, weight }).collect()
    }

    /// Returns the run with the J that other weights expect.
    fn with_weights(&self, weights: &[f64]) -> Self {
        let mut run = self.clone();
        let expected = |terms: &Option<Vec<f64>>| Some(probability(log_odds(weights, terms.as_deref()?)) as f32);
        run.agreement.expected_j = self.terms.iter().map(expected).collect();
        run
    }
}

/// Returns the kinds of the runs, in order.
pub fn kinds(runs: &[JudgedRun]) -> Vec<String> {
    let mut kinds: Vec<String> = runs.iter().map(|run| run.kind.clone()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}

/// Fits the weights on all runs but those of a kind.
pub fn weights(runs: &[JudgedRun], left_out: Option<&str>) -> Vec<f64> {
    let runs = runs.iter().filter(|run| Some(run.kind.as_str()) != left_out);
    fit(&runs.flat_map(JudgedRun::examples).collect::<Vec<_>>(), RIDGE)
}

/// Returns the runs of each kind with the J that weights fitted on the others expect; empty without other kinds.
pub fn left_out(runs: &[JudgedRun]) -> Vec<JudgedRun> {
    let kinds = kinds(runs);
    let of_kind = |kind: &String| {
        let weights = weights(runs, Some(kind));
        runs.iter().filter(|run| run.kind == *kind).map(|run| run.with_weights(&weights)).collect::<Vec<_>>()
    };
    if kinds.len() < 2 { Vec::new() } else { kinds.iter().flat_map(of_kind).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run whose J is `high` where the term is 1, and 1 less that elsewhere; the last frame is not judged.
    fn run(kind: &str, high: f64) -> JudgedRun {
        let term = |t: usize| f64::from(u8::from(t.is_multiple_of(2)));
        let terms = (0..10).map(|t| (t < 9).then(|| vec![term(t)])).collect();
        let j = (0..10).map(|t| (t, if term(t) > 0.0 { high } else { 1.0 - high })).collect();
        JudgedRun { kind: kind.to_owned(), agreement: Agreement::default(), terms, j }
    }

    #[test]
    fn each_kind_is_judged_by_weights_fitted_on_the_others() {
        let runs = [run("a", 0.9), run("b", 0.9), run("b", 0.9), run("c", 0.1)];
        assert_eq!(kinds(&runs), ["a", "b", "c"]);
        let [bias, weight] = weights(&runs, Some("c"))[..] else { panic!() };
        assert!(bias < 0.0 && weight > 1.0, "{bias} {weight}");
        let left_out = left_out(&runs);
        assert_eq!(left_out.iter().map(|run| run.kind.as_str()).collect::<Vec<_>>(), ["a", "b", "b", "c"]);
        // What was learned on a and b is wrong on c.
        let expectations = left_out[3].expectations();
        assert_eq!(expectations.len(), 9);
        assert!(expectations[0].agreement > 0.7 && expectations[0].j < 0.2, "{expectations:?}");
        assert_eq!(left_out[3].doubts().unjudged, [9]);
        assert!(super::left_out(&runs[..1]).is_empty());
    }
}
