//! The simulated compass.

use super::{CompassNoise, CompassReading, Disturbance};
use crate::Result;
use loc_core::error::{finite, positive};
use loc_core::{Pose2, angle};
use nalgebra::Vector2;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::FRAC_PI_2;

/// A compass on a robot, and the field it stands in.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct Compass {
    /// Direction of true north in the map, counter-clockwise from its x axis \[rad\].
    pub north: f64,
    /// By how much magnetic north lies east of true north \[rad\].
    pub declination: f64,
    /// The declination that the compass is set to \[rad\].
    pub assumed_declination: f64,
    /// Strength of the Earth's horizontal field \[uT\].
    pub horizontal_field: f64,
    /// Errors of the device.
    pub noise: CompassNoise,
    /// What else is magnetic in the world.
    pub disturbances: Vec<Disturbance>,
}

impl Compass {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for angles that are not finite, a field that is not positive,
    /// and those of [`CompassNoise::check`] and [`Disturbance::check`].
    pub fn check(&self) -> Result<()> {
        finite("direction of north [rad]", self.north)?;
        finite("declination [rad]", self.declination)?;
        finite("assumed declination [rad]", self.assumed_declination)?;
        positive("horizontal magnetic field [uT]", self.horizontal_field)?;
        self.noise.check()?;
        self.disturbances.iter().try_for_each(Disturbance::check)
    }

    /// The heading that a robot at `pose` reads.
    pub fn measure<R: Rng + ?Sized>(&self, pose: Pose2, rng: &mut R) -> CompassReading {
        let (sin, cos) = (self.north - self.declination).sin_cos();
        let earth = Vector2::new(cos, sin) * self.horizontal_field;
        let place = pose.position();
        let in_map = self.disturbances.iter().fold(earth, |sum, bent| sum + bent.at(&place));
        let noise = Vector2::from_fn(|_, _| StandardNormal.sample(rng)) * self.noise.sigma;
        let iron = Vector2::from(self.noise.hard_iron);
        let field = pose.rotation().transpose() * in_map + iron + noise;
        let believed_north = self.north - self.assumed_declination;
        CompassReading {
            heading: angle::wrap(believed_north - field.y.atan2(field.x)),
            strength: field.norm(),
        }
    }

    /// Standard deviation of the heading in an undisturbed field, small against a turn \[rad\].
    pub fn heading_sigma(&self) -> f64 {
        self.noise.sigma / self.horizontal_field
    }
}

impl Default for Compass {
    /// In a map whose x axis points east, y north, in a clean field of 20 uT (central Europe)
    /// without declination, with the noise of [`CompassNoise::hmc5883l`].
    fn default() -> Self {
        Compass {
            north: FRAC_PI_2,
            declination: 0.0,
            assumed_declination: 0.0,
            horizontal_field: 20.0,
            noise: CompassNoise::hmc5883l(),
            disturbances: Vec::new(),
        }
    }
}
