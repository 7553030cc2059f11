//! Which clusters are objects, and which are the scene behind them.
//!
//! The scene runs on beyond the frame, objects mostly end inside of it. So clusters are told apart by how much of the frame's rim they
//! hold over the whole clip. A cluster is background if
//!
//! - its share of the rim's pixels is at least 0.8 of its share of all pixels: it is 1 on average, and near 0 for what seldom touches the
//!   rim; and
//! - it holds more of the rim than a square of its area would that stands on one side of the frame: small things that enter or leave the
//!   picture hold much of the rim for their size, but never more than that.
//!
//! Far and near parts of the scene, which parallax makes different clusters, are both background by this rule. Not in the paper, which
//! leaves open what the background is (ALGORITHMS 6.4).

use super::CutLabels;
use crate::order;
use crate::superpixel::Superpixels;

/// Least share of the rim over share of the area of a background cluster.
const RIM_TO_AREA: f64 = 0.8;

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

/// Tells objects from background; the cluster with most pixels on the rim is background in any case.
pub fn find_objects(superpixels: &[Superpixels], cut: &CutLabels, num_clusters: usize) -> Objects {
    let census = Census::take(superpixels, cut, num_clusters);
    let total = |counts: &[f64]| counts.iter().sum::<f64>();
    let ratio_bound = RIM_TO_AREA * total(&census.rim) / total(&census.area).max(1.0);
    let is_scene = |c: usize| {
        census.area[c] == 0.0 || (census.rim[c] >= ratio_bound * census.area[c] && census.rim[c] > census.side[c])
    };
    let surrounding = (0..num_clusters).rev().max_by(|&a, &b| census.rim[a].total_cmp(&census.rim[b]));
    let mut found: Vec<usize> = (0..num_clusters).filter(|&c| Some(c) != surrounding && !is_scene(c)).collect();
    order::sort_by_key(&mut found, |&c| !order::double(census.area[c]));
    found.truncate(255);
    let mut of_cluster = vec![0; num_clusters];
    for (label, &c) in (1..=255).zip(&found) {
        of_cluster[c] = label;
    }
    Objects { count: found.len(), of_cluster }
}

/// What each cluster covers, summed over the frames.
struct Census {
    /// Pixels.
    area: Vec<f64>,
    /// Pixels in the outermost rows and columns.
    rim: Vec<f64>,
    /// Sides of squares of the area in each frame.
    side: Vec<f64>,
}

impl Census {
    fn take(superpixels: &[Superpixels], cut: &CutLabels, num_clusters: usize) -> Self {
        let [mut area, mut rim, mut side] = [(); 3].map(|()| vec![0.0; num_clusters]);
        for (regions, labels) in superpixels.iter().zip(&cut.labels) {
            let (w, h) = (regions.label.width(), regions.label.height());
            let mut covered = vec![0_u32; num_clusters];
            for y in 0..h {
                for (x, &p) in regions.label.row(y).iter().enumerate() {
                    let c = labels[p as usize] as usize;
                    covered[c] += 1;
                    if x == 0 || y == 0 || x + 1 == w || y + 1 == h {
                        rim[c] += 1.0;
                    }
                }
            }
            for (c, &pixels) in covered.iter().enumerate() {
                area[c] += f64::from(pixels);
                side[c] += f64::from(pixels).sqrt();
            }
        }
        Self { area, rim, side }
    }
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
        let objects = find_objects(&regions, &cut, 4);
        assert_eq!((objects.count, objects.of_cluster), (2, vec![2, 0, 1, 0]));
    }

    #[test]
    fn what_enters_through_one_side_is_an_object() {
        let (regions, cut) = frame(&["0000000", "0000000", "0000011", "0000011", "0000000", "0000000"]);
        assert_eq!(find_objects(&regions, &cut, 2).of_cluster, [0, 1]);
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
