//! Textons: which kind of small pattern each pixel belongs to.
//!
//! Instead of clusters of filter responses, which differ from one image to the next and jump between the frames of a
//! video, each pixel is shared among nine fixed kinds: flat, and a bright or a dark line in one of four directions. A
//! kind's share is its response (a second difference) over the sum of all responses and [`FLAT`], so contrast matters
//! only where it is low.

use super::blur::{mirror, pad};
use crate::order::larger;

/// Kinds of patterns.
pub(super) const TEXTONS: usize = 9;
/// The sum of responses, in brightness `0..=1`, at which a pixel is half flat. Lower finds texture in noise.
const FLAT: f32 = 0.05;

/// Shares of each kind, as planes of the size of `brightness`; they sum to one at each pixel.
pub(super) fn textons(brightness: &[f32], width: usize) -> [Vec<f32>; TEXTONS] {
    let height = brightness.len() / width;
    let mut shares = [0; TEXTONS].map(|_| vec![0.0; brightness.len()]);
    let mut rows = [Vec::new(), Vec::new(), Vec::new()];
    for y in 0..height {
        for (dy, row) in rows.iter_mut().enumerate() {
            pad(&brightness[mirror(y as isize + dy as isize - 1, height) * width..][..width], 1, row);
        }
        let [above, here, below] = rows.each_ref().map(|row| [0, 1, 2].map(|dx| &row[dx..][..width]));
        let out = shares.each_mut().map(|plane| &mut plane[y * width..][..width]);
        for x in 0..width {
            let twice = 2.0 * here[1][x];
            let lines = [
                twice - here[0][x] - here[2][x],
                twice - above[0][x] - below[2][x],
                twice - above[1][x] - below[1][x],
                twice - above[2][x] - below[0][x],
            ];
            let scale = 1.0 / (lines[0].abs() + lines[1].abs() + lines[2].abs() + lines[3].abs() + FLAT);
            out[0][x] = FLAT * scale;
            for k in 0..4 {
                out[1 + k][x] = larger(lines[k], 0.0) * scale;
                out[5 + k][x] = larger(-lines[k], 0.0) * scale;
            }
        }
    }
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_sum_to_one_and_name_the_pattern() {
        // A bright column in a dark image, and one bright dot.
        let image: Vec<f32> = (0..64).map(|i| if i % 8 == 2 || i == 46 { 1.0 } else { 0.0 }).collect();
        let shares = textons(&image, 8);
        for i in 0..64 {
            let sum: f32 = shares.iter().map(|s| s[i]).sum();
            assert!((sum - 1.0).abs() < 1e-5, "{sum} at {i}");
        }
        let on_line = 3 * 8 + 2;
        assert!(shares[1][on_line] > 0.3 && shares[3][on_line] == 0.0, "a column is a line across x");
        assert_eq!(shares[0][3 * 8 + 5 - 1], 1.0, "flat beside them");
        assert!(shares[5][on_line + 1] > 0.0, "dark beside bright");
        assert_eq!(textons(&[0.3], 1)[0], [1.0]);
    }
}
