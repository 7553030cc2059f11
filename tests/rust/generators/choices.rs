//! Random choices of a generator, from a seed or from the bytes of a fuzzer, and files with faults.

use tracecut::rng::Rng;

/// A source of choices. The same bytes or the same seed give the same choices.
#[derive(Debug, Clone)]
pub struct Choices<'a> {
    bytes: &'a [u8],
    rng: Rng,
}

impl Choices<'static> {
    /// Returns choices from a seed.
    pub fn from_seed(seed: u64, name: &str) -> Self {
        Self { bytes: &[], rng: Rng::for_stage(seed, name) }
    }
}

impl<'a> Choices<'a> {
    /// Returns choices from bytes: the first eight are a seed, which makes more choices when the others are used up.
    pub fn from_bytes(bytes: &'a [u8], name: &str) -> Self {
        let (seed, bytes) = bytes.split_first_chunk::<8>().map_or((0, bytes), |(s, b)| (u64::from_le_bytes(*s), b));
        Self { bytes, rng: Rng::for_stage(seed, name) }
    }

    /// Returns a number in `0..n`, from as few bytes as possible.
    pub fn below(&mut self, n: usize) -> usize {
        let drawn = match n {
            0..=256 => self.take::<1>().map(|[a]| usize::from(a)),
            257..=65_536 => self.take().map(|b| usize::from(u16::from_le_bytes(b))),
            _ => self.take().map(|b| usize::try_from(u64::from_le_bytes(b)).unwrap_or(usize::MAX)),
        };
        drawn.map_or_else(|| self.rng.below(n), |number| number % n.max(1))
    }

    /// Returns a number in `low..high`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        match self.take() {
            Some(b) => low + (high - low) * f64::from(u32::from_le_bytes(b)) / 4_294_967_296.0,
            None => self.rng.range(low, high),
        }
    }

    /// Returns 64 random bits.
    pub fn next_u64(&mut self) -> u64 {
        self.take().map_or_else(|| self.rng.next_u64(), u64::from_le_bytes)
    }

    /// Returns one of the values.
    pub fn pick<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len())]
    }

    /// Returns true once in `n` calls on average.
    pub fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.bytes.split_first_chunk::<N>()?;
        self.bytes = rest;
        Some(*taken)
    }
}

/// Numbers that readers get wrong.
const EDGE_NUMBERS: [u32; 10] = [0, 1, 0x7f, 0x80, 0xff, 0x7fff, 0xffff, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff];

/// Returns `bytes` with one to six faults; parts of `other` may be inserted.
pub fn mutate(choices: &mut Choices<'_>, bytes: &[u8], other: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + choices.below(6) {
        add_fault(choices, &mut bytes, other);
    }
    bytes
}

/// Adds one fault.
fn add_fault(choices: &mut Choices<'_>, bytes: &mut Vec<u8>, other: &[u8]) {
    let length = bytes.len();
    let at = choices.below(length + 1);
    let end = (at + 1 + choices.below(24)).min(length);
    match choices.below(8) {
        0 => bytes.truncate(at),
        1 if at < length => bytes[at] ^= 1 << choices.below(8),
        2 if at < length => bytes[at] = choices.below(256) as u8,
        3 => drop(bytes.drain(at..end.max(at))),
        4 => {
            let part = bytes[at..end.max(at)].to_vec();
            bytes.splice(at..at, part);
        }
        5 => {
            let from = choices.below(other.len() + 1);
            let part = other[from..(from + choices.below(64)).min(other.len())].to_vec();
            bytes.splice(at..end.max(at), part);
        }
        6 => replace_number(choices, bytes, at),
        _ => replace_digit(choices, bytes, at),
    }
}

/// Replaces the bytes from `at` on by a number, in either byte order.
fn replace_number(choices: &mut Choices<'_>, bytes: &mut [u8], at: usize) {
    let number = choices.pick(&EDGE_NUMBERS);
    let mut word = if choices.once_in(2) { number.to_le_bytes() } else { number.to_be_bytes() };
    word.rotate_left(choices.below(4));
    let width = choices.pick(&[1, 2, 4]);
    bytes.iter_mut().skip(at).zip(word).take(width).for_each(|(byte, value)| *byte = value);
}

/// Replaces the next digit by another digit or sign: a fault in a text file.
fn replace_digit(choices: &mut Choices<'_>, bytes: &mut [u8], at: usize) {
    if let Some(byte) = bytes.iter_mut().skip(at).find(|byte| byte.is_ascii_digit()) {
        *byte = choices.pick(b"0123456789-.eEnN \n");
    }
}
