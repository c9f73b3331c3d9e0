//! The left-handed convention of the KURT2 robot (E5), beside the right-handed one used here.
//!
//! KURT2's plane is spanned by x, to the right, and z, straight on. Its heading is 0 along z and
//! grows clockwise. Turned into this workspace's frame, z is forward (our x), x is to the right
//! (our -y), and the heading changes its sign.
//!
//! ```
//! use loc_core::frames::{Kurt2Drive, Kurt2Pose};
//! let drive = Kurt2Drive::new(0.25)?;
//! let pose = drive.step(Kurt2Pose::default(), 0.80, 0.75, 1.0);
//! assert!((pose.x - 0.0774).abs() < 5e-5 && (pose.z - 0.7711).abs() < 5e-5);
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::error::positive;
use crate::{Pose2, Result, Twist2};

/// A pose in KURT2's left-handed frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Kurt2Pose {
    /// To the right \[m\].
    pub x: f64,
    /// Straight on \[m\].
    pub z: f64,
    /// Heading, 0 along z, clockwise positive \[rad\].
    pub theta: f64,
}

/// KURT2's differential drive in its own convention.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kurt2Drive {
    track: f64,
}

impl Kurt2Drive {
    /// A drive from the distance between its wheels, document 003's b \[m\].
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] unless the distance is positive.
    pub fn new(track: f64) -> Result<Self> {
        Ok(Kurt2Drive { track: positive("wheel track [m]", track)? })
    }

    /// Turn rate, clockwise, `omega = (v_L - v_R)/b` \[rad/s\].
    pub fn omega(&self, left: f64, right: f64) -> f64 {
        (left - right) / self.track
    }

    /// One step of dead reckoning as document 003 writes it:
    /// `x += v dt sin(theta + omega dt/2)`, `z += v dt cos(theta + omega dt/2)`.
    pub fn step(&self, pose: Kurt2Pose, left: f64, right: f64, dt: f64) -> Kurt2Pose {
        let v = 0.5 * (left + right);
        let turn = self.omega(left, right) * dt;
        let (sin, cos) = (pose.theta + 0.5 * turn).sin_cos();
        Kurt2Pose {
            x: pose.x + v * dt * sin,
            z: pose.z + v * dt * cos,
            theta: crate::angle::wrap(pose.theta + turn),
        }
    }
}

impl From<Kurt2Pose> for Pose2 {
    fn from(pose: Kurt2Pose) -> Self {
        Pose2::new(pose.z, -pose.x, -pose.theta)
    }
}

impl From<Pose2> for Kurt2Pose {
    fn from(pose: Pose2) -> Self {
        Kurt2Pose { x: -pose.y, z: pose.x, theta: crate::angle::wrap(-pose.theta) }
    }
}

/// A clockwise velocity (v, omega) of KURT2 as a right-handed twist.
pub fn twist_from_kurt2(v: f64, omega_clockwise: f64) -> Twist2 {
    Twist2::forward(v, -omega_clockwise)
}
