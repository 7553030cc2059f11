//! How sure masks are.

use super::results::missing_frame;
use crate::Error;
use crate::cut::margins;
use crate::image::Plane;
use crate::mask::{Said, confidence};
use crate::session::base::{Outputs, Stage, Sureness};
use crate::session::run::{Clip, Session};

impl Session {
    /// How likely the label of each pixel of frame `t` is right, in that the pixel is on an object or is not, in
    /// `0.0..=1.0`, at working size. Calibrated on clips of several kinds: docs/confidence.md.
    ///
    /// # Errors
    /// As [`Session::explain`].
    pub fn confidence(&self, t: usize) -> Result<Plane<f32>, Error> {
        match (self.clip(), self.after(Stage::Masks)) {
            (Some(clip), Some(outputs)) if t < outputs.masks.len() => Ok(confidence_in(outputs, clip, t)),
            (_, outputs) => Err(missing_frame("confidence", t, outputs.map_or(0, |outputs| outputs.masks.len()))),
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

fn confidence_in(outputs: &Outputs, clip: &Clip, t: usize) -> Plane<f32> {
    let Outputs { superpixels, cut, masks, .. } = outputs;
    let sureness = cut.sureness.get_or_init(|| sureness(outputs, clip));
    let first: usize = superpixels[..t].iter().map(|s| s.count).sum();
    let (mask, superpixel) = (&masks[t], superpixels[t].label());
    let margin = Plane::from_fn(mask.width(), mask.height(), |x, y| {
        let superpixel = superpixel[(x, y)] as usize;
        let by_cut = outputs.label_of(cut.labels.labels[t][superpixel]) == mask[(x, y)];
        if by_cut { sureness.margins[first + superpixel] } else { 0.0 }
    });
    confidence(Said { mask, margin: &margin, cue: &sureness.cue })
}

fn sureness(outputs: &Outputs, clip: &Clip) -> Sureness {
    let Outputs { superpixels, cut, .. } = outputs;
    let margins = margins(&outputs.cut_input(), &clip.params.cut, &cut.labels, &cut.objects.of_cluster);
    let (mut sums, mut node) = ([(0.0_f64, 0.0_f64); 256], 0);
    for (superpixels, labels) in superpixels.iter().zip(&cut.labels.labels) {
        for (area, &cluster) in superpixels.areas().into_iter().zip(labels) {
            let cue = cut.ground.cues.get(node).map_or(0.0, |cue| cue.clamp(-4.0, 4.0));
            let sum = &mut sums[usize::from(outputs.label_of(cluster))];
            *sum = (sum.0 + f64::from(area) * f64::from(cue), sum.1 + f64::from(area));
            node += 1;
        }
    }
    Sureness { margins, cue: sums.map(|(sum, area)| (sum / area.max(1.0)) as f32) }
}
