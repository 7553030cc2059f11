//! The median of several clusterings: what most of them say counts, and one that hangs on a single decision does not.

use super::clusters::Clusters;

/// The clustering that is nearest to all others, the first of equals, by the variation of information (Meila 2007).
pub(super) fn median(mut all: Vec<Clusters>) -> Clusters {
    let sum = |a: &Clusters| all.iter().map(|b| variation_of_information(a, b)).sum::<f64>();
    let sums: Vec<f64> = all.iter().map(sum).collect();
    let best = (0..all.len()).fold(0, |best, a| if sums[a] < sums[best] - TIE { a } else { best });
    all.swap_remove(best)
}

/// Sums that differ by less are equal but for rounding.
const TIE: f64 = 1e-9;

/// What one clustering does not say of the other, and the other way round, in nats a trajectory.
fn variation_of_information(a: &Clusters, b: &Clusters) -> f64 {
    let (mut of_a, mut of_b, mut of_both) = (vec![0_u32; a.count], vec![0; b.count], vec![0; a.count * b.count]);
    for (&p, &q) in a.label.iter().zip(&b.label) {
        of_a[p as usize] += 1;
        of_b[q as usize] += 1;
        of_both[p as usize * b.count + q as usize] += 1;
    }
    let n = a.label.len().max(1) as f64;
    let entropy = |counts: &[u32]| {
        let shares = counts.iter().filter(|&&count| count > 0).map(|&count| f64::from(count) / n);
        -shares.map(|share| share * libm::log(share)).sum::<f64>()
    };
    2.0 * entropy(&of_both) - entropy(&of_a) - entropy(&of_b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clusters(digits: &str) -> Clusters {
        let label: Vec<u32> = digits.bytes().map(|digit| u32::from(digit - b'0')).collect();
        Clusters { count: 1 + label.iter().max().map_or(0, |&l| l as usize), label }
    }

    #[test]
    fn the_one_that_most_are_like_is_taken_and_the_first_of_equals() {
        let [two, nearly, one] = ["00001111", "00011111", "00000000"].map(clusters);
        assert_eq!(median(vec![one.clone(), two.clone(), nearly.clone()]), nearly);
        assert_eq!(median(vec![one.clone(), two.clone(), two.clone()]), two);
        assert_eq!(median(vec![one.clone(), two.clone()]), one);
        assert_eq!(median(vec![Clusters::default(); 2]), Clusters::default());
    }

    #[test]
    fn it_is_a_distance_that_names_do_not_matter_to() {
        let all = ["00001111", "00110011", "01230123", "00000000"].map(clusters);
        for a in &all {
            assert!(variation_of_information(a, a).abs() < 1e-12);
            for b in &all {
                let d = variation_of_information(a, b);
                assert!((d - variation_of_information(b, a)).abs() < 1e-12);
                let detour = |c: &Clusters| variation_of_information(a, c) + variation_of_information(c, b);
                assert!(all.iter().all(|c| d < detour(c) + 1e-12));
            }
        }
        assert!(variation_of_information(&all[0], &clusters("11110000")).abs() < 1e-12);
        // Two halves across two halves: each says nothing of the other.
        assert!((variation_of_information(&all[0], &all[1]) - 2.0 * libm::log(2.0)).abs() < 1e-12);
    }
}
