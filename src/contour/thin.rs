//! Thinning: what is left of a strength map on its ridges.

use crate::image::Plane;

/// Directions that an orientation map tells apart.
pub(crate) const ORIENTATIONS: usize = 8;

/// `strength` where it is largest across the boundary, 0 elsewhere. `orientation[i]` is the direction of the boundary's normal, in steps
/// of a half turn by [`ORIENTATIONS`] from the x axis towards the y axis.
///
/// A pixel stays when it is larger than the interpolated values one pixel before it and not smaller than those behind it.
pub(crate) fn thin(strength: &Plane<f32>, orientation: &Plane<u8>) -> Plane<f32> {
    let (w, h) = (strength.width(), strength.height());
    let mut out = Plane::filled(w, h, 0.0);
    let normals = normals();
    for y in 0..h {
        for x in 0..w {
            let value = strength[(x, y)];
            if value <= 0.0 {
                continue;
            }
            let (nx, ny) = normals[usize::from(orientation[(x, y)]) % ORIENTATIONS];
            let (x, y) = (x as f32, y as f32);
            let before = crate::image::sample_bilinear(strength, x - nx, y - ny);
            let behind = crate::image::sample_bilinear(strength, x + nx, y + ny);
            if value > before && value >= behind {
                out[(x as usize, y as usize)] = value;
            }
        }
    }
    out
}

/// Unit normals of the orientations.
pub(crate) fn normals() -> [(f32, f32); ORIENTATIONS] {
    std::array::from_fn(|k| {
        let angle = std::f32::consts::PI * k as f32 / ORIENTATIONS as f32;
        (libm::cosf(angle), libm::sinf(angle))
    })
}
