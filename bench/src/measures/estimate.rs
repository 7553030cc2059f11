//! Means and their standard errors.
//!
//! **In:** values, or means with standard errors of their own. **Out:** an [`Estimate`]. The standard error of the mean
//! of n independent values is their standard deviation, with n − 1 in its denominator, divided by the root of n.

use serde::Serialize;

/// A mean and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error; `None` if unknown, as that of a single value.
    pub standard_error: Option<f64>,
}

impl Estimate {
    /// Computes the mean of independent values; `None` without one.
    pub fn of(values: &[f64]) -> Option<Self> {
        Self::of_groups(&[values])
    }

    /// Computes the mean of the means of groups of independent values; `None` without a group or if one is empty.
    ///
    /// A value of a group of m, of k groups, has the weight 1 / (k m). The standard error is that of a weighted mean
    /// (Cochran, *Sampling Techniques*, 1977, the linearised ratio): n / (n − 1) times the sum of the squares of
    /// weight times deviation from the mean, and of this the root. Groups of one value are allowed, and with a single
    /// group it is that of [`Estimate::of`].
    pub fn of_groups<G: AsRef<[f64]>>(groups: &[G]) -> Option<Self> {
        if groups.is_empty() || groups.iter().any(|group| group.as_ref().is_empty()) {
            return None;
        }
        let weight = |group: &[f64]| 1.0 / (groups.len() * group.len()) as f64;
        let sum = |term: &dyn Fn(f64, f64) -> f64| -> f64 {
            let terms = groups.iter().map(AsRef::as_ref).flat_map(|g| g.iter().map(move |&value| (value, weight(g))));
            terms.map(|(value, weight)| term(value, weight)).sum()
        };
        let mean = sum(&|value, weight| value * weight);
        let squares = sum(&|value, weight| (weight * (value - mean)).powi(2));
        let count = groups.iter().map(|group| group.as_ref().len()).sum::<usize>() as f64;
        let standard_error = (count > 1.0).then(|| (squares * count / (count - 1.0)).sqrt());
        Some(Self { mean, standard_error })
    }

    /// Computes the mean of independent estimates; `None` without one. Its standard error is unknown if one of theirs is.
    pub fn mean_of(estimates: &[Self]) -> Option<Self> {
        let count = estimates.len() as f64;
        let squares = estimates.iter().map(|e| Some(e.standard_error?.powi(2))).sum::<Option<f64>>();
        let mean = estimates.iter().map(|e| e.mean).sum::<f64>() / count;
        (count > 0.0).then(|| Self { mean, standard_error: squares.map(|s| s.sqrt() / count) })
    }

    /// Returns true if the mean is further from 0 than twice its standard error; false if that is unknown.
    pub fn is_significant(self) -> bool {
        self.standard_error.is_some_and(|error| self.mean.abs() > 2.0 * error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} and {b}");
    }

    fn naive(values: &[f64]) -> (f64, f64) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
        (mean, variance.sqrt() / n.sqrt())
    }

    #[test]
    fn the_standard_error_is_that_of_the_textbook() {
        for values in [&[0.25, 0.75][..], &[1.0, 2.0, 4.0, 8.0], &[0.5; 3]] {
            let (mean, error) = naive(values);
            let found = Estimate::of(values).unwrap();
            close(found.mean, mean);
            close(found.standard_error.unwrap(), error);
        }
        assert_eq!(Estimate::of(&[0.5]), Some(Estimate { mean: 0.5, standard_error: None }));
        assert_eq!(Estimate::of(&[]), None);
    }

    #[test]
    fn groups_count_alike() {
        let found = Estimate::of_groups(&[vec![1.0, 3.0], vec![4.0]]).unwrap();
        close(found.mean, 3.0);
        // Weights of 1/4, 1/4 and 1/2; deviations of -2, 0 and 1.
        close(found.standard_error.unwrap(), (1.5_f64 * (0.25 + 0.25)).sqrt());
        assert_eq!(Estimate::of_groups(&[vec![1.0], vec![]]), None);
        // Groups of one value each are one group.
        assert_eq!(Estimate::of_groups(&[[1.0], [4.0]]), Estimate::of(&[1.0, 4.0]));
    }

    #[test]
    fn errors_of_independent_estimates_add_in_squares() {
        let estimate = |mean, standard_error| Estimate { mean, standard_error };
        let found = Estimate::mean_of(&[estimate(1.0, Some(3.0)), estimate(2.0, Some(4.0))]).unwrap();
        assert_eq!(found, estimate(1.5, Some(2.5)));
        let unknown = Estimate::mean_of(&[estimate(1.0, Some(3.0)), estimate(2.0, None)]);
        assert_eq!(unknown, Some(estimate(1.5, None)));
        assert_eq!(Estimate::mean_of(&[]), None);
        assert!(estimate(-0.5, Some(0.2)).is_significant());
        assert!(!estimate(-0.5, Some(0.25)).is_significant() && !estimate(0.5, None).is_significant());
    }
}
