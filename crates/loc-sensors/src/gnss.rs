//! Satellite positioning (B10), such as GPS: the position on the Earth, outdoors.
//!
//! A receiver gives latitude, longitude and height, [`Geodetic`], on the ellipsoid WGS84. A robot
//! counts metres in a plane: [`LocalFrame`] converts both ways, exactly, between the ellipsoid and
//! the frame east-north-up (ENU) that touches it at an origin. [`GnssFix`] is one measurement,
//! [`GnssNoise`] is its error model, and [`Gnss`] simulates the receiver, with
//! errors correlated in time, as those of satellites are, and with outages.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::gnss::{Geodetic, Gnss, LocalFrame};
//! let osnabrueck = Geodetic::from_degrees(52.2719, 8.0443, 64.0)?;
//! let frame = LocalFrame::new(osnabrueck)?;
//! let mut receiver = Gnss::new(frame);
//! let pose = Pose2::new(100.0, 50.0, 0.0);
//! let fix = receiver.measure(pose, 1.0, &mut stream(1, "gnss")).unwrap();
//! let enu = frame.to_enu(&fix.position);
//! assert!((enu.x - 100.0).hypot(enu.y - 50.0) < 15.0);
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::Result;
use crate::check::in_range;
use loc_core::error::{non_negative, positive};
use loc_core::{Gaussian, Pose2};
use nalgebra::{Matrix3, Vector2, Vector3};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{FRAC_PI_2, TAU};

/// One position as the receiver reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GnssFix {
    /// The measured position.
    pub position: Geodetic,
    /// Covariance of east, north and up that it claims \[m^2\].
    pub covariance: Matrix3<f64>,
}

impl GnssFix {
    /// The position in the plane of a local frame, east and north \[m\].
    pub fn in_plane(&self, frame: &LocalFrame) -> Gaussian<2> {
        let enu = frame.to_enu(&self.position);
        let covariance = self.covariance.fixed_view::<2, 2>(0, 0).into();
        Gaussian { mean: Vector2::new(enu.x, enu.y), covariance }
    }
}

/// Errors of a position: a part that is new with every fix, and one that drifts (satellites,
/// ionosphere), a first-order Gauss-Markov process.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct GnssNoise {
    /// Standard deviation of the new part, east and north \[m\].
    pub white_sigma: f64,
    /// Standard deviation of the drifting part, east and north \[m\].
    pub drift_sigma: f64,
    /// Time constant of the drift: its autocorrelation falls to 1/e \[s\].
    pub drift_time: f64,
    /// Factor of the vertical errors.
    pub vertical_factor: f64,
}

impl GnssNoise {
    /// A perfect receiver.
    pub const NONE: GnssNoise =
        GnssNoise { white_sigma: 0.0, drift_sigma: 0.0, drift_time: 1.0, vertical_factor: 1.0 };

    /// u-blox NEO-M8: position accuracy 2.5 m CEP by its data sheet, which is 2.1 m standard
    /// deviation in each direction. That most of it drifts within minutes is the nature of the
    /// error; the shares are an assumption.
    pub fn neo_m8() -> Self {
        GnssNoise { white_sigma: 0.6, drift_sigma: 2.0, drift_time: 120.0, vertical_factor: 1.5 }
    }

    /// Standard deviation of the whole error, east and north \[m\].
    pub fn sigma(&self) -> f64 {
        f64::hypot(self.white_sigma, self.drift_sigma)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN, infinity, and a drift time that is
    /// not positive.
    pub fn check(&self) -> Result<()> {
        non_negative("white sigma of a position [m]", self.white_sigma)?;
        non_negative("drift sigma of a position [m]", self.drift_sigma)?;
        positive("time constant of a position's drift [s]", self.drift_time)?;
        non_negative("factor of vertical errors", self.vertical_factor)?;
        Ok(())
    }
}

/// Times without a position, such as under bridges: they begin at random and last at random, both
/// exponentially distributed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Outages {
    /// How many begin per second \[1/s\].
    pub rate: f64,
    /// How long one lasts on average \[s\].
    pub mean_duration: f64,
}

impl Outages {
    /// None at all.
    pub const NONE: Outages = Outages { rate: 0.0, mean_duration: 1.0 };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative rate, or a duration that is not positive.
    pub fn check(&self) -> Result<()> {
        non_negative("outages per second [1/s]", self.rate)?;
        positive("mean duration of outages [s]", self.mean_duration)?;
        Ok(())
    }

    /// Probability that the receiver is out of service `dt` \[s\] after it was (`true`) or was not
    /// (`false`): the exact transition of the two-state process.
    pub fn probability_after(&self, out: bool, dt: f64) -> f64 {
        let recovery = 1.0 / self.mean_duration;
        let settled = self.rate / (self.rate + recovery);
        let start = if out { 1.0 } else { 0.0 };
        settled + (start - settled) * (-(self.rate + recovery) * dt).exp()
    }
}

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

    /// The true drift at the last fix, east, north and up \[m\]; `None` before the first one.
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

    /// Advances the drift by one step; the first one is drawn from the stationary distribution.
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

