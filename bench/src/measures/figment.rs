//! The measures of the paper's Table 1, for people who move alike, each in pieces, and get entangled (the Figment
//! dataset).
//!
//! **In:** labelled trajectories, and for some frames (Figment: every seventh) which object each pixel shows: 0 the
//! background, 1 and up the people. **Out:** [`Scores`] of a sequence, over sequences their [`mean`].
//!
//! A *point* is a trajectory in a labelled frame, at its nearest pixel. Every cluster is assigned to the one object, or
//! the background, that holds most of its points, the first of equal ones; many may be assigned to the same one. Then:
//!
//! 1. Density: pixels of the labelled frames that carry a point, in percent.
//! 2. Clustering error: points in a cluster that is not assigned to their object, in percent of all points.
//! 3. Per region clustering error: the same among the points of one object, in percent; 100 for an object without
//!    points. Mean over the people, without the background, as the paper says of it.
//!
//! For the others the paper refers to Fragkiadaki and Shi (CVPR 2011). As computed here, each a mean over the people
//! that some labelled frame shows:
//!
//! 4. Over-segmentation: clusters assigned to the object beyond the first.
//! 5. Recall: pixels of the object that lie within a given distance of a point of a cluster assigned to it, in percent.
//!    (The paper's recall is above its density, so points must cover more than their own pixels.)
//! 6. Leakage: objects of which the cluster that holds most of their points has more than half of its own elsewhere, in
//!    percent. An object without points leaks.
//! 7. Tracking time: labelled frames in which more than half of the object's points are in its main cluster, in percent
//!    of those that show it. The main cluster is the one with most of its points among those assigned to it; without
//!    any there is no such frame.

use super::moseg::{nearest_pixel, overlap};
use serde::Serialize;
use tracecut::Error;
use tracecut::discretize::Clusters;
use tracecut::image::Plane;
use tracecut::trajectory::Trajectories;

/// Scores of a sequence as in the paper's Table 1, in percent but for the over-segmentation and the number of objects.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Scores {
    /// Pixels that carry a point.
    pub density: f64,
    /// Points in clusters of another object.
    pub clustering_error: f64,
    /// The same for each object, the background left out; mean.
    pub per_region_error: f64,
    /// Clusters of an object beyond the first; mean.
    pub oversegmentation: f64,
    /// Pixels of an object near points of its clusters; mean.
    pub recall: f64,
    /// Objects whose cluster lies mostly elsewhere.
    pub leakage: f64,
    /// Frames in which an object keeps its cluster; mean.
    pub tracking_time: f64,
    /// People that the labelled frames show.
    pub objects: f64,
}

/// Scores `tracks` with labels `clusters` against `labelled`: frame numbers and the objects of these frames' pixels, of
/// which points of trajectories cover those within `radius` pixels.
///
/// # Errors
/// [`Error::Data`] without labelled frames, or when one is not of the clip or not of the trajectories' size.
pub fn score(
    labelled: &[(usize, &Plane<u8>)],
    tracks: &Trajectories,
    clusters: &Clusters,
    radius: f64,
) -> Result<Scores, Error> {
    check(labelled, tracks)?;
    let num_objects = labelled.iter().flat_map(|l| l.1.data()).max().map_or(1, |&m| usize::from(m) + 1);
    let frames: Vec<Vec<Vec<u64>>> =
        labelled.iter().map(|l| overlap(std::slice::from_ref(l), num_objects, tracks, clusters)).collect();
    let table = Table::new(&frames, num_objects, clusters.count);
    let (covered, visible) = cover(labelled, tracks, clusters, &table, radius);
    let people: Vec<usize> = (1..num_objects).filter(|&g| visible[g].iter().any(|&n| n > 0)).collect();
    let average =
        |value: &dyn Fn(usize) -> f64| people.iter().map(|&g| value(g)).sum::<f64>() / people.len().max(1) as f64;
    let tracked = |g: usize| {
        let visible_frames: Vec<usize> = (0..frames.len()).filter(|&t| visible[g][t] > 0).collect();
        let num_tracked = visible_frames.iter().filter(|&&t| table.keeps(g, &frames[t])).count();
        percent(num_tracked as u64, visible_frames.len() as u64)
    };
    let (wrong, points) = (0..num_objects).map(|g| table.wrong(g)).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    let error = |g: usize| {
        let (wrong, points) = table.wrong(g);
        if points == 0 { 100.0 } else { percent(wrong, points) }
    };
    let pixels: usize = labelled.iter().map(|l| l.1.data().len()).sum();
    Ok(Scores {
        density: percent(occupied(labelled, tracks), pixels as u64),
        clustering_error: percent(wrong, points),
        per_region_error: average(&error),
        oversegmentation: average(&|g| table.assigned_to(g).count().saturating_sub(1) as f64),
        recall: average(&|g| percent(covered[g], visible[g].iter().sum())),
        leakage: average(&|g| if table.leaks(g) { 100.0 } else { 0.0 }),
        tracking_time: average(&tracked),
        objects: people.len() as f64,
    })
}

