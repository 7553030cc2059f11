//! The Moseg benchmark's numbers (Brox and Malik, ECCV 2010) for labelled trajectories or pixels against labelled
//! frames.
//!
//! **In:** the shot's definition, the region map of each labelled frame used, and in pixels of those maps labelled
//! trajectories, or a label for each pixel. **Out:** [`Scores`]; over many shots their [`mean`] and [`trimmed_mean`].
//!
//! 1. Each trajectory alive in a labelled frame votes there, at its nearest pixel, for the pair of that pixel's
//!    region and the trajectory's cluster: `overlap[region][cluster]`. Two on one pixel are a *double occupation*.
//! 2. Each region takes the cluster that covers most of it; several regions may take the same one (under-segmentation).
//! 3. Each cluster with any vote stands for one region: of the regions that took it the one it covers most; if none
//!    took it, the region of most of its votes, and it counts as one over-segmentation. Its votes in that region are
//!    right, its votes in any other region are errors *of that other region*.
//! 4. Density is the share of the labelled frames' pixels that carry a vote. The overall error is the share of wrong
//!    votes, each weighted by the definition's penalty. A region's error is the share of its votes that are wrong, 100
//!    % if none is right; the average runs over the regions visible in the labelled frames used. Extracted objects are
//!    the regions with an error below 10 %, less one for the background.
//!
//! Labels of pixels are scored as if each pixel were a trajectory that lives in its frame only ([`score_dense`]); the
//! published program has no other way to score them. Their density is 100 %.
//!
//! The published program compares where it means to assign, so that a track file as long as the whole shot is scored on
//! all labelled frames and one of 10, 50 or 200 frames on those up to that number. Here a file of any length is scored
//! on the labelled frames within its length, which is the same for both.

use super::definition::Definition;
use serde::Serialize;
use tracecut::Error;
use tracecut::discretize::Clusters;
use tracecut::image::Plane;
use tracecut::trajectory::Trajectories;

/// A region counts as extracted when its error is below this, in percent (Brox and Malik 2010).
const EXTRACTED_BELOW: f64 = 10.0;

/// In a region map: a pixel that is not scored.
pub const UNSCORED: u8 = u8::MAX;

/// The benchmark's scores of one shot.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scores {
    /// Pixels of the labelled frames that carry a trajectory, in percent.
    pub density: f64,
    /// Wrong votes weighted by their penalty, in percent of all; 0 without votes.
    pub overall: f64,
    /// Mean of the visible regions' errors, in percent.
    pub average: f64,
    /// Clusters that no region took.
    pub oversegmentation: f64,
    /// Regions with an error below 10 %, the background not counted.
    pub extracted: f64,
    /// Regions that appear in the labelled frames used.
    pub visible: f64,
    /// Labelled frames used.
    pub labeled: f64,
}

/// Scores `tracks` with labels `clusters` against `maps`, the region map of each labelled frame within
/// `tracks.num_frames` in the definition's order. Points on [`UNSCORED`] pixels have no vote.
///
/// # Errors
/// [`Error::Data`] when the maps' number or size does not fit, or when the tracks are longer than the shot.
pub fn score(
    definition: &Definition,
    maps: &[Plane<u8>],
    tracks: &Trajectories,
    clusters: &Clusters,
) -> Result<Scores, Error> {
    let frames: Vec<usize> = definition.labelled_within(tracks.num_frames).map(|f| f.index).collect();
    check(definition, maps, tracks.num_frames, frames.len())?;
    let mut votes = Votes::new(definition.num_regions(), clusters.count);
    for (&frame, map) in frames.iter().zip(maps) {
        votes.add_tracks(map, frame, tracks, clusters);
    }
    Ok(conclude(definition, &votes, maps))
}

