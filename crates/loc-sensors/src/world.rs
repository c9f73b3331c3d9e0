//! What simulated sensors see of a world.
//!
//! A sensor never knows which map it stands in: it asks through these traits, so any map can be
//! its world. [`Landmarks`] is the smallest such world, a plain list.

use nalgebra::Point2;

/// A world with numbered landmarks.
pub trait LandmarkWorld {
    /// Calls `visit` with number and position \[m\] of each landmark at most `radius` \[m\] from
    /// `center`, always in the same order.
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    );
}

/// A world with walls.
pub trait RangeWorld {
    /// Distance from `origin` \[m\] to the first obstacle in `direction` \[rad\], both in the map
    /// frame; `None` where there is none within `max_range` \[m\].
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64>;

    /// The same for a fan of rays from one point, into `ranges`: ray k in direction
    /// `first + k * increment`, +inf where nothing is hit. Worlds that gain by it override it.
    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        for (k, range) in ranges.iter_mut().enumerate() {
            let direction = first + k as f64 * increment;
            *range = self.cast(origin, direction, max_range).unwrap_or(f64::INFINITY);
        }
    }
}

/// A list of numbered landmarks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Landmarks(Vec<(u32, Point2<f64>)>);

impl<const K: usize> From<[(u32, [f64; 2]); K]> for Landmarks {
    fn from(landmarks: [(u32, [f64; 2]); K]) -> Self {
        Landmarks(landmarks.into_iter().map(|(id, xy)| (id, Point2::from(xy))).collect())
    }
}

impl LandmarkWorld for Landmarks {
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    ) {
        for (id, position) in &self.0 {
            if nalgebra::distance(center, position) <= radius {
                visit(*id, *position);
            }
        }
    }
}
