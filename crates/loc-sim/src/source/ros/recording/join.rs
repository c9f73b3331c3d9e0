//! Scans, odometry and true poses, brought into one order of time.

use super::beside::{Satellites, in_the_middle};
use super::counts::Counts;
use super::delay::MeasuredDelay;
use super::noise::NoisyOdometry;
use super::preview::Preview;
use super::roles::{ReferenceFrom, Roles};
use super::scan::{converted, level};
use super::{RosOptions, unsuitable};
use crate::source::laser_log::{Entry, RecordedScan};
use crate::source::ros::bag::{Channel, MessageReader};
use crate::source::ros::messages::{self, Stamp};
use crate::source::ros::tf::TransformBuffer;
use crate::{Error, Result};
use loc_core::nalgebra::Isometry3;
use loc_core::{Gaussian, Pose2};
use loc_sensors::event::Measurement;
use loc_sensors::imu::ImuReading;
use std::collections::VecDeque;
use std::sync::Arc;

/// How long a transform of the laser holds beyond its stamp \[s\].
const HOLD: f64 = 1.0;

/// Reads a bag and gives its entries in order of their stamps.
pub(super) struct Join {
    bag: Box<dyn MessageReader>,
    pub(super) roles: Roles,
    mounting: Option<Pose2>,
    pub(super) delay: MeasuredDelay,
    pub(super) frames: TransformBuffer,
    noise: Option<NoisyOdometry>,
    pub(super) satellites: Satellites,
    /// Odometry around what waits, in order of time; `passed` of it are given out.
    pub(super) odometry: VecDeque<(Stamp, Pose2)>,
    pub(super) waiting: VecDeque<(Stamp, Waiting)>,
    pub(super) ready: VecDeque<Entry>,
    pub(super) latest_scan: Option<Stamp>,
    pub(super) latest_truth: Option<Stamp>,
    /// Of the inertial unit and of the satellite receiver.
    pub(super) latest_beside: [Option<Stamp>; 2],
    pub(super) given: Stamp,
    ended: bool,
    last_stamp: Option<Stamp>,
    pub(super) counts: Counts,
    data: Vec<u8>,
}

/// What waits for the odometry to pass it.
#[derive(Debug)]
pub(super) enum Waiting {
    Scan(messages::LaserScan),
    Truth(Pose2),
    /// A sample with the frame of its unit.
    Inertial(String, ImuReading),
    Position(Gaussian<2>),
}

impl Join {
    pub(super) fn new(
        bag: Box<dyn MessageReader>,
        preview: Preview,
        roles: Roles,
        options: &RosOptions,
        delay: MeasuredDelay,
    ) -> Result<Self> {
        Ok(Join {
            bag,
            roles,
            mounting: options.mounting,
            delay,
            frames: preview.frames,
            noise: options.odometry_noise.map(|(noise, seed)| NoisyOdometry::new(noise, seed)),
            satellites: Satellites::default(),
            odometry: VecDeque::new(),
            waiting: VecDeque::new(),
            ready: VecDeque::new(),
            latest_scan: None,
            latest_truth: None,
            latest_beside: [None; 2],
            given: Stamp(i64::MIN),
            ended: false,
            last_stamp: preview.last_stamp,
            counts: Counts::default(),
            data: Vec::new(),
        })
    }

    pub(super) fn has_reference(&self) -> bool {
        self.roles.reference != ReferenceFrom::Nothing
    }

    /// The last stamp of the bag \[s\].
    pub(super) fn end(&self) -> f64 {
        self.last_stamp.map_or(0.0, Stamp::seconds)
    }

    /// The next entry in order of time.
    pub(super) fn next_entry(&mut self) -> Result<Option<Entry>> {
        loop {
            if let Some(entry) = self.ready.pop_front() {
                return Ok(Some(entry));
            }
            if self.ended {
                return Ok(None);
            }
            match self.bag.next_message()? {
                Some(message) => {
                    let (channel, log_time) = (message.channel, message.log_time);
                    self.data.clear();
                    self.data.extend_from_slice(message.data);
                    let Some(channel) = self.bag.channels().get(channel).cloned() else { continue };
                    self.take(&channel, Stamp(log_time));
                    self.give_until(self.watermark());
                }
                None => {
                    self.ended = true;
                    self.give_until(Some(Stamp(i64::MAX)));
                }
            }
        }
    }

