//! Masks as pictures: frames tinted by them.

use crate::overlay::PALETTE;
use tracecut::image::{Frame, Plane};

/// How much of a tinted pixel is the label's colour.
const TINT_SHARE: f32 = 0.5;

/// The frame with the pixels of each label other than 0 tinted, and outlined in the full colour; RGB. `labels` has the frame's size.
pub(crate) fn tinted(frame: &Frame, labels: &Plane<u8>) -> Vec<u8> {
    let mut rgb = frame.rgb().to_vec();
    for y in 0..labels.height() {
        for x in 0..labels.width() {
            let label = labels[(x, y)];
            if label > 0 {
                let share = if is_rim(labels, x, y) { 1.0 } else { TINT_SHARE };
                blend(&mut rgb, y * labels.width() + x, PALETTE[usize::from(label) % PALETTE.len()], share);
            }
        }
    }
    rgb
}

/// Whether one of the four neighbours inside the image has another label.
fn is_rim(labels: &Plane<u8>, x: usize, y: usize) -> bool {
    let here = labels[(x, y)];
    let (right, below) = (x + 1 < labels.width(), y + 1 < labels.height());
    (x > 0 && labels[(x - 1, y)] != here)
        || (y > 0 && labels[(x, y - 1)] != here)
        || (right && labels[(x + 1, y)] != here)
        || (below && labels[(x, y + 1)] != here)
}

/// Paints the true pixels of `lines` over `rgb`.
pub(crate) fn paint_lines(rgb: &mut [u8], lines: &Plane<bool>, colour: [u8; 3]) {
    for (pixel, _) in lines.data().iter().enumerate().filter(|(_, line)| **line) {
        blend(rgb, pixel, colour, 1.0);
    }
}

fn blend(rgb: &mut [u8], pixel: usize, colour: [u8; 3], share: f32) {
    for (value, new) in rgb[3 * pixel..3 * pixel + 3].iter_mut().zip(colour) {
        *value = (f32::from(*value) + share * (f32::from(new) - f32::from(*value)) + 0.5) as u8;
    }
}
