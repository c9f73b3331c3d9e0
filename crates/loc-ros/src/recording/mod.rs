//! A bag as a recording of a robot: scans, odometry, inertial samples, satellite fixes and true
//! poses, in order of their stamps.
//!
//! The bag is read twice. The first reading counts its topics, finds the one with the scans and the
//! one with the odometry by their types, and collects the fixed transforms (`/tf_static` may come
//! late). The second reading, [`Recording`], gives a [`Moment`] after the other.
//!
//! Messages come in order of arrival, but belong to the time of their stamps: a scan waits until
//! the odometry has passed its stamp, and gets the pose that is interpolated between the two around
//! it.
//!
//! ```no_run
//! use loc_ros::{Recording, RecordingOptions};
//! let recording = Recording::open("my_bag".as_ref(), &RecordingOptions::default())?;
//! for moment in recording {
//!     for event in moment?.events() {
//!         println!("{:.3} s: {:?}", event.stamp, event.payload);
//!     }
//! }
//! # Ok::<(), loc_ros::Error>(())
//! ```

mod reader;
mod roles;
mod sensors;

pub use reader::Recording;

use crate::Error;
use loc_core::Pose2;
use loc_core::motion::VelocityNoise;
use loc_sensors::event::{Control, Event, Measurement, Payload, Truth};
use std::path::Path;

/// Names that a parameter file of nav2_amcl gives. A bag that has none of a name is read without
/// it, and a note says so.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosNames {
    /// The topic with the scans (`scan_topic`).
    pub scan_topic: Option<String>,
    /// The frame of the robot (`base_frame_id`).
    pub base_frame: Option<String>,
    /// The frame of the odometry (`odom_frame_id`).
    pub odom_frame: Option<String>,
    /// The frame of the map (`global_frame_id`).
    pub map_frame: Option<String>,
}

/// What is not found in a bag by itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordingOptions {
    /// The topic with the scans; the only one of a type of scans where left out.
    pub scan_topic: Option<String>,
    /// The topic with the odometry; the only one of its type where left out.
    pub odom_topic: Option<String>,
    /// The topic with the true poses, `/tf` for the transform from the map that was recorded, or
    /// `none`; found by its name where left out.
    pub reference_topic: Option<String>,
    /// Names to use where the bag has them and nothing else is said.
    pub names: RosNames,
    /// The topic of the inertial unit, or `none`; the only one of its type where left out.
    pub imu_topic: Option<String>,
    /// The topic of the satellite receiver, or `none`; the only one of its type where left out.
    pub fix_topic: Option<String>,
    /// The pose of the laser on the robot, in place of what the transforms say.
    pub mounting: Option<Pose2>,
    /// What is added to the stamps of the odometry \[s\]; negative for an odometry that comes late.
    pub odometry_delay: f64,
    /// Noise that is added to the odometry, with the seed of its stream.
    pub odometry_noise: Option<(VelocityNoise, u64)>,
}

/// What a recording holds of one moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// Its time \[s\].
    pub stamp: f64,
    /// The robot's pose in its odometry.
    pub odometry: Option<Pose2>,
    /// What a sensor measured.
    pub measurement: Option<Measurement>,
    /// The robot's pose in the map.
    pub truth: Option<Pose2>,
}

impl Moment {
    /// Odometry, measurement and true pose as events, in this order.
    pub fn events(self) -> impl Iterator<Item = Event> {
        let odometry = self.odometry.map(|pose| Payload::Control(Control::Odometry(pose)));
        let measurement = self.measurement.map(Payload::Measurement);
        let truth = self.truth.map(|pose| Payload::Truth(Truth { pose, speed: None }));
        let payloads = [odometry, measurement, truth].into_iter().flatten();
        payloads.map(move |payload| Event::now(self.stamp, payload))
    }
}

fn unsuitable(path: &Path, expected: impl Into<String>, found: impl Into<String>) -> Error {
    Error::Recording { path: path.to_owned(), expected: expected.into(), found: found.into() }
}
