//! Time-stamped inputs shared by all sources and localizers: a stream of events.
//!
//! A recording, a simulated robot and a live one have one interface: controls and measurements with
//! the time they belong to, in the order of their arrival, with the ground truth where it is known.

use crate::compass::CompassReading;
use crate::imu::ImuReading;
use crate::landmark_camera::LandmarkObservation;
use crate::laser::LaserScan;
use loc_core::{Gaussian, Pose2, Twist2};
use std::sync::Arc;

/// A control, a measurement or a ground truth, with its times.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// The time the payload belongs to \[s\].
    pub stamp: f64,
    /// Time of arrival \[s\]; events are in order of this.
    pub arrival: f64,
    /// The content.
    pub payload: Payload,
}

/// The content of an event.
#[derive(Debug, Clone, PartialEq)]
pub enum Payload {
    /// A motion command or odometry.
    Control(Control),
    /// What a sensor measured.
    Measurement(Measurement),
    /// The true state of the robot.
    Truth(Truth),
}

/// The motion of the robot from the stamp on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// It drives with this velocity, until the next control.
    Velocity(Twist2),
    /// It accelerates along its rail \[m/s^2\], until the next control.
    Acceleration(f64),
    /// It has moved to this pose of its odometry's frame, whose place in the map is unknown.
    Odometry(Pose2),
}

/// What a sensor measured.
#[derive(Debug, Clone, PartialEq)]
// ANCHOR: measurement
pub enum Measurement {
    /// Landmarks observed at one time, any number of them.
    Landmarks(Vec<LandmarkObservation>),
    /// A sweep of a laser.
    Scan {
        /// The ranges.
        scan: Arc<LaserScan>,
        /// Where the laser sits on the robot (`base_from_laser`).
        mounting: Pose2,
    },
    /// Accelerations and turn rates of an inertial unit in the middle of the robot.
    Inertial(ImuReading),
    /// The heading of a compass.
    Compass(CompassReading),
    /// The place of a satellite receiver's antenna in the map, with the covariance that it claims.
    Position(Gaussian<2>),
    /// Position along the rail \[m\], from the sensor with this index.
    RailPosition {
        /// Index of the sensor, counted from 0.
        sensor: usize,
        /// Position \[m\].
        position: f64,
    },
}
// ANCHOR_END: measurement

/// The true state of the robot (ground truth).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Its pose in the map.
    pub pose: Pose2,
    /// Its forward speed \[m/s\], where known.
    pub speed: Option<f64>,
}

impl Event {
    /// An event that arrives at its stamp.
    pub fn now(stamp: f64, payload: Payload) -> Self {
        Event { stamp, arrival: stamp, payload }
    }

    /// Order of arrival; of simultaneous arrivals, controls come first and the truth last.
    pub fn order(&self, other: &Event) -> std::cmp::Ordering {
        self.arrival.total_cmp(&other.arrival).then(self.rank().cmp(&other.rank()))
    }

    fn rank(&self) -> u8 {
        match self.payload {
            Payload::Control(_) => 0,
            Payload::Measurement(_) => 1,
            Payload::Truth(_) => 2,
        }
    }
}
