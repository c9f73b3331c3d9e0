//! What a data sheet says of a radar.

use super::RadarNoise;
use crate::Result;
use crate::check::{in_range, reach};
use loc_core::error::positive;
use std::f64::consts::TAU;

/// View, reach and errors of a radar.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct RadarSpec {
    /// Opening angle, half of it to each side \[rad\].
    pub fov: f64,
    /// Nearest distance \[m\].
    pub range_min: f64,
    /// Farthest distance \[m\].
    pub range_max: f64,
    /// Largest radial speed, either way \[m/s\].
    pub speed_max: f64,
    /// Measurements per second \[Hz\].
    pub rate: f64,
    /// Errors of the echoes.
    pub noise: RadarNoise,
}

impl RadarSpec {
    /// Continental ARS 408-21, near field: 0.2 m to 70 m, 60 deg either way, every 72 ms; accuracy
    /// 0.1 m, 1 deg (at 45 deg, better ahead) and 0.1 km/h. The data sheet's speeds reach from
    /// -400 to 200 km/h, of which the smaller bound is taken both ways.
    pub fn ars408_near() -> Self {
        RadarSpec {
            fov: 120_f64.to_radians(),
            range_min: 0.2,
            range_max: 70.0,
            speed_max: 200.0 / 3.6,
            rate: 1.0 / 0.072,
            noise: RadarNoise {
                range_sigma: 0.1,
                bearing_sigma: 1_f64.to_radians(),
                speed_sigma: 0.1 / 3.6,
                ..RadarNoise::NONE
            },
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for an opening angle that is not positive or of more than a
    /// turn, distances in the wrong order, a speed or rate that is not positive, and bad noise.
    pub fn check(&self) -> Result<()> {
        let opens = |fov: f64| fov > 0.0 && fov <= TAU;
        in_range("field of view of a radar [rad]", "above 0, at most a turn", self.fov, opens)?;
        reach(self.range_min, self.range_max)?;
        positive("largest radial speed [m/s]", self.speed_max)?;
        positive("measurements per second [Hz]", self.rate)?;
        self.noise.check()
    }
}

impl Default for RadarSpec {
    /// The [`RadarSpec::ars408_near`].
    fn default() -> Self {
        RadarSpec::ars408_near()
    }
}
