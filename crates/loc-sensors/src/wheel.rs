//! Wheel odometry (B1): the velocity that the wheels report.
//!
//! Each wheel counts its turns; the assumed radius and track convert the counts to a velocity.
//! [`WheelOdometry`] simulates the chain: the true motion turns the true wheels, the systematic
//! causes of E7 ([`WheelFaults`]) act between wheel and ground, random errors follow the error
//! model of E7. [`OdometryCalibration`] is the inverse: it removes the systematic part from a
//! recorded velocity.
//!
//! ```
//! use loc_core::{Twist2, random::stream};
//! use loc_sensors::wheel::{WheelFaults, WheelOdometry};
//! let worn_left_wheel = WheelFaults { left_radius: 0.98, ..WheelFaults::NONE };
//! let odometry = WheelOdometry::new(0.4)?.with_faults(worn_left_wheel)?;
//! let straight = Twist2::forward(1.0, 0.0);
//! let reported = odometry.measure(straight, 0.1, &mut stream(1, "odometry"));
//! assert!(reported.vx > 1.0 && reported.omega < 0.0, "the small wheel turns faster");
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::Result;
use loc_core::Twist2;
use loc_core::error::{finite, non_negative, positive, probability};
use loc_core::kinematics::Differential;
use loc_core::motion::VelocityNoise;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// Simulated wheel odometry of a differential drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelOdometry {
    drive: Differential,
    noise: VelocityNoise,
    faults: WheelFaults,
}

impl WheelOdometry {
    /// Perfect odometry of a drive whose wheels are `track` \[m\] apart.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] unless the track is positive.
    pub fn new(track: f64) -> Result<Self> {
        let drive = Differential::new(track)?;
        Ok(WheelOdometry { drive, noise: VelocityNoise::NONE, faults: WheelFaults::NONE })
    }

    /// Adds random errors after the error model of E7.
    #[must_use]
    pub fn with_noise(mut self, noise: VelocityNoise) -> Self {
        self.noise = noise;
        self
    }

    /// Adds systematic errors.
    ///
    /// # Errors
    /// Those of [`WheelFaults::check`].
    pub fn with_faults(mut self, faults: WheelFaults) -> Result<Self> {
        faults.check()?;
        self.faults = faults;
        Ok(self)
    }

    /// The velocity that the wheels report of a step of `dt` \[s\] at the true velocity `twist`.
    ///
    /// Sideways motion turns no wheel and is not seen.
    pub fn measure<R: Rng + ?Sized>(&self, twist: Twist2, dt: f64, rng: &mut R) -> Twist2 {
        let seen = self.through_the_wheels(twist, dt, rng);
        let sigma = self.noise.variances(twist, dt).map(f64::sqrt);
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        Twist2::forward(seen.vx + sigma.x * draw(), seen.omega + sigma.z * draw())
    }

    /// True velocity -> true rims -> what each wheel turns -> the reported velocity.
    fn through_the_wheels<R: Rng + ?Sized>(&self, twist: Twist2, dt: f64, rng: &mut R) -> Twist2 {
        let half_track = 0.5 * self.drive.track() * self.faults.track;
        let left = twist.vx - twist.omega * half_track;
        let right = twist.vx + twist.omega * half_track;
        let left = self.reported(left, self.faults.left_radius, dt, rng);
        let right = self.reported(right, self.faults.right_radius, dt, rng);
        self.drive.twist(left, right)
    }

    /// The rim speed that one wheel reports while its rim really moves at `rim` \[m/s\].
    ///
    /// Draws the same number of random values whatever the faults are.
    fn reported<R: Rng + ?Sized>(&self, rim: f64, radius: f64, dt: f64, rng: &mut R) -> f64 {
        let faults = &self.faults;
        let mut speed = rim / (radius * (1.0 - faults.sinkage));
        if rng.random::<f64>() < 1.0 - (-faults.slip_rate * dt).exp() {
            speed /= 1.0 - faults.slip;
        }
        if rng.random::<f64>() < 1.0 - (-faults.bumps_per_m * rim.abs() * dt).exp() {
            speed += rim.signum() * faults.bump / dt;
        }
        speed
    }
}

