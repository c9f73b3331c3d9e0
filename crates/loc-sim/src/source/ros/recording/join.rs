//! Scans, odometry and true poses, brought into one order of time.

use super::counts::Counts;
use super::delay::MeasuredDelay;
use super::noise::NoisyOdometry;
use super::preview::{Preview, transforms};
use super::roles::{OdometryFrom, ReferenceFrom, Roles};
use super::scan::{converted, level};
use super::{RosOptions, unsuitable};
use crate::source::laser_log::{Entry, RecordedScan};
use crate::source::ros::bag::{Channel, MessageReader};
use crate::source::ros::messages::{
    self, Message, MultiEchoLaserScan, Odometry, PointCloud2, PoseStamped,
    PoseWithCovarianceStamped, Slice, Stamp, TfMessage,
};
use crate::source::ros::tf::TransformBuffer;
use crate::{Error, Result};
use loc_core::Pose2;
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
    frames: TransformBuffer,
    noise: Option<NoisyOdometry>,
    /// Odometry around what waits, in order of time; `passed` of it are given out.
    pub(super) odometry: VecDeque<(Stamp, Pose2)>,
    pub(super) waiting: VecDeque<(Stamp, Waiting)>,
    pub(super) ready: VecDeque<Entry>,
    pub(super) latest_scan: Option<Stamp>,
    pub(super) latest_truth: Option<Stamp>,
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
            odometry: VecDeque::new(),
            waiting: VecDeque::new(),
            ready: VecDeque::new(),
            latest_scan: None,
            latest_truth: None,
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

    fn take_message(&mut self, channel: &Channel, log_time: Stamp, data: &[u8]) -> Result<()> {
        let topic = &channel.topic;
        if let Some(moving) = transforms(channel) {
            let message = TfMessage::from_bytes(data, &channel.encoding)?;
            if let OdometryFrom::Transform(parent) = &self.roles.odometry {
                let plain = |frame: &str| frame.trim_start_matches('/').to_owned();
                let own = message.transforms.iter().filter(|transform| {
                    plain(&transform.header.frame_id) == *parent
                        && plain(&transform.child_frame_id) == self.roles.base
                });
                let own: Vec<_> = own.map(|t| (t.header.stamp, t.transform.planar())).collect();
                for (stamp, pose) in own {
                    self.take_odometry(stamp, log_time, pose);
                }
            }
            self.counts.bad_transforms += self.frames.insert_all(&message, moving);
        } else if *topic == self.roles.scans {
            self.take_scan(channel, log_time, data)?;
        } else if OdometryFrom::Topic(topic.clone()) == self.roles.odometry {
            let message = Odometry::from_bytes(data, &channel.encoding)?;
            self.take_odometry(message.header.stamp, log_time, message.pose.pose.planar());
        } else if ReferenceFrom::Topic(topic.clone()) == self.roles.reference {
            self.take_truth(channel, log_time, data)?;
        }
        Ok(())
    }

    fn take_scan(&mut self, channel: &Channel, log_time: Stamp, data: &[u8]) -> Result<()> {
        self.counts.scans += 1;
        let encoding = &channel.encoding;
        let scan = if channel.is_of(MultiEchoLaserScan::NAME) {
            MultiEchoLaserScan::from_bytes(data, encoding)?.first_echo()
        } else if channel.is_of(PointCloud2::NAME) {
            PointCloud2::from_bytes(data, encoding)?.slice(&Slice::default())?
        } else {
            messages::LaserScan::from_bytes(data, encoding)?
        };
        let stamp = self.stamp(scan.header.stamp, log_time);
        if self.latest_scan.is_some_and(|latest| stamp <= latest) {
            self.counts.out_of_order += 1;
            return Ok(());
        }
        self.latest_scan = Some(stamp);
        self.wait(stamp, Waiting::Scan(scan));
        Ok(())
    }

    fn take_truth(&mut self, channel: &Channel, log_time: Stamp, data: &[u8]) -> Result<()> {
        let encoding = &channel.encoding;
        let (header, pose) = if channel.is_of(Odometry::NAME) {
            let message = Odometry::from_bytes(data, encoding)?;
            (message.header, message.pose.pose)
        } else if channel.is_of(PoseStamped::NAME) {
            let message = PoseStamped::from_bytes(data, encoding)?;
            (message.header, message.pose)
        } else {
            let message = PoseWithCovarianceStamped::from_bytes(data, encoding)?;
            (message.header, message.pose.pose)
        };
        let stamp = self.stamp(header.stamp, log_time);
        let late = self.latest_truth.is_some_and(|latest| stamp <= latest);
        match pose.planar() {
            Some(pose) if !late => {
                self.latest_truth = Some(stamp);
                self.wait(stamp, Waiting::Truth(pose));
            }
            _ => self.counts.out_of_order += 1,
        }
        Ok(())
    }

    fn take_odometry(&mut self, stamp: Stamp, log_time: Stamp, pose: Option<Pose2>) {
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

    /// The stamp of a message, or the time at which it was recorded where it has none.
    fn stamp(&mut self, stamp: Stamp, log_time: Stamp) -> Stamp {
        if stamp != Stamp(0) {
            return stamp;
        }
        self.counts.zero_stamps += 1;
        log_time
    }

    fn wait(&mut self, stamp: Stamp, what: Waiting) {
        // Of what belongs to the same time, a scan comes before the pose that judges it.
        let is_scan = matches!(what, Waiting::Scan(_));
        let after = |known: Stamp| known > stamp || (is_scan && known == stamp);
        let later = self.waiting.iter().rev().take_while(|(known, _)| after(*known)).count();
        self.waiting.insert(self.waiting.len() - later, (stamp, what));
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
        let names = self.roles.notes.iter().cloned();
        let notes = self.bag.notes().into_iter().chain(reference).chain(self.delay.note());
        notes.chain(names).chain(self.counts.notes()).collect()
    }
}

impl std::fmt::Debug for Join {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Join").field("path", &self.bag.path()).field("roles", &self.roles).finish()
    }
}
