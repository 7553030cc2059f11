//! Which clusters are objects, and which are the scene behind them.
//!
//! The scene runs on beyond the frame, objects mostly end inside of it. So clusters are told apart by how many of their trajectory points
//! lie on the frame's rim, a band of 6 % of its shorter side. A cluster is background if
//!
//! - its share of the points on the rim is at least 0.8 of its share of all points: it is 1 on average, and near 0 for what seldom
//!   touches the rim; and
//! - it holds more of the rim than a square of its area would that stands on one side of the frame: small things that enter or leave the
//!   picture hold much of the rim for their size, but never more than that.
//!
//! Far and near parts of the scene, which parallax makes different clusters, are both background by this rule. Trajectories are counted
//! and not the pixels of masks, since the cut gives what has no trajectories, such as a plain sky, to whatever lies beside it. Not in
//! the paper, which leaves open what the background is (ALGORITHMS 6.4).

use crate::discretize::Clusters;
use crate::order;
use crate::trajectory::Trajectories;

/// Least share of the rim over share of all points of a background cluster.
const RIM_TO_ALL: f64 = 0.8;
/// Width of the rim over the shorter side of the frame.
const RIM_WIDTH: f32 = 0.06;

/// The mask label of each cluster.
///
/// Law: 0 is the background; objects are numbered 1, 2, ... by falling number of trajectory points. All objects but the 255 largest count
/// as background.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Objects {
    /// Number of objects.
    pub count: usize,
    /// Mask label of each cluster, 0 for the background.
    pub of_cluster: Vec<u8>,
}

/// Tells objects from background; the cluster with most points on the rim is background in any case.
pub fn find_objects(tracks: &Trajectories, clusters: &Clusters) -> Objects {
    let census = Census::take(tracks, clusters);
    let total = |counts: &[f64]| counts.iter().sum::<f64>();
    let ratio_bound = RIM_TO_ALL * total(&census.on_rim) / total(&census.points).max(1.0);
    let is_scene =
        |c: usize| census.on_rim[c] >= ratio_bound * census.points[c] && census.rim_length[c] > census.side_length[c];
    let surrounding = (0..clusters.count).rev().max_by(|&a, &b| census.on_rim[a].total_cmp(&census.on_rim[b]));
    let mut found: Vec<usize> = (0..clusters.count).filter(|&c| Some(c) != surrounding && !is_scene(c)).collect();
    order::sort_by_key(&mut found, |&c| !order::double(census.points[c]));
    found.truncate(255);
    let mut of_cluster = vec![0; clusters.count];
    for (label, &c) in (1..=255).zip(&found) {
        of_cluster[c] = label;
    }
    Objects { count: found.len(), of_cluster }
}

/// What each cluster covers, summed over the frames.
struct Census {
    /// Trajectory points.
    points: Vec<f64>,
    /// Those of them on the rim.
    on_rim: Vec<f64>,
    /// Length of the frame's outline that these stand for, in pixels.
    rim_length: Vec<f64>,
    /// Side of a square of the area that the cluster's points stand for, in pixels.
    side_length: Vec<f64>,
}

impl Census {
    fn take(tracks: &Trajectories, clusters: &Clusters) -> Self {
        let [mut points, mut on_rim, mut rim_length, mut side_length] = [(); 4].map(|()| vec![0.0; clusters.count]);
        let (w, h) = (tracks.size.0 as f32, tracks.size.1 as f32);
        let band = RIM_WIDTH * w.min(h);
        let (area, outline) = (f64::from(w * h), f64::from(2.0 * (w + h)));
        for t in 0..tracks.num_frames {
            let (mut here, mut here_on_rim) = (vec![0.0; clusters.count], vec![0.0; clusters.count]);
            for (i, x, y) in tracks.alive(t) {
                let c = clusters.label[i] as usize;
                here[c] += 1.0;
                if x.min(y).min(w - 1.0 - x).min(h - 1.0 - y) < band {
                    here_on_rim[c] += 1.0;
                }
            }
            let (all, all_on_rim) = (here.iter().sum::<f64>(), here_on_rim.iter().sum::<f64>());
            for c in 0..clusters.count {
                points[c] += here[c];
                on_rim[c] += here_on_rim[c];
                rim_length[c] += outline * here_on_rim[c] / all_on_rim.max(1.0);
                side_length[c] += (area * here[c] / all.max(1.0)).sqrt();
            }
        }
        Self { points, on_rim, rim_length, side_length }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clip of one frame with a trajectory in each of the picture's characters, ten pixels apart; the digit is its cluster.
    fn frame(picture: &[&str], count: usize) -> (Trajectories, Clusters) {
        let (w, h) = (picture[0].len(), picture.len());
        let mut tracks = Trajectories::empty(1, (10 * w, 10 * h));
        let mut label = Vec::new();
        for (y, row) in picture.iter().enumerate() {
            for (x, digit) in row.bytes().enumerate() {
                // The outermost points lie a pixel inside of the frame.
                let spread = |k: usize, n: usize| 1.0 + k as f32 * (10 * n - 3) as f32 / (n - 1) as f32;
                tracks.push(0, [(spread(x, w), spread(y, h), 0.0)]);
                label.push(u32::from(digit - b'0'));
            }
        }
        (tracks, Clusters { count, label })
    }

    #[test]
    fn what_the_rim_encloses_is_an_object_and_the_largest_comes_first() {
        let (tracks, clusters) = frame(&["1111111", "1011221", "1111221", "1111111"], 3);
        let objects = find_objects(&tracks, &clusters);
        assert_eq!((objects.count, objects.of_cluster), (2, vec![2, 0, 1]));
    }

    #[test]
    fn what_enters_through_one_side_is_an_object() {
        let (tracks, clusters) = frame(&["00000000", "00000000", "00001111", "00001111", "00000000", "00000000"], 2);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 1]);
    }

    #[test]
    fn two_parts_of_the_scene_are_both_background() {
        let (tracks, clusters) = frame(&["0000000", "0000000", "0002200", "1112211", "1111111", "1111111"], 3);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 0, 1]);
    }

    #[test]
    fn one_cluster_or_none_is_background() {
        let (tracks, clusters) = frame(&["00", "00"], 1);
        assert_eq!(find_objects(&tracks, &clusters), Objects { count: 0, of_cluster: vec![0] });
        let nothing = (Trajectories::empty(3, (8, 8)), Clusters::default());
        assert_eq!(find_objects(&nothing.0, &nothing.1), Objects::default());
    }
}
