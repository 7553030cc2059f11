//! What objects look like, to know them again when they come back.
//!
//! In: trajectories of a window with their objects, and its frames. Out: of each object the colours along its trajectories,
//! and where it was last. Two portraits resemble each other by these. Not in the paper.

use crate::cut::{Colour, Histogram};
use crate::image::Frame;
use crate::objects::Objects;
use crate::trajectory::Trajectories;
use serde::{Deserialize, Serialize};

/// What resemblance loses over the side of a frame. It is small: the camera may have turned meanwhile.
const NEARNESS: f32 = 0.1;

/// The colours along the trajectories of an object, and where it was last.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Portrait {
    colours: Histogram,
    /// The mean place of its points in the last frame that has any, as parts of the frame's sides.
    place: (f32, f32),
}

/// A portrait of each object, under its label; `cluster` has the cluster of each trajectory.
pub(crate) fn portraits(
    tracks: &Trajectories,
    cluster: &[u32],
    objects: &Objects,
    frames: &[Frame],
) -> Vec<(usize, Portrait)> {
    let blank = Portrait { colours: Histogram::new(), place: (0.5, 0.5) };
    let mut found: Vec<_> = objects.labels().into_iter().map(|label| (usize::from(label), blank.clone())).collect();
    for (t, frame) in frames.iter().enumerate().take(tracks.num_frames) {
        let (w, h) = (frame.width(), frame.height());
        let mut sums = [(0.0, 0.0, 0.0); 256];
        for (i, x, y) in tracks.alive(t) {
            let label = usize::from(objects.of_cluster[cluster[i] as usize]);
            let Some((_, portrait)) = found.iter_mut().find(|(own, _)| *own == label) else { continue };
            let at = |v: f32, side: usize| ((v + 0.5).max(0.0) as usize).min(side - 1);
            let pixel = 3 * (at(y, h) * w + at(x, w));
            portrait.colours.add(&Colour::from_rgb(&frame.rgb()[pixel..pixel + 3]).corners(), 1.0);
            let sum = &mut sums[label];
            *sum = (sum.0 + x / w as f32, sum.1 + y / h as f32, sum.2 + 1.0);
        }
        for (label, portrait) in &mut found {
            let (x, y, n) = sums[*label];
            if n > 0.0 {
                portrait.place = (x / n, y / n);
            }
        }
    }
    found
}

impl Portrait {
    /// How alike two are, at most 1: by their colours, and a little by how near they are.
    pub(super) fn resemblance(&self, other: &Self) -> f32 {
        let (x, y) = (self.place.0 - other.place.0, self.place.1 - other.place.1);
        self.colours.similarity(&other.colours) - NEARNESS * (x * x + y * y).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The objects in a frame of three columns of these colours, with points all over.
    fn seen(columns: [[u8; 3]; 3], of_cluster: [u8; 3]) -> Vec<(usize, Portrait)> {
        let (w, h) = (60, 20);
        let frame = Frame::from_rgb((0..w * h).flat_map(|i| columns[i % w / 20]).collect(), w, h).unwrap();
        let mut tracks = Trajectories::empty(2, (w, h));
        let places: Vec<usize> = (0..60).step_by(2).collect();
        places.iter().for_each(|&x| tracks.push(0, [(x as f32, 9.0, 0.0); 2]));
        let cluster: Vec<u32> = places.iter().map(|&x| (x / 20) as u32).collect();
        let objects = Objects { highest_label: 2, of_cluster: of_cluster.to_vec() };
        portraits(&tracks, &cluster, &objects, &[frame.clone(), frame])
    }

    const RED: [u8; 3] = [200, 40, 30];
    const BLUE: [u8; 3] = [30, 60, 180];
    const GREY: [u8; 3] = [90, 90, 90];

    #[test]
    fn who_looks_alike_resembles_and_more_so_nearby() {
        let [left, right] = [[RED, GREY, GREY], [GREY, GREY, RED]].map(|columns| seen(columns, [1, 2, 0]));
        let other = seen([BLUE, GREY, GREY], [1, 2, 0]);
        assert_eq!((left[0].0, left[1].0, left.len()), (1, 2, 2));
        let red = &left[0].1;
        assert!((red.resemblance(red) - 1.0).abs() < 1e-6);
        assert!(red.resemblance(&other[0].1) < 0.1 && red.resemblance(&right[0].1) < 0.1);
        let moved = seen([GREY, GREY, RED], [0, 0, 1])[0].1.resemblance(red);
        assert!((0.9..0.95).contains(&moved), "{moved}");
    }

    #[test]
    fn an_object_of_several_clusters_has_one_portrait_and_one_without_trajectories_resembles_nothing() {
        let both = seen([RED, BLUE, BLUE], [1, 0, 1]);
        let red = seen([RED, BLUE, BLUE], [1, 0, 0]);
        assert_eq!((both.len(), red.len()), (1, 1));
        let alike = both[0].1.resemblance(&red[0].1);
        assert!((0.6..0.75).contains(&alike), "{alike}");
        let blank = Portrait { colours: Histogram::new(), place: (0.5, 0.5) };
        assert!(blank.resemblance(&blank) <= 0.0);
    }
}