/// Mean over sequences; the objects are summed.
pub fn mean(sequences: &[Scores]) -> Scores {
    let over = |value: fn(&Scores) -> f64| sequences.iter().map(value).sum::<f64>() / sequences.len().max(1) as f64;
    Scores {
        density: over(|s| s.density),
        clustering_error: over(|s| s.clustering_error),
        per_region_error: over(|s| s.per_region_error),
        oversegmentation: over(|s| s.oversegmentation),
        recall: over(|s| s.recall),
        leakage: over(|s| s.leakage),
        tracking_time: over(|s| s.tracking_time),
        objects: sequences.iter().map(|s| s.objects).sum(),
    }
}

fn check(labelled: &[(usize, &Plane<u8>)], tracks: &Trajectories) -> Result<(), Error> {
    let breach = |reason: String| Err(Error::Data { reason });
    if labelled.is_empty() {
        return breach("there is no labelled frame (expected at least 1)".to_owned());
    }
    for (frame, map) in labelled {
        if *frame >= tracks.num_frames {
            return breach(format!("frame {frame} is labelled (expected frames in 0..{})", tracks.num_frames));
        }
        if (map.width(), map.height()) != tracks.size {
            let size = (map.width(), map.height());
            return breach(format!("a mask of {size:?} pixels (expected {:?}, as the frames)", tracks.size));
        }
    }
    Ok(())
}

fn percent(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { 100.0 * part as f64 / whole as f64 }
}

/// Points of all labelled frames by object and cluster, and which cluster is whose.
struct Table {
    overlap: Vec<Vec<u64>>,
    /// The object of each cluster; `None` for those without a point.
    object: Vec<Option<usize>>,
}

impl Table {
    fn new(frames: &[Vec<Vec<u64>>], num_objects: usize, num_clusters: usize) -> Self {
        let at = |g: usize, c: usize| frames.iter().map(|f| f[g][c]).sum();
        let overlap: Vec<Vec<u64>> = (0..num_objects).map(|g| (0..num_clusters).map(|c| at(g, c)).collect()).collect();
        let most = |c: usize| {
            let best = (0..num_objects).fold(0, |best, g| if overlap[g][c] > overlap[best][c] { g } else { best });
            (overlap[best][c] > 0).then_some(best)
        };
        let object = (0..num_clusters).map(most).collect();
        Self { overlap, object }
    }

    fn assigned_to(&self, g: usize) -> impl Iterator<Item = usize> {
        (0..self.object.len()).filter(move |&c| self.object[c] == Some(g))
    }

    /// Points of object `g` in clusters of others, and all its points.
    fn wrong(&self, g: usize) -> (u64, u64) {
        let right: u64 = self.assigned_to(g).map(|c| self.overlap[g][c]).sum();
        let total = self.overlap[g].iter().sum();
        (total - right, total)
    }

    /// Returns true if most of the cluster that has most of `g` lies elsewhere.
    fn leaks(&self, g: usize) -> bool {
        let Some(best) = first_largest(0..self.object.len(), |c| self.overlap[g][c]) else { return true };
        let size: u64 = self.overlap.iter().map(|row| row[best]).sum();
        2 * self.overlap[g][best] < size || self.overlap[g][best] == 0
    }

    /// Returns true if most of the object's points in a frame are in its main cluster.
    fn keeps(&self, g: usize, frame: &[Vec<u64>]) -> bool {
        let total: u64 = frame[g].iter().sum();
        first_largest(self.assigned_to(g), |c| self.overlap[g][c]).is_some_and(|main| 2 * frame[g][main] > total)
    }
}