    /// Puts a message where it belongs.
    fn take(&mut self, channel: &Channel, log_time: Stamp) {
        let data = std::mem::take(&mut self.data);
        let result = self.take_message(channel, log_time, &data);
        self.data = data;
        if let Err(error) = result {
            self.counts.unreadable(format!("{}: {error}", channel.topic));
        }
    }

    pub(super) fn take_odometry(&mut self, stamp: Stamp, log_time: Stamp, pose: Option<Pose2>) {
        let stamp = self.stamp(stamp, log_time);
        let stamp = Stamp(stamp.0.saturating_add(Stamp::from_seconds(self.delay.used).0));
        let late = self.odometry.back().is_some_and(|(latest, _)| stamp <= *latest);
        match pose {
            Some(pose) if !late && stamp > self.given => {
                let pose = pose * self.roles.base_in_odometry;
                let pose = self.noise.as_mut().map_or(pose, |noise| noise.next(pose));
                self.odometry.push_back((stamp, pose));
            }
            _ => self.counts.out_of_order += 1,
        }
    }

    /// A scan with the place of its laser and, where the transforms say it, of the robot.
    pub(super) fn recorded(
        &self,
        scan: &messages::LaserScan,
        stamp: Stamp,
        odometry: Pose2,
    ) -> Result<RecordedScan> {
        let (mounting, upside_down) = match self.mounting {
            Some(mounting) => (mounting, false),
            None => {
                let frame = &scan.header.frame_id;
                level(&self.frames.lookup(&self.roles.base, frame, stamp, HOLD)?, frame)?
            }
        };
        let truth = match &self.roles.reference {
            ReferenceFrom::Transform(map) => {
                let place = self.frames.lookup(map, &self.roles.base, stamp, HOLD).ok();
                place.map(|place| messages::planar(&place))
            }
            _ => None,
        };
        let scan = Arc::new(converted(scan, upside_down)?);
        Ok(RecordedScan { scan, mounting, odometry, truth })
    }

    /// A sample in the robot's middle; a unit without a frame sits there.
    pub(super) fn inertial(
        &self,
        frame: &str,
        reading: &ImuReading,
        stamp: Stamp,
    ) -> Result<Measurement> {
        let place = match frame {
            "" => Isometry3::identity(),
            frame => self.frames.lookup(&self.roles.base, frame, stamp, HOLD)?,
        };
        let reading = in_the_middle(reading, &place);
        reading.check()?;
        Ok(Measurement::Inertial(reading))
    }

    /// The error of a bag of which no scan could be used.
    pub(super) fn no_scans(&mut self) -> Error {
        if let Some(error) = self.counts.why_without_transform.take() {
            return error;
        }
        let expected = "laser scans to use, with odometry before and after them";
        let mut found = format!("{} messages on {}", self.counts.scans, self.roles.scans);
        for note in self.notes() {
            found.push_str("; ");
            found.push_str(&note);
        }
        unsuitable(self.bag.path(), expected, found)
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let reference = match &self.roles.reference {
            ReferenceFrom::Nothing => None,
            ReferenceFrom::Topic(topic) => Some(format!("reference: {topic}")),
            ReferenceFrom::Transform(map) => {
                Some(format!("reference: the recorded transform from {map}, itself an estimate"))
            }
        };
        let notes = self.bag.notes().into_iter().chain(reference).chain(self.delay.note());
        let notes =
            notes.chain(self.satellites.note()).chain(self.roles.not_chosen.iter().cloned());
        notes.chain(self.counts.notes()).collect()
    }
}

impl std::fmt::Debug for Join {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Join").field("path", &self.bag.path()).field("roles", &self.roles).finish()
    }
}
