//! Affine maps of the plane, with a sine that gives the same bytes on every target.

/// The map `(x, y) → (xx·x + xy·y + x0, yx·x + yy·y + y0)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Affine {
    xx: f64,
    xy: f64,
    yx: f64,
    yy: f64,
    x0: f64,
    y0: f64,
}

impl Affine {
    /// The identity map.
    pub(crate) const IDENTITY: Self = Self { xx: 1.0, xy: 0.0, yx: 0.0, yy: 1.0, x0: 0.0, y0: 0.0 };

    /// Returns the translation by `(x, y)`.
    pub(crate) fn translation(x: f64, y: f64) -> Self {
        Self { x0: x, y0: y, ..Self::IDENTITY }
    }

    /// Returns the scaling about the origin by the factors `x` and `y`, neither of them zero.
    pub(crate) fn scaling(x: f64, y: f64) -> Self {
        Self { xx: x, yy: y, ..Self::IDENTITY }
    }

    /// Returns the rotation about the origin by `turns` full turns, clockwise on the screen (y points down).
    #[inline(never)]
    pub(crate) fn rotation(turns: f64) -> Self {
        let (sin, cos) = (sin_turns(turns), sin_turns(turns + 0.25));
        Self { xx: cos, xy: -sin, yx: sin, yy: cos, ..Self::IDENTITY }
    }

    /// Returns the shear that moves each row sideways by `slope` times its distance from the row `y0`: the motion of a ground
    /// plane seen by a camera that moves sideways.
    pub(crate) fn shear(slope: f64, y0: f64) -> Self {
        Self { xy: slope, x0: -slope * y0, ..Self::IDENTITY }
    }

    /// Composes this map with `next`, which is applied after it.
    #[must_use]
    #[inline(never)]
    pub(crate) fn then(&self, next: &Self) -> Self {
        let (x0, y0) = next.apply(self.x0, self.y0);
        Self {
            xx: next.xx * self.xx + next.xy * self.yx,
            xy: next.xx * self.xy + next.xy * self.yy,
            yx: next.yx * self.xx + next.yy * self.yx,
            yy: next.yx * self.xy + next.yy * self.yy,
            x0,
            y0,
        }
    }

    /// Maps `(x, y)`.
    pub(crate) fn apply(&self, x: f64, y: f64) -> (f64, f64) {
        (self.xx * x + self.xy * y + self.x0, self.yx * x + self.yy * y + self.y0)
    }

    /// Returns the signed factor by which areas grow.
    pub(crate) fn determinant(&self) -> f64 {
        self.xx * self.yy - self.xy * self.yx
    }

    /// Returns the inverse map. The determinant must not be zero.
    #[must_use]
    pub(crate) fn inverse(&self) -> Self {
        let scale = 1.0 / self.determinant();
        let (xx, xy) = (self.yy * scale, -self.xy * scale);
        let (yx, yy) = (-self.yx * scale, self.xx * scale);
        Self { xx, xy, yx, yy, x0: -(xx * self.x0 + xy * self.y0), y0: -(yx * self.x0 + yy * self.y0) }
    }
}

/// Computes the sine of an angle in full turns, to about 1e-9.
///
/// The last bit of `f64::sin` may differ between platforms and change rounded pixels; sums and products are exact.
#[inline(never)]
pub(crate) fn sin_turns(turns: f64) -> f64 {
    let turns = turns - (turns + 0.5).floor();
    let folded = if turns > 0.25 {
        0.5 - turns
    } else if turns < -0.25 {
        -0.5 - turns
    } else {
        turns
    };
    let x = folded * std::f64::consts::TAU;
    let xx = x * x;
    // Taylor series to x¹³, by Horner's rule.
    let terms = [1.0 / 156.0, 1.0 / 110.0, 1.0 / 72.0, 1.0 / 42.0, 1.0 / 20.0, 1.0 / 6.0];
    x * terms.iter().fold(1.0, |sum, term| 1.0 - xx * term * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sine_is_a_sine() {
        for k in -40..40 {
            let turns = f64::from(k) * 0.0613;
            let expected = (turns * std::f64::consts::TAU).sin();
            assert!((sin_turns(turns) - expected).abs() < 2e-9, "sine of {turns} turns: {}", sin_turns(turns));
        }
    }

    #[test]
    fn a_map_and_its_inverse_cancel() {
        let map = Affine::scaling(1.3, 0.7).then(&Affine::rotation(0.2)).then(&Affine::translation(5.0, -3.0));
        let map = map.then(&Affine::shear(0.4, 7.0));
        let (x, y) = map.apply(11.0, -2.0);
        let (x, y) = map.inverse().apply(x, y);
        assert!((x - 11.0).abs() < 1e-12 && (y + 2.0).abs() < 1e-12, "({x}, {y})");
        assert!((map.determinant() - 0.91).abs() < 1e-8);
    }
}
