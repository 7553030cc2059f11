//! How well the foreground among trajectories matches the foreground of labelled frames.
//!
//! **In:** the region map of each labelled frame, trajectories in pixels of these maps, and which of them are
//! foreground. **Out:** [`ForegroundScores`]; over many shots their [`mean`].
//!
//! Region 0 is the background, whatever its size: so it is in every definition file that the Moseg benchmark publishes
//! (its grey value is 0, the one that unnamed grey values count as). All others are foreground, things that stand in
//! front of an object included.
//!
//! Each trajectory alive in a labelled frame is one point, at its nearest pixel; the points of all labelled frames of
//! a shot are counted together, so that a frame's weight is its number of trajectories.

use super::definition::Definition;
use serde::Serialize;
use tracecut::Error;
use tracecut::image::Plane;
use tracecut::trajectory::Trajectories;

/// Agreement of the foreground of one shot with the truth; each in `0.0..=1.0`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ForegroundScores {
    /// Points that are foreground in both, by those that are in either; 1 if there are none.
    pub iou: f64,
    /// Points of the true foreground that were found; 1 if there are none.
    pub recall: f64,
    /// Points of the true background that were taken for foreground; 0 if there are none.
    pub false_alarms: f64,
}

/// Scores `foreground`, one value for each of `tracks`, against `maps`, the region map of each labelled frame within
/// `tracks.num_frames` in the definition's order.
///
/// # Errors
/// [`Error::Data`] when the number of maps or of values does not fit.
pub fn score(
    definition: &Definition,
    maps: &[Plane<u8>],
    tracks: &Trajectories,
    foreground: &[bool],
) -> Result<ForegroundScores, Error> {
    let frames: Vec<usize> = definition.labelled_within(tracks.num_frames).map(|f| f.index).collect();
    if maps.len() != frames.len() || foreground.len() != tracks.len() {
        let reason = format!(
            "{} region maps and {} values of foreground (expected {} and {})",
            maps.len(),
            foreground.len(),
            frames.len(),
            tracks.len()
        );
        return Err(Error::Data { reason });
    }
    // counts[found][true]
    let mut counts = [[0_u64; 2]; 2];
    for (&frame, map) in frames.iter().zip(maps) {
        for (i, x, y) in tracks.alive(frame) {
            // Casts saturate at 0.
            let (x, y) = ((x + 0.5) as usize, (y + 0.5) as usize);
            if x < map.width() && y < map.height() {
                counts[usize::from(foreground[i])][usize::from(map[(x, y)] != 0)] += 1;
            }
        }
    }
    let [[_, missed], [wrong, right]] = counts;
    let share = |part: u64, total: u64, of_none: f64| if total == 0 { of_none } else { part as f64 / total as f64 };
    Ok(ForegroundScores {
        iou: share(right, right + wrong + missed, 1.0),
        recall: share(right, right + missed, 1.0),
        false_alarms: share(wrong, wrong + counts[0][0], 0.0),
    })
}

/// Mean over shots, each counting the same; of none, zero.
pub fn mean(shots: &[ForegroundScores]) -> ForegroundScores {
    let over = |value: fn(&ForegroundScores) -> f64| shots.iter().map(value).sum::<f64>() / shots.len().max(1) as f64;
    ForegroundScores { iou: over(|s| s.iou), recall: over(|s| s.recall), false_alarms: over(|s| s.false_alarms) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measures::definition::LabelledFrame;

    /// A shot of one frame of 4 x 2 pixels whose right half is region 2, with a trajectory at every pixel.
    fn shot() -> (Definition, Vec<Plane<u8>>, Trajectories) {
        let definition = Definition {
            grey: vec![0, 1, 2],
            penalty: vec![vec![0.0; 3]; 3],
            num_frames: 1,
            labelled: vec![LabelledFrame { index: 0, mask: String::new(), image: String::new() }],
        };
        let map = Plane::from_fn(4, 2, |x, _| if x < 2 { 0 } else { 2 });
        let mut tracks = Trajectories::empty(1, (4, 2));
        for i in 0..8 {
            tracks.push(0, [((i % 4) as f32 + 0.4, (i / 4) as f32 - 0.4, 0.0)]);
        }
        (definition, vec![map], tracks)
    }

    #[test]
    fn points_are_counted_by_what_they_are_and_what_they_were_taken_for() {
        let (definition, maps, tracks) = shot();
        // Three of four points of the object, one of four points of the background.
        let foreground = [true, false, true, true, false, false, true, false];
        let scores = score(&definition, &maps, &tracks, &foreground).unwrap();
        assert_eq!(scores, ForegroundScores { iou: 3.0 / 5.0, recall: 0.75, false_alarms: 0.25 });
    }

    #[test]
    fn the_truth_scores_1_and_without_any_foreground_nothing_is_missed() {
        let (definition, maps, tracks) = shot();
        let truth: Vec<bool> = (0..8).map(|i| i % 4 >= 2).collect();
        let perfect = ForegroundScores { iou: 1.0, recall: 1.0, false_alarms: 0.0 };
        assert_eq!(score(&definition, &maps, &tracks, &truth).unwrap(), perfect);
        let empty = vec![Plane::filled(4, 2, 0)];
        assert_eq!(score(&definition, &empty, &tracks, &[false; 8]).unwrap(), perfect);
    }

    #[test]
    fn counts_that_do_not_fit_are_an_error() {
        let (definition, maps, tracks) = shot();
        assert!(score(&definition, &[], &tracks, &[false; 8]).is_err());
        assert!(score(&definition, &maps, &tracks, &[false; 7]).is_err());
    }

    #[test]
    fn shots_count_the_same_in_the_mean() {
        let shot = |v: f64| ForegroundScores { iou: v, recall: v, false_alarms: 1.0 - v };
        assert_eq!(mean(&[shot(1.0), shot(0.5)]), ForegroundScores { iou: 0.75, recall: 0.75, false_alarms: 0.25 });
        assert_eq!(mean(&[]).iou, 0.0);
    }
}
