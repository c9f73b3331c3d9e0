//! FastSLAM on time-stamped inputs.

use super::{FastSlam, FastSlamSettings, finite_twist};
use crate::Result;
use loc_core::motion::dead_reckon;
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Twist2};
use loc_filters::RobotSettings;
use loc_filters::delayed::{Clock, Sequential};
use loc_filters::localizer::{
    Estimate, EstimatedMap, Localizer, Outcome, ParticleSet, observed_position,
};
use loc_filters::slam::Identities;
use loc_sensors::event::{Control, Measurement};

/// FastSLAM over time-stamped inputs in order; [`Delayed`](loc_filters::delayed::Delayed) around it
/// takes late ones, with copies that share their maps.
///
/// A velocity holds from its stamp until the next one. Observations may come between velocities,
/// several at one stamp, or not at all.
#[derive(Debug, Clone)]
pub struct FastSlamLocalizer {
    slam: FastSlam,
    clock: Clock,
    twist: Twist2,
}

impl FastSlamLocalizer {
    /// A localizer without a map that stands still at `stamp` \[s\] with a belief over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(
        settings: FastSlamSettings,
        stamp: f64,
        start: Gaussian<3>,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        let clock = Clock::starting_at(stamp)?;
        let slam = FastSlam::new(start, settings, rng)?;
        Ok(FastSlamLocalizer { slam, clock, twist: Twist2::ZERO })
    }

    /// The filter after the last input.
    pub fn slam(&self) -> &FastSlam {
        &self.slam
    }

    fn predict_to(&mut self, what: &'static str, stamp: f64) -> loc_filters::Result<()> {
        let dt = self.clock.advance(what, stamp)?;
        if dt > 0.0 {
            self.slam.predict(self.twist, dt)?;
        }
        Ok(())
    }
}

impl Localizer for FastSlamLocalizer {
    fn predict(&mut self, stamp: f64, control: &Control) -> loc_filters::Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        finite_twist(*twist)?;
        self.predict_to("velocity", stamp)?;
        self.twist = *twist;
        Ok(())
    }

    fn correct(
        &mut self,
        stamp: f64,
        measurement: &Measurement,
    ) -> loc_filters::Result<Vec<Outcome>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        for observation in observations {
            observation.observed.check()?;
        }
        self.predict_to("observations", stamp)?;
        let mut outcomes = self.slam.correct(observations)?;
        let camera = self.slam.pose()?.pose() * self.slam.settings().robot.mounting;
        for (outcome, observation) in outcomes.iter_mut().zip(observations) {
            outcome.observed_at = observed_position(camera, observation);
        }
        Ok(outcomes)
    }

    fn estimate(&self, stamp: f64) -> loc_filters::Result<Estimate> {
        let dt = self.clock.until(loc_core::error::finite("stamp [s]", stamp)?);
        let pose = self.slam.pose()?;
        if dt <= 0.0 {
            return Ok(pose.into());
        }
        let RobotSettings { integration, odometry, .. } = &self.slam.settings().robot;
        Ok(dead_reckon(&pose, self.twist, dt, *integration, odometry).into())
    }

    fn particle_count(&self) -> usize {
        self.slam.settings().particles
    }

    fn particle_set(&self, max: usize) -> Option<ParticleSet> {
        Some(ParticleSet { particles: self.slam.particles().thinned(max), weighted: None })
    }

    fn map(&self) -> loc_filters::Result<Option<EstimatedMap>> {
        let known_association = self.slam.settings().identities == Identities::Known;
        Ok(Some(EstimatedMap { known_association, landmarks: self.slam.landmarks()? }))
    }
}

impl Sequential for FastSlamLocalizer {
    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Landmarks(_))
    }
}
