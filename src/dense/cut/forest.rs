//! Extremely randomized trees that tell two classes of samples apart.
//!
//! In: weighted samples of two classes. Out: [`Forest`], the probability of the second class at any sample. Each tree splits
//! all samples by the best of a few features, each at a random threshold, until few are left (Geurts, Ernst and Wehenkel,
//! "Extremely randomized trees", Machine Learning 2006); the probability is the mean over the trees. Cost: O(samples · depth)
//! for each tree, and O(depth) for each tree and prediction.

use super::appearance::{Features, NUM_FEATURES};
use crate::rng::Rng;

/// Number of trees. Twice as many, on twice the samples, score no better (docs/speed.md).
const NUM_TREES: usize = 12;
/// Number of features that are tried for a split: about the root of their number, as the publication recommends.
const FEATURES_PER_SPLIT: usize = 4;
/// Least number of samples in a leaf. Chosen by eye.
const MIN_LEAF_SAMPLES: usize = 12;

/// A sample to learn from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) features: Features,
    /// Its class.
    pub(super) is_object: bool,
    /// Its weight, positive.
    pub(super) weight: f32,
}

/// Trees that were grown on samples of two classes.
#[derive(Debug, Clone)]
pub(super) struct Forest {
    trees: Vec<Vec<Node>>,
}

/// A node of a tree: samples with a smaller feature than the threshold go to the next node, others to `right`.
#[derive(Debug, Clone, Copy)]
struct Node {
    feature: u32,
    /// [`LEAF`] in a leaf.
    right: u32,
    /// In a leaf the share of the second class.
    threshold: f32,
}

/// No node has the root on its right.
const LEAF: u32 = 0;

impl Node {
    fn leaf(share: f32) -> Self {
        Self { feature: 0, right: LEAF, threshold: share }
    }
}

impl Forest {
    /// Grows the trees.
    pub(super) fn grow(samples: &[Sample], rng: &mut Rng) -> Self {
        let grow_tree = |_| {
            let mut order: Vec<u32> = (0..samples.len() as u32).collect();
            let mut nodes = Vec::new();
            Grower { samples, rng, nodes: &mut nodes }.grow(&mut order);
            nodes
        };
        Self { trees: (0..NUM_TREES).map(grow_tree).collect() }
    }

    /// Returns the probability of the second class for each sample. One tree after the other, as a tree fits the cache.
    pub(super) fn probabilities(&self, samples: &[Features]) -> Vec<f32> {
        let mut sums = vec![0.0; samples.len()];
        for tree in &self.trees {
            sums.iter_mut().zip(samples).for_each(|(sum, features)| *sum += share(tree, features));
        }
        let count = self.trees.len().max(1) as f32;
        sums.into_iter().map(|sum| sum / count).collect()
    }
}

/// Returns the share of the leaf that a sample falls into.
fn share(tree: &[Node], features: &Features) -> f32 {
    let mut at = 0;
    loop {
        let Node { feature, right, threshold } = tree[at as usize];
        if right == LEAF {
            return threshold;
        }
        at = if features[feature as usize] < threshold { at + 1 } else { right };
    }
}

/// Grows one tree.
struct Grower<'a> {
    samples: &'a [Sample],
    rng: &'a mut Rng,
    nodes: &'a mut Vec<Node>,
}

/// The weights of the two classes.
#[derive(Debug, Clone, Copy, Default)]
struct ClassWeights {
    background: f32,
    object: f32,
    samples: usize,
}

impl ClassWeights {
    fn add(&mut self, sample: &Sample) {
        *if sample.is_object { &mut self.object } else { &mut self.background } += sample.weight;
        self.samples += 1;
    }

    fn total(&self) -> f32 {
        self.background + self.object
    }

    /// The purity times the weight: their sum over two sides is largest for the split of least Gini impurity.
    fn purity(&self) -> f32 {
        (self.background * self.background + self.object * self.object) / self.total()
    }
}

