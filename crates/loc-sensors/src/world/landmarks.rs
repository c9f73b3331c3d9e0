//! The smallest world with landmarks.

use super::LandmarkWorld;
use nalgebra::Point2;

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
