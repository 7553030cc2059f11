//! Median of several clusterings, which does not depend on a single decision.

use super::Clusters;

/// Returns the clustering with the least sum of distances to the others, the first of equals.
pub(super) fn median_clustering(mut clusterings: Vec<Clusters>) -> Clusters {
    let sum = |a: &Clusters| clusterings.iter().map(|b| variation_of_information(a, b)).sum::<f64>();
    let sums: Vec<f64> = clusterings.iter().map(sum).collect();
    let best = (0..sums.len()).fold(0, |best, a| if sums[a] < sums[best] - MAX_ROUNDING_ERROR { a } else { best });
    clusterings.swap_remove(best)
}

/// Difference of sums, in nats, that may be due to rounding.
const MAX_ROUNDING_ERROR: f64 = 1e-9;

/// Variation of information (Meila 2007), `2 H(A, B) − H(A) − H(B)`, in nats a trajectory.
fn variation_of_information(a: &Clusters, b: &Clusters) -> f64 {
    let (mut size_a, mut size_b, mut joint) = (vec![0_u32; a.count], vec![0; b.count], vec![0; a.count * b.count]);
    for (&p, &q) in a.label.iter().zip(&b.label) {
        size_a[p as usize] += 1;
        size_b[q as usize] += 1;
        joint[p as usize * b.count + q as usize] += 1;
    }
    let n = a.label.len().max(1) as f64;
    let entropy = |counts: &[u32]| {
        let shares = counts.iter().filter(|&&count| count > 0).map(|&count| f64::from(count) / n);
        -shares.map(|share| share * libm::log(share)).sum::<f64>()
    };
    2.0 * entropy(&joint) - entropy(&size_a) - entropy(&size_b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clusters(digits: &str) -> Clusters {
        let label: Vec<u32> = digits.bytes().map(|digit| u32::from(digit - b'0')).collect();
        Clusters { count: 1 + label.iter().max().map_or(0, |&l| l as usize), label }
    }

    #[test]
    fn the_nearest_to_the_others_is_taken_and_the_first_of_equals() {
        let [two, nearly, one] = ["00001111", "00011111", "00000000"].map(clusters);
        assert_eq!(median_clustering(vec![one.clone(), two.clone(), nearly.clone()]), nearly);
        assert_eq!(median_clustering(vec![one.clone(), two.clone(), two.clone()]), two);
        assert_eq!(median_clustering(vec![one.clone(), two.clone()]), one);
        assert_eq!(median_clustering(vec![Clusters::default(); 2]), Clusters::default());
    }

    #[test]
    fn variation_of_information_is_a_metric_on_partitions() {
        let clusterings = ["00001111", "00110011", "01230123", "00000000"].map(clusters);
        for a in &clusterings {
            assert!(variation_of_information(a, a).abs() < 1e-12);
            for b in &clusterings {
                let d = variation_of_information(a, b);
                assert!((d - variation_of_information(b, a)).abs() < 1e-12);
                let detour = |c: &Clusters| variation_of_information(a, c) + variation_of_information(c, b);
                assert!(clusterings.iter().all(|c| d < detour(c) + 1e-12));
            }
        }
        assert!(variation_of_information(&clusterings[0], &clusters("11110000")).abs() < 1e-12);
        // Two halves across two halves are independent.
        assert!((variation_of_information(&clusterings[0], &clusterings[1]) - 2.0 * libm::log(2.0)).abs() < 1e-12);
    }
}
