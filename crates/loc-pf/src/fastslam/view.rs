//! How far the camera has been seen to see.

use super::look::Place;
use nalgebra::Point2;

/// The part of the surroundings that the camera sees. Landmarks well within it should be seen
/// again.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct View {
    range: f64,
    bearing: f64,
}

impl View {
    /// The part of the view in which a landmark should be seen.
    const MIDDLE: f64 = 0.7;
    /// The least that a camera is taken to see \[m, rad\].
    const MIN_RANGE: f64 = 1.0;
    const MIN_BEARING: f64 = 0.25;
    /// A provisional landmark that is farther away than this, in ranges, has had its chance.
    const GONE: f64 = 1.5;

    pub(super) fn include(&mut self, place: &Place) {
        self.range = self.range.max(place.range);
        self.bearing = self.bearing.max(place.bearing.abs());
    }

    /// Density in distance and direction of something new that is anywhere in the view, where a
    /// observation at distance `range` \[m\] was: in polar coordinates far things are denser.
    pub(super) fn density(&self, range: f64) -> f64 {
        let (farthest, widest) =
            (self.range.max(Self::MIN_RANGE), self.bearing.max(Self::MIN_BEARING));
        range / (farthest * farthest * widest)
    }

    pub(super) fn should_see(&self, from_camera: &Point2<f64>) -> bool {
        from_camera.coords.norm() < Self::MIDDLE * self.range
            && from_camera.y.atan2(from_camera.x).abs() < Self::MIDDLE * self.bearing
    }

    pub(super) fn has_left(&self, from_camera: &Point2<f64>) -> bool {
        from_camera.coords.norm() > Self::GONE * self.range
    }
}