/// The item of the largest value, the first of equal ones.
fn first_largest(items: impl Iterator<Item = usize>, value: impl Fn(usize) -> u64) -> Option<usize> {
    items.reduce(|best, next| if value(next) > value(best) { next } else { best })
}

/// Pixels that carry a point.
fn occupied(labelled: &[(usize, &Plane<u8>)], tracks: &Trajectories) -> u64 {
    let mut count = 0;
    for (frame, map) in labelled {
        let mut is_occupied = vec![false; map.data().len()];
        for (_, x, y) in tracks.alive(*frame) {
            if let Some(pixel) = nearest_pixel(x, y, map.width(), map.height()) {
                count += u64::from(!std::mem::replace(&mut is_occupied[pixel], true));
            }
        }
    }
    count
}

/// Counts each object's pixels near points of its clusters, over all frames, and its pixels in each frame.
fn cover(
    labelled: &[(usize, &Plane<u8>)],
    tracks: &Trajectories,
    clusters: &Clusters,
    table: &Table,
    radius: f64,
) -> (Vec<u64>, Vec<Vec<u64>>) {
    let num_objects = table.overlap.len();
    let (mut covered, mut visible) = (vec![0; num_objects], vec![vec![0; labelled.len()]; num_objects]);
    for (t, (frame, map)) in labelled.iter().enumerate() {
        map.data().iter().for_each(|&g| visible[usize::from(g)][t] += 1);
        let mut is_covered = map.map(|_| false);
        for (i, x, y) in tracks.alive(*frame) {
            let (Some(pixel), Some(object)) =
                (nearest_pixel(x, y, map.width(), map.height()), table.object[clusters.label[i] as usize])
            else {
                continue;
            };
            for neighbour in disc(pixel, map.width(), map.height(), radius) {
                is_covered.data_mut()[neighbour] |= usize::from(map.data()[neighbour]) == object;
            }
        }
        for (&g, _) in map.data().iter().zip(is_covered.data()).filter(|(_, is_covered)| **is_covered) {
            covered[usize::from(g)] += 1;
        }
    }
    (covered, visible)
}

