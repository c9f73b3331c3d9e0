//! Time-stamped inputs shared by all sources and localizers: a stream of events.
//!
//! A recording, a simulated robot and a live one look the same from here: controls and
//! measurements with the time they belong to, in the order in which they became known, with the
//! truth among them where it is known.

use crate::compass::CompassReading;
use crate::imu::ImuReading;
use crate::landmark_camera::LandmarkObservation;
use crate::laser::LaserScan;
use loc_core::{Gaussian, Pose2, Twist2};
use std::sync::Arc;

/// Something that became known.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// The time it belongs to \[s\].
    pub stamp: f64,
    /// When it became known \[s\]; events are in order of this.
    pub arrival: f64,
    /// What became known.
    pub payload: Payload,
}

/// What an event tells.
#[derive(Debug, Clone, PartialEq)]
pub enum Payload {
    /// How the robot moves from the stamp on.
    Control(Control),
    /// What a sensor measured.
    Measurement(Measurement),
    /// Where the robot really was.
    Truth(Truth),
}

/// How the robot moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Control {
    /// It drives with this velocity, until told otherwise.
    Velocity(Twist2),
    /// It accelerates along its rail \[m/s^2\], until told otherwise.
    Acceleration(f64),
    /// It has moved to this pose of its odometry's frame, whose place in the map is unknown.
    Odometry(Pose2),
}

/// What a sensor measured.
#[derive(Debug, Clone, PartialEq)]
// ANCHOR: measurement
pub enum Measurement {
    /// Landmarks seen at one moment, any number of them.
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

/// Where the robot really was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Its pose in the map.
    pub pose: Pose2,
    /// Its forward speed \[m/s\], where known.
    pub speed: Option<f64>,
}

impl Event {
    /// An event that is known at once.
    pub fn now(stamp: f64, payload: Payload) -> Self {
        Event { stamp, arrival: stamp, payload }
    }

    /// Order of arrival; of what arrives together, controls come first and the truth last.
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
