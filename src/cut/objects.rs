//! Which clusters are objects, and which are the scene behind them.
//!
//! The scene runs on beyond the frame, objects mostly end inside of it. So clusters are told apart by how much of the frame's rim they
//! hold, over the whole clip, against how much of its area: about 1 for what surrounds the rest, 0 for what never touches the rim. Far and near
//! parts of the scene, which parallax makes different clusters, are both background by this rule, and an object that fills most of the
//! picture is none. Not in the paper, which leaves open what the background is (ALGORITHMS 6.4).

use super::CutLabels;
use crate::superpixel::Superpixels;

/// Share of the rim over share of the area above which a cluster is background.
const RIM_TO_AREA: f64 = 0.7;

/// The mask label of each cluster.
///
/// Law: 0 is the background; objects are numbered 1, 2, ... by falling number of pixels in the clip. Clusters without a pixel count as
/// background, as do all objects but the 255 largest.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Objects {
    /// Number of objects.
    pub count: usize,
    /// Mask label of each cluster, 0 for the background.
    pub of_cluster: Vec<u8>,
}

/// Tells objects from background.
///
/// Background is every cluster whose share of the rim's pixels is at least 0.7 times its share of all pixels, and in any case the one
/// with most rim pixels.
pub fn find_objects(superpixels: &[Superpixels], cut: &CutLabels, num_clusters: usize) -> Objects {
    let (area, rim) = census(superpixels, cut, num_clusters);
    let total = |counts: &[u64]| counts.iter().sum::<u64>() as f64;
    let ratio_bound = RIM_TO_AREA * total(&rim) / total(&area).max(1.0);
    let surrounding = (0..num_clusters).rev().max_by_key(|&c| rim[c]);
    let mut found: Vec<usize> = (0..num_clusters)
        .filter(|&c| Some(c) != surrounding && (rim[c] as f64) < ratio_bound * area[c] as f64)
        .collect();
    found.sort_by_key(|&c| std::cmp::Reverse(area[c]));
    found.truncate(255);
    let mut of_cluster = vec![0; num_clusters];
    for (label, &c) in (1..=255).zip(&found) {
        of_cluster[c] = label;
    }
    Objects { count: found.len(), of_cluster }
}

/// Pixels of each cluster, and those of them in the outermost rows and columns.
fn census(superpixels: &[Superpixels], cut: &CutLabels, num_clusters: usize) -> (Vec<u64>, Vec<u64>) {
    let (mut area, mut rim) = (vec![0; num_clusters], vec![0; num_clusters]);
    for (regions, labels) in superpixels.iter().zip(&cut.labels) {
        let (w, h) = (regions.label.width(), regions.label.height());
        for y in 0..h {
            for (x, &p) in regions.label.row(y).iter().enumerate() {
                let c = labels[p as usize] as usize;
                area[c] += 1;
                rim[c] += u64::from(x == 0 || y == 0 || x + 1 == w || y + 1 == h);
            }
        }
    }
    (area, rim)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Plane;

    /// A clip of one frame in which each pixel is a superpixel of its own; `picture` holds the clusters as digits.
    fn frame(picture: &[&str]) -> (Vec<Superpixels>, CutLabels) {
        let (w, h) = (picture[0].len(), picture.len());
        let labels = picture.iter().flat_map(|row| row.bytes().map(|b| u32::from(b - b'0'))).collect();
        let label = Plane::from_fn(w, h, |x, y| (y * w + x) as u32);
        let regions = Superpixels { label, count: w * h, ..Superpixels::default() };
        (vec![regions], CutLabels { labels: vec![labels] })
    }

    #[test]
    fn what_the_rim_encloses_is_an_object_and_the_largest_comes_first() {
        let (regions, cut) = frame(&["1111111", "1011221", "1111221", "1111111"]);
        let objects = find_objects(&regions, &cut, 3);
        assert_eq!((objects.count, objects.of_cluster), (2, vec![2, 0, 1]));
    }

    #[test]
    fn two_parts_of_the_scene_are_both_background() {
        let (regions, cut) = frame(&["0000000", "0002200", "0002200", "1112211", "1111111"]);
        assert_eq!(find_objects(&regions, &cut, 3).of_cluster, [0, 0, 1]);
    }

    #[test]
    fn one_cluster_or_none_is_background() {
        let (regions, cut) = frame(&["00", "00"]);
        assert_eq!(find_objects(&regions, &cut, 1), Objects { count: 0, of_cluster: vec![0] });
        assert_eq!(find_objects(&[], &CutLabels::default(), 0), Objects::default());
    }
}
