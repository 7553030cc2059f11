//! Parameters of the cut.

crate::params! {
    /// The Gabriel cut.
    pub struct CutParams {
        /// Weight of a superpixel's own trajectories (λ of section 4.2, whose value the paper does not give).
        pub unary_weight: f32 = 1.0, in 0.0..=1000.0, expert;
        /// Weight of the border between two superpixels of a frame. Higher makes labels smoother.
        pub spatial_weight: f32 = 2.0, in 0.0..=1000.0;
        /// A border costs `exp(−mean Pb / this)` to cut. The paper prints the mean Pb itself, a misprint.
        pub pb_scale: f32 = 0.03, in 0.001..=100.0, expert;
        /// Weights borders by their length, relative to the mean and within 0.05 to 4. The paper does not.
        pub weight_by_length: bool = true, in 0..=1, expert;
        /// Weight of the share of common trajectories between superpixels of consecutive frames.
        pub temporal_weight: f32 = 1.0, in 0.0..=1000.0;
        /// Number of further cuts, each with the appearance of objects and background, as learned from the cut before. Not
        /// in the paper; docs/choices.md.
        pub appearance_rounds: u32 = 3, in 0..=10, expert;
        /// Weight of the log-odds by appearance in these cuts.
        pub appearance_weight: f32 = 0.8, in 0.0..=100.0, expert;
        /// Factor on the weight of trajectories in these cuts, as what they told is learned.
        pub appearance_unary_factor: f32 = 0.35, in 0.0..=1.0, expert;
        /// A superpixel's own trajectories do not count if a larger share of it than this lies between trajectories of
        /// different labels (section 4.2: 0.3). 1 turns the rule off.
        pub ambiguous_share: f32 = 1.0, in 0.0..=1.0, expert;
        /// Weight of a salient trajectory that moves unlike all around it: it counts for every object and not for the
        /// background. Not in the paper; docs/choices.md.
        pub outlier_weight: f32 = 1.0, in 0.0..=100.0, expert;
    }
}

impl CutParams {
    /// The paper's energy, with its misprints resolved: nothing by length, all weights 1, the 30 % rule for
    /// ambiguous superpixels.
    ///
    /// From outside: `preset` = `paper`.
    pub(crate) fn paper() -> Self {
        Self {
            spatial_weight: 1.0,
            weight_by_length: false,
            outlier_weight: 0.0,
            appearance_rounds: 0,
            ambiguous_share: 0.3,
            ..Self::default()
        }
    }
}
