//! Classification of clusters as objects or scene, by the frame border.
//!
//! The scene runs on beyond the frame, while objects mostly end inside of it. The frame is divided into square cells, eight
//! along its shorter side. In each frame a cell counts for the clusters of its trajectories, in proportion, and for the border
//! as far as they are near it: wholly within half a cell, and not from one and a half on, so that no pixel more or less
//! decides. A cluster's border share is its part of the border over its part of all cells, its excess the difference of both;
//! these and its motion against the camera's give its log-odds ([`crate::evidence`]).
//!
//! Near and far parts of the scene, which parallax makes different clusters, are both background by this rule. It counts
//! trajectories and not the pixels of masks, since the cut gives areas without trajectories, such as a plain sky, to
//! whatever lies beside them; and cells, since the density of trajectories varies. Not in the paper, which does not define
//! the background. Cost: O(points). It fails where an object fills one side of the frame.

use crate::discretize::Clusters;
use crate::evidence::{ClusterCues, ClusterMotion};
use crate::order;
use crate::trajectory::Trajectories;

/// Cells along the shorter side of the frame. Chosen by eye.
const CELLS_PER_SIDE: usize = 8;
/// Distance from the frame border, in cells, from which a point does not count for it; up to one cell less it counts wholly. Chosen
/// by eye.
const BORDER_REACH: f32 = 1.5;
/// Most objects: masks have a byte a pixel.
const MAX_OBJECTS: usize = 255;

/// Mask label of each cluster.
///
/// Law: 0 is the background; objects have the numbers 1, 2, ... by falling area, and all but the 255 largest
/// count as background. Objects keep their labels in later windows of a long clip and when the user corrects some, so
/// that there may be gaps.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Objects {
    /// The highest label.
    pub highest_label: usize,
    /// Mask label of each cluster, 0 for the background.
    pub of_cluster: Vec<u8>,
}

impl Objects {
    /// Returns the labels of all objects, lowest first.
    #[doc(hidden)] // For the command line and the Python package.
    pub fn labels(&self) -> Vec<u8> {
        (1..=255).filter(|label| self.of_cluster.contains(label)).collect()
    }
}

/// Classifies clusters by the frame border. The cluster with most of the border is always background.
pub(crate) fn find_objects(tracks: &Trajectories, clusters: &Clusters) -> Objects {
    let counts = CellCounts::new(tracks, clusters);
    let cues = counts.cues(&[]);
    let surrounding = counts.surrounding();
    let is_object = |&c: &usize| Some(c) != surrounding && cues[c].log_odds() > 0.0;
    counts.number((0..clusters.count).filter(is_object).collect())
}

/// Returns the cues of each cluster. `motions` has the motion of each, and is empty if unknown.
pub(crate) fn cluster_cues(tracks: &Trajectories, clusters: &Clusters, motions: &[ClusterMotion]) -> Vec<ClusterCues> {
    CellCounts::new(tracks, clusters).cues(motions)
}

/// Numbers the clusters that are objects by falling area; all but the 255 largest become background.
#[must_use]
pub fn number_objects(tracks: &Trajectories, clusters: &Clusters, is_object: &[bool]) -> Objects {
    CellCounts::new(tracks, clusters).number((0..clusters.count).filter(|&c| is_object[c]).collect())
}

/// Number of cells that each cluster covers, with fractions, summed over the frames.
struct CellCounts {
    cells: Vec<f64>,
    /// The same, weighted by nearness to the frame border.
    border_cells: Vec<f64>,
}

impl CellCounts {
    fn new(tracks: &Trajectories, clusters: &Clusters) -> Self {
        let count = clusters.count;
        let (mut cells, mut border_cells) = (vec![0.0; count], vec![0.0; count]);
        let (w, h) = (tracks.size.0 as f32, tracks.size.1 as f32);
        let side = (w.min(h) / CELLS_PER_SIDE as f32).max(1.0);
        let [columns, rows] = [w, h].map(|length| (length / side).round().max(1.0) as usize);
        for t in 0..tracks.num_frames {
            let (mut points, mut border) = (vec![0_u32; columns * rows * count], vec![0.0; columns * rows * count]);
            for (i, x, y) in tracks.alive(t) {
                // Equal cells: the share is the same in a mirrored frame.
                let column = ((x + 0.5).max(0.0) * columns as f32 / w) as usize;
                let row = ((y + 0.5).max(0.0) * rows as f32 / h) as usize;
                let cell = row.min(rows - 1) * columns + column.min(columns - 1);
                let place = cell * count + clusters.label[i] as usize;
                points[place] += 1;
                let distance = (x + 0.5).min(w - x - 0.5).min(y + 0.5).min(h - y - 0.5);
                border[place] += f64::from((BORDER_REACH - distance / side).clamp(0.0, 1.0));
            }
            for (points, border) in points.chunks_exact(count.max(1)).zip(border.chunks_exact(count.max(1))) {
                let total = f64::from(points.iter().sum::<u32>().max(1));
                for (c, (&n, border)) in points.iter().zip(border).enumerate() {
                    cells[c] += f64::from(n) / total;
                    border_cells[c] += border / total;
                }
            }
        }
        Self { cells, border_cells }
    }