/// Computes the mean intersection over union of each object's points with its best cluster, over all regions with a point
/// but the first, the background; `None` without one. A fragmented object scores low here, which only the
/// over-segmentation of [`Scores`] shows. Inputs as in [`score`].
///
/// # Errors
/// As [`score`].
pub fn best_clusters(
    definition: &Definition,
    maps: &[Plane<u8>],
    tracks: &Trajectories,
    clusters: &Clusters,
) -> Result<Option<f64>, Error> {
    let overlap = overlap_of(definition, maps, tracks, clusters)?;
    let of_cluster = |c: usize| overlap.iter().map(|row| row[c]).sum::<u64>();
    let best = |row: &Vec<u64>| {
        let total = row.iter().sum::<u64>();
        let iou = |(c, &both): (usize, &u64)| both as f64 / (total + of_cluster(c) - both).max(1) as f64;
        (total > 0).then(|| row.iter().enumerate().map(iou).fold(0.0, f64::max))
    };
    let values: Vec<f64> = overlap.iter().skip(1).filter_map(best).collect();
    Ok((!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64))
}

/// `overlap[region][cluster]`: how many points each region and cluster have in common in the labelled frames. Inputs as
/// in [`score`].
///
/// # Errors
/// As [`score`].
pub fn overlap_of(
    definition: &Definition,
    maps: &[Plane<u8>],
    tracks: &Trajectories,
    clusters: &Clusters,
) -> Result<Vec<Vec<u64>>, Error> {
    let frames: Vec<usize> = definition.labelled_within(tracks.num_frames).map(|f| f.index).collect();
    check(definition, maps, tracks.num_frames, frames.len())?;
    let mut votes = Votes::new(definition.num_regions(), clusters.count);
    for (frame, map) in frames.into_iter().zip(maps) {
        votes.add_tracks(map, frame, tracks, clusters);
    }
    Ok(votes.overlap)
}

/// Scores `labels`, the plane of pixel labels of each labelled frame within the first `num_frames` frames, against
/// `maps`, their region maps, both in the definition's order. Labels are in `0..num_labels`; 0 is a label as any other.
///
/// # Errors
/// [`Error::Data`] when the number or size of maps and planes does not fit, when a label is too large, or when the clip
/// is longer than the shot.
pub fn score_dense(
    definition: &Definition,
    maps: &[Plane<u8>],
    labels: &[Plane<u32>],
    num_labels: usize,
    num_frames: usize,
) -> Result<Scores, Error> {
    check(definition, maps, num_frames, definition.labelled_within(num_frames).count())?;
    check_labels(maps, labels, num_labels)?;
    let mut votes = Votes::new(definition.num_regions(), num_labels);
    for (map, labels) in maps.iter().zip(labels) {
        votes.add_pixels(map, labels);
    }
    Ok(conclude(definition, &votes, maps))
}

/// Mean over shots. Overall error and over-segmentation are over shots of positive density; extracted objects are
/// summed.
pub fn mean(shots: &[Scores]) -> Scores {
    combine(shots, |values| values.iter().sum::<f64>() / values.len().max(1) as f64)
}

/// As [`mean`], but of each number the lowest and the highest 10 % (rounded to a whole number of shots) are left out.
pub fn trimmed_mean(shots: &[Scores]) -> Scores {
    combine(shots, |values| trimmed(values.to_vec()).unwrap_or_default())
}

/// Computes the mean without the lowest and the highest 10 % (rounded to a whole number); `None` without values.
pub fn trimmed(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let cut = (values.len() as f64 / 10.0).round() as usize;
    let middle = &values[cut..values.len() - cut];
    (!middle.is_empty()).then(|| middle.iter().sum::<f64>() / middle.len() as f64)
}

fn combine(shots: &[Scores], average: impl Fn(&mut [f64]) -> f64) -> Scores {
    let over = |value: fn(&Scores) -> f64, only_dense: bool| {
        let mut values: Vec<f64> = shots.iter().filter(|s| s.density > 0.0 || !only_dense).map(value).collect();
        average(&mut values)
    };
    Scores {
        density: over(|s| s.density, false),
        overall: over(|s| s.overall, true),
        average: over(|s| s.average, false),
        oversegmentation: over(|s| s.oversegmentation, true),
        extracted: shots.iter().map(|s| s.extracted).sum(),
        visible: shots.iter().map(|s| s.visible).sum(),
        labeled: shots.iter().map(|s| s.labeled).sum(),
    }
}

