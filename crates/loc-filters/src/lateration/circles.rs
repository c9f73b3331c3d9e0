//! Two circles in the plane, in closed form (D1, D4).

use super::Range;
use crate::{Error, Result};
use nalgebra::{Point2, Vector2};

/// Where two circles meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Crossing {
    /// At two points, left and right of the line from the first landmark to the second; the same
    /// point twice where they touch.
    Meet([Point2<f64>; 2]),
    /// Nowhere: the point that fits best instead.
    Miss {
        /// The most likely place: the gap is shared in proportion to the variances.
        nearest: Point2<f64>,
        /// The distance between the two circles \[m\].
        gap: f64,
        /// How they miss each other.
        reason: Miss,
    },
}

/// How two circles miss each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Miss {
    /// The distances together are shorter than the landmarks are apart.
    Apart,
    /// One circle lies inside the other.
    Inside,
}

/// Both places that lie at two distances from two landmarks.
///
/// ```
/// use loc_filters::lateration::{Crossing, Range, two_circles};
/// let (left, right) = (Range::new([0.0, 0.0], 5.0, 0.1), Range::new([6.0, 0.0], 5.0, 0.1));
/// let Crossing::Meet([above, below]) = two_circles(&left, &right)? else { unreachable!() };
/// assert_eq!((above, below), ([3.0, 4.0].into(), [3.0, -4.0].into()));
/// # Ok::<(), loc_filters::Error>(())
/// ```
///
/// # Errors
/// Those of [`Range::check`], and [`Error::Undetermined`] for landmarks at the same place.
pub fn two_circles(a: &Range<2>, b: &Range<2>) -> Result<Crossing> {
    a.check()?;
    b.check()?;
    let way = b.landmark - a.landmark;
    let apart = way.norm();
    if apart <= 1e-12 * (1.0 + a.landmark.coords.norm() + b.landmark.coords.norm()) {
        return Err(Error::Undetermined {
            expected: "two landmarks at different places",
            found: format!("both at ({}, {})", a.landmark.x, a.landmark.y),
        });
    }
    let ahead = way / apart;
    if apart > a.distance + b.distance {
        let gap = apart - a.distance - b.distance;
        return Ok(miss(a, ahead, a.distance, gap, b, Miss::Apart));
    }
    if a.distance > apart + b.distance {
        // From the large circle inwards; both landmarks lie on the same side of the gap.
        let gap = a.distance - apart - b.distance;
        return Ok(miss(a, ahead, a.distance, -gap, b, Miss::Inside));
    }
    if b.distance > apart + a.distance {
        let gap = b.distance - apart - a.distance;
        return Ok(miss(b, -ahead, b.distance, -gap, a, Miss::Inside));
    }
    // Where the line through both points crosses that through the landmarks.
    let along = 0.5 * (apart + (a.distance - b.distance) * (a.distance + b.distance) / apart);
    let across = ((a.distance - along) * (a.distance + along)).max(0.0).sqrt();
    let foot = a.landmark + ahead * along;
    let left = Vector2::new(-ahead.y, ahead.x) * across;
    Ok(Crossing::Meet([foot + left, foot - left]))
}

/// The point of the gap that begins at `radius` from `a` along `ahead` and is `gap` long.
fn miss(
    a: &Range<2>,
    ahead: Vector2<f64>,
    radius: f64,
    gap: f64,
    b: &Range<2>,
    reason: Miss,
) -> Crossing {
    let (in_a, in_b) = (a.sigma * a.sigma, b.sigma * b.sigma);
    let nearest = a.landmark + ahead * (radius + gap * (in_a / (in_a + in_b)));
    Crossing::Miss { nearest, gap: gap.abs(), reason }
}
