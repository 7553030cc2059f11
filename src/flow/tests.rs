//! Laws of the flow: known motions, symmetry, degenerate frames.

use super::*;
use crate::image::gaussian_blur;
use crate::rng::Rng;

/// Smooth random texture with brightness around 128.
fn texture(width: usize, height: usize, seed: u64) -> Plane<f32> {
    let mut rng = Rng::for_stage(seed, "texture");
    let noise = Plane::from_fn(width, height, |_, _| rng.range(-1.0, 1.0) as f32);
    gaussian_blur(&noise, 2.0).map(|v| 128.0 + 350.0 * v)
}

/// The part of `plane` displaced by `(u, v)`: pixel `(x, y)` of the result shows `plane` at `(x + margin - u, y + margin - v)`.
fn shifted(plane: &Plane<f32>, margin: usize, u: f32, v: f32) -> Plane<f32> {
    let (width, height) = (plane.width() - 2 * margin, plane.height() - 2 * margin);
    Plane::from_fn(width, height, |x, y| sample_bilinear(plane, (x + margin) as f32 - u, (y + margin) as f32 - v))
}

fn flow(from: &Plane<f32>, to: &Plane<f32>) -> FlowField {
    let params = FlowParams::default();
    flow_between(&FlowPyramid::new(from, &params), &FlowPyramid::new(to, &params), &params)
}

/// Mean end-point error against one displacement, `margin` pixels inside the border.
fn error_inside(flow: &FlowField, u: f32, v: f32, margin: usize) -> f32 {
    let (width, height) = (flow.u.width(), flow.u.height());
    let mut sum = 0.0;
    for y in margin..height - margin {
        for x in margin..width - margin {
            sum += (flow.u[(x, y)] - u).hypot(flow.v[(x, y)] - v);
        }
    }
    sum / ((width - 2 * margin) * (height - 2 * margin)) as f32
}

#[test]
fn translation_of_smooth_noise_is_found_to_a_twentieth_of_a_pixel() {
    // Made at three times the size, so that the shift is sampled well below the texture's finest detail.
    let scene = texture(200, 160, 3);
    let error = error_inside(&flow(&shifted(&scene, 20, 0.0, 0.0), &shifted(&scene, 20, 3.4, -2.1)), 3.4, -2.1, 12);
    assert!(error < 0.05, "error {error}");
}

#[test]
fn identical_and_flat_frames_do_not_move() {
    let scene = texture(70, 50, 1);
    let still = flow(&scene, &scene);
    assert!(still.u.data().iter().chain(still.v.data()).all(|v| v.abs() < 1e-3));
    let flat = Plane::filled(70, 50, 90.0);
    let still = flow(&flat, &flat);
    assert!(still.u.data().iter().chain(still.v.data()).all(|&v| v == 0.0));
}

#[test]
fn any_size_gives_finite_flow_of_that_size() {
    for (width, height) in [(1, 1), (17, 3), (1, 40), (40, 1), (2, 2), (9, 8), (65, 33)] {
        let flow = flow(&texture(width, height, 5), &texture(width, height, 6));
        assert_eq!((flow.u.width(), flow.u.height(), flow.v.width(), flow.v.height()), (width, height, width, height));
        assert!(flow.u.data().iter().chain(flow.v.data()).all(|v| v.is_finite()), "{width}x{height}");
    }
    assert_eq!(flow(&Plane::default(), &Plane::default()), FlowField::default());
}