fn breach(reason: String) -> Result<(), Error> {
    Err(Error::Data { reason })
}

fn check(definition: &Definition, maps: &[Plane<u8>], num_frames: usize, num_used: usize) -> Result<(), Error> {
    if num_frames > definition.num_frames {
        return breach(format!(
            "the labels run over {num_frames} frames (expected at most {}, the length of the shot)",
            definition.num_frames
        ));
    }
    if num_used == 0 || maps.len() != num_used {
        return breach(format!(
            "{} region maps for {num_used} labelled frames in the first {num_frames} (expected one for each, at least 1)",
            maps.len()
        ));
    }
    let size = |map: &Plane<u8>| (map.width(), map.height());
    if let Some(other) = maps.iter().find(|m| size(m) != size(&maps[0])) {
        return breach(format!("masks of {:?} and {:?} pixels (expected one size)", size(&maps[0]), size(other)));
    }
    match maps.iter().flat_map(|m| m.data()).find(|&&r| r != UNSCORED && r as usize >= definition.num_regions()) {
        Some(region) => breach(format!("region {region} in a map (expected 0..{})", definition.num_regions())),
        None => Ok(()),
    }
}

fn check_labels(maps: &[Plane<u8>], labels: &[Plane<u32>], num_labels: usize) -> Result<(), Error> {
    if labels.len() != maps.len() {
        return breach(format!("{} planes of labels (expected {}, one for each map)", labels.len(), maps.len()));
    }
    for (labels, map) in labels.iter().zip(maps) {
        let (size, expected) = ((labels.width(), labels.height()), (map.width(), map.height()));
        if size != expected {
            return breach(format!("a plane of labels of {size:?} pixels (expected {expected:?}, as the masks are)"));
        }
    }
    match labels.iter().flat_map(|l| l.data()).find(|&&l| l as usize >= num_labels) {
        Some(label) => breach(format!("label {label} (expected 0..{num_labels})")),
        None => Ok(()),
    }
}

struct Votes {
    /// `overlap[region][cluster]`.
    overlap: Vec<Vec<u64>>,
    num_clusters: usize,
    double: u64,
}

impl Votes {
    fn new(num_regions: usize, num_clusters: usize) -> Self {
        Self { overlap: vec![vec![0; num_clusters]; num_regions], num_clusters, double: 0 }
    }

    /// Step 1 for one labelled frame.
    fn add_tracks(&mut self, map: &Plane<u8>, frame: usize, tracks: &Trajectories, clusters: &Clusters) {
        let mut is_occupied = map.map(|_| false);
        for (i, x, y) in tracks.alive(frame) {
            let Some(pixel) = nearest_pixel(x, y, map.width(), map.height()) else { continue };
            if map.data()[pixel] == UNSCORED {
                continue;
            }
            self.overlap[map.data()[pixel] as usize][clusters.label[i] as usize] += 1;
            self.double += u64::from(is_occupied.data()[pixel]);
            is_occupied.data_mut()[pixel] = true;
        }
    }

    /// Step 1 for one labelled frame whose every pixel votes.
    fn add_pixels(&mut self, map: &Plane<u8>, labels: &Plane<u32>) {
        for (&region, &label) in map.data().iter().zip(labels.data()).filter(|(region, _)| **region != UNSCORED) {
            self.overlap[region as usize][label as usize] += 1;
        }
    }
}

/// Steps 2 to 4.
fn conclude(definition: &Definition, votes: &Votes, maps: &[Plane<u8>]) -> Scores {
    let visible = visible_regions(definition.num_regions(), maps);
    let assignment = assign(&votes.overlap, votes.num_clusters);
    summarize(definition, votes, &visible, &assignment, maps)
}

/// Index of the pixel nearest to `(x, y)`, if it is inside. As in the published program the rounding is towards zero
/// after adding one half, so that points up to 1.5 pixels left of or above the image still vote in its first column or
/// row.
fn nearest_pixel(x: f32, y: f32, width: usize, height: usize) -> Option<usize> {
    let (x, y) = ((f64::from(x) + 0.5).trunc(), (f64::from(y) + 0.5).trunc());
    let inside = x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64;
    inside.then(|| y as usize * width + x as usize)
}

