//! Taking the systematic errors out of recorded odometry.

use crate::Result;
use loc_core::Twist2;
use loc_core::error::{finite, non_negative, positive};

/// How a recorded velocity becomes the one that the robot really drove.
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
    /// Time until the robot does what was recorded \[s\]: positive where commands were recorded.
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
    /// The velocity is right as it is.
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

    /// The velocity driven, of a recorded one. The slowdown stops the robot at most.
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
