//! Which clusters are objects, and which are the scene behind them.
//!
//! The scene runs on beyond the frame, objects mostly end inside of it. So clusters are told apart by how much of the
//! frame's rim they hold. The frame is laid out in square cells, eight along its shorter side; the outermost are its
//! rim. In each frame a cell counts for the clusters of the trajectories in it, in proportion, and as one whatever
//! their number. What is known of a cluster is weighed ([`crate::evidence`]): its share of the rim over its share of all
//! cells, and how far it is from the motion of the camera.
//!
//! Far and near parts of the scene, which parallax makes different clusters, are both background by this rule. It looks
//! at trajectories and not at the pixels of masks, since the cut gives what has no trajectories, such as a plain sky,
//! to whatever lies beside it; and at cells, since trajectories are dense on one thing and sparse on another. Not in
//! the paper, which leaves open what the background is.

use crate::discretize::Clusters;
use crate::evidence::Signs;
use crate::order;
use crate::trajectory::Trajectories;

/// Cells along the shorter side of the frame.
const CELLS: usize = 8;

/// The mask label of each cluster.
///
/// Law: 0 is the background; [`find_objects`] numbers objects 1, 2, ... by falling area, and all but the 255 largest
/// count as background. In later windows of a long clip objects keep the labels that they had before, and so they do
/// when the user corrects some, so that there may be gaps.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Objects {
    /// The highest label.
    pub highest_label: usize,
    /// Mask label of each cluster, 0 for the background.
    pub of_cluster: Vec<u8>,
}

impl Objects {
    /// The labels of all objects, lowest first.
    pub fn labels(&self) -> Vec<u8> {
        (1..=255).filter(|label| self.of_cluster.contains(label)).collect()
    }
}

/// Tells objects from background; the cluster with most of the rim is background in any case.
///
/// # Examples
/// A trajectory for each digit, which is its cluster: what the rim encloses is an object.
///
/// ```
/// use tracecut::discretize::Clusters;
/// use tracecut::mask::find_objects;
/// use tracecut::trajectory::Trajectories;
///
/// let rows = ["00000000", "00000000", "00011000", "00011000", "00011000", "00000000", "00000000", "00000000"];
/// let mut tracks = Trajectories::empty(1, (80, 80));
/// let mut label = Vec::new();
/// for (y, row) in rows.iter().enumerate() {
///     for (x, digit) in row.bytes().enumerate() {
///         tracks.push(0, [(10.0 * x as f32 + 4.0, 10.0 * y as f32 + 4.0, 0.0)]);
///         label.push(u32::from(digit - b'0'));
///     }
/// }
/// let objects = find_objects(&tracks, &Clusters { count: 2, label });
/// assert_eq!((objects.labels(), objects.of_cluster), (vec![1], vec![0, 1]));
/// ```
#[must_use]
pub fn find_objects(tracks: &Trajectories, clusters: &Clusters) -> Objects {
    find_objects_above(tracks, clusters, 0.0)
}

/// The same where more than `least` must speak for an object.
pub(crate) fn find_objects_above(tracks: &Trajectories, clusters: &Clusters, least: f64) -> Objects {
    let census = Census::take(tracks, clusters);
    let signs = census.signs(&[]);
    let is_object = |&c: &usize| signs[c].is_some_and(|signs| signs.value() > least);
    numbered(&census, (0..clusters.count).filter(is_object).collect())
}

/// What clusters are judged by; `None` for the one that is background in any case. `strangeness` is how far each is from
/// the camera's motion, empty where it is not known.
pub(crate) fn signs(tracks: &Trajectories, clusters: &Clusters, strangeness: &[f64]) -> Vec<Option<Signs>> {
    Census::take(tracks, clusters).signs(strangeness)
}

/// Numbers the clusters that are objects by falling area; all but the 255 largest become background.
#[must_use]
pub fn number_objects(tracks: &Trajectories, clusters: &Clusters, is_object: &[bool]) -> Objects {
    let census = Census::take(tracks, clusters);
    numbered(&census, (0..clusters.count).filter(|&c| is_object[c]).collect())
}

/// Labels by falling area for the clusters `found`.
fn numbered(census: &Census, mut found: Vec<usize>) -> Objects {
    order::sort_by_key(&mut found, |&c| !order::f64_key(census.cells[c]));
    found.truncate(255);
    let mut of_cluster = vec![0; census.cells.len()];
    for (label, &c) in (1..=255).zip(&found) {
        of_cluster[c] = label;
    }
    Objects { highest_label: found.len(), of_cluster }
}

/// What each cluster covers, summed over the frames.
struct Census {
    /// Cells, and parts of cells.
    cells: Vec<f64>,
    /// Those of them on the rim.
    rim: Vec<f64>,
}

impl Census {
    /// The cluster with most of the rim has none.
    fn signs(&self, strangeness: &[f64]) -> Vec<Option<Signs>> {
        let total = |counts: &[f64]| counts.iter().sum::<f64>();
        let typical = total(&self.rim) / total(&self.cells).max(1.0);
        let of = |c: usize| Signs::Moving {
            rim: self.rim[c] / (typical * self.cells[c]).max(1e-9),
            strangeness: strangeness.get(c).copied(),
        };
        let count = self.cells.len();
        let surrounding = (0..count).rev().max_by(|&a, &b| self.rim[a].total_cmp(&self.rim[b]));
        (0..count).map(|c| (Some(c) != surrounding).then(|| of(c))).collect()
    }

