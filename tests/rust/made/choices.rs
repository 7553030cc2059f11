//! Choices of a generator: from the bytes of a fuzzer while there are any, then, or from the begin, from a seed.

use tracecut::rng::Rng;

/// Where a generator's choices come from. The same bytes, or the same seed, give the same choices.
#[derive(Debug, Clone)]
pub struct Choices<'a> {
    bytes: &'a [u8],
    rng: Rng,
}

impl Choices<'static> {
    /// All from a seed.
    pub fn of_seed(seed: u64, name: &str) -> Self {
        Self { bytes: &[], rng: Rng::for_stage(seed, name) }
    }
}

impl<'a> Choices<'a> {
    /// The first eight bytes are a seed, the others are choices; when they are used up, the seed makes more.
    pub fn of_bytes(bytes: &'a [u8], name: &str) -> Self {
        let (seed, bytes) = bytes.split_first_chunk::<8>().map_or((0, bytes), |(s, b)| (u64::from_le_bytes(*s), b));
        Self { bytes, rng: Rng::for_stage(seed, name) }
    }

    /// A number in `0..n`, from as few bytes as it takes.
    pub fn below(&mut self, n: usize) -> usize {
        let drawn = match n {
            0..=256 => self.take::<1>().map(|[a]| usize::from(a)),
            257..=65_536 => self.take().map(|b| usize::from(u16::from_le_bytes(b))),
            _ => self.take().map(|b| usize::try_from(u64::from_le_bytes(b)).unwrap_or(usize::MAX)),
        };
        drawn.map_or_else(|| self.rng.below(n), |number| number % n.max(1))
    }

    /// A number in `low..high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        match self.take() {
            Some(b) => low + (high - low) * f64::from(u32::from_le_bytes(b)) / 4_294_967_296.0,
            None => self.rng.range(low, high),
        }
    }

    /// 64 bits.
    pub fn next_u64(&mut self) -> u64 {
        self.take().map_or_else(|| self.rng.next_u64(), u64::from_le_bytes)
    }

    /// One of these.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.bytes.split_first_chunk::<N>()?;
        self.bytes = rest;
        Some(*taken)
    }
}
