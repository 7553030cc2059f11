//! Single images: boundaries, superpixels, discontinuities.

use super::choices::Choices;
use super::clips::{image, params};
use super::laws::{check_boundaries, check_superpixels};
use tracecut::contour::{boundary_map, contour_segments};
use tracecut::image::Frame;
use tracecut::mask::enlarge;
use tracecut::still::image_discontinuities;
use tracecut::superpixel::{superpixels_in, superpixels_of};

/// All that there is to an image, under any legal parameters.
pub fn any_image(choices: &mut Choices<'_>) {
    let (params, frame) = (params(choices), image(choices));
    let map = boundary_map(&frame);
    check_boundaries(&map);
    check_segments(&frame, &contour_segments(&map, &params.contour));
    let wanted = choices.once_in(2).then(|| 1 + choices.below(300));
    let found = superpixels_in(&map, wanted, &params.contour, &params.superpixel);
    check_superpixels(&found);
    assert_eq!(found, superpixels_of(&frame, wanted, &params.contour, &params.superpixel));
    let mask = found.label().map(|label| (label % 4) as u8);
    if choices.once_in(4) {
        let picture = super::clips::image(choices);
        // Refused unless the picture is a larger one of the same shape.
        let _ = enlarge(&mask, &picture, |label| label != 2);
    }
    if choices.once_in(2) {
        check_discontinuities(&frame, &params);
    }
}

fn check_segments(frame: &Frame, segments: &tracecut::contour::Segments) {
    let inside = |v: f32, side: usize| (-0.5..=side as f32 - 0.5).contains(&v);
    let count = segments.points.len();
    assert!(segments.points.iter().all(|&(x, y)| inside(x, frame.width()) && inside(y, frame.height())));
    assert!(segments.lines.iter().all(|&(a, b)| a != b && (a.max(b) as usize) < count));
}

fn check_discontinuities(frame: &Frame, params: &tracecut::Params) {
    let found = image_discontinuities(frame, &params.still, params.clip.seed);
    check_boundaries(&found.pb);
    check_boundaries(&found.combined);
    assert!(found.eigenvalues.iter().all(|v| v.is_finite()));
    assert!(found.eigenvectors.iter().flat_map(|plane| plane.data()).all(|v| v.is_finite()));
    for map in [&found.d, &found.spectral] {
        assert!(map.strength.data().iter().chain(map.thin.data()).all(|v| v.is_finite() && *v >= 0.0));
    }
}
