//! Angles in radians: wrapping, differences and circular means.
//!
//! An angle and the same angle plus a full turn are one direction. Everything here works on the
//! representative in (-pi, pi], so that a heading error of 359 degrees counts as one of -1 degree.
//!
//! ```
//! use loc_core::angle;
//! use std::f64::consts::PI;
//! assert!((angle::difference(-PI + 0.1, PI - 0.1) - 0.2).abs() < 1e-12);
//! ```

use std::f64::consts::{PI, TAU};

/// The representative of `angle` in (-pi, pi] \[rad\]. NaN and infinity give NaN.
pub fn wrap(angle: f64) -> f64 {
    if angle > -PI && angle <= PI {
        return angle;
    }
    // The remainder is exact for angles of every size, and NaN for infinity.
    let rest = angle % TAU;
    if rest > PI {
        rest - TAU
    } else if rest <= -PI {
        rest + TAU
    } else {
        rest
    }
}

/// The shortest signed turn from `b` to `a`, wrapped `a - b` \[rad\].
pub fn difference(a: f64, b: f64) -> f64 {
    wrap(a - b)
}

/// The direction of the sum of the unit vectors of `angles` \[rad\].
///
/// `None` where that sum vanishes: no angles, opposite ones, or any that is not finite.
pub fn circular_mean(angles: impl IntoIterator<Item = f64>) -> Option<f64> {
    weighted_circular_mean(angles.into_iter().map(|angle| (angle, 1.0)))
}

/// The direction of the weighted sum of unit vectors, of pairs (angle \[rad\], weight).
///
/// `None` where that sum vanishes.
pub fn weighted_circular_mean(angles: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    let (sin, cos, total) = angles.into_iter().fold((0.0, 0.0, 0.0), |(s, c, n), (angle, w)| {
        (s + w * angle.sin(), c + w * angle.cos(), n + w.abs())
    });
    let length: f64 = f64::hypot(sin, cos);
    // A resultant at the level of rounding has no direction.
    (length > 1e-12 * total).then(|| sin.atan2(cos))
}
