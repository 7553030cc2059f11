//! How sure masks are.

use super::results::missing_frame;
use super::why::found_input;
use crate::Error;
use crate::cut::margins;
use crate::image::Plane;
use crate::mask::{Said, confidence};
use crate::session::base::{Segmented, Sureness};
use crate::session::run::Clip;
use crate::session::run::State;
use crate::session::run::{Phase, Session};

impl Session {
    /// How likely the label of each pixel of frame `t` is right, in that the pixel is on an object or is not, in
    /// `0.0..=1.0`, at working size. Calibrated on clips of several kinds: docs/confidence.md.
    ///
    /// # Errors
    /// As [`Session::explain`].
    pub fn confidence(&self, t: usize) -> Result<Plane<f32>, Error> {
        match &self.phase {
            Phase::Begun(clip, State::Segmented(found)) if t < found.masks.len() => Ok(found.confidence(clip, t)),
            Phase::Begun(_, State::Segmented(found)) => Err(missing_frame("confidence", t, found.masks.len())),
            _ => Err(missing_frame("confidence", t, 0)),
        }
    }

    /// The mean of [`Session::confidence`] over the pixels of each label in all frames, the background first; 0 of a
    /// label without pixels.
    ///
    /// # Errors
    /// As [`Session::explain`].
    pub fn object_confidence(&self) -> Result<Vec<f32>, Error> {
        let labels = self.objects().map_or(0, |objects| objects.highest_label) + 1;
        let mut sums = vec![(0.0_f64, 0_u32); labels];
        for t in 0..self.num_frames() {
            let (mask, sure) = (self.working_labels(t)?, self.confidence(t)?);
            for (&label, &p) in mask.data().iter().zip(sure.data()) {
                let sum = &mut sums[usize::from(label)];
                *sum = (sum.0 + f64::from(p), sum.1 + 1);
            }
        }
        Ok(sums.into_iter().map(|(sum, count)| (sum / f64::from(count.max(1))) as f32).collect())
    }
}

impl Segmented {
    fn confidence(&self, clip: &Clip, t: usize) -> Plane<f32> {
        let sure = self.cut.sure.get_or_init(|| self.sureness(clip));
        let (mask, superpixels) = (&self.masks[t], &self.parts.superpixels[t]);
        let first: usize = self.parts.superpixels[..t].iter().map(|s| s.count).sum();
        let superpixel = superpixels.label();
        let margin = Plane::from_fn(mask.width(), mask.height(), |x, y| {
            let superpixel = superpixel[(x, y)] as usize;
            let by_cut = self.label_of(self.cut.labels.labels[t][superpixel]) == mask[(x, y)];
            if by_cut { sure.margins[first + superpixel] } else { 0.0 }
        });
        confidence(Said { mask, margin: &margin, cue: &sure.cue })
    }

    /// The mask label of a cluster.
    pub(crate) fn label_of(&self, cluster: u32) -> u8 {
        self.cut.objects.of_cluster.get(cluster as usize).copied().unwrap_or(0)
    }

    fn sureness(&self, clip: &Clip) -> Sureness {
        let input = found_input(self);
        let margins = margins(&input, &clip.params.cut, &self.cut.labels, &self.cut.objects.of_cluster);
        let (mut said, mut node) = ([(0.0_f64, 0.0_f64); 256], 0);
        for (superpixels, labels) in self.parts.superpixels.iter().zip(&self.cut.labels.labels) {
            for (area, &cluster) in superpixels.areas().into_iter().zip(labels) {
                let cue = self.cut.ground.cues.get(node).map_or(0.0, |cue| cue.clamp(-4.0, 4.0));
                let sum = &mut said[usize::from(self.label_of(cluster))];
                *sum = (sum.0 + f64::from(area) * f64::from(cue), sum.1 + f64::from(area));
                node += 1;
            }
        }
        Sureness { margins, cue: said.map(|(sum, area)| (sum / area.max(1.0)) as f32) }
    }
}
