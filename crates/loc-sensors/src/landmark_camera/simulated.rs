//! The simulated landmark camera.

use super::{LandmarkNoise, LandmarkObservation, Observed, ObservedKind};
use crate::Result;
use crate::world::LandmarkWorld;
use loc_core::error::{non_negative, positive, probability};
use loc_core::{Pose2, angle};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// A landmark camera on a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LandmarkCamera {
    /// The camera's pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Opening angle, half of it to each side \[rad\]; a full turn sees everything.
    pub fov: f64,
    /// Nearest distance \[m\].
    pub min_range: f64,
    /// Farthest distance \[m\].
    pub max_range: f64,
    /// Which numbers it delivers.
    pub kind: ObservedKind,
    /// Probability that a landmark in view is detected.
    pub detection_probability: f64,
    /// Probability that a detected landmark gets the number of another one in reach.
    pub wrong_identity_probability: f64,
    /// Errors of distance and direction.
    pub noise: LandmarkNoise,
}

impl LandmarkCamera {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for an opening angle or range that is not positive,
    /// probabilities outside \[0, 1\], or bad noise.
    pub fn check(&self) -> Result<()> {
        positive("field of view [rad]", self.fov)?;
        non_negative("nearest range [m]", self.min_range)?;
        positive("farthest range [m] minus nearest", self.max_range - self.min_range)?;
        probability("detection probability", self.detection_probability)?;
        probability("wrong identity probability", self.wrong_identity_probability)?;
        self.noise.check()
    }

    /// Where the camera sees a point of the map: distance \[m\] and direction \[rad\], without
    /// noise; `None` out of view.
    fn view(&self, camera: Pose2, landmark: &nalgebra::Point2<f64>) -> Option<(f64, f64)> {
        let (dx, dy) = (landmark.x - camera.x, landmark.y - camera.y);
        let range = f64::hypot(dx, dy);
        let bearing = angle::wrap(dy.atan2(dx) - camera.theta);
        let in_reach = (self.min_range..=self.max_range).contains(&range);
        (in_reach && bearing.abs() <= 0.5 * self.fov).then_some((range, bearing))
    }

    /// What the camera reports from a robot at `pose`, in the world's order.
    pub fn observe<R: Rng + ?Sized>(
        &self,
        world: &(impl LandmarkWorld + ?Sized),
        pose: Pose2,
        rng: &mut R,
    ) -> Vec<LandmarkObservation> {
        let camera = pose * self.mounting;
        let mut in_reach = Vec::new();
        world.visit_landmarks(&camera.position(), self.max_range, &mut |id, position| {
            in_reach.push((id, position));
        });
        let mut observations = Vec::new();
        for (id, position) in &in_reach {
            let Some((range, bearing)) = self.view(camera, position) else {
                continue;
            };
            if rng.random::<f64>() < self.detection_probability {
                let landmark = self.read_number(*id, &in_reach, rng);
                observations
                    .push(LandmarkObservation { landmark, sight: self.blur(range, bearing, rng) });
            }
        }
        observations
    }

    fn blur<R: Rng + ?Sized>(&self, range: f64, bearing: f64, rng: &mut R) -> Observed {
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        let range = range + self.noise.range_sigma_at(range) * draw();
        let bearing = angle::wrap(bearing + self.noise.bearing_sigma * draw());
        Observed::new(self.kind, range.max(0.0), bearing)
    }

    /// The number that is read off a landmark, now and then that of another one in reach.
    fn read_number<R: Rng + ?Sized, P>(&self, id: u32, in_reach: &[(u32, P)], rng: &mut R) -> u32 {
        let wrong = rng.random::<f64>() < self.wrong_identity_probability;
        let others: Vec<u32> = in_reach.iter().map(|(n, _)| *n).filter(|n| *n != id).collect();
        if wrong && !others.is_empty() { others[rng.random_range(0..others.len())] } else { id }
    }
}

impl Default for LandmarkCamera {
    /// Sees all around up to 10 m, without misses.
    fn default() -> Self {
        LandmarkCamera {
            mounting: Pose2::IDENTITY,
            fov: TAU,
            min_range: 0.0,
            max_range: 10.0,
            kind: ObservedKind::RangeBearing,
            detection_probability: 1.0,
            wrong_identity_probability: 0.0,
            noise: LandmarkNoise::default(),
        }
    }
}
