//! The drives of simulated robots (differential, legs, Ackermann, Mecanum) and their odometry.

use super::{DriveConfig, Segment};
use crate::Result;
use crate::config::field;
use loc_core::Twist2;
use loc_core::kinematics::{Ackermann, Differential, Mecanum, MecanumWheels};
use loc_core::motion::VelocityNoise;
use loc_sensors::encoder::SteeringEncoder;
use loc_sensors::wheel::{WheelFaults, WheelOdometry};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;

/// A differential drive and what its odometry gets wrong.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WheelConfig {
    /// Distance between the wheels \[m\].
    pub track: f64,
    /// Random errors.
    pub noise: Option<VelocityNoise>,
    /// Systematic errors.
    #[serde(default)]
    pub faults: WheelFaults,
}

/// Legs, which carry a robot in every direction, and what its odometry gets wrong (M10).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LegConfig {
    /// Random errors.
    pub noise: VelocityNoise,
}

/// The odometry of a robot.
#[derive(Debug, Clone, Copy)]
pub(super) enum BodyOdometry {
    Wheels(WheelOdometry),
    Ackermann(AckermannOdometry),
    /// Of legs, and of wheels that go in every direction.
    Velocity(VelocityNoise),
}

/// The drive of a robot.
#[derive(Debug, Clone, Copy)]
pub(super) enum Body<'a> {
    Wheels(&'a WheelConfig),
    Legs(&'a LegConfig),
    Ackermann(&'a AckermannConfig),
    Mecanum(&'a MecanumConfig),
}

impl<'a> Body<'a> {
    /// The drive that is configured.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for none and for several.
    pub(super) fn of(drive: &'a DriveConfig) -> Result<Self> {
        let given = [
            drive.wheels.as_ref().map(Body::Wheels),
            drive.legs.as_ref().map(Body::Legs),
            drive.ackermann.as_ref().map(Body::Ackermann),
            drive.mecanum.as_ref().map(Body::Mecanum),
        ];
        let mut given = given.into_iter().flatten();
        match (given.next(), given.next()) {
            (Some(body), None) => Ok(body),
            (first, _) => {
                let keys = "drive.wheels, drive.legs, drive.ackermann, drive.mecanum";
                Err(field(keys, "one of them", if first.is_some() { "several" } else { "none" }))
            }
        }
    }

    /// The velocity from the motion of the wheels, where the segment gives that.
    pub(super) fn by_wheels(self, segment: &Segment) -> Result<Option<Twist2>> {
        let Segment { v, steering, left, right, wheels, .. } = *segment;
        Ok(match (self, left, right, steering, wheels) {
            (Body::Wheels(wheels), Some(left), Some(right), None, None) if v.is_none() => {
                Some(Differential::new(wheels.track)?.twist(left, right))
            }
            (Body::Ackermann(car), None, None, Some(steering), None) => {
                Some(car.kinematics()?.twist(v.unwrap_or(0.0), steering))
            }
            (Body::Mecanum(drive), None, None, None, Some(speeds)) if v.is_none() => {
                Some(drive.twist(speeds)?)
            }
            _ => None,
        })
    }

    /// The keys by which a segment may be given, for errors.
    pub(super) fn segment_keys(self) -> &'static str {
        match self {
            Body::Wheels(_) => "v with omega, or left with right",
            Body::Legs(_) => "v, sideways and omega",
            Body::Ackermann(_) => "v with steering, or v with omega",
            Body::Mecanum(_) => "v, sideways and omega, or four wheels",
        }
    }

    /// Whether this drive can move with a velocity.
    ///
    /// # Errors
    /// [`loc_core::Error::ImpossibleMotion`] for a car that is to turn on the spot.
    pub(super) fn check(self, twist: Twist2) -> Result<()> {
        if let Body::Ackermann(car) = self {
            car.kinematics()?.wheels(twist)?;
        }
        Ok(())
    }

    /// Whether it can go sideways.
    pub(super) fn can_sidestep(self) -> bool {
        matches!(self, Body::Legs(_) | Body::Mecanum(_))
    }

    /// Random errors of its odometry.
    pub(super) fn noise(self) -> Result<VelocityNoise> {
        match self {
            Body::Wheels(WheelConfig { noise, .. })
            | Body::Ackermann(AckermannConfig { noise, .. })
            | Body::Mecanum(MecanumConfig { noise, .. }) => {
                Ok(noise.unwrap_or(VelocityNoise::NONE))
            }
            Body::Legs(legs) => Ok(legs.noise),
        }
    }

    pub(super) fn odometry(self) -> Result<BodyOdometry> {
        let noise = self.noise()?;
        Ok(match self {
            Body::Wheels(wheels) => {
                let odometry = WheelOdometry::new(wheels.track)?.with_noise(noise);
                BodyOdometry::Wheels(odometry.with_faults(wheels.faults)?)
            }
            Body::Ackermann(car) => BodyOdometry::Ackermann(car.odometry(noise)?),
            Body::Legs(_) | Body::Mecanum(_) => BodyOdometry::Velocity(noise),
        })
    }
}

impl BodyOdometry {
    /// The velocity that it reports of a step of `dt` \[s\] at the true velocity `twist`.
    pub(super) fn measure<R: Rng + ?Sized>(
        &mut self,
        twist: Twist2,
        dt: f64,
        rng: &mut R,
    ) -> Twist2 {
        match self {
            BodyOdometry::Wheels(wheels) => wheels.measure(twist, dt, rng),
            BodyOdometry::Ackermann(car) => car.measure(twist, dt, rng),
            BodyOdometry::Velocity(noise) => disturbed(noise, twist, dt, rng),
        }
    }
}

/// A velocity with random errors (E7).
fn disturbed<R: Rng + ?Sized>(
    noise: &VelocityNoise,
    twist: Twist2,
    dt: f64,
    rng: &mut R,
) -> Twist2 {
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

/// A car and what its odometry gets wrong.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AckermannConfig {
    /// From the rear axle, where its pose is, to the front axle \[m\].
    pub wheelbase: f64,
    /// Counts of the steering's encoder in a full turn of the wheels' angle.
    pub steering_counts: u32,
    /// Random errors of speed and turn rate.
    pub noise: Option<VelocityNoise>,
}

impl AckermannConfig {
    /// The library's form.
    fn kinematics(&self) -> Result<Ackermann> {
        Ok(Ackermann::new(self.wheelbase)?)
    }

    fn odometry(&self, noise: VelocityNoise) -> Result<AckermannOdometry> {
        let encoder = SteeringEncoder::new(self.steering_counts)?;
        Ok(AckermannOdometry { kinematics: self.kinematics()?, encoder, noise })
    }
}

/// The odometry of a car: its speed, and the angle that the encoder of the steering counts.
#[derive(Debug, Clone, Copy)]
pub(in crate::source::drive) struct AckermannOdometry {
    kinematics: Ackermann,
    encoder: SteeringEncoder,
    noise: VelocityNoise,
}

impl AckermannOdometry {
    fn measure<R: Rng + ?Sized>(&mut self, twist: Twist2, dt: f64, rng: &mut R) -> Twist2 {
        let felt = Twist2 { vy: 0.0, ..disturbed(&self.noise, twist, dt, rng) };
        // The steering angle of a car at rest does not follow from its motion.
        let Ok((speed, steering)) = self.kinematics.wheels(felt) else { return felt };
        let count = self.encoder.measure(steering, rng);
        self.kinematics.twist(speed, self.encoder.angle(count))
    }
}

/// A Mecanum drive and what its odometry gets wrong.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MecanumConfig {
    /// Between front and rear axle \[m\].
    pub wheelbase: f64,
    /// Between left and right wheels \[m\].
    pub track: f64,
    /// Random errors.
    pub noise: Option<VelocityNoise>,
}

impl MecanumConfig {
    /// The velocity at rim speeds of the wheels: front left and right, rear left and right \[m/s\].
    fn twist(&self, speeds: [f64; 4]) -> Result<Twist2> {
        let [front_left, front_right, rear_left, rear_right] = speeds;
        let wheels = MecanumWheels { front_left, front_right, rear_left, rear_right };
        Ok(Mecanum::new(self.wheelbase, self.track)?.twist(wheels))
    }
}