/// Marks the regions that appear in any of the maps.
fn visible_regions(num_regions: usize, maps: &[Plane<u8>]) -> Vec<bool> {
    let mut visible = vec![false; num_regions];
    for &region in maps.iter().flat_map(|m| m.data()).filter(|&&region| region != UNSCORED) {
        visible[region as usize] = true;
    }
    visible
}

/// The region that a cluster is assigned to.
struct Assignment {
    region: usize,
    over_segmented: bool,
}

/// Steps 2 and 3: for each cluster its region; `None` for clusters without a vote.
fn assign(overlap: &[Vec<u64>], num_clusters: usize) -> Vec<Option<Assignment>> {
    let largest = |values: &mut dyn Iterator<Item = (usize, u64)>| {
        values.reduce(|best, next| if next.1 > best.1 { next } else { best }).filter(|best| best.1 > 0)
    };
    let assigned_cluster: Vec<Option<usize>> =
        overlap.iter().map(|row| largest(&mut row.iter().copied().enumerate()).map(|(cluster, _)| cluster)).collect();
    let column = |cluster: usize| overlap.iter().map(move |row| row[cluster]).enumerate();
    (0..num_clusters)
        .map(|cluster| {
            let takers = largest(&mut column(cluster).filter(|&(region, _)| assigned_cluster[region] == Some(cluster)));
            let majority = largest(&mut column(cluster))?;
            Some(Assignment { region: takers.unwrap_or(majority).0, over_segmented: takers.is_none() })
        })
        .collect()
}

