//! What objects look like, to know them again when they come back.

use crate::cut::{Colour, Histogram};
use crate::image::Frame;
use crate::trajectory::Trajectories;

/// What resemblance loses over the side of a frame. It is small: the camera may have turned meanwhile.
const NEARNESS: f32 = 0.1;

/// The colours along the trajectories of some cluster or object, and where it was last.
#[derive(Debug, Clone)]
pub(crate) struct Portrait {
    colours: Histogram,
    /// The mean place of its points in the last frame that has any, as parts of the frame's sides; and that frame.
    place: (f32, f32),
}

/// A portrait of each of `count` clusters; `label` has the cluster of each trajectory.
pub(crate) fn portraits(tracks: &Trajectories, label: &[u32], count: usize, frames: &[Frame]) -> Vec<Portrait> {
    let mut found = vec![Portrait { colours: Histogram::new(), place: (0.5, 0.5) }; count];
    for (t, frame) in frames.iter().enumerate().take(tracks.num_frames) {
        let (w, h) = (frame.width(), frame.height());
        let mut sums = vec![(0.0, 0.0, 0.0); count];
        for (i, x, y) in tracks.alive(t) {
            let (c, at) = (label[i] as usize, |v: f32, side: usize| ((v + 0.5).max(0.0) as usize).min(side - 1));
            let pixel = 3 * (at(y, h) * w + at(x, w));
            found[c].colours.add(Colour::of(&frame.rgb()[pixel..pixel + 3]), 1.0);
            sums[c] = (sums[c].0 + x / w as f32, sums[c].1 + y / h as f32, sums[c].2 + 1.0);
        }
        for (portrait, (x, y, n)) in found.iter_mut().zip(sums).filter(|(_, sum)| sum.2 > 0.0) {
            portrait.place = (x / n, y / n);
        }
    }
    found
}

impl Portrait {
    /// Of what several clusters make together; `None` without any.
    pub(super) fn of_all<'a>(parts: impl Iterator<Item = &'a Self>) -> Option<Self> {
        parts.fold(None, |all: Option<Self>, part| {
            let Some(mut all) = all else { return Some(part.clone()) };
            let (a, b) = (all.colours.total(), part.colours.total());
            let mean = |x: f32, y: f32| (a * x + b * y) / (a + b).max(1.0);
            all.place = (mean(all.place.0, part.place.0), mean(all.place.1, part.place.1));
            all.colours.add_all(&part.colours);
            Some(all)
        })
    }

    /// How alike two are, at most 1: by their colours, and a little by how near they are.
    pub(super) fn resemblance(&self, other: &Self) -> f32 {
        let (x, y) = (self.place.0 - other.place.0, self.place.1 - other.place.1);
        self.colours.likeness(&other.colours) - NEARNESS * (x * x + y * y).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clusters of a frame in three columns of these colours, with points all over.
    fn seen(columns: [[u8; 3]; 3], label: impl Fn(usize) -> u32) -> Vec<Portrait> {
        let (w, h) = (60, 20);
        let frame = Frame::from_rgb((0..w * h).flat_map(|i| columns[i % w / 20]).collect(), w, h).unwrap();
        let mut tracks = Trajectories::empty(2, (w, h));
        let places: Vec<usize> = (0..60).step_by(2).collect();
        places.iter().for_each(|&x| tracks.push(0, [(x as f32, 9.0, 0.0); 2]));
        let label: Vec<u32> = places.iter().map(|&x| label(x / 20)).collect();
        portraits(&tracks, &label, 2, &[frame.clone(), frame])
    }

    const RED: [u8; 3] = [200, 40, 30];
    const BLUE: [u8; 3] = [30, 60, 180];
    const GREY: [u8; 3] = [90, 90, 90];

    #[test]
    fn who_looks_alike_resembles_and_more_so_nearby() {
        let left = seen([RED, GREY, GREY], |column| u32::from(column == 0));
        let right = seen([GREY, GREY, RED], |column| u32::from(column == 2));
        let other = seen([BLUE, GREY, GREY], |column| u32::from(column == 0));
        assert!((left[1].resemblance(&left[1]) - 1.0).abs() < 1e-6);
        let (moved, strange) = (left[1].resemblance(&right[1]), left[1].resemblance(&other[1]));
        assert!((0.9..0.95).contains(&moved) && strange < 0.1, "{moved} {strange}");
        assert!(left[0].resemblance(&left[1]) < 0.1);
    }

    #[test]
    fn several_clusters_make_one_portrait() {
        let parts = seen([RED, BLUE, BLUE], |column| u32::from(column > 0));
        let whole = seen([RED, BLUE, BLUE], |_| 0);
        let all = Portrait::of_all(parts.iter()).unwrap();
        assert!((all.resemblance(&whole[0]) - 1.0).abs() < 1e-4);
        assert!(Portrait::of_all([].iter()).is_none());
        // A cluster without trajectories resembles nothing.
        assert!(whole[1].resemblance(&whole[0]) <= 0.0);
    }
}
