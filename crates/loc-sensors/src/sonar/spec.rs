//! What data sheets say of ultrasonic rangers.

use super::SonarNoise;
use crate::Result;
use crate::check::{count, in_range, reach};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Cone, reach and errors of an ultrasonic ranger.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SonarSpec {
    /// Full opening angle of the cone \[rad\].
    pub cone: f64,
    /// Shortest distance \[m\].
    pub range_min: f64,
    /// Longest distance \[m\].
    pub range_max: f64,
    /// The largest angle between the sound and a wall's perpendicular that gives an echo \[rad\]:
    /// smooth walls mirror sound.
    pub widest_incidence: f64,
    /// How many rays stand for the cone in the simulation.
    pub rays: usize,
    /// Errors of the distance.
    pub noise: SonarNoise,
}

impl SonarSpec {
    /// More rays than this no cone needs.
    pub const MAX_RAYS: usize = 10_000;

    /// HC-SR04, the sensor of hobby robots: 2 cm to 4 m, 15 deg either way, ranging accuracy 3 mm.
    pub fn hc_sr04() -> Self {
        SonarSpec {
            cone: 30_f64.to_radians(),
            range_min: 0.02,
            range_max: 4.0,
            noise: SonarNoise { sigma: 0.003, ..SonarNoise::NONE },
            ..SonarSpec::default()
        }
    }

    /// Polaroid 6500, the ring around the research robots of the nineties: 0.15 m to 10.7 m, 1 %
    /// over the whole range; its main lobe is 15 deg either way.
    pub fn polaroid_6500() -> Self {
        SonarSpec {
            range_min: 0.15,
            range_max: 10.7,
            noise: SonarNoise { sigma_per_m: 0.01, ..SonarNoise::NONE },
            ..SonarSpec::default()
        }
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a cone or an incidence that is not positive or too wide,
    /// distances in the wrong order and bad noise; [`crate::Error::Length`] for no rays or too
    /// many.
    pub fn check(&self) -> Result<()> {
        let opens = |cone: f64| cone > 0.0 && cone <= TAU;
        in_range("cone of a sonar [rad]", "above 0, at most a turn", self.cone, opens)?;
        let slants = |angle: f64| angle > 0.0 && angle <= FRAC_PI_2;
        let expected = "above 0, at most pi/2";
        in_range("widest incidence of a sonar [rad]", expected, self.widest_incidence, slants)?;
        count("rays of a sonar", "1 to 10000", Self::MAX_RAYS, self.rays)?;
        reach(self.range_min, self.range_max)?;
        self.noise.check()
    }
}

impl Default for SonarSpec {
    /// A perfect sensor up to 5 m, 15 deg either way.
    fn default() -> Self {
        SonarSpec {
            cone: 30_f64.to_radians(),
            range_min: 0.02,
            range_max: 5.0,
            widest_incidence: 25_f64.to_radians(),
            rays: 31,
            noise: SonarNoise::NONE,
        }
    }
}