/// Semi-major axis of WGS84 \[m\].
const A: f64 = 6_378_137.0;
/// Flattening of WGS84.
const F: f64 = 1.0 / 298.257_223_563;
/// Square of its first eccentricity.
const E2: f64 = F * (2.0 - F);

/// A place by latitude and longitude on the ellipsoid WGS84.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Geodetic {
    /// Latitude, north positive \[rad\].
    pub latitude: f64,
    /// Longitude, east positive \[rad\].
    pub longitude: f64,
    /// Height above the ellipsoid \[m\].
    pub height: f64,
}

impl Geodetic {
    /// A place from latitude and longitude \[deg\] and height \[m\].
    ///
    /// # Errors
    /// Those of [`Geodetic::check`].
    pub fn from_degrees(latitude_deg: f64, longitude_deg: f64, height: f64) -> Result<Self> {
        let place = Geodetic {
            latitude: latitude_deg.to_radians(),
            longitude: longitude_deg.to_radians(),
            height,
        };
        place.check()?;
        Ok(place)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for latitudes beyond the poles, longitudes of more than a
    /// turn, and heights of more than 10000 km.
    pub fn check(&self) -> Result<()> {
        let within = |bound: f64| move |value: f64| value.abs() <= bound;
        in_range("latitude [rad]", "-pi/2 to pi/2", self.latitude, within(FRAC_PI_2))?;
        in_range("longitude [rad]", "-2 pi to 2 pi", self.longitude, within(TAU))?;
        in_range("height [m]", "-1e6 to 1e7", self.height, |h| (-1e6..=1e7).contains(&h))?;
        Ok(())
    }

    /// The place in the frame that turns with the Earth (ECEF): x to the equator at longitude 0, z
    /// to the north pole \[m\].
    pub fn to_ecef(&self) -> Vector3<f64> {
        let (sin_lat, cos_lat) = self.latitude.sin_cos();
        let (sin_lon, cos_lon) = self.longitude.sin_cos();
        let normal = A / (1.0 - E2 * sin_lat * sin_lat).sqrt();
        let across = (normal + self.height) * cos_lat;
        let up = (normal * (1.0 - E2) + self.height) * sin_lat;
        Vector3::new(across * cos_lon, across * sin_lon, up)
    }

    /// The place of a point of the Earth's frame \[m\]; below 1e-9 m from the inverse of
    /// [`to_ecef`](Geodetic::to_ecef) anywhere but within 100 km of the Earth's centre.
    pub fn from_ecef(point: &Vector3<f64>) -> Self {
        let across = f64::hypot(point.x, point.y);
        // Bowring's start, then his fixed point on the parametric latitude; each round gains more
        // than three digits near the surface.
        let ratio = 1.0 - F;
        let mut tan_reduced = point.z / (ratio * across);
        let mut latitude = 0.0;
        for _ in 0..5 {
            let reduced = tan_reduced.atan();
            let (sin, cos) = reduced.sin_cos();
            let above = point.z + E2 / (1.0 - E2) * ratio * A * sin.powi(3);
            latitude = above.atan2(across - E2 * A * cos.powi(3));
            tan_reduced = ratio * latitude.tan();
        }
        let (sin, cos) = latitude.sin_cos();
        // Along the normal: stable at the poles and at the equator alike.
        let height = across * cos + point.z * sin - A * (1.0 - E2 * sin * sin).sqrt();
        Geodetic { latitude, longitude: point.y.atan2(point.x), height }
    }
}

/// A flat frame that touches the ellipsoid at an origin: x east, y north, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    origin: Geodetic,
    origin_in_ecef: Vector3<f64>,
    enu_from_ecef: Matrix3<f64>,
}

impl LocalFrame {
    /// The frame at an origin.
    ///
    /// # Errors
    /// Those of [`Geodetic::check`].
    pub fn new(origin: Geodetic) -> Result<Self> {
        origin.check()?;
        let (sin_lat, cos_lat) = origin.latitude.sin_cos();
        let (sin_lon, cos_lon) = origin.longitude.sin_cos();
        let enu_from_ecef = Matrix3::new(
            -sin_lon,
            cos_lon,
            0.0,
            -sin_lat * cos_lon,
            -sin_lat * sin_lon,
            cos_lat,
            cos_lat * cos_lon,
            cos_lat * sin_lon,
            sin_lat,
        );
        Ok(LocalFrame { origin, origin_in_ecef: origin.to_ecef(), enu_from_ecef })
    }

    /// The origin.
    pub fn origin(&self) -> Geodetic {
        self.origin
    }

    /// East, north and up of a place \[m\].
    pub fn to_enu(&self, place: &Geodetic) -> Vector3<f64> {
        self.enu_from_ecef * (place.to_ecef() - self.origin_in_ecef)
    }

    /// The place at east, north and up \[m\].
    pub fn to_geodetic(&self, enu: &Vector3<f64>) -> Geodetic {
        Geodetic::from_ecef(&(self.origin_in_ecef + self.enu_from_ecef.transpose() * enu))
    }
}
