//! The appearance of objects, to recognise them when they return.
//!
//! In: the trajectories of a window with their objects, and its frames. Out: for each object the histogram of the colours
//! along its trajectories and its last position; two appearances are compared by both. Not in the paper.

use crate::cut::{Colour, Histogram};
use crate::image::Frame;
use crate::objects::Objects;
use crate::trajectory::Trajectories;
use serde::{Deserialize, Serialize};

/// Loss of similarity over a distance of one side of the frame; chosen by eye, and small, since the camera may have turned
/// meanwhile.
const DISTANCE_PENALTY: f32 = 0.1;

/// The colours along the trajectories of an object, and its last position.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Appearance {
    colours: Histogram,
    /// Mean position of its points in the last frame that has any, relative to the sides of the frame.
    position: (f32, f32),
}

/// Returns the appearance of each object with its label. `cluster` has the cluster of each trajectory.
pub(crate) fn object_appearances(
    tracks: &Trajectories,
    cluster: &[u32],
    objects: &Objects,
    frames: &[Frame],
) -> Vec<(usize, Appearance)> {
    let blank = Appearance { colours: Histogram::new(), position: (0.5, 0.5) };
    let mut appearances: Vec<_> =
        objects.labels().into_iter().map(|label| (usize::from(label), blank.clone())).collect();
    for (t, frame) in frames.iter().enumerate().take(tracks.num_frames) {
        let (w, h) = (frame.width(), frame.height());
        let mut sums = [(0.0, 0.0, 0.0); 256];
        for (i, x, y) in tracks.alive(t) {
            let label = usize::from(objects.of_cluster[cluster[i] as usize]);
            let Some((_, appearance)) = appearances.iter_mut().find(|(l, _)| *l == label) else { continue };
            let pixel = |v: f32, side: usize| ((v + 0.5).max(0.0) as usize).min(side - 1);
            let offset = 3 * (pixel(y, h) * w + pixel(x, w));
            appearance.colours.add(&Colour::from_rgb(&frame.rgb()[offset..offset + 3]).corners(), 1.0);
            let sum = &mut sums[label];
            *sum = (sum.0 + x / w as f32, sum.1 + y / h as f32, sum.2 + 1.0);
        }
        for (label, appearance) in &mut appearances {
            let (x, y, n) = sums[*label];
            if n > 0.0 {
                appearance.position = (x / n, y / n);
            }
        }
    }
    appearances
}

impl Appearance {
    /// Returns the similarity of two appearances, at most 1: similarity of colours, less a little for their distance.
    pub(super) fn similarity(&self, other: &Self) -> f32 {
        let (x, y) = (self.position.0 - other.position.0, self.position.1 - other.position.1);
        self.colours.similarity(&other.colours) - DISTANCE_PENALTY * (x * x + y * y).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The objects in a frame of three columns of these colours, with points all over.
    fn seen(columns: [[u8; 3]; 3], of_cluster: [u8; 3]) -> Vec<(usize, Appearance)> {
        let (w, h) = (60, 20);
        let frame = Frame::from_rgb((0..w * h).flat_map(|i| columns[i % w / 20]).collect(), w, h).unwrap();
        let mut tracks = Trajectories::empty(2, (w, h));
        let places: Vec<usize> = (0..60).step_by(2).collect();
        places.iter().for_each(|&x| tracks.push(0, [(x as f32, 9.0, 0.0); 2]));
        let cluster: Vec<u32> = places.iter().map(|&x| (x / 20) as u32).collect();
        let objects = Objects { highest_label: 2, of_cluster: of_cluster.to_vec() };
        object_appearances(&tracks, &cluster, &objects, &[frame.clone(), frame])
    }

    const RED: [u8; 3] = [200, 40, 30];
    const BLUE: [u8; 3] = [30, 60, 180];
    const GREY: [u8; 3] = [90, 90, 90];

    #[test]
    fn similar_colours_and_nearby_positions_are_similar() {
        let [left, right] = [[RED, GREY, GREY], [GREY, GREY, RED]].map(|columns| seen(columns, [1, 2, 0]));
        let other = seen([BLUE, GREY, GREY], [1, 2, 0]);
        assert_eq!((left[0].0, left[1].0, left.len()), (1, 2, 2));
        let red = &left[0].1;
        assert!((red.similarity(red) - 1.0).abs() < 1e-6);
        assert!(red.similarity(&other[0].1) < 0.1 && red.similarity(&right[0].1) < 0.1);
        let moved = seen([GREY, GREY, RED], [0, 0, 1])[0].1.similarity(red);
        assert!((0.9..0.95).contains(&moved), "{moved}");
    }

    #[test]
    fn an_object_of_several_clusters_has_one_appearance_and_one_without_trajectories_is_similar_to_none() {
        let both = seen([RED, BLUE, BLUE], [1, 0, 1]);
        let red = seen([RED, BLUE, BLUE], [1, 0, 0]);
        assert_eq!((both.len(), red.len()), (1, 1));
        let alike = both[0].1.similarity(&red[0].1);
        assert!((0.6..0.75).contains(&alike), "{alike}");
        let blank = Appearance { colours: Histogram::new(), position: (0.5, 0.5) };
        assert!(blank.similarity(&blank) <= 0.0);
    }
}
