//! Two driven wheels on one axle (E1).

use crate::error::positive;
use crate::{Error, Result, Twist2};
use nalgebra::Matrix3x2;

/// A drive with a left and a right wheel: `v = (v_R + v_L)/2`, `omega = (v_R - v_L)/l`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Differential {
    track: f64,
}

impl Differential {
    /// A drive from the distance between its wheels, the lectures' l \[m\].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the distance is positive.
    pub fn new(track: f64) -> Result<Self> {
        Ok(Differential { track: positive("wheel track [m]", track)? })
    }

    /// Distance between the wheels \[m\].
    pub fn track(&self) -> f64 {
        self.track
    }

    /// The robot's velocity from the rim speeds of the wheels \[m/s\].
    // ANCHOR: differential
    pub fn twist(&self, left: f64, right: f64) -> Twist2 {
        Twist2::forward(0.5 * (right + left), (right - left) / self.track)
    }
    // ANCHOR_END: differential

    /// Derivative of (vx, vy, omega) over (left, right), 3 x 2.
    pub fn jacobian(&self) -> Matrix3x2<f64> {
        let per_track = 1.0 / self.track;
        Matrix3x2::new(0.5, 0.5, 0.0, 0.0, -per_track, per_track)
    }

    /// The rim speeds (left, right) that give a velocity \[m/s\].
    ///
    /// # Errors
    /// [`Error::ImpossibleMotion`] for a sideways speed.
    pub fn wheels(&self, twist: Twist2) -> Result<(f64, f64)> {
        refuse_sideways("differential drive", twist)?;
        let half = 0.5 * twist.omega * self.track;
        Ok((twist.vx - half, twist.vx + half))
    }
}

/// Refuses velocities that slide sideways.
pub(super) fn refuse_sideways(drive: &'static str, twist: Twist2) -> Result<()> {
    if twist.vy.abs() > 1e-9 {
        let motion = format!("slide sideways at {} m/s", twist.vy);
        return Err(Error::ImpossibleMotion { drive, motion });
    }
    Ok(())
}
