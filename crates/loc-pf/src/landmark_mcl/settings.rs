//! All settings of Monte Carlo localization with landmarks.

use crate::sensor::landmark::ObservationModel;
use crate::{Resampling, Result};
use loc_core::error::{in_range, positive, probability};
use loc_core::motion::{Integration, VelocityNoise};

/// Settings of [`LandmarkMcl`](super::LandmarkMcl), with defaults that serve a small indoor robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct LandmarkMclSettings {
    /// Number of particles.
    pub particles: usize,
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// How far odometry may be off.
    pub motion_noise: VelocityNoise,
    /// How observations come about.
    pub sights: ObservationModel,
    /// How far the robot may be outside of the box around the landmarks \[m\].
    pub margin: f64,
    /// The particle set is resampled where its effective sample size falls below this share.
    pub resample_below: f64,
    /// How particles are drawn.
    pub resampling: Resampling,
    /// How far resampled particles are moved apart, as a share of what suits a normal distribution,
    /// in \[0, 1\]: copies of one particle would stay copies on a robot that stands still. At most
    /// a quarter of an observation's sigma.
    pub roughening: f64,
    /// What to do when lost.
    pub recovery: RecoverySettings,
    /// Number of threads.
    pub threads: usize,
}

/// When observations no longer fit, particles are put where they would (augmented MCL).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct RecoverySettings {
    /// Decay of the slow average of how well observations fit; also known as alpha_slow.
    pub alpha_slow: f64,
    /// Decay of the fast one; 0 for no recovery. Also known as alpha_fast.
    pub alpha_fast: f64,
    /// The fast average must fall below the slow one divided by this before anything is done; the
    /// share of new particles is then `1 - fast / slow`. 1 is the textbook, which replaces a few
    /// whenever observations fit a little worse than usual.
    pub factor: f64,
    /// Share of the new particles that are put where the observations are, the others anywhere.
    pub sensor_resetting: f64,
}

impl Default for LandmarkMclSettings {
    fn default() -> Self {
        LandmarkMclSettings {
            particles: 2000,
            integration: Integration::default(),
            motion_noise: VelocityNoise::default(),
            sights: ObservationModel::default(),
            margin: 1.0,
            resample_below: 0.5,
            resampling: Resampling::default(),
            roughening: 1.0,
            recovery: RecoverySettings::default(),
            threads: 1,
        }
    }
}

impl Default for RecoverySettings {
    fn default() -> Self {
        RecoverySettings { alpha_slow: 0.01, alpha_fast: 0.1, factor: 2.0, sensor_resetting: 0.9 }
    }
}

impl LandmarkMclSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`] naming the first that is not
    /// allowed.
    pub fn validate(&self) -> Result<()> {
        if self.particles == 0 {
            let (what, expected) = ("particles", "at least 1");
            return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
        }
        self.motion_noise.check()?;
        self.sights.validate()?;
        positive("margin around the landmarks [m]", self.margin)?;
        probability("resample_below", self.resample_below)?;
        probability("roughening", self.roughening)?;
        self.recovery.validate()?;
        Ok(())
    }
}

impl RecoverySettings {
    fn validate(&self) -> Result<()> {
        probability("alpha_slow", self.alpha_slow)?;
        probability("alpha_fast", self.alpha_fast)?;
        let at_least_1 = |factor: f64| factor.is_finite() && factor >= 1.0;
        in_range("recovery factor", "a finite number >= 1", self.factor, at_least_1)?;
        probability("share of sensor resetting", self.sensor_resetting)?;
        Ok(())
    }
}