    /// Cues of each cluster.
    fn cues(&self, motions: &[ClusterMotion]) -> Vec<ClusterCues> {
        let Self { cells, border_cells } = self;
        let [all, border] = [cells, border_cells].map(|cells| cells.iter().sum::<f64>().max(1.0));
        let cues = |c: usize| {
            let (part, border_part) = (cells[c] / all, border_cells[c] / border);
            ClusterCues::Moving {
                border_share: border_part / part.max(1e-9),
                border_excess: (border_part - part).max(0.0),
                motion: motions.get(c).copied(),
            }
        };
        (0..cells.len()).map(cues).collect()
    }

    /// The cluster with most of the border.
    fn surrounding(&self) -> Option<usize> {
        let border_cells = &self.border_cells;
        (0..border_cells.len()).rev().max_by(|&a, &b| border_cells[a].total_cmp(&border_cells[b]))
    }

    /// Numbers these clusters by falling area.
    fn number(&self, mut objects: Vec<usize>) -> Objects {
        order::sort_by_key(&mut objects, |&c| !order::f64_key(self.cells[c]));
        objects.truncate(MAX_OBJECTS);
        let mut of_cluster = vec![0; self.cells.len()];
        for (label, &c) in (1..=255).zip(&objects) {
            of_cluster[c] = label;
        }
        Objects { highest_label: objects.len(), of_cluster }
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
    fn clusters_inside_the_border_are_objects_and_the_largest_comes_first() {
        let (tracks, clusters) = frame(ENCLOSED, 3);
        let objects = find_objects(&tracks, &clusters);
        assert_eq!((objects.highest_label, objects.of_cluster), (2, vec![2, 0, 1]));
    }

    #[test]
    fn contrast_to_the_camera_allows_more_of_the_border() {
        let corner = ["00000000", "00000000", "00000000", "00000000", "00001111", "00001111", "00001111", "00001111"];
        let (tracks, clusters) = frame(corner, 2);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 0]);
        let value = |tracks: &Trajectories, clusters: &Clusters, contrast: f64| {
            let motion = |contrast| ClusterMotion { contrast, residual_sq: 1.0 };
            cluster_cues(tracks, clusters, &[motion(0.2), motion(contrast)])[1].log_odds()
        };
        assert!(value(&tracks, &clusters, 6.0) > 0.0);
        let side = ["00000000", "00000000", "00000000", "00001111", "00001111", "00000000", "00000000", "00000000"];
        let (tracks, clusters) = frame(side, 2);
        assert!(value(&tracks, &clusters, 4.0) > 0.0 && value(&tracks, &clusters, 0.3) < 0.0);
    }

    #[test]
    fn a_cluster_that_enters_through_one_side_is_an_object() {
        let side = ["00000000", "00000000", "00000000", "00001111", "00001111", "00000000", "00000000", "00000000"];
        let (tracks, clusters) = frame(side, 2);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 1]);
    }

    #[test]
    fn a_mirrored_clip_has_the_same_shares() {
        // Cells of an eighth of the height do not fill the width.
        let size = (107, 80);
        let shares = |is_mirrored: bool| {
            let mut tracks = Trajectories::empty(1, size);
            let mut label = Vec::new();
            for k in 0..107 * 8 {
                let (x, y) = (k % 107, 10 * (k / 107) + 5);
                let column = if is_mirrored { 106 - x } else { x };
                tracks.push(0, [(column as f32, y as f32, 0.0)]);
                label.push(u32::from(x < 12 && y < 40));
            }
            let motions = [0.0, 4.0].map(|contrast| ClusterMotion { contrast, residual_sq: 1.0 });
            cluster_cues(&tracks, &Clusters { count: 2, label }, &motions)[1]
        };
        assert_eq!(shares(false), shares(true));
    }

    #[test]
    fn two_parts_of_the_scene_are_both_background() {
        let parts = ["00000000", "00000000", "00022000", "00022000", "11122111", "11111111", "11111111", "11111111"];
        let (tracks, clusters) = frame(parts, 3);
        assert_eq!(find_objects(&tracks, &clusters).of_cluster, [0, 0, 1]);
    }

    #[test]
    fn the_density_of_trajectories_does_not_count() {
        let (mut tracks, mut clusters) = frame(ENCLOSED, 3);
        for k in 0..500 {
            // Many more on one of the objects, which now also touches the border.
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
