//! A compass (B5): a magnetometer that finds north.
//!
//! It measures the magnetic field in the plane; its direction is magnetic north. The angle to true
//! north is the declination, for which the [`Compass`] assumes a value that may be wrong. Steel
//! doors and motors disturb the field around them ([`Disturbance`]), iron on the robot turns with
//! it ([`CompassNoise::hard_iron`]). [`CompassReading`] gives the heading and the strength of the
//! field, from which a disturbance can be detected.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::compass::Compass;
//! let compass = Compass::default(); // A map whose x axis points east.
//! let reading = compass.measure(Pose2::new(0.0, 0.0, 0.7), &mut stream(1, "compass"));
//! assert!((reading.heading - 0.7).abs() < 0.1);
//! ```

use crate::Result;
use loc_core::error::{finite, non_negative, positive};
use loc_core::{Pose2, angle};
use nalgebra::{Point2, Vector2};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::FRAC_PI_2;

/// One heading as the compass reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CompassReading {
    /// Heading in the map, counter-clockwise from its x axis, in (-pi, pi] \[rad\].
    pub heading: f64,
    /// Strength of the horizontal field \[uT\]: far from that of the Earth, the heading is wrong.
    pub strength: f64,
}

impl CompassReading {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for NaN, infinity and a negative strength.
    pub fn check(&self) -> Result<()> {
        finite("heading of a compass [rad]", self.heading)?;
        non_negative("strength of the magnetic field [uT]", self.strength)?;
        Ok(())
    }
}

/// Errors of the device itself.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct CompassNoise {
    /// Standard deviation of each component of the field \[uT\]; that of the heading is this by the
    /// strength of the horizontal field.
    pub sigma: f64,
    /// Field of the robot's own iron, which turns with it, forward and left \[uT\].
    pub hard_iron: [f64; 2],
}

impl CompassNoise {
    /// A perfect compass.
    pub const NONE: CompassNoise = CompassNoise { sigma: 0.0, hard_iron: [0.0; 2] };

    /// Honeywell HMC5883L: a field resolution of 2 mG (0.2 uT) by its data sheet, taken for the
    /// standard deviation; 0.6 deg in a field of 20 uT. Calibrated iron.
    pub fn hmc5883l() -> Self {
        CompassNoise { sigma: 0.2, hard_iron: [0.0; 2] }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative sigma, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of the magnetic field [uT]", self.sigma)?;
        for component in self.hard_iron {
            finite("field of the robot's iron [uT]", component)?;
        }
        Ok(())
    }
}

/// A magnetic object in the world: its field is added to the Earth's, strongest in the middle,
/// `field exp(-distance^2 / 2 radius^2)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Disturbance {
    /// Its middle in the map \[m\].
    pub center: [f64; 2],
    /// How far it reaches \[m\].
    pub radius: f64,
    /// Its field in the middle, along the axes of the map \[uT\].
    pub field: [f64; 2],
}

impl Disturbance {
    /// Its field at a place of the map \[uT\].
    pub fn at(&self, place: &Point2<f64>) -> Vector2<f64> {
        let distance = (place - Point2::from(self.center)).norm() / self.radius;
        Vector2::from(self.field) * (-0.5 * distance * distance).exp()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a radius that is not positive, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        for value in self.center {
            finite("middle of a magnetic disturbance [m]", value)?;
        }
        positive("radius of a magnetic disturbance [m]", self.radius)?;
        for value in self.field {
            finite("field of a magnetic disturbance [uT]", value)?;
        }
        Ok(())
    }
}

/// A compass on a robot, and the magnetic field around it.
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
    /// Magnetic objects in the world.
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

    /// The measurement of a robot at `pose`.
    pub fn measure<R: Rng + ?Sized>(&self, pose: Pose2, rng: &mut R) -> CompassReading {
        let (sin, cos) = (self.north - self.declination).sin_cos();
        let earth = Vector2::new(cos, sin) * self.horizontal_field;
        let place = pose.position();
        let in_map = self.disturbances.iter().fold(earth, |sum, source| sum + source.at(&place));
        let noise = Vector2::from_fn(|_, _| StandardNormal.sample(rng)) * self.noise.sigma;
        let iron = Vector2::from(self.noise.hard_iron);
        let field = pose.rotation().transpose() * in_map + iron + noise;
        let assumed_north = self.north - self.assumed_declination;
        CompassReading {
            heading: angle::wrap(assumed_north - field.y.atan2(field.x)),
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
