//! Results drawn over their frames: trajectory points, coloured by label.

use crate::failure::Result;
use crate::pictures::{Pixels, Series};
use crate::window::WindowResult;
use std::path::PathBuf;
use tracecut::discretize::Clusters;
use tracecut::image::Frame;
use tracecut::trajectory::Trajectories;

/// Colours of labels 0, 1, ...: a pale grey for the largest cluster, which is mostly the background, then the palette
/// of Okabe and Ito (2008), designed to be distinguishable with any colour vision, then darker and lighter variants of it.
/// Starts again after the last.
pub(crate) const PALETTE: [[u8; 3]; 16] = [
    [222, 222, 222],
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [213, 94, 0],
    [0, 114, 178],
    [204, 121, 167],
    [138, 90, 0],
    [180, 225, 255],
    [0, 90, 66],
    [255, 182, 138],
    [120, 40, 0],
    [150, 140, 255],
    [110, 50, 85],
    [160, 235, 120],
];

/// Brightness of the frame under the points, so that pale and dark points are both visible; chosen by eye.
const FRAME_SHARE: f32 = 0.75;

/// Draws the trajectories of a window over the frames that it settles, into `folder`.
pub(crate) fn write_window(window: &WindowResult<'_>, folder: PathBuf) -> Result<()> {
    let (points, results) = (Series::open(folder)?, window.results()?);
    for t in window.settled.clone() {
        let frame = window.frame(t)?;
        let picture = draw(frame, t, results.tracks, results.clusters);
        points.write(window.first + t, (frame.width(), frame.height()), Pixels::Rgb(&picture))?;
    }
    Ok(())
}

/// The frame, dimmed, with a disc for each trajectory alive in it; RGB.
fn draw(frame: &Frame, index: usize, tracks: &Trajectories, clusters: &Clusters) -> Vec<u8> {
    let mut canvas = Canvas {
        rgb: frame.rgb().iter().map(|&v| (f32::from(v) * FRAME_SHARE) as u8).collect(),
        width: frame.width(),
        height: frame.height(),
    };
    // About 2 pixels in a 640-pixel image: apart at the default spacing, and still visible when the image is shown
    // small.
    let radius = (frame.width().max(frame.height()) as f32 / 280.0).max(0.9);
    for (i, x, y) in tracks.alive(index) {
        canvas.disc((x, y), radius + 0.35 * radius.min(2.5), [0, 0, 0], 0.6);
        canvas.disc((x, y), radius, PALETTE[clusters.label[i] as usize % PALETTE.len()], 1.0);
    }
    canvas.rgb
}

struct Canvas {
    rgb: Vec<u8>,
    width: usize,
    height: usize,
}

impl Canvas {
    /// Blends a disc over the picture; its edge is a ramp one pixel wide.
    fn disc(&mut self, (cx, cy): (f32, f32), radius: f32, colour: [u8; 3], opacity: f32) {
        let reach = radius + 0.5;
        let span =
            |c: f32, end: usize| (c - reach).ceil().max(0.0) as usize..((c + reach + 1.0).max(0.0) as usize).min(end);
        for y in span(cy, self.height) {
            for x in span(cx, self.width) {
                let distance = (x as f32 - cx).hypot(y as f32 - cy);
                let cover = (reach - distance).clamp(0.0, 1.0) * opacity;
                let pixel = 3 * (y * self.width + x);
                for (value, new) in self.rgb[pixel..pixel + 3].iter_mut().zip(colour) {
                    *value = (f32::from(*value) + cover * (f32::from(new) - f32::from(*value)) + 0.5) as u8;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn discs_cover_their_area_and_stay_inside_the_picture() {
        let mut canvas = Canvas { rgb: vec![0; 3 * 21 * 15], width: 21, height: 15 };
        canvas.disc((10.3, 7.6), 4.0, [255, 0, 0], 1.0);
        let area: f32 = canvas.rgb.iter().step_by(3).map(|&v| f32::from(v) / 255.0).sum();
        assert!((area - 16.0 * std::f32::consts::PI).abs() < 1.0, "area {area}");
        for place in [(-30.0, 2.0), (0.0, 0.0), (20.0, 14.0), (1e9, -1e9)] {
            canvas.disc(place, 2.0, [0, 255, 0], 1.0);
        }
        assert_eq!(canvas.rgb[1], 255);
    }

    #[test]
    fn colours_are_distinct() {
        for (a, first) in PALETTE.iter().enumerate() {
            for second in &PALETTE[..a] {
                let distance: u32 = first.iter().zip(second).map(|(&p, &q)| u32::from(p.abs_diff(q))).sum();
                assert!(distance > 60, "{first:?} {second:?}");
            }
        }
    }
}
