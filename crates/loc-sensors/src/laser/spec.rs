//! The data sheet of a scanner: angles, ranges, timing, noise; and faults of single beams.

use super::LaserScan;
use crate::Result;
use crate::check::{count, in_range, reach};
use loc_core::error::{finite, non_negative, positive, probability};
use std::f64::consts::TAU;

/// Angles, ranges, timing and noise of a scanner.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LaserSpec {
    /// Angle of beam 0, counter-clockwise from straight ahead \[rad\].
    pub angle_min: f64,
    /// Angle from one beam to the next \[rad\]; negative for a scanner that turns clockwise.
    pub angle_increment: f64,
    /// Number of beams.
    pub beams: usize,
    /// Scans per second; the mirror makes one turn for each \[Hz\].
    pub rate: f64,
    /// Shortest range \[m\].
    pub range_min: f64,
    /// Longest range \[m\].
    pub range_max: f64,
    /// Errors of the ranges.
    pub noise: LaserNoise,
}

impl LaserSpec {
    /// SICK LMS100 at its finer resolution: 270 deg in steps of 0.25 deg at 25 Hz, 0.5 m to 18 m,
    /// statistical error 12 mm (typical).
    pub fn sick_lms100() -> Self {
        LaserSpec {
            rate: 25.0,
            range_min: 0.5,
            range_max: 18.0,
            noise: LaserNoise { sigma: 0.012, sigma_per_m: 0.0 },
            ..LaserSpec::centered(270.0, 0.25)
        }
    }

    /// SICK LMS100 at its higher rate: steps of 0.5 deg at 50 Hz.
    pub fn sick_lms100_50_hz() -> Self {
        let coarse = LaserSpec::centered(270.0, 0.5);
        let LaserSpec { angle_increment, beams, .. } = coarse;
        LaserSpec { rate: 50.0, angle_increment, beams, ..LaserSpec::sick_lms100() }
    }

    /// Hokuyo UST-10LX: 1081 beams over 270 deg at 40 Hz, 0.06 m to 10 m. The data sheet states
    /// a repeated accuracy of sigma < 30 mm; that bound is the noise here, single devices are
    /// better.
    pub fn hokuyo_ust_10lx() -> Self {
        LaserSpec {
            rate: 40.0,
            range_min: 0.06,
            range_max: 10.0,
            noise: LaserNoise { sigma: 0.03, sigma_per_m: 0.0 },
            ..LaserSpec::centered(270.0, 0.25)
        }
    }

    /// A perfect scanner with a field of view of `fov_deg` in steps of `step_deg`, straight ahead
    /// in the middle; 20 Hz, up to 30 m.
    fn centered(fov_deg: f64, step_deg: f64) -> Self {
        LaserSpec {
            angle_min: -0.5 * fov_deg.to_radians(),
            angle_increment: step_deg.to_radians(),
            beams: (fov_deg / step_deg).round() as usize + 1,
            rate: 20.0,
            range_min: 0.0,
            range_max: 30.0,
            noise: LaserNoise::NONE,
        }
    }

    /// Angle of the last beam \[rad\].
    pub fn angle_max(&self) -> f64 {
        self.angle_min + self.angle_increment * self.beams.saturating_sub(1) as f64
    }

    /// Time from one beam to the next \[s\].
    pub fn time_increment(&self) -> f64 {
        self.angle_increment.abs() / (TAU * self.rate)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for angles that are not finite or span more than a turn, an
    /// increment of 0, ranges in the wrong order, a rate that is not positive and bad noise;
    /// [`crate::Error::Length`] for no beams or too many.
    pub fn check(&self) -> Result<()> {
        finite("angle of a laser's first beam [rad]", self.angle_min)?;
        let turns = |step: f64| step.is_finite() && step != 0.0;
        let expected = "a finite number other than 0";
        in_range("angle between a laser's beams [rad]", expected, self.angle_increment, turns)?;
        count("beams of a laser", "1 to 1000000", LaserScan::MAX_BEAMS, self.beams)?;
        let span = (self.angle_max() - self.angle_min).abs();
        let one_turn = |span: f64| span <= TAU + 1e-9;
        in_range("angle from first to last beam [rad]", "at most a turn", span, one_turn)?;
        positive("scans per second [Hz]", self.rate)?;
        reach(self.range_min, self.range_max)?;
        self.noise.check()
    }

    /// A scan of this scanner with the given ranges.
    pub(super) fn scan(&self, ranges: Vec<f64>) -> LaserScan {
        LaserScan {
            angle_min: self.angle_min,
            angle_max: self.angle_max(),
            angle_increment: self.angle_increment,
            time_increment: self.time_increment(),
            scan_time: 1.0 / self.rate,
            range_min: self.range_min,
            range_max: self.range_max,
            ranges,
            intensities: Vec::new(),
        }
    }
}

impl Default for LaserSpec {
    /// The [`LaserSpec::hokuyo_ust_10lx`].
    fn default() -> Self {
        LaserSpec::hokuyo_ust_10lx()
    }
}

/// Normal errors of the range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LaserNoise {
    /// Standard deviation of a range at the scanner \[m\].
    pub sigma: f64,
    /// Its growth with the range \[m/m\].
    pub sigma_per_m: f64,
}

impl LaserNoise {
    /// A perfect scanner.
    pub const NONE: LaserNoise = LaserNoise { sigma: 0.0, sigma_per_m: 0.0 };

    /// Standard deviation of a range of `range` \[m\].
    pub fn sigma_at(&self, range: f64) -> f64 {
        self.sigma + self.sigma_per_m * range
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of a laser's range [m]", self.sigma)?;
        non_negative("growth of a laser's sigma [m/m]", self.sigma_per_m)?;
        Ok(())
    }
}

/// Faults of single beams, each with a probability. [`LaserFaults::NONE`] is a scanner
/// in a clean room.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LaserFaults {
    /// The light does not come back (a black or shining surface): +inf.
    pub dropout: f64,
    /// The scanner reports an error (sunlight): NaN.
    pub erroneous: f64,
    /// An obstacle that is not on the map blocks the beam (a person): any shorter range.
    pub short: f64,
}

impl LaserFaults {
    /// No faults.
    pub const NONE: LaserFaults = LaserFaults { dropout: 0.0, erroneous: 0.0, short: 0.0 };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for probabilities outside \[0, 1\] or with a sum above 1.
    pub fn check(&self) -> Result<()> {
        probability("probability of a dropout", self.dropout)?;
        probability("probability of an erroneous beam", self.erroneous)?;
        probability("probability of a short beam", self.short)?;
        let sum = self.dropout + self.erroneous + self.short;
        in_range("sum of a laser's fault probabilities", "at most 1", sum, |sum| sum <= 1.0)?;
        Ok(())
    }
}
