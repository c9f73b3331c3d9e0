//! The simulated receiver.

use super::{GnssFix, GnssNoise, LocalFrame, Outages};
use crate::Result;
use loc_core::Pose2;
use nalgebra::{Matrix3, Vector3};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// A receiver on a robot whose map frame is a local frame: x east, y north.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gnss {
    frame: LocalFrame,
    noise: GnssNoise,
    outages: Outages,
    mounting: Pose2,
    /// The drifting error, unknown before the first fix.
    drift: Option<Vector3<f64>>,
    out: bool,
}

impl Gnss {
    /// A receiver with the noise of [`GnssNoise::neo_m8`] and without outages, in the middle of
    /// the robot.
    pub fn new(frame: LocalFrame) -> Self {
        Gnss {
            frame,
            noise: GnssNoise::neo_m8(),
            outages: Outages::NONE,
            mounting: Pose2::IDENTITY,
            drift: None,
            out: false,
        }
    }

    /// Sets the errors.
    ///
    /// # Errors
    /// Those of [`GnssNoise::check`].
    pub fn with_noise(mut self, noise: GnssNoise) -> Result<Self> {
        noise.check()?;
        self.noise = noise;
        Ok(self)
    }

    /// Sets the outages.
    ///
    /// # Errors
    /// Those of [`Outages::check`].
    pub fn with_outages(mut self, outages: Outages) -> Result<Self> {
        outages.check()?;
        self.outages = outages;
        Ok(self)
    }

    /// Sets the place of the antenna, `base_from_antenna`.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a pose that is not finite.
    pub fn with_mounting(mut self, mounting: Pose2) -> Result<Self> {
        crate::check::finite_pose("mounting of an antenna", mounting)?;
        self.mounting = mounting;
        Ok(self)
    }

    /// The true drift of the last fix, east, north and up \[m\]; `None` before the first one.
    pub fn drift(&self) -> Option<Vector3<f64>> {
        let scale = Vector3::new(1.0, 1.0, self.noise.vertical_factor);
        self.drift.map(|drift| drift.component_mul(&scale))
    }

    /// The fix of a robot at `pose`, `dt` \[s\] after the last call; `None` during an outage.
    ///
    /// The claimed covariance is that of the whole error, drift included. Draws the same number of
    /// random values in and out of an outage.
    pub fn measure<R: Rng + ?Sized>(
        &mut self,
        pose: Pose2,
        dt: f64,
        rng: &mut R,
    ) -> Option<GnssFix> {
        let out = self.outages.probability_after(self.out, dt);
        self.out = rng.random::<f64>() < out;
        let scale = Vector3::new(1.0, 1.0, self.noise.vertical_factor);
        let error = self.next_drift(dt, rng) + normal3(rng) * self.noise.white_sigma;
        let antenna = pose * self.mounting;
        let enu = Vector3::new(antenna.x, antenna.y, 0.0) + error.component_mul(&scale);
        let variance = scale.component_mul(&scale) * self.noise.sigma().powi(2);
        let covariance = Matrix3::from_diagonal(&variance);
        let fix = GnssFix { position: self.frame.to_geodetic(&enu), covariance };
        (!self.out).then_some(fix)
    }

    /// Moves the drift on; the first one is drawn from where the process settles.
    fn next_drift<R: Rng + ?Sized>(&mut self, dt: f64, rng: &mut R) -> Vector3<f64> {
        let kept = self.drift.map_or(0.0, |_| (-dt / self.noise.drift_time).exp());
        let fresh = self.noise.drift_sigma * (1.0 - kept * kept).max(0.0).sqrt();
        let drift = self.drift.unwrap_or_default() * kept + normal3(rng) * fresh;
        self.drift = Some(drift);
        drift
    }
}

fn normal3<R: Rng + ?Sized>(rng: &mut R) -> Vector3<f64> {
    Vector3::from_fn(|_, _| StandardNormal.sample(rng))
}
