//! What moves a simulated robot, and how it feels its own motion.

use crate::Result;
use crate::config::field;
use crate::source::OdometryNoiseConfig;
use loc_core::Twist2;
use loc_core::kinematics::Differential;
use loc_core::motion::VelocityNoise;
use loc_sensors::wheel::{WheelFaults, WheelOdometry};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

/// A differential drive and what its odometry gets wrong.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelConfig {
    /// Distance between the wheels.
    pub track_m: f64,
    /// Random errors.
    pub noise: Option<OdometryNoiseConfig>,
    /// Systematic errors.
    #[serde(default)]
    pub faults: WheelFaults,
}

/// Legs, which carry a robot in every direction, and what its odometry gets wrong (M10).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LegConfig {
    /// Random errors.
    pub noise: OdometryNoiseConfig,
}

/// The odometry of a robot on wheels or legs.
#[derive(Debug, Clone, Copy)]
pub(super) enum BodyOdometry {
    Wheels(WheelOdometry),
    Legs(VelocityNoise),
}

/// What a robot stands on.
#[derive(Debug, Clone, Copy)]
pub(super) enum Body<'a> {
    Wheels(&'a WheelConfig),
    Legs(&'a LegConfig),
}

impl<'a> Body<'a> {
    /// The one of the two that is given.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for none and both.
    pub(super) fn of(wheels: Option<&'a WheelConfig>, legs: Option<&'a LegConfig>) -> Result<Self> {
        match (wheels, legs) {
            (Some(wheels), None) => Ok(Body::Wheels(wheels)),
            (None, Some(legs)) => Ok(Body::Legs(legs)),
            (Some(_), Some(_)) => Err(field("drive.wheels, drive.legs", "one of the two", "both")),
            (None, None) => Err(field("drive.wheels, drive.legs", "one of the two", "none")),
        }
    }

    /// The velocity at given speeds of two wheels \[m/s\]; `None` for a robot on legs.
    pub(super) fn by_wheels(self, left: f64, right: f64) -> Result<Option<Twist2>> {
        Ok(match self {
            Body::Wheels(wheels) => Some(Differential::new(wheels.track_m)?.twist(left, right)),
            Body::Legs(_) => None,
        })
    }

    /// Whether it can go sideways.
    pub(super) fn can_sidestep(self) -> bool {
        matches!(self, Body::Legs(_))
    }

    /// Random errors of its odometry.
    pub(super) fn noise(self) -> Result<VelocityNoise> {
        match self {
            Body::Wheels(wheels) => {
                wheels.noise.map_or(Ok(VelocityNoise::NONE), |noise| noise.noise())
            }
            Body::Legs(legs) => legs.noise.noise(),
        }
    }

    pub(super) fn odometry(self) -> Result<BodyOdometry> {
        let noise = self.noise()?;
        Ok(match self {
            Body::Wheels(wheels) => {
                let odometry = WheelOdometry::new(wheels.track_m)?.with_noise(noise);
                BodyOdometry::Wheels(odometry.with_faults(wheels.faults)?)
            }
            Body::Legs(_) => BodyOdometry::Legs(noise),
        })
    }
}

impl BodyOdometry {
    /// The velocity that it reports of a step of `dt` \[s\] at the true velocity `twist`.
    pub(super) fn measure<R: Rng + ?Sized>(&self, twist: Twist2, dt: f64, rng: &mut R) -> Twist2 {
        match self {
            BodyOdometry::Wheels(wheels) => wheels.measure(twist, dt, rng),
            BodyOdometry::Legs(noise) => {
                let sigmas = noise.variances(twist, dt).map(f64::sqrt);
                let mut draw = |mean: f64, sigma: f64| -> f64 {
                    let unit: f64 = StandardNormal.sample(rng);
                    mean + sigma * unit
                };
                Twist2 {
                    vx: draw(twist.vx, sigmas.x),
                    vy: draw(twist.vy, sigmas.y),
                    omega: draw(twist.omega, sigmas.z),
                }
            }
        }
    }
}
