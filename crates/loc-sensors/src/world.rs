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
