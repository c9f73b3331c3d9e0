//! Wheel speeds and the robot's velocity, in both directions (E1, E3, E4).
//!
//! Wheel speeds are rim speeds \[m/s\]: revolutions times circumference. Each drive has `twist`,
//! from its wheels to the robot's [`Twist2`]; `wheels`, the inverse; and the Jacobian of
//! `twist`, which maps the noise of the wheels to that of the velocity: `S_u = J S_wheels J^T`.
//!
//! ```
//! use loc_core::kinematics::Differential;
//! let drive = Differential::new(0.4)?;
//! let twist = drive.twist(0.9, 1.1);
//! assert!((twist.vx - 1.0).abs() < 1e-12 && (twist.omega - 0.5).abs() < 1e-12);
//! # Ok::<(), loc_core::Error>(())
//! ```
//!
//! The KURT2 robot has a left-handed convention (E5). Its plane is spanned by x, to the right, and
//! z, straight on; its heading is 0 along z and grows clockwise. In this workspace's right-handed
//! frame, z is forward (x here), x is to the right (-y here), and the heading changes its sign.
//!
//! ```
//! use loc_core::kinematics::{Kurt2Drive, Kurt2Pose};
//! let drive = Kurt2Drive::new(0.25)?;
//! let pose = drive.step(Kurt2Pose::default(), 0.80, 0.75, 1.0);
//! assert!((pose.x - 0.0774).abs() < 5e-5 && (pose.z - 0.7711).abs() < 5e-5);
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::error::positive;
use crate::{Error, Pose2, Result, Twist2};
use nalgebra::{Matrix3x2, Matrix3x4, Matrix4x3, Vector4};

/// A drive with a left and a right driven wheel on one axle (E1): `v = (v_R + v_L)/2`,
/// `omega = (v_R - v_L)/l`.
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
fn refuse_sideways(drive: &'static str, twist: Twist2) -> Result<()> {
    if twist.vy.abs() > 1e-9 {
        let motion = format!("slide sideways at {} m/s", twist.vy);
        return Err(Error::ImpossibleMotion { drive, motion });
    }
    Ok(())
}

/// A Mecanum drive (E4): four wheels with rollers at 45 degrees, in X arrangement seen from above;
/// omnidirectional.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Mecanum {
    lever: f64,
}

/// Rim speeds of the four wheels \[m/s\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MecanumWheels {
    /// Front left.
    pub front_left: f64,
    /// Front right.
    pub front_right: f64,
    /// Rear left.
    pub rear_left: f64,
    /// Rear right.
    pub rear_right: f64,
}

impl MecanumWheels {
    /// The vector (front left, front right, rear left, rear right).
    pub fn to_vector(self) -> Vector4<f64> {
        Vector4::new(self.front_left, self.front_right, self.rear_left, self.rear_right)
    }
}

impl Mecanum {
    /// A drive from the distances between its axles and between its left and right wheels \[m\].
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] unless both are positive.
    pub fn new(wheelbase: f64, track: f64) -> Result<Self> {
        let wheelbase = positive("wheelbase [m]", wheelbase)?;
        let track = positive("wheel track [m]", track)?;
        Ok(Mecanum { lever: 0.5 * (wheelbase + track) })
    }

    /// The robot's velocity from its four rim speeds, by least squares where they contradict each
    /// other.
    pub fn twist(&self, wheels: MecanumWheels) -> Twist2 {
        Twist2::from_vector(&(self.jacobian() * wheels.to_vector()))
    }

    /// Derivative of (vx, vy, omega) over the rim speeds in the order of
    /// [`MecanumWheels::to_vector`], 3 x 4.
    pub fn jacobian(&self) -> Matrix3x4<f64> {
        let turn = 1.0 / self.lever;
        0.25 * Matrix3x4::new(
            1.0, 1.0, 1.0, 1.0, //
            -1.0, 1.0, 1.0, -1.0, //
            -turn, turn, -turn, turn,
        )
    }

    /// The rim speeds that give a velocity; every velocity is possible.
    pub fn wheels(&self, twist: Twist2) -> MecanumWheels {
        let a = self.lever;
        let by_twist = Matrix4x3::new(1.0, -1.0, -a, 1.0, 1.0, a, 1.0, 1.0, -a, 1.0, -1.0, a);
        let w = by_twist * twist.to_vector();
        MecanumWheels { front_left: w[0], front_right: w[1], rear_left: w[2], rear_right: w[3] }
    }

    /// How far four rim speeds contradict each other \[m/s\]: the speed at which the rollers must
    /// slip. 0 for wheels that roll freely.
    pub fn slip(&self, wheels: MecanumWheels) -> f64 {
        let w = wheels;
        0.5 * (w.front_left + w.front_right - w.rear_left - w.rear_right)
    }
}

/// A drive with steered front wheels, as a car (E3), reduced to the bicycle in its middle plane:
/// `omega = v tan(steering) / L`, with v taken at the rear axle.
///
/// The speed comes from the rear wheels (B1), the steering angle from a rotary encoder (B2).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ackermann {
    wheelbase: f64,
}

impl Ackermann {
    /// A drive from the distance between its axles, L \[m\].
    ///
    /// # Errors
    /// [`Error::OutOfRange`] unless the distance is positive.
    pub fn new(wheelbase: f64) -> Result<Self> {
        Ok(Ackermann { wheelbase: positive("wheelbase [m]", wheelbase)? })
    }

    /// Distance between the axles \[m\].
    pub fn wheelbase(&self) -> f64 {
        self.wheelbase
    }

    /// The velocity of the rear axle from speed \[m/s\] and steering angle, positive to the left
    /// \[rad\].
    pub fn twist(&self, speed: f64, steering: f64) -> Twist2 {
        Twist2::forward(speed, speed * steering.tan() / self.wheelbase)
    }

    /// Derivative of (vx, vy, omega) over (speed, steering), 3 x 2.
    pub fn jacobian(&self, speed: f64, steering: f64) -> Matrix3x2<f64> {
        let tan = steering.tan();
        let by_steering = speed * (1.0 + tan * tan) / self.wheelbase;
        Matrix3x2::new(1.0, 0.0, 0.0, 0.0, tan / self.wheelbase, by_steering)
    }

    /// Speed \[m/s\] and steering angle \[rad\] that give a velocity.
    ///
    /// # Errors
    /// [`Error::ImpossibleMotion`] for a sideways speed, and for a turn on the spot.
    pub fn wheels(&self, twist: Twist2) -> Result<(f64, f64)> {
        refuse_sideways("Ackermann drive", twist)?;
        if twist.vx == 0.0 && twist.omega != 0.0 {
            let motion = format!("turn on the spot at {} rad/s", twist.omega);
            return Err(Error::ImpossibleMotion { drive: "Ackermann drive", motion });
        }
        if twist.vx == 0.0 {
            return Ok((0.0, 0.0));
        }
        Ok((twist.vx, (twist.omega * self.wheelbase / twist.vx).atan()))
    }

    /// Steering angles (left, right) of the two front wheels, `track` \[m\] apart, whose axes meet
    /// the rear axle's in one point when the middle plane is steered by `steering` \[rad\].
    pub fn front_wheel_angles(&self, steering: f64, track: f64) -> (f64, f64) {
        let (forward, inward) = (self.wheelbase * steering.sin(), 0.5 * track * steering.sin());
        let angle =
            |side: f64| (forward / (self.wheelbase * steering.cos() + side * inward)).atan();
        (angle(-1.0), angle(1.0))
    }
}

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
