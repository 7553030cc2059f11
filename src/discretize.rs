//! Discontinuity-aware discretization (section 2.3). (Essay follows.)

crate::params! {
    /// Discontinuity-aware discretization.
    pub struct DiscretizeParams {
        /// ρ: clusters whose mean discontinuity along their common border is below it are merged (section 2.3).
        pub merge_threshold: f64 = 0.7, in 0.0..=1.0;
    }
}

/// A label for each trajectory.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Clusters {
    /// Number of clusters.
    pub count: usize,
    /// Label of each trajectory in `0..count`; 0 is the cluster with most trajectory points, and so on.
    pub label: Vec<u32>,
}
