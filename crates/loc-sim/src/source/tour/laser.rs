//! A laser scanner, in the units of configuration files.

use crate::Result;
use loc_core::Pose2;
use loc_core::error::positive;
use loc_sensors::laser::{LaserFaults, LaserScanner, LaserSpec};
use serde::Deserialize;

/// A laser scanner on a robot.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaserConfig {
    /// Its data sheet.
    pub preset: LaserPreset,
    /// Time between two scans that are looked at; a multiple of the time step.
    #[serde(default = "every")]
    pub every_s: f64,
    /// Where it sits on the robot: forward.
    #[serde(default)]
    pub forward_m: f64,
    /// Where it sits on the robot: to the left.
    #[serde(default)]
    pub left_m: f64,
    /// How it is turned, counter-clockwise.
    #[serde(default)]
    pub yaw_deg: f64,
    /// Standard deviation of a range, where it is not the data sheet's.
    pub sigma_m: Option<f64>,
    /// Longest range, where it is not the data sheet's.
    pub max_range_m: Option<f64>,
    /// What goes wrong with single beams, as probabilities: `dropout`, `erroneous`, `short`.
    #[serde(default)]
    pub faults: LaserFaults,
}

/// Scanners with a data sheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum LaserPreset {
    /// [`LaserSpec::hokuyo_ust_10lx`]: 270 deg in 0.25 deg, up to 10 m.
    #[serde(rename = "hokuyo-ust-10lx")]
    HokuyoUst10Lx,
    /// [`LaserSpec::sick_lms100`]: 270 deg in 0.25 deg, up to 18 m.
    #[serde(rename = "sick-lms100")]
    SickLms100,
    /// [`LaserSpec::sick_lms100_50_hz`]: 270 deg in 0.5 deg, up to 18 m.
    #[serde(rename = "sick-lms100-50hz")]
    SickLms100At50Hz,
}

fn every() -> f64 {
    0.2
}

impl LaserConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn scanner(&self) -> Result<LaserScanner> {
        positive("laser.every_s", self.every_s)?;
        let mut spec = match self.preset {
            LaserPreset::HokuyoUst10Lx => LaserSpec::hokuyo_ust_10lx(),
            LaserPreset::SickLms100 => LaserSpec::sick_lms100(),
            LaserPreset::SickLms100At50Hz => LaserSpec::sick_lms100_50_hz(),
        };
        spec.noise.sigma = self.sigma_m.unwrap_or(spec.noise.sigma);
        spec.range_max = self.max_range_m.unwrap_or(spec.range_max);
        let mounting = Pose2::new(self.forward_m, self.left_m, self.yaw_deg.to_radians());
        let scanner = LaserScanner { mounting, spec, faults: self.faults };
        scanner.check()?;
        Ok(scanner)
    }
}
