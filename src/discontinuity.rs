//! Delaunay neighbourhoods, densities and embedding discontinuities (section 2.2). (Essay follows.)

crate::params! {
    /// Embedding discontinuities.
    pub struct DiscontinuityParams {
        /// d_ij above which an edge lies on an object boundary (section 2.2; the paper's value).
        pub threshold: f64 = 0.6, in 0.0..=1.0;
    }
}

/// The spatial neighbour pairs of all frames with their discontinuities.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Discontinuities {
    /// Unique neighbour pairs `(i, j)`, `i < j`, sorted.
    pub pairs: Vec<(u32, u32)>,
    /// Embedding affinity `Ŵ_ij` of each pair.
    pub affinity: Vec<f64>,
    /// Discontinuity `d_ij` of each pair, in `0.0..=1.0`.
    pub d: Vec<f64>,
    /// Density `δ_i` of each trajectory.
    pub density: Vec<f64>,
    /// Where the edges of each frame begin in `frame_edges`; `num_frames + 1` numbers.
    pub frame_offset: Vec<u32>,
    /// Indices into `pairs`: the Delaunay edges of frame `t` are `frame_offset[t]..frame_offset[t + 1]`.
    pub frame_edges: Vec<u32>,
}
