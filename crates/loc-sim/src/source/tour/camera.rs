//! The camera that sees the landmarks of the building, as far as no wall is before them.

use super::{TourConfig, TourWorld};
use crate::Result;
use loc_core::Pose2;
use loc_core::random::{ChaCha8Rng, stream};
use loc_maps::LandmarkMap;
use loc_sensors::event::Measurement;
use loc_sensors::landmark_camera::LandmarkCamera;
use loc_sensors::world::{LandmarkWorld, RangeWorld};
use nalgebra::Point2;

/// A landmark hangs on a wall, hence within a cell or two of one \[m\].
const ON_THE_WALL: f64 = 0.15;

/// A camera that looks now and then.
#[derive(Debug)]
pub(super) struct TourCamera {
    camera: LandmarkCamera,
    every: usize,
    rng: ChaCha8Rng,
}

impl TourCamera {
    /// The camera, where the configuration has one.
    pub(super) fn new(config: &TourConfig, seed: u64) -> Result<Option<Self>> {
        let Some(camera) = &config.camera else { return Ok(None) };
        Ok(Some(TourCamera {
            camera: camera.camera()?,
            every: config.steps("tour.camera.every_s", camera.every_s)?,
            rng: stream(seed, "camera"),
        }))
    }

    /// What it sees at a step, where it looks and something is in view.
    pub(super) fn look(
        &mut self,
        step: usize,
        world: &TourWorld,
        pose: Pose2,
    ) -> Option<Measurement> {
        if !step.is_multiple_of(self.every) {
            return None;
        }
        let observations = self.camera.observe(&InSight(world), pose, &mut self.rng);
        (!observations.is_empty()).then_some(Measurement::Landmarks(observations))
    }
}

/// The landmarks of a building that no wall hides.
struct InSight<'a>(&'a TourWorld);

impl LandmarkWorld for InSight<'_> {
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    ) {
        let landmarks: &LandmarkMap = &self.0.landmarks;
        landmarks.visit_landmarks(center, radius, &mut |id, position| {
            let way = position - center;
            let free = way.norm() - ON_THE_WALL;
            if free <= 0.0 || self.0.walls.cast(center, way.y.atan2(way.x), free).is_none() {
                visit(id, position);
            }
        });
    }
}
