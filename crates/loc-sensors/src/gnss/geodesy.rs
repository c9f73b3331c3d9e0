//! WGS84 and local frames.

use crate::Result;
use crate::check::in_range;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};

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
