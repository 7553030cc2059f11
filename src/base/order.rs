//! Sorting by 64-bit keys, through one routine.
//!
//! The standard library's sorts are compiled anew for each type of element and each closure, several KiB a time; they
//! had come to be an eighth of the wasm file. Here every order is stated as a number, so that a single sort, of
//! numbers, serves all. Keys of pairs, signed numbers and floats keep their order.

/// The larger of two numbers, none of them NaN: `f32::max` is a call in wasm, this an instruction for four at once.
#[inline]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Up to this length elements are moved one by one, which needs no memory.
const FEW: usize = 12;

/// Sorts `items` by `key`; those of equal keys keep their order. O(n log n); takes 16 bytes an item.
pub(crate) fn sort_by_key<T>(items: &mut [T], key: impl Fn(&T) -> u64) {
    if items.len() <= FEW {
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
    // Each cycle of the permutation is walked once: what belongs at `at` is fetched from where it was.
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

/// The one instance of the standard library's sort. Places differ, so it needs not be stable.
#[inline(never)]
fn sort_keys(order: &mut [(u64, u32)]) {
    order.sort_unstable();
}

/// Orders by `a`, then by `b`.
pub(crate) fn pair(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// Orders signed numbers.
pub(crate) fn signed(v: i32) -> u32 {
    v as u32 ^ 1 << 31
}

/// Orders single floats as `total_cmp` does.
pub(crate) fn single(v: f32) -> u32 {
    let bits = v.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

/// The value at place `n`, counted from 0, of all values by order; 0 where there are not so many. Two counts, no sorting.
pub(crate) fn nth(values: &[f32], mut n: usize) -> f32 {
    let mut found = 0;
    for (shift, above) in [(16, 0), (0, 0xffff_0000_u32)] {
        let mut counts = vec![0_usize; 1 << 16];
        for key in values.iter().map(|&v| single(v)).filter(|key| key & above == found) {
            counts[(key >> shift & 0xffff) as usize] += 1;
        }
        let Some(place) = counts.iter().position(|&count| {
            let is_here = n < count;
            n -= if is_here { 0 } else { count };
            is_here
        }) else {
            return 0.0;
        };
        found |= (place as u32) << shift;
    }
    values.iter().copied().find(|&v| single(v) == found).unwrap_or(0.0)
}

/// Orders double floats as `total_cmp` does.
pub(crate) fn double(v: f64) -> u64 {
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
            let key = |v: (u32, i32)| pair(v.0, signed(v.1));
            prop_assert_eq!(key(a).cmp(&key(b)), a.cmp(&b));
        }

        #[test]
        fn keys_keep_the_order_of_floats(a in any::<f32>(), b in any::<f32>(), c in any::<f64>(), d in any::<f64>()) {
            prop_assert_eq!(single(a).cmp(&single(b)), a.total_cmp(&b));
            prop_assert_eq!(double(c).cmp(&double(d)), c.total_cmp(&d));
        }
    }

    #[test]
    fn the_nth_value_is_that_of_sorted_values() {
        let mut rng = crate::rng::Rng::for_stage(3, "nth");
        let values: Vec<f32> = (0..500).map(|_| (rng.range(-2.0, 2.0) as f32 * 8.0).round() / 8.0 * 1e-3).collect();
        let mut sorted = values.clone();
        sorted.sort_by(f32::total_cmp);
        (0..500).for_each(|n| assert_eq!(nth(&values, n).to_bits(), sorted[n].to_bits()));
        assert_eq!((nth(&values, 500), nth(&[], 0)), (0.0, 0.0));
    }

    #[test]
    fn zeros_infinities_and_what_is_not_a_number_have_their_places() {
        let rising = [f32::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-40, 2.0, f32::INFINITY, f32::NAN];
        assert!(rising.is_sorted_by_key(|&v| single(v)));
        assert!(rising.is_sorted_by_key(|&v| double(f64::from(v))));
    }
}
