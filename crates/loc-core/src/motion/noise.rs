//! How far the velocity that odometry reports may be off (E7).

use super::Twist2;
use crate::Result;
use crate::error::non_negative;
use nalgebra::{Matrix3, Vector3};

/// The error model of the lectures: variances that grow with the way driven and turned.
///
/// The errors of distance and heading grow like a random walk, so that their variance after a
/// drive does not depend on how finely it is cut into steps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct VelocityNoise {
    /// Variance of the distance, per metre driven \[m^2/m\].
    pub k_d: f64,
    /// Variance of the heading, per radian turned \[rad^2/rad\].
    pub k_theta: f64,
    /// Variance of the heading, per metre driven \[rad^2/m\].
    pub k_drift: f64,
}

impl VelocityNoise {
    /// Perfect odometry.
    pub const NONE: VelocityNoise = VelocityNoise { k_d: 0.0, k_theta: 0.0, k_drift: 0.0 };

    /// The model from the standard deviations that the lectures speak of: `distance` \[m\] after
    /// 1 m, `turn` \[rad\] after a full turn, `drift` \[rad\] after 1 m.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative or non-finite value.
    pub fn from_sigmas(distance: f64, turn: f64, drift: f64) -> Result<Self> {
        Ok(VelocityNoise {
            k_d: non_negative("sigma of the distance [m per m]", distance)?.powi(2),
            k_theta: non_negative("sigma of a full turn [rad]", turn)?.powi(2)
                / std::f64::consts::TAU,
            k_drift: non_negative("sigma of the drift [rad per m]", drift)?.powi(2),
        })
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("k_d [m^2/m]", self.k_d)?;
        non_negative("k_theta [rad^2/rad]", self.k_theta)?;
        non_negative("k_drift [rad^2/m]", self.k_drift)?;
        Ok(())
    }

    /// Variances of (vx, vy, omega) over a step of `dt` \[s\]:
    /// `k_d/T |v|` and `k_theta/T |omega| + k_drift/T |v|`.
    ///
    /// A drive that reports no sideways speed has no error of it; one that slides (Mecanum) has
    /// `k_d/T` times the speed in each direction of travel. A step without length has none.
    // ANCHOR: velocity-noise
    pub fn variances(&self, twist: Twist2, dt: f64) -> Vector3<f64> {
        if dt <= 0.0 {
            return Vector3::zeros();
        }
        let per_time = 1.0 / dt;
        Vector3::new(
            self.k_d * per_time * twist.vx.abs(),
            self.k_d * per_time * twist.vy.abs(),
            per_time * (self.k_theta * twist.omega.abs() + self.k_drift * twist.speed()),
        )
    }
    // ANCHOR_END: velocity-noise

    /// Sigma_u: the diagonal matrix of [`variances`](VelocityNoise::variances).
    pub fn covariance(&self, twist: Twist2, dt: f64) -> Matrix3<f64> {
        Matrix3::from_diagonal(&self.variances(twist, dt))
    }
}

impl Default for VelocityNoise {
    /// 5 cm after 1 m, 5 degrees after a full turn, 2 degrees after 1 m: the lectures' example.
    fn default() -> Self {
        let [distance, turn, drift] = [0.05, 5_f64.to_radians(), 2_f64.to_radians()];
        VelocityNoise {
            k_d: distance * distance,
            k_theta: turn * turn / std::f64::consts::TAU,
            k_drift: drift * drift,
        }
    }
}
