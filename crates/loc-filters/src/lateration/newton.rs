//! Newton's method from a start, as the lectures have it (D1, D3).

use super::Range;
use crate::{Error, Result};
use nalgebra::{Matrix3, Point, Vector3};

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
/// on the line (plane) through the landmarks, from which no way leads to either side.
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