    fn take(tracks: &Trajectories, clusters: &Clusters) -> Self {
        let count = clusters.count;
        let (mut cells, mut rim) = (vec![0.0; count], vec![0.0; count]);
        let (w, h) = (tracks.size.0 as f32, tracks.size.1 as f32);
        let cell = (w.min(h) / CELLS as f32).max(1.0);
        let (columns, rows) = ((w / cell).ceil().max(1.0) as usize, (h / cell).ceil().max(1.0) as usize);
        for t in 0..tracks.num_frames {
            let mut points = vec![0_u32; columns * rows * count];
            for (i, x, y) in tracks.alive(t) {
                let column = ((x + 0.5).max(0.0) / cell) as usize;
                let row = ((y + 0.5).max(0.0) / cell) as usize;
                let place = row.min(rows - 1) * columns + column.min(columns - 1);
                points[place * count + clusters.label[i] as usize] += 1;
            }
            for (place, points) in points.chunks_exact(count.max(1)).enumerate() {
                let all = f64::from(points.iter().sum::<u32>().max(1));
                let (column, row) = (place % columns, place / columns);
                let outermost = column == 0 || row == 0 || column + 1 == columns || row + 1 == rows;
                for (c, &n) in points.iter().enumerate() {
                    cells[c] += f64::from(n) / all;
                    rim[c] += if outermost { f64::from(n) / all } else { 0.0 };
                }
            }
        }
        Self { cells, rim }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clip of one frame of 80 by 80 pixels, eight by eight cells, with a trajectory in each cell; digits are
    /// clusters.
    fn frame(picture: [&str; 8], count: usize) -> (Trajectories, Clusters) {
        let mut tracks = Trajectories::empty(1, (80, 80));
        let mut label = Vec::new();
        for (y, row) in picture.iter().enumerate() {
            for (x, digit) in row.bytes().enumerate() {
                tracks.push(0, [(10.0 * x as f32 + 4.0, 10.0 * y as f32 + 4.0, 0.0)]);
                label.push(u32::from(digit - b'0'));
            }
        }
        (tracks, Clusters { count, label })
    }

    const ENCLOSED: [&str; 8] =
        ["11111111", "10011111", "11111111", "11112221", "11112221", "11111111", "11111111", "11111111"];

    #[test]
    fn what_the_rim_encloses_is_an_object_and_the_largest_comes_first() {
        let (tracks, clusters) = frame(ENCLOSED, 3);
        let objects = find_objects(&tracks, &clusters);
        assert_eq!((objects.highest_label, objects.of_cluster), (2, vec![2, 0, 1]));
    }

    #[test]
    fn what_differs_from_the_motion_of_the_camera_may_hold_more_of_the_rim_and_what_goes_with_it_less() {
        let corner = ["00000000", "00000000", "00000000", "00000000", "00001111", "00001111", "00001111", "00001111"];
        let (tracks, clusters) = frame(corner, 2);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 0]);
        let value = |tracks: &Trajectories, clusters: &Clusters, strangeness: f64| {
            signs(tracks, clusters, &[0.2, strangeness])[1].map(|signs| signs.value())
        };
        assert!(value(&tracks, &clusters, 6.0) > Some(0.0));
        let side = ["00000000", "00000000", "00000000", "00001111", "00001111", "00000000", "00000000", "00000000"];
        let (tracks, clusters) = frame(side, 2);
        assert!(value(&tracks, &clusters, 4.0) > Some(0.0) && value(&tracks, &clusters, 0.3) < Some(0.0));
    }

    #[test]
    fn what_enters_through_one_side_is_an_object() {
        let side = ["00000000", "00000000", "00000000", "00001111", "00001111", "00000000", "00000000", "00000000"];
        let (tracks, clusters) = frame(side, 2);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 1]);
    }

    #[test]
    fn two_parts_of_the_scene_are_both_background() {
        let parts = ["00000000", "00000000", "00022000", "00022000", "11122111", "11111111", "11111111", "11111111"];
        let (tracks, clusters) = frame(parts, 3);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 0, 1]);
    }

    #[test]
    fn dense_trajectories_weigh_no_more_than_sparse_ones() {
        let (mut tracks, mut clusters) = frame(ENCLOSED, 3);
        for k in 0..500 {
            // Many more on one of the objects, which now also touches the rim.
            tracks.push(0, [(79.0 - 0.06 * k as f32, 35.0, 0.0)]);
            clusters.label.push(2);
        }
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [2, 0, 1]);
    }

    #[test]
    fn one_cluster_or_none_is_background() {
        let (tracks, clusters) = frame(["00000000"; 8], 1);
        assert_eq!(find_objects(&tracks, &clusters), Objects { highest_label: 0, of_cluster: vec![0] });
        let nothing = (Trajectories::empty(3, (8, 8)), Clusters::default());
        assert_eq!(find_objects(&nothing.0, &nothing.1), Objects::default());
    }
}
