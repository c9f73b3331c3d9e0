//! From a scan to its lines.

use super::Line;
use super::assemble::assemble;
use super::fit::{Hit, refined};
use super::split::{runs, split};
use crate::Result;
use crate::check::in_range;
use crate::laser::{LaserNoise, LaserScan};
use loc_core::error::{non_negative, positive};
use std::f64::consts::FRAC_PI_2;

/// Finds straight walls in a scan.
///
/// Beams fall into runs at breakpoints; a run is split until each part is straight as far as
/// noise and roughness can tell; neighbouring parts that are one wall are merged; beams about a
/// corner go to the wall on whose side of it they are; each wall is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LineExtractor {
    /// Errors of the ranges.
    pub noise: LaserNoise,
    /// Standard deviation of a beam's direction \[rad\].
    pub angle_sigma: f64,
    /// Standard deviation of a wall's surface about its plane \[m\].
    pub roughness: f64,
    /// How many standard deviations a point may lie off its wall.
    pub gate_sigmas: f64,
    /// The flattest angle between beam and wall at which a wall is followed \[rad\].
    pub grazing_angle: f64,
    /// The widest angle without a return that a wall may continue across \[rad\].
    pub max_gap: f64,
    /// A wall needs this many beams.
    pub min_points: usize,
    /// A wall must be this long \[m\].
    pub min_length: f64,
    /// Its direction must be known this well \[rad\]: of stubs beyond a corner it is not clear
    /// which beams are theirs, and their covariance would promise too much.
    pub max_alpha_sigma: f64,
}

impl LineExtractor {
    /// An extractor for a scanner with the given errors.
    pub fn new(noise: LaserNoise) -> Self {
        LineExtractor { noise, ..LineExtractor::default() }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative standard deviations, a gate or an angle that is
    /// not positive, fewer than 3 points, or a negative length.
    pub fn check(&self) -> Result<()> {
        self.noise.check()?;
        non_negative("sigma of a beam's direction [rad]", self.angle_sigma)?;
        non_negative("roughness of walls [m]", self.roughness)?;
        positive("gate of points off a wall [sigmas]", self.gate_sigmas)?;
        let acute = |angle: f64| angle > 0.0 && angle < FRAC_PI_2;
        in_range("grazing angle [rad]", "between 0 and pi/2", self.grazing_angle, acute)?;
        positive("widest gap in a wall [rad]", self.max_gap)?;
        in_range("fewest points of a wall", "at least 3", self.min_points as f64, |n| n >= 3.0)?;
        non_negative("least length of a wall [m]", self.min_length)?;
        positive("largest sigma of a wall's direction [rad]", self.max_alpha_sigma)?;
        Ok(())
    }

    /// The walls in a scan, in the scanner's frame and in the order of the beams.
    ///
    /// # Errors
    /// Those of [`LaserScan::check`] and [`LineExtractor::check`].
    pub fn extract(&self, scan: &LaserScan) -> Result<Vec<Line>> {
        self.check()?;
        scan.check()?;
        let hits: Vec<Hit> = scan.beams().map(|beam| Hit::new(beam, self)).collect();
        let mut parts = Vec::new();
        for run in runs(&hits, self, scan.angle_increment.abs()) {
            split(&hits, run, self, &mut parts);
        }
        let walls = assemble(&hits, &parts, self);
        let enough = |line: &Line| {
            line.points >= self.min_points
                && line.length() >= self.min_length
                && line.covariance.m22 <= self.max_alpha_sigma.powi(2)
        };
        Ok(walls.iter().filter_map(|wall| refined(wall)).filter(enough).collect())
    }
}

impl Default for LineExtractor {
    /// For an indoor scanner with errors of 2 cm.
    fn default() -> Self {
        LineExtractor {
            noise: LaserNoise { sigma: 0.02, sigma_per_m: 0.0 },
            angle_sigma: 0.001,
            roughness: 0.005,
            gate_sigmas: 5.0,
            grazing_angle: 5_f64.to_radians(),
            max_gap: 3_f64.to_radians(),
            min_points: 10,
            min_length: 0.3,
            max_alpha_sigma: 0.03,
        }
    }
}