/// Correction of the systematic errors of a recorded velocity.
///
/// ```text
/// v'     = speed_scale v (1 - turn_slowdown |omega|)
/// omega' = turn_scale omega + curvature v
/// ```
///
/// each holding from `delay` after its stamp on. [`OdometryCalibration::NONE`] changes nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct OdometryCalibration {
    /// Time until the robot executes what was recorded \[s\]: positive where commands were
    /// recorded.
    pub delay: f64,
    /// Factor of the forward speed.
    pub speed_scale: f64,
    /// Share of the forward speed lost per turn rate \[s/rad\].
    pub turn_slowdown: f64,
    /// Factor of the turn rate.
    pub turn_scale: f64,
    /// Curvature of the path that was meant to be straight, positive to the left \[1/m\].
    pub curvature: f64,
}

impl OdometryCalibration {
    /// No correction.
    pub const NONE: OdometryCalibration = OdometryCalibration {
        delay: 0.0,
        speed_scale: 1.0,
        turn_slowdown: 0.0,
        turn_scale: 1.0,
        curvature: 0.0,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for values that are not finite, scales that are not positive,
    /// or a negative slowdown.
    pub fn check(&self) -> Result<()> {
        finite("odometry delay [s]", self.delay)?;
        positive("speed scale", self.speed_scale)?;
        non_negative("slowdown in turns [s/rad]", self.turn_slowdown)?;
        positive("turn scale", self.turn_scale)?;
        finite("curvature [1/m]", self.curvature)?;
        Ok(())
    }

    /// The velocity driven, from a recorded one. The slowdown never reverses the robot.
    pub fn correct(&self, recorded: Twist2) -> Twist2 {
        let kept = (1.0 - self.turn_slowdown * recorded.omega.abs()).max(0.0);
        Twist2 {
            vx: self.speed_scale * recorded.vx * kept,
            vy: self.speed_scale * recorded.vy * kept,
            omega: self.turn_scale * recorded.omega + self.curvature * recorded.vx,
        }
    }
}

impl Default for OdometryCalibration {
    fn default() -> Self {
        OdometryCalibration::NONE
    }
}

/// The systematic causes of odometry errors (E7), between the turns of the wheels and the distance
/// driven. [`WheelFaults::NONE`] is a perfect drive.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct WheelFaults {
    /// True radius of the left wheel, as a share of the nominal one (unequal wheel diameters).
    pub left_radius: f64,
    /// True radius of the right wheel, as a share of the nominal one.
    pub right_radius: f64,
    /// True distance between the contact points, as a share of the nominal track (contact point
    /// not at the middle of the wheel).
    pub track: f64,
    /// Share of both wheels' radii that sinks into soft ground.
    pub sinkage: f64,
    /// Share of a wheel's turning that is lost to slip while it accelerates ahead of the ground:
    /// the wheel reports `1/(1 - slip)` of the distance.
    pub slip: f64,
    /// Probability per second that a wheel slips during a step.
    pub slip_rate: f64,
    /// Extra distance that a wheel rolls over a bump \[m\].
    pub bump: f64,
    /// Bumps per metre driven and wheel \[1/m\].
    pub bumps_per_m: f64,
}

impl WheelFaults {
    /// No faults.
    pub const NONE: WheelFaults = WheelFaults {
        left_radius: 1.0,
        right_radius: 1.0,
        track: 1.0,
        sinkage: 0.0,
        slip: 0.0,
        slip_rate: 0.0,
        bump: 0.0,
        bumps_per_m: 0.0,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for radii and tracks that are not positive, shares outside
    /// \[0, 1\], or negative rates.
    pub fn check(&self) -> Result<()> {
        positive("share of the left wheel's radius", self.left_radius)?;
        positive("share of the right wheel's radius", self.right_radius)?;
        positive("share of the wheel track", self.track)?;
        probability("sinkage", self.sinkage)?;
        positive("1 - sinkage", 1.0 - self.sinkage)?;
        probability("slip", self.slip)?;
        positive("1 - slip", 1.0 - self.slip)?;
        non_negative("slip rate [1/s]", self.slip_rate)?;
        non_negative("height of bumps [m]", self.bump)?;
        non_negative("bumps per metre", self.bumps_per_m)?;
        Ok(())
    }
}

impl Default for WheelFaults {
    fn default() -> Self {
        WheelFaults::NONE
    }
}
