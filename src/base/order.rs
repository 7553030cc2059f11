//! Sorting by 64-bit keys, through one routine.
//!
//! The standard library's sorts are compiled once for each element type and closure, several KiB each, and had grown to
//! an eighth of the wasm file. Here every order is expressed as a number, so that one sort of numbers serves all.

/// Returns the larger of two numbers that are not NaN. In wasm `f32::max` is a call, this one SIMD instruction.
#[inline]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Longest list sorted by insertion, which needs no memory. Chosen by eye.
const MAX_INSERTION_LEN: usize = 12;

/// Sorts `items` by `key`, stably, in O(n log n) time with 16 bytes of memory per item.
pub(crate) fn sort_by_key<T>(items: &mut [T], key: impl Fn(&T) -> u64) {
    if items.len() <= MAX_INSERTION_LEN {
        for end in 1..items.len() {
            let mut at = end;
            while at > 0 && key(&items[at - 1]) > key(&items[at]) {
                items.swap(at - 1, at);
                at -= 1;
            }
        }
        return;
    }
    let mut order: Vec<(u64, u32)> = items.iter().map(key).zip(0..).collect();
    sort_keys(&mut order);
    // Follows each cycle of the permutation once: the item that belongs at `at` is swapped in from `from`.
    for start in 0..items.len() {
        let mut at = start;
        loop {
            let from = std::mem::replace(&mut order[at].1, at as u32) as usize;
            if from == start {
                break;
            }
            items.swap(at, from);
            at = from;
        }
    }
}

/// The only instance of the standard library's sort. Indices differ, so it need not be stable.
#[inline(never)]
fn sort_keys(order: &mut [(u64, u32)]) {
    order.sort_unstable();
}

/// Returns a key that orders by `a`, then by `b`.
pub(crate) fn pair_key(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// Returns a key that orders as `v` does.
pub(crate) fn i32_key(v: i32) -> u32 {
    v as u32 ^ 1 << 31
}

/// Returns a key that orders as `f32::total_cmp` does.
pub(crate) fn f32_key(v: f32) -> u32 {
    let bits = v.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

/// Returns the `n`-th smallest value, counted from 0, or 0 if `values` is shorter. Radix selection: two histograms of
/// 16 bits each, O(values).
pub(crate) fn nth_smallest(values: &[f32], mut n: usize) -> f32 {
    let mut prefix = 0;
    for (shift, above) in [(16, 0), (0, 0xffff_0000_u32)] {
        let mut counts = vec![0_usize; 1 << 16];
        for key in values.iter().map(|&v| f32_key(v)).filter(|key| key & above == prefix) {
            counts[(key >> shift & 0xffff) as usize] += 1;
        }
        let Some(digit) = counts.iter().position(|&count| {
            let is_here = n < count;
            n -= if is_here { 0 } else { count };
            is_here
        }) else {
            return 0.0;
        };
        prefix |= (digit as u32) << shift;
    }
    values.iter().copied().find(|&v| f32_key(v) == prefix).unwrap_or(0.0)
}

/// Returns a key that orders as `f64::total_cmp` does.
pub(crate) fn f64_key(v: f64) -> u64 {
    let bits = v.to_bits();
    if bits >> 63 == 0 { bits | 1 << 63 } else { !bits }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn sorts_as_the_stable_sort_of_the_standard_library(list in prop::collection::vec((0_u8..9, any::<u16>()), 0..60)) {
            let (mut mine, mut theirs) = (list.clone(), list);
            sort_by_key(&mut mine, |v| u64::from(v.0));
            theirs.sort_by_key(|v| v.0);
            prop_assert_eq!(mine, theirs);
        }

        #[test]
        fn keys_keep_the_order_of_pairs_and_signed_numbers(a in any::<(u32, i32)>(), b in any::<(u32, i32)>()) {
            let key = |v: (u32, i32)| pair_key(v.0, i32_key(v.1));
            prop_assert_eq!(key(a).cmp(&key(b)), a.cmp(&b));
        }

        #[test]
        fn keys_keep_the_order_of_floats(a in any::<f32>(), b in any::<f32>(), c in any::<f64>(), d in any::<f64>()) {
            prop_assert_eq!(f32_key(a).cmp(&f32_key(b)), a.total_cmp(&b));
            prop_assert_eq!(f64_key(c).cmp(&f64_key(d)), c.total_cmp(&d));
        }
    }

    #[test]
    fn the_nth_smallest_value_is_the_nth_of_sorted_values() {
        let mut rng = crate::rng::Rng::for_stage(3, "nth");
        let values: Vec<f32> = (0..500).map(|_| (rng.range(-2.0, 2.0) as f32 * 8.0).round() / 8.0 * 1e-3).collect();
        let mut sorted = values.clone();
        sorted.sort_by(f32::total_cmp);
        (0..500).for_each(|n| assert_eq!(nth_smallest(&values, n).to_bits(), sorted[n].to_bits()));
        assert_eq!((nth_smallest(&values, 500), nth_smallest(&[], 0)), (0.0, 0.0));
    }

    #[test]
    fn zeros_infinities_and_what_is_not_a_number_have_their_places() {
        let rising = [f32::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-40, 2.0, f32::INFINITY, f32::NAN];
        assert!(rising.is_sorted_by_key(|&v| f32_key(v)));
        assert!(rising.is_sorted_by_key(|&v| f64_key(f64::from(v))));
    }
}
