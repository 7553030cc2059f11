//! The confidence of masks, and their agreement in time.

use super::results::missing_frame;
use crate::Error;
use crate::cut::margins;
use crate::image::Plane;
use crate::mask::{Agreement, ConfidenceInput, agreement, confidence};
use crate::session::base::{ConfidenceTerms, Outputs, Stage};
use crate::session::run::{Clip, Session};

/// Largest background evidence of a superpixel in the mean over a label; chosen by eye.
const MAX_CUE: f32 = 4.0;

impl Session {
    /// Returns the probability that each pixel of frame `t` is correctly labelled as object or background, at working size.
    /// Calibrated on clips of several kinds: docs/confidence.md.
    ///
    /// # Errors
    /// As [`Session::explain`].
    pub fn confidence(&self, t: usize) -> Result<Plane<f32>, Error> {
        match (self.clip(), self.outputs_after(Stage::Masks)) {
            (Some(clip), Some(outputs)) if t < outputs.masks.len() => Ok(frame_confidence(outputs, clip, t)),
            (_, outputs) => Err(missing_frame("confidence", t, outputs.map_or(0, |outputs| outputs.masks.len()))),
        }
    }

    /// Returns the mean of [`Session::confidence`] over the pixels of each label in all frames, the background first; 0 for a
    /// label without pixels.
    ///
    /// # Errors
    /// As [`Session::explain`].
    pub fn object_confidence(&self) -> Result<Vec<f32>, Error> {
        let labels = self.objects().map_or(0, |objects| objects.highest_label) + 1;
        let mut sums = vec![(0.0_f64, 0_u32); labels];
        for t in 0..self.num_frames() {
            let (mask, confidence) = (self.working_labels(t)?, self.confidence(t)?);
            for (&label, &p) in mask.data().iter().zip(confidence.data()) {
                let sum = &mut sums[usize::from(label)];
                *sum = (sum.0 + f64::from(p), sum.1 + 1);
            }
        }
        Ok(sums.into_iter().map(|(sum, count)| (sum / f64::from(count.max(1))) as f32).collect())
    }

    /// Returns the agreement of the present masks with the masks of nearby frames along the flow: low where masks change
    /// against the motion. In windows only frames of the window are compared. `None` until all masks are made, and without
    /// masks.
    pub fn agreement(&self) -> Option<&Agreement> {
        let outputs = self.outputs_after(Stage::Masks).filter(|outputs| !outputs.masks.is_empty())?;
        let Clip { flows, params, .. } = self.clip()?;
        let [given, used] = [&self.params, &**params].map(|params| params.discretize.merge_log_odds);
        let merge_log_odds = (used != given).then_some(used);
        let compute = || Agreement { merge_log_odds, ..agreement(&outputs.masks, flows) };
        Some(outputs.cut.agreement.get_or_init(compute))
    }
}

fn frame_confidence(outputs: &Outputs, clip: &Clip, t: usize) -> Plane<f32> {
    let Outputs { superpixels, cut, masks, .. } = outputs;
    let terms = cut.confidence_terms.get_or_init(|| confidence_terms(outputs, clip));
    let first: usize = superpixels[..t].iter().map(|s| s.count).sum();
    let (mask, superpixel) = (&masks[t], superpixels[t].label());
    let margin = Plane::from_fn(mask.width(), mask.height(), |x, y| {
        let superpixel = superpixel[(x, y)] as usize;
        let is_cut_label = outputs.mask_label(cut.labels.labels[t][superpixel]) == mask[(x, y)];
        if is_cut_label { terms.margins[first + superpixel] } else { 0.0 }
    });
    confidence(ConfidenceInput { mask, margin: &margin, cues: &terms.cues })
}

fn confidence_terms(outputs: &Outputs, clip: &Clip) -> ConfidenceTerms {
    let Outputs { superpixels, cut, .. } = outputs;
    let margins = margins(&outputs.cut_input(), &clip.params.cut, &cut.labels, &cut.objects.of_cluster);
    let (mut sums, mut node) = ([(0.0_f64, 0.0_f64); 256], 0);
    for (superpixels, labels) in superpixels.iter().zip(&cut.labels.labels) {
        for (area, &cluster) in superpixels.areas().into_iter().zip(labels) {
            let cue = cut.context.evidence.get(node).map_or(0.0, |cue| cue.clamp(-MAX_CUE, MAX_CUE));
            let sum = &mut sums[usize::from(outputs.mask_label(cluster))];
            *sum = (sum.0 + f64::from(area) * f64::from(cue), sum.1 + f64::from(area));
            node += 1;
        }
    }
    ConfidenceTerms { margins, cues: sums.map(|(sum, area)| (sum / area.max(1.0)) as f32) }
}
