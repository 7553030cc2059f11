//! The only source of pseudo-random numbers, seeded and platform-independent.

/// SplitMix64, a small deterministic generator (Steele, Lea, Flood: "Fast splittable pseudorandom number generators", 2014).
#[derive(Debug, Clone)]
pub struct Rng(u64);

impl Rng {
    /// Creates a generator with a stream of its own for `stage`, so that one more draw in a stage does not change another.
    pub fn for_stage(seed: u64, stage: &str) -> Self {
        // FNV-1a. Any fixed hash serves that differs between stage names.
        let name =
            stage.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3));
        Self(seed ^ name)
    }

    /// Draws 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Draws a uniform number in `[0, 1)`.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Draws a uniform number in `[low, high)`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Draws a uniform index in `0..n`; `n` must be positive.
    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.next_u64()) * n as u128) >> 64) as usize
    }
}

/// Hashes an integer by SplitMix64's finaliser.
pub fn mix(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_repeat_and_differ_by_stage() {
        let draw = |stage| {
            let mut rng = Rng::for_stage(7, stage);
            [rng.next_u64(), rng.next_u64()]
        };
        assert_eq!(draw("flow"), draw("flow"));
        assert_ne!(draw("flow"), draw("track"));
    }

    #[test]
    fn uniform_numbers_have_the_right_mean() {
        let mut rng = Rng::for_stage(1, "test");
        let mean = (0..10_000).map(|_| rng.uniform()).sum::<f64>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.02, "mean {mean}");
        assert!((0..1000).all(|_| rng.below(7) < 7));
    }
}