impl Grower<'_> {
    /// Adds the node of these samples and all below it.
    fn grow(&mut self, order: &mut [u32]) {
        let mut weights = ClassWeights::default();
        order.iter().for_each(|&i| weights.add(&self.samples[i as usize]));
        let is_pure = weights.background <= 0.0 || weights.object <= 0.0;
        let split = if is_pure || order.len() < 2 * MIN_LEAF_SAMPLES { None } else { self.split(order) };
        let Some((feature, threshold)) = split else {
            self.nodes.push(Node::leaf(weights.object / weights.total()));
            return;
        };
        let node = self.nodes.len();
        self.nodes.push(Node::leaf(0.0));
        let mut low = 0;
        for k in 0..order.len() {
            if self.samples[order[k] as usize].features[feature] < threshold {
                order.swap(low, k);
                low += 1;
            }
        }
        let (left, right) = order.split_at_mut(low);
        self.grow(left);
        self.nodes[node] = Node { feature: feature as u32, right: self.nodes.len() as u32, threshold };
        self.grow(right);
    }

    /// Returns the best of some random splits: the feature and the threshold; `None` if no feature has two values.
    fn split(&mut self, order: &[u32]) -> Option<(usize, f32)> {
        let mut features: [usize; NUM_FEATURES] = std::array::from_fn(|k| k);
        let (mut best, mut tried) = (None, 0);
        for drawn in 0..NUM_FEATURES {
            features.swap(drawn, drawn + self.rng.below(NUM_FEATURES - drawn));
            let feature = features[drawn];
            let values = order.iter().map(|&i| self.samples[i as usize].features[feature]);
            let (min, max) = values.fold((f32::INFINITY, f32::NEG_INFINITY), |(min, max), v| (min.min(v), max.max(v)));
            if min >= max {
                continue;
            }
            let threshold = min + (max - min) * self.rng.uniform() as f32;
            let mut sides = [ClassWeights::default(); 2];
            for &i in order {
                let sample = &self.samples[i as usize];
                sides[usize::from(sample.features[feature] >= threshold)].add(sample);
            }
            tried += 1;
            if sides.iter().all(|side| side.samples >= MIN_LEAF_SAMPLES) {
                let purity = sides[0].purity() + sides[1].purity();
                if best.is_none_or(|(highest, _, _)| purity > highest) {
                    best = Some((purity, feature, threshold));
                }
            }
            if tried == FEATURES_PER_SPLIT {
                break;
            }
        }
        best.map(|(_, feature, threshold)| (feature, threshold))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples of noise, of which the feature `feature` tells the class.
    fn samples(count: usize, feature: usize) -> Vec<Sample> {
        let mut rng = Rng::for_stage(5, "samples");
        let sample = |_| {
            let mut features: Features = std::array::from_fn(|_| rng.uniform() as f32);
            let is_object = rng.below(2) == 1;
            features[feature] += f32::from(u8::from(is_object)) * 0.8;
            Sample { features, is_object, weight: 1.0 }
        };
        (0..count).map(sample).collect()
    }

    fn grow(samples: &[Sample]) -> Forest {
        Forest::grow(samples, &mut Rng::for_stage(1, "forest"))
    }

    #[test]
    fn the_feature_that_tells_the_classes_apart_decides() {
        let forest = grow(&samples(1200, 7));
        let probability = |value: f32| {
            let mut features = [0.5; NUM_FEATURES];
            features[7] = value;
            forest.probabilities(&[features])[0]
        };
        assert!(probability(0.1) < 0.25 && probability(1.7) > 0.75, "{} {}", probability(0.1), probability(1.7));
        assert!((0.2..0.8).contains(&probability(0.9)), "{}", probability(0.9));
    }

    #[test]
    fn a_tree_sorts_its_samples_into_leaves_that_hold_enough_and_tell_their_share() {
        let samples = samples(400, 2);
        for tree in &grow(&samples).trees {
            let leaf_of = |features: &Features| {
                let mut at = 0;
                while tree[at].right != LEAF {
                    let Node { feature, right, threshold } = tree[at];
                    at = if features[feature as usize] < threshold { at + 1 } else { right as usize };
                }
                at
            };
            let mut counts = vec![[0_u32; 2]; tree.len()];
            for sample in &samples {
                counts[leaf_of(&sample.features)][usize::from(sample.is_object)] += 1;
            }
            for (node, [background, object]) in tree.iter().zip(counts) {
                if node.right == LEAF {
                    let count = background + object;
                    assert!(count as usize >= MIN_LEAF_SAMPLES, "{count}");
                    assert!((node.threshold - object as f32 / count as f32).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn weights_count_as_copies_and_equal_samples_are_not_split() {
        let sample = |is_object, weight| Sample { features: [0.5; NUM_FEATURES], is_object, weight };
        let forest = grow(&[sample(true, 1.0), sample(false, 3.0)]);
        assert_eq!(forest.probabilities(&[[0.1; NUM_FEATURES]]), [0.25]);
        let many: Vec<Sample> = (0..100).map(|k| sample(k % 4 == 0, 1.0)).collect();
        assert!(grow(&many).trees.iter().all(|tree| tree.len() == 1));
    }

    #[test]
    fn the_same_seed_grows_the_same_forest() {
        let samples = samples(300, 0);
        let probe: Features = std::array::from_fn(|k| 0.1 * k as f32);
        let probability = |seed| Forest::grow(&samples, &mut Rng::for_stage(seed, "forest")).probabilities(&[probe])[0];
        assert_eq!(probability(1).to_bits(), probability(1).to_bits());
        assert_ne!(probability(1).to_bits(), probability(2).to_bits());
    }
}
