//! What a cue is worth in this clip: histograms of its values on objects and background, as log-odds.

/// What trajectories say of a superpixel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Witness {
    /// Its trajectories on objects, and on the background.
    pub(super) object: u32,
    pub(super) background: u32,
    /// Its pixels.
    pub(super) area: u32,
}

/// Bins of a cue's values.
const BINS: usize = 16;
/// Pixels that a trajectory vouches for; no superpixel has more than it has.
const VOUCHED: u32 = 48;
/// How much is known before anything is learned, as a share of all pixels.
const PRIOR: f32 = 0.05;
/// The background's typical value, before anything is learned.
const TYPICAL: f32 = 0.15;
/// Share of pixels that may have any value, so that rare values say little.
const STRAY: f32 = 0.02;
/// No value of a cue says more than this.
const MOST: f32 = 3.0;

/// The log-odds of an object for each superpixel by one cue, 0 to 1 and higher on objects; 0 where it is negative: not
/// known.
pub(super) fn log_odds(cue: &[f32], witnesses: &[Witness]) -> Vec<f32> {
    let table = table(cue, witnesses);
    cue.iter().map(|&value| if value < 0.0 { 0.0 } else { interpolated(&table, value) }).collect()
}

/// The log-odds of each bin, never falling.
fn table(cue: &[f32], witnesses: &[Witness]) -> [f32; BINS] {
    let prior = PRIOR * witnesses.iter().map(|w| w.area as f32).sum::<f32>();
    // Before anything is seen, objects have values of any size, high ones more so, and the background low ones.
    let place = |k: usize| (k as f32 + 0.5) / BINS as f32;
    let mut on = shared_out(prior, |k| 0.5 + place(k));
    let mut off = shared_out(prior, |k| libm::expf(-place(k) / TYPICAL));
    for (&value, w) in cue.iter().zip(witnesses).filter(|(value, _)| **value >= 0.0) {
        let count = w.object + w.background;
        let bin = ((value * BINS as f32) as usize).min(BINS - 1);
        let area = w.area.min(VOUCHED * count) as f32;
        on[bin] += area * w.object as f32 / count.max(1) as f32;
        off[bin] += area * w.background as f32 / count.max(1) as f32;
    }
    let (on, off) = (shares(&on), shares(&off));
    let weight = std::array::from_fn(|k| on[k] + off[k]);
    rising(&std::array::from_fn(|k| libm::logf(on[k] / off[k]).clamp(-MOST, MOST)), &weight)
}

/// Numbers in these proportions, with this sum.
fn shared_out(sum: f32, part: impl Fn(usize) -> f32) -> [f32; BINS] {
    let all: f32 = (0..BINS).map(&part).sum();
    std::array::from_fn(|k| sum * part(k) / all)
}

/// Shares of the sum, none of them 0.
fn shares(counts: &[f32; BINS]) -> [f32; BINS] {
    let all = counts.iter().sum::<f32>().max(1e-6);
    counts.map(|count| (1.0 - STRAY) * count / all + STRAY / BINS as f32)
}

/// The nearest table that never falls, in the sense of weighted squares: neighbours that fall are pooled.
fn rising(table: &[f32; BINS], weight: &[f32; BINS]) -> [f32; BINS] {
    let mut pools: Vec<(f32, f32, usize)> = Vec::new();
    for (&value, &weight) in table.iter().zip(weight) {
        let mut pool = (value, weight, 1);
        while let Some(&(before, w, count)) = pools.last().filter(|last| last.0 > pool.0) {
            pools.pop();
            let sum = w + pool.1;
            pool = ((before * w + pool.0 * pool.1) / sum, sum, count + pool.2);
        }
        pools.push(pool);
    }
    let mut found = pools.iter().flat_map(|&(value, _, count)| std::iter::repeat_n(value, count));
    std::array::from_fn(|_| found.next().unwrap_or(0.0))
}

/// Between the middles of bins.
fn interpolated(table: &[f32; BINS], value: f32) -> f32 {
    let place = (value * BINS as f32 - 0.5).clamp(0.0, (BINS - 1) as f32);
    let k = (place as usize).min(BINS - 2);
    let share = place - k as f32;
    (1.0 - share) * table[k] + share * table[k + 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn superpixel(object: u32, background: u32) -> Witness {
        Witness { object, background, area: 100 }
    }

    #[test]
    fn a_cue_that_tells_objects_from_background_says_so() {
        let cue: Vec<f32> = (0..200).map(|i| if i % 4 == 0 { 0.8 } else { 0.1 }).collect();
        let witnesses: Vec<Witness> =
            (0..200).map(|i| superpixel(u32::from(i % 4 == 0), u32::from(i % 4 > 0))).collect();
        let odds = log_odds(&cue, &witnesses);
        assert!(odds[0] > 1.5 && odds[1] < -1.5, "{} {}", odds[0], odds[1]);
    }

    #[test]
    fn a_cue_that_has_the_same_values_on_both_says_nothing() {
        let cue: Vec<f32> = (0..4000).map(|i| (i % 10) as f32 / 10.0).collect();
        let witnesses: Vec<Witness> =
            (0..4000).map(|i| superpixel(u32::from(i % 3 == 0), u32::from(i % 3 > 0))).collect();
        let most = log_odds(&cue, &witnesses).into_iter().fold(0.0, |m: f32, o| m.max(o.abs()));
        assert!(most < 0.5, "{most}");
    }

    #[test]
    fn without_witnesses_high_values_speak_for_objects_and_low_ones_against() {
        let odds = log_odds(&[0.0, 0.5, 1.0], &[superpixel(0, 0); 3]);
        assert!(odds[0] < -0.5 && odds[2] > 0.5 && odds[0] < odds[1] && odds[1] < odds[2], "{odds:?}");
    }

    #[test]
    fn more_of_a_cue_never_speaks_less_for_an_object() {
        let mut rng = crate::rng::Rng::for_stage(3, "odds");
        let cue: Vec<f32> = (0..300).map(|_| rng.below(1001) as f32 / 1000.0).collect();
        let witnesses: Vec<Witness> = (0..300).map(|_| superpixel(rng.below(4) as u32, rng.below(4) as u32)).collect();
        let mut found: Vec<(f32, f32)> = cue.iter().copied().zip(log_odds(&cue, &witnesses)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!(found.windows(2).all(|w| w[0].1 <= w[1].1 + 1e-5));
    }
}