/// Step 4.
fn summarize(
    definition: &Definition,
    votes: &Votes,
    visible: &[bool],
    assignment: &[Option<Assignment>],
    maps: &[Plane<u8>],
) -> Scores {
    let num_regions = definition.num_regions();
    let (mut right, mut wrong) = (vec![0_u64; num_regions], vec![0_u64; num_regions]);
    let mut penalty = 0.0;
    for (cluster, assigned) in assignment.iter().enumerate() {
        let Some(assigned) = assigned else { continue };
        for (region, row) in votes.overlap.iter().enumerate() {
            if region == assigned.region {
                right[region] += row[cluster];
            } else {
                wrong[region] += row[cluster];
                penalty += row[cluster] as f64 * definition.penalty[assigned.region][region];
            }
        }
    }
    let total: u64 = right.iter().chain(&wrong).sum();
    let percent = |part: f64, total: u64| if total == 0 { 0.0 } else { 100.0 * part / total as f64 };
    let error = |r: usize| if right[r] == 0 { 100.0 } else { percent(wrong[r] as f64, right[r] + wrong[r]) };
    let num_visible = visible.iter().filter(|&&v| v).count();
    let average = (0..num_regions).filter(|&r| visible[r]).map(error).sum::<f64>() / num_visible.max(1) as f64;
    let extracted = (0..num_regions).filter(|&r| error(r) < EXTRACTED_BELOW).count().saturating_sub(1);
    let pixels: u64 = maps.iter().map(|m| m.data().len() as u64).sum();
    Scores {
        density: percent((total - votes.double) as f64, pixels),
        overall: percent(penalty, total),
        average,
        oversegmentation: assignment.iter().flatten().filter(|a| a.over_segmented).count() as f64,
        extracted: extracted as f64,
        visible: num_visible as f64,
        labeled: maps.len() as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::definition::LabelledFrame;

    /// A shot of one labelled frame whose regions `rows` draws, digit by digit.
    fn shot(num_regions: usize, rows: [&str; 4]) -> (Definition, Vec<Plane<u8>>) {
        let definition = Definition {
            grey: (0..num_regions as u8).collect(),
            penalty: (0..num_regions)
                .map(|a| (0..num_regions).map(|b| f64::from(u8::from(a != b))).collect())
                .collect(),
            num_frames: 1,
            labelled: vec![LabelledFrame { index: 0, mask: String::new(), image: String::new() }],
        };
        let data = rows.iter().flat_map(|row| row.bytes().map(|b| b - b'0')).collect();
        (definition, vec![Plane::from_vec(4, 4, data).unwrap()])
    }

    /// One point for each `(x, y, label)`.
    fn tracks(points: &[(f32, f32, u32)]) -> (Trajectories, Clusters) {
        let mut tracks = Trajectories::empty(1, (4, 4));
        for &(x, y, _) in points {
            tracks.push(0, [(x, y, 0.0)]);
        }
        let label: Vec<u32> = points.iter().map(|p| p.2).collect();
        (tracks, Clusters { count: label.iter().max().map_or(0, |&m| m as usize + 1), label })
    }

    /// A point at every pixel, labelled as `rows` draws; a dot is no point.
    fn drawn(rows: [&str; 4]) -> (Trajectories, Clusters) {
        let mut points = Vec::new();
        for (y, row) in rows.iter().enumerate() {
            for (x, digit) in row.bytes().enumerate().filter(|(_, digit)| *digit != b'.') {
                points.push((x as f32, y as f32, u32::from(digit - b'0')));
            }
        }
        tracks(&points)
    }

    const LEFT_RIGHT: [&str; 4] = ["0011", "0011", "0011", "0011"];

    fn scored(num_regions: usize, regions: [&str; 4], (tracks, clusters): (Trajectories, Clusters)) -> Scores {
        let (definition, maps) = shot(num_regions, regions);
        score(&definition, &maps, &tracks, &clusters).unwrap()
    }

    #[test]
    fn perfect_labels_have_no_error_whatever_their_numbers() {
        let scores = scored(2, LEFT_RIGHT, drawn(["1100", "1100", "1100", "1100"]));
        let perfect = Scores {
            density: 100.0,
            overall: 0.0,
            average: 0.0,
            oversegmentation: 0.0,
            extracted: 1.0,
            visible: 2.0,
            labeled: 1.0,
        };
        assert_eq!(scores, perfect);
    }

    #[test]
    fn one_cluster_for_two_regions_is_wrong_in_the_smaller() {
        // 6 of 10 points in region 0: region 1 has no right point.
        let scores = scored(2, LEFT_RIGHT, drawn(["0000", "0000", "00..", "...."]));
        assert_eq!((scores.overall, scores.average, scores.oversegmentation), (40.0, 50.0, 0.0));
        assert_eq!((scores.extracted, scores.density), (0.0, 62.5));
    }

    #[test]
    fn a_cluster_that_no_region_takes_is_one_over_segmentation_without_error() {
        let scores = scored(2, LEFT_RIGHT, drawn(["0011", "0011", "0011", "0211"]));
        assert_eq!((scores.overall, scores.average, scores.oversegmentation), (0.0, 0.0, 1.0));
        assert_eq!(scores.extracted, 1.0);
    }

    #[test]
    fn points_across_the_border_are_errors_of_the_region_they_lie_in() {
        // One of region 1's eight points carries region 0's cluster.
        let scores = scored(2, LEFT_RIGHT, drawn(["0001", "0011", "0011", "0011"]));
        assert_eq!((scores.overall, scores.average), (100.0 / 16.0, 100.0 / 8.0 / 2.0));
        assert_eq!(scores.extracted, 0.0);
    }

    #[test]
    fn a_visible_region_without_a_point_is_wholly_wrong_and_an_invisible_one_does_not_count() {
        let scores = scored(3, LEFT_RIGHT, drawn(["00..", "00..", "00..", "00.."]));
        assert_eq!((scores.overall, scores.average, scores.visible), (0.0, 50.0, 2.0));
        assert_eq!(scores.oversegmentation, 0.0);
    }

    #[test]
    fn the_best_cluster_of_an_object_loses_what_other_clusters_hold_of_it() {
        let best = |rows: [&str; 4]| {
            let (definition, maps) = shot(2, LEFT_RIGHT);
            let (tracks, clusters) = drawn(rows);
            best_clusters(&definition, &maps, &tracks, &clusters).unwrap()
        };
        assert_eq!(best(LEFT_RIGHT), Some(1.0));
        assert_eq!(best(["0011", "0011", "0022", "0022"]), Some(0.5));
        // Of ten points of the cluster eight are the object's.
        assert_eq!(best(["1011", "1011", "0011", "0011"]), Some(0.8));
        assert_eq!(best(["00..", "00..", "00..", "00.."]), None);
    }

    #[test]
    fn points_on_pixels_that_are_not_scored_have_no_vote() {
        let (definition, mut maps) = shot(2, LEFT_RIGHT);
        maps[0].data_mut()[..4].fill(UNSCORED);
        let (tracks, clusters) = drawn(["1100", "0011", "0011", "0011"]);
        let scores = score(&definition, &maps, &tracks, &clusters).unwrap();
        assert_eq!((scores.overall, scores.average, scores.extracted), (0.0, 0.0, 1.0));
        let dense = score_dense(&definition, &maps, &[painted(["1100", "0011", "0011", "0011"])], 2, 1).unwrap();
        assert_eq!((dense.overall, dense.average), (0.0, 0.0));
    }

    #[test]
    fn two_points_on_a_pixel_count_once_in_density_and_twice_in_errors() {
        let scores = scored(2, LEFT_RIGHT, tracks(&[(0.0, 0.0, 0), (0.49, 0.49, 0), (3.0, 3.0, 1), (2.0, 2.0, 0)]));
        assert_eq!(scores.density, 100.0 * 3.0 / 16.0);
        assert_eq!((scores.overall, scores.average), (25.0, 25.0));
    }

    #[test]
    fn points_vote_at_their_nearest_pixel_and_not_outside() {
        for (x, votes) in [(3.49, 1), (3.5, 0), (-0.5, 1), (-1.49, 1), (-1.5, 0), (f32::MAX, 0)] {
            assert_eq!(nearest_pixel(x, 0.0, 4, 4).iter().len(), votes, "x = {x}");
            assert_eq!(nearest_pixel(0.0, x, 4, 4).iter().len(), votes, "y = {x}");
        }
        assert_eq!(nearest_pixel(1.5, 2.49, 4, 4), Some(10));
    }

    #[test]
    fn penalties_weigh_the_overall_error_only() {
        let (mut definition, maps) = shot(2, LEFT_RIGHT);
        definition.penalty = vec![vec![0.0, 0.5], vec![0.25, 0.0]];
        let (tracks, clusters) = drawn(["0001", "0011", "0011", "0011"]);
        let scores = score(&definition, &maps, &tracks, &clusters).unwrap();
        assert_eq!((scores.overall, scores.average), (50.0 / 16.0, 6.25));
    }

    #[test]
    fn no_tracks_leave_every_visible_region_wrong() {
        let scores = scored(2, LEFT_RIGHT, tracks(&[]));
        assert_eq!((scores.density, scores.overall, scores.average, scores.extracted), (0.0, 0.0, 100.0, 0.0));
    }

    #[test]
    fn maps_and_tracks_that_do_not_fit_are_refused() {
        let (definition, maps) = shot(2, LEFT_RIGHT);
        let (mut tracks, clusters) = drawn(LEFT_RIGHT);
        assert!(score(&definition, &[], &tracks, &clusters).unwrap_err().to_string().contains("0 region maps for 1"));
        let bad = [Plane::filled(4, 4, 2)];
        assert!(score(&definition, &bad, &tracks, &clusters).unwrap_err().to_string().contains("region 2 in a map"));
        tracks.num_frames = 2;
        assert!(score(&definition, &maps, &tracks, &clusters).unwrap_err().to_string().contains("at most 1"));
    }

    /// Labels of pixels as `drawn` draws them.
    fn painted(rows: [&str; 4]) -> Plane<u32> {
        let data = rows.iter().flat_map(|row| row.bytes().map(|b| u32::from(b - b'0'))).collect();
        Plane::from_vec(4, 4, data).unwrap()
    }

    #[test]
    fn labels_of_pixels_score_as_a_trajectory_at_each_pixel() {
        for rows in [
            LEFT_RIGHT,
            ["1100", "1100", "1100", "1100"],
            ["0000", "0000", "0000", "0000"],
            ["0012", "0012", "0311", "4511"],
            ["0101", "2323", "1010", "7777"],
        ] {
            for regions in [LEFT_RIGHT, ["0000", "0110", "0220", "0000"]] {
                let (mut definition, maps) = shot(3, regions);
                definition.penalty[1][2] = 0.25;
                let (tracks, clusters) = drawn(rows);
                let sparse = score(&definition, &maps, &tracks, &clusters).unwrap();
                let dense = score_dense(&definition, &maps, &[painted(rows)], clusters.count, 1).unwrap();
                assert_eq!(dense, sparse, "{rows:?} on {regions:?}");
                assert_eq!(dense.density, 100.0);
                // Labels without a pixel change nothing.
                assert_eq!(score_dense(&definition, &maps, &[painted(rows)], 40, 1).unwrap(), dense);
            }
        }
    }

    #[test]
    fn labels_of_pixels_are_counted_over_all_labelled_frames() {
        let (mut definition, mut maps) = shot(2, LEFT_RIGHT);
        definition.num_frames = 10;
        definition.labelled.push(LabelledFrame { index: 9, mask: String::new(), image: String::new() });
        maps.push(maps[0].map(|region| 1 - region));
        let labels = [painted(LEFT_RIGHT), painted(LEFT_RIGHT)];
        // The second frame is wrong throughout.
        let scores = score_dense(&definition, &maps, &labels, 2, 10).unwrap();
        assert_eq!((scores.overall, scores.average, scores.labeled), (50.0, 50.0, 2.0));
        let first = score_dense(&definition, &maps[..1], &labels[..1], 2, 9).unwrap();
        assert_eq!((first.overall, first.labeled), (0.0, 1.0));
    }

    #[test]
    fn planes_of_labels_that_do_not_fit_are_refused() {
        let (definition, maps) = shot(2, LEFT_RIGHT);
        let refusal = |labels: &[Plane<u32>], num_labels, num_frames| {
            score_dense(&definition, &maps, labels, num_labels, num_frames).unwrap_err().to_string()
        };
        assert!(refusal(&[], 2, 1).contains("0 planes of labels (expected 1"));
        assert!(refusal(&[Plane::filled(4, 3, 0)], 2, 1).contains("(4, 3)"));
        assert!(refusal(&[painted(LEFT_RIGHT)], 1, 1).contains("label 1 (expected 0..1)"));
        assert!(refusal(&[painted(LEFT_RIGHT)], 2, 2).contains("at most 1"));
    }

    #[test]
    fn trimmed_mean_drops_the_extremes_of_each_number_and_still_sums_objects() {
        let shots: Vec<Scores> = (0..13)
            .map(|i| Scores {
                density: 1.0,
                overall: f64::from(i) * 2.0,
                average: if i == 5 { 1300.0 } else { 0.0 },
                oversegmentation: 1.0,
                extracted: 1.0,
                visible: 2.0,
                labeled: 3.0,
            })
            .collect();
        let (all, trimmed) = (mean(&shots), trimmed_mean(&shots));
        assert_eq!((all.overall, all.average, all.extracted), (12.0, 100.0, 13.0));
        assert_eq!((trimmed.overall, trimmed.average, trimmed.extracted), (12.0, 0.0, 13.0));
        // Four shots: nothing to drop.
        assert_eq!(trimmed_mean(&shots[..4]).overall, 3.0);
        assert_eq!(trimmed_mean(&[]).overall, 0.0);
    }

    #[test]
    fn shots_without_points_count_in_density_and_region_error_only() {
        let (with, without) = (scored(2, LEFT_RIGHT, drawn(LEFT_RIGHT)), scored(2, LEFT_RIGHT, tracks(&[])));
        let both = mean(&[with, without]);
        assert_eq!((both.density, both.overall, both.average), (50.0, 0.0, 50.0));
    }
}