/// The pixels of an image whose centres are at most `radius` away from the centre of `pixel`.
fn disc(pixel: usize, width: usize, height: usize, radius: f64) -> impl Iterator<Item = usize> {
    let (x, y, reach) = (pixel % width, pixel / width, radius.max(0.0) as usize);
    let rows = y.saturating_sub(reach)..(y + reach + 1).min(height);
    rows.flat_map(move |v| (x.saturating_sub(reach)..(x + reach + 1).min(width)).map(move |u| (u, v)))
        .filter(move |&(u, v)| ((u.abs_diff(x).pow(2) + v.abs_diff(y).pow(2)) as f64) <= radius * radius)
        .map(move |(u, v)| v * width + u)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames drawn digit by digit, each with the labels of a point at each pixel; a dot is none. Points of the same
    /// place are one trajectory as long as their label stays.
    fn drawn(frames: &[[&str; 2]], radius: f64) -> Scores {
        let width = frames[0][0].len();
        let digits = |row: &str| row.bytes().map(|b| b - b'0').collect::<Vec<u8>>();
        let maps: Vec<Plane<u8>> = frames.iter().map(|f| Plane::from_vec(width, 1, digits(f[0])).unwrap()).collect();
        let mut tracks = Trajectories::empty(frames.len(), (width, 1));
        let mut label = Vec::new();
        for (t, frame) in frames.iter().enumerate() {
            for (x, b) in frame[1].bytes().enumerate().filter(|(_, b)| *b != b'.') {
                tracks.push(t, [(x as f32, 0.0, 0.0)]);
                label.push(u32::from(b - b'0'));
            }
        }
        let clusters = Clusters { count: label.iter().max().map_or(0, |&m| m as usize + 1), label };
        let labelled: Vec<_> = maps.iter().enumerate().collect();
        score(&labelled, &tracks, &clusters, radius).unwrap()
    }

    #[test]
    fn a_cluster_for_each_person_is_without_error() {
        let s = drawn(&[["00112200", "00112200"], ["01122000", "01122000"]], 0.0);
        let expected =
            Scores { density: 100.0, recall: 100.0, tracking_time: 100.0, objects: 2.0, ..Scores::default() };
        assert_eq!(s, expected);
    }

    #[test]
    fn one_cluster_for_two_people_goes_to_the_one_with_more_points() {
        // Cluster 1 has three points of object 1 and two of object 2.
        let s = drawn(&[["00011122", "00011111"]], 0.0);
        assert_eq!((s.clustering_error, s.per_region_error), (25.0, 50.0));
        assert_eq!((s.recall, s.tracking_time), (50.0, 50.0));
        // Object 1 has three fifths of the cluster, object 2 two.
        assert_eq!((s.leakage, s.oversegmentation), (50.0, 0.0));
    }

    #[test]
    fn a_person_in_pieces_is_over_segmented_and_keeps_its_largest_piece_only() {
        // Object 1 is in clusters 1 (5 points), 2 (3 points); in the second frame cluster 2 has most of it.
        let s = drawn(&[["00111111", "00111112"], ["00111000", "00.22000"]], 0.0);
        assert_eq!((s.oversegmentation, s.clustering_error, s.leakage), (1.0, 0.0, 0.0));
        assert_eq!((s.tracking_time, s.objects), (50.0, 1.0));
        // One pixel of 16 has no point: it is one of nine of the object.
        assert_eq!((s.density, s.recall), (100.0 * 15.0 / 16.0, 100.0 * 8.0 / 9.0));
    }

    #[test]
    fn half_of_a_persons_points_are_not_most_of_them() {
        assert_eq!(drawn(&[["001111", "001122"]], 0.0).tracking_time, 0.0);
        assert_eq!(drawn(&[["001110", "001120"]], 0.0).tracking_time, 100.0);
    }

    #[test]
    fn points_cover_a_disc_but_only_of_their_own_object() {
        for (radius, recall) in [(0.0, 20.0), (1.0, 60.0), (1.9, 60.0), (2.0, 80.0), (3.0, 100.0), (50.0, 100.0)] {
            assert_eq!(drawn(&[["0011111000", "...1.....0"]], radius).recall, recall, "{radius}");
        }
        // The other person's point covers nothing of this one, nor does this one's beyond its own pixels.
        let s = drawn(&[["1111222", "...1..2"]], 3.0);
        assert_eq!(s.recall, 100.0);
        assert_eq!(drawn(&[["1111222", "...1..."]], 9.0).recall, 50.0);
        assert_eq!(disc(0, 3, 3, 1.5).collect::<Vec<_>>(), [0, 1, 3, 4]);
        assert_eq!(disc(4, 3, 3, 1.0).collect::<Vec<_>>(), [1, 3, 4, 5, 7]);
    }

    #[test]
    fn people_without_points_are_all_wrong_and_those_not_shown_do_not_count() {
        // Object 2 never appears, object 3 has no points.
        let s = drawn(&[["00113300", "0011..00"]], 0.0);
        assert_eq!((s.objects, s.per_region_error, s.leakage), (2.0, 50.0, 50.0));
        assert_eq!((s.clustering_error, s.recall, s.tracking_time), (0.0, 50.0, 50.0));
        let none = drawn(&[["0011", "...."]], 1.0);
        let expected = Scores { per_region_error: 100.0, leakage: 100.0, objects: 1.0, ..Scores::default() };
        assert_eq!(none, expected);
        assert_eq!(drawn(&[["0000", "0000"]], 1.0), Scores { density: 100.0, ..Scores::default() });
    }

    #[test]
    fn masks_that_do_not_fit_are_refused() {
        let tracks = Trajectories::empty(3, (4, 2));
        let (good, wide) = (Plane::filled(4, 2, 0_u8), Plane::filled(5, 2, 0_u8));
        let of = |labelled: &[(usize, &Plane<u8>)]| score(labelled, &tracks, &Clusters::default(), 1.0);
        assert!(of(&[(0, &good), (2, &good)]).is_ok());
        assert!(of(&[]).unwrap_err().to_string().contains("no labelled frame"));
        assert!(of(&[(3, &good)]).unwrap_err().to_string().contains("frame 3"));
        assert!(of(&[(0, &wide)]).unwrap_err().to_string().contains("(5, 2)"));
    }

    #[test]
    fn means_weigh_sequences_alike_and_objects_add_up() {
        let of = |recall, objects| Scores { recall, objects, ..Scores::default() };
        assert_eq!(mean(&[of(20.0, 2.0), of(40.0, 8.0)]), of(30.0, 10.0));
        assert_eq!(mean(&[]), Scores::default());
    }
}
