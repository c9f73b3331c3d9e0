//! Places to start from, in closed form.
//!
//! The difference of two equations `|x - l_i|^2 = d_i^2` is linear in x. Landmarks that do not lie
//! on one line (plane) so determine the place; those that do leave out the direction across it, in
//! which the mean of the equations gives the distance, to either side.

use super::Range;
use crate::{Error, Result};
use nalgebra::{Matrix3, Point, SymmetricEigen, Vector3};

/// The landmarks' extent across their line (plane) may be this share of that along it before it
/// counts.
const FLAT: f64 = 1e-6;
/// Below this share of the whole extent they lie at one place.
const POINT: f64 = 1e-12;

/// Candidates for the place of ranges in a frame in which their extent is 1, of which each is near a minimum of the cost if the ranges fit: first
/// those on both sides of the line (plane) that fits the landmarks best, then, where the landmarks
/// do not lie on it, that of the linear equations.
///
/// # Errors
/// [`Error::Undetermined`] where too many directions are left out.
pub(super) fn candidates<const D: usize>(ranges: &[Range<D>]) -> Result<Vec<Point<f64, D>>> {
    let count = ranges.len() as f64;
    let landmarks: Vec<Vector3<f64>> = ranges.iter().map(in_space).collect();
    let middle = landmarks.iter().sum::<Vector3<f64>>() / count;
    let arms: Vec<_> = landmarks.iter().map(|landmark| landmark - middle).collect();
    let mean_square = ranges.iter().map(|r| r.distance * r.distance).sum::<f64>() / count;
    let mean_arm = arms.iter().map(Vector3::norm_squared).sum::<f64>() / count;
    // Least squares of arm . x = (|arm|^2 - mean - (d^2 - mean)) / 2.
    let right = |arm: &Vector3<f64>, r: &Range<D>| {
        0.5 * (arm.norm_squared() - mean_arm - (r.distance * r.distance - mean_square))
    };
    let sides: Vector3<f64> = arms.iter().zip(ranges).map(|(a, r)| a * right(a, r)).sum();
    let (axes, extents) = principal_axes::<D>(&arms);
    // Whole numbers below the number of coordinates.
    let (across, before) = (D - 1, D - 2);
    if extents[before] <= f64::max(FLAT * extents[0], POINT) {
        return Err(undetermined(D, extents[0] > POINT));
    }
    let along = |k: usize| axes[k] * (axes[k].dot(&sides) / extents[k].powi(2));
    let foot: Vector3<f64> = (0..across).map(along).sum();
    let squared = mean_square - mean_arm - foot.norm_squared();
    let height = axes[across] * squared.max(0.0).sqrt();
    let mut places = vec![foot + height, foot - height];
    if extents[across] > FLAT * extents[0] {
        places.push(foot + along(across));
    }
    // Distances that contradict each other may fit best somewhere else.
    let far = mean_square.sqrt();
    places.extend(axes.iter().take(D).flat_map(|axis| [axis * far, -axis * far]));
    let place = |place: Vector3<f64>| Point::from(std::array::from_fn(|k| (middle + place)[k]));
    Ok(places.into_iter().map(place).collect())
}

/// A landmark with zeros for the coordinates that it has not.
fn in_space<const D: usize>(range: &Range<D>) -> Vector3<f64> {
    Vector3::from_fn(|k, _| range.landmark.coords.get(k).copied().unwrap_or(0.0))
}

/// The principal axes of points about their middle, and the extents along them, the longest first.
/// Coordinates that the points have not come last.
fn principal_axes<const D: usize>(arms: &[Vector3<f64>]) -> ([Vector3<f64>; 3], [f64; 3]) {
    let mut scatter: Matrix3<f64> = arms.iter().map(|arm| arm * arm.transpose()).sum();
    for k in D..3 {
        scatter[(k, k)] = -scatter.trace();
    }
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(scatter);
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigenvalues[j].total_cmp(&eigenvalues[i]));
    (
        order.map(|k| eigenvectors.column(k).into_owned()),
        order.map(|k| eigenvalues[k].max(0.0).sqrt()),
    )
}

fn undetermined(coordinates: usize, apart: bool) -> Error {
    let expected = match coordinates {
        2 => "landmarks at two different places or more",
        _ => "landmarks that do not lie on one line",
    };
    Error::Undetermined {
        expected,
        found: ["all at one place", "all on one line"][usize::from(apart)].into(),
    }
}
