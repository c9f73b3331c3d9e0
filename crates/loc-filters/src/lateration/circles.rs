//! Exact intersections: two circles in closed form (D1, D4), and Newton's method (D1, D3).

use super::Range;
use crate::{Error, Result};
use nalgebra::{Matrix3, Point, Point2, Vector2, Vector3};

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
    let offset = b.landmark - a.landmark;
    let apart = offset.norm();
    if apart <= 1e-12 * (1.0 + a.landmark.coords.norm() + b.landmark.coords.norm()) {
        return Err(Error::Undetermined {
            expected: "two landmarks at different places",
            found: format!("both at ({}, {})", a.landmark.x, a.landmark.y),
        });
    }
    let ahead = offset / apart;
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

/// More steps than a start near a root ever needs: each doubles the right digits.
const STEPS: usize = 50;

/// The place at given distances from as many landmarks as it has coordinates: two in the plane,
/// three in space.
///
/// Newton's method on `|x - l_i|^2 - d_i^2 = 0`. There are two such places; which of them is found
/// depends on the start, which should lie near the robot.
///
/// ```
/// use loc_filters::lateration::{Range, newton};
/// let ranges = [Range::new([0.0, 0.0], 5.0, 0.1), Range::new([6.0, 0.0], 5.0, 0.1)];
/// let place = newton(&ranges, [2.0, 1.0].into())?;
/// assert!((place.x - 3.0).abs() < 1e-12 && (place.y - 4.0).abs() < 1e-12);
/// # Ok::<(), loc_filters::Error>(())
/// ```
///
/// # Errors
/// Those of [`Range::check`], [`loc_core::Error::OutOfRange`] for a start that is not finite, and
/// [`Error::NoRoot`] where the method does not settle: the circles do not meet, or the start lies
/// on the line (plane) through the landmarks, from which no step leads to either side.
// ANCHOR: newton
pub fn newton<const D: usize>(
    ranges: &[Range<D>; D],
    start: Point<f64, D>,
) -> Result<Point<f64, D>> {
    const { assert!(D == 2 || D == 3, "lateration works in the plane and in space") };
    ranges.iter().try_for_each(Range::check)?;
    for &coordinate in start.iter() {
        loc_core::error::finite("start of Newton's method [m]", coordinate)?;
    }
    let mut place = start;
    for _ in 0..STEPS {
        // The identity stands for coordinates that the plane has not.
        let (mut values, mut slopes) = (Vector3::zeros(), Matrix3::identity());
        for (i, range) in ranges.iter().enumerate() {
            values[i] = (place - range.landmark).norm_squared() - range.distance.powi(2);
            for k in 0..D {
                slopes[(i, k)] = 2.0 * (place[k] - range.landmark[k]);
            }
        }
        let Some(step) = slopes.lu().solve(&values) else { break };
        if !step.iter().all(|value| value.is_finite()) {
            break;
        }
        (0..D).for_each(|k| place[k] -= step[k]);
        if step.norm() <= 1e-13 * size(ranges, &place) {
            return Ok(place);
        }
    }
    Err(Error::NoRoot { start: format!("{:?}", start.coords.as_slice()) })
}
// ANCHOR_END: newton

/// The largest number that takes part, to judge rounding by.
fn size<const D: usize>(ranges: &[Range<D>; D], place: &Point<f64, D>) -> f64 {
    let largest = |range: &Range<D>| range.landmark.coords.amax().max(range.distance);
    ranges.iter().map(largest).fold(place.coords.amax(), f64::max)
}
