//! Ridge-regularised logistic regression (Hoerl and Kennard 1970; le Cessie and van Houwelingen 1992): the weights of
//! terms whose sum is a log-odds.
//!
//! In: examples, each with its terms, how likely it is what is asked for, and its weight. Out: a base and a weight for
//! each term. Newton's method on terms of mean 0 and variance 1; the same numbers at each run.

/// One example: terms, truth and weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// The terms; each example has as many.
    pub terms: Vec<f64>,
    /// Its true probability, 0 to 1.
    pub truth: f64,
    /// Its weight, above 0.
    pub weight: f64,
}

/// Steps of Newton's method; it converges within ten.
const STEPS: usize = 40;
/// Least variance of an answer: far from the border between yes and no steps would be without bounds.
const LEAST_VARIANCE: f64 = 1e-4;

/// The base and the weights of the terms, with `ridge` as the price of a weight's square in units of the mean loss, on
/// terms of variance 1. Empty without examples.
pub fn fit(examples: &[Example], ridge: f64) -> Vec<f64> {
    let Some(first) = examples.first() else { return Vec::new() };
    let (n, total) = (first.terms.len(), examples.iter().map(|e| e.weight).sum::<f64>());
    let mean_of = |value: &dyn Fn(&Example) -> f64| examples.iter().map(|e| e.weight * value(e)).sum::<f64>() / total;
    let mean: Vec<f64> = (0..n).map(|k| mean_of(&|e| e.terms[k])).collect();
    let spread = |k: usize| mean_of(&|e| (e.terms[k] - mean[k]).powi(2)).sqrt().max(1e-9);
    let spread: Vec<f64> = (0..n).map(spread).collect();
    let rows: Vec<Vec<f64>> = examples
        .iter()
        .map(|e| std::iter::once(1.0).chain((0..n).map(|k| (e.terms[k] - mean[k]) / spread[k])).collect())
        .collect();
    let mut parameters = vec![0.0; n + 1];
    for _ in 0..STEPS {
        let (mut slope, mut bend) = (vec![0.0; n + 1], vec![vec![0.0; n + 1]; n + 1]);
        for (row, e) in rows.iter().zip(examples) {
            let p = probability(row.iter().zip(&parameters).map(|(x, w)| x * w).sum());
            let (weight, variance) = (e.weight / total, (p * (1.0 - p)).max(LEAST_VARIANCE));
            for (a, &x) in row.iter().enumerate() {
                slope[a] += weight * (p - e.truth) * x;
                row.iter().enumerate().for_each(|(b, &y)| bend[a][b] += weight * variance * x * y);
            }
        }
        for k in 0..=n {
            // The base is free, but for what makes the equations solvable.
            let price = if k == 0 { 1e-6 } else { ridge };
            slope[k] += price * parameters[k];
            bend[k][k] += price;
        }
        parameters.iter_mut().zip(solve(bend, slope)).for_each(|(w, step)| *w -= step);
    }
    let weights: Vec<f64> = parameters[1..].iter().zip(&spread).map(|(w, s)| w / s).collect();
    let base = parameters[0] - weights.iter().zip(&mean).map(|(w, m)| w * m).sum::<f64>();
    std::iter::once(base).chain(weights).collect()
}

/// The log-odds that weights, a base first, give to terms.
pub fn log_odds(weights: &[f64], terms: &[f64]) -> f64 {
    weights[0] + weights[1..].iter().zip(terms).map(|(weight, term)| weight * term).sum::<f64>()
}

/// The probability of a log-odds.
pub fn probability(log_odds: f64) -> f64 {
    1.0 / (1.0 + (-log_odds).exp())
}

/// The mean loss, in nats: how surprising the truth of the examples is.
pub fn loss(weights: &[f64], examples: &[Example]) -> f64 {
    let weighted_loss = |e: &Example| {
        let p = probability(log_odds(weights, &e.terms)).clamp(1e-9, 1.0 - 1e-9);
        -e.weight * (e.truth * p.ln() + (1.0 - e.truth) * (1.0 - p).ln())
    };
    examples.iter().map(weighted_loss).sum::<f64>() / examples.iter().map(|e| e.weight).sum::<f64>().max(1e-9)
}

/// Solves a symmetric positive definite system by elimination.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        for i in k + 1..n {
            let factor = a[i][k] / a[k][k];
            let (upper, lower) = a.split_at_mut(i);
            lower[0].iter_mut().zip(&upper[k]).skip(k).for_each(|(x, y)| *x -= factor * y);
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - sum) / a[k][k];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracecut::rng::Rng;

    /// Examples whose odds are known.
    fn drawn(weights: [f64; 3], count: usize) -> Vec<Example> {
        let mut rng = Rng::for_stage(1, "logistic");
        let mut example = || {
            let terms = vec![rng.range(-2.0, 2.0), rng.range(5.0, 9.0)];
            let truth = f64::from(u8::from(rng.uniform() < probability(log_odds(&weights, &terms))));
            Example { terms, truth, weight: 1.0 }
        };
        (0..count).map(|_| example()).collect()
    }

    #[test]
    fn weights_that_examples_were_drawn_by_are_found() {
        let weights = [-7.0, 2.0, 1.0];
        let examples = drawn(weights, 4000);
        let found = fit(&examples, 1e-6);
        assert!(found.iter().zip(weights).all(|(a, b)| (a / b - 1.0).abs() < 0.15), "{found:?}");
        let worse = [-7.0, 1.0, 1.0];
        assert!(loss(&found, &examples) <= loss(&weights, &examples) + 1e-9);
        assert!(loss(&found, &examples) < loss(&worse, &examples));
    }

    #[test]
    fn the_ridge_holds_weights_back_where_examples_are_parted_wholly() {
        let part = |x: f64| Example { terms: vec![x], truth: f64::from(u8::from(x > 0.0)), weight: 1.0 };
        let examples: Vec<_> = [-2.0, -1.0, 1.0, 2.0].map(part).to_vec();
        let (loose, tight) = (fit(&examples, 1e-3), fit(&examples, 1e-1));
        assert!(loose[1] > tight[1] && tight[1] > 0.0 && loose[1] < 20.0, "{loose:?} {tight:?}");
        assert_eq!(fit(&[], 1.0), Vec::<f64>::new());
    }

    #[test]
    fn an_example_of_weight_two_counts_as_two() {
        let mut once = drawn([0.5, 1.0, 0.0], 50);
        once[0].weight = 2.0;
        let mut twice = drawn([0.5, 1.0, 0.0], 50);
        twice.push(twice[0].clone());
        let (a, b) = (fit(&once, 1e-2), fit(&twice, 1e-2));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    }
}
