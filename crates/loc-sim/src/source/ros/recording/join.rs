//! Scans, odometry and true poses, brought into one order of time.

use super::noise::NoisyOdometry;
use super::preview::{Preview, transforms};
use super::roles::{OdometryFrom, ReferenceFrom, Roles};
use super::{RosOptions, unsuitable};
use crate::source::laser_log::{Entry, RecordedScan, What};
use crate::source::ros::bag::{Channel, MessageReader};
use crate::source::ros::messages::{
    self, Message, MultiEchoLaserScan, Odometry, PointCloud2, PoseStamped,
    PoseWithCovarianceStamped, Slice, Stamp, TfMessage,
};
use crate::source::ros::tf::TransformBuffer;
use crate::{Error, Result};
use loc_core::nalgebra::{Isometry3, Vector3};
use loc_core::{Pose2, angle};
use loc_sensors::laser::LaserScan;
use std::collections::VecDeque;
use std::sync::Arc;

/// A message waits this long for those of other topics that belong before it \[ns\].
const PATIENCE: i64 = 5_000_000_000;

/// Gap of the odometry over which nothing is interpolated \[s\].
const LONGEST_GAP: f64 = 1.0;

/// How long a transform of the laser holds beyond its stamp \[s\].
const HOLD: f64 = 1.0;

/// How far a laser may be tilted and still count as level: cos 10 degrees.
const LEVEL: f64 = 0.985;

/// Reads a bag and gives its entries in order of their stamps.
pub(super) struct Join {
    bag: Box<dyn MessageReader>,
    roles: Roles,
    mounting: Option<Pose2>,
    frames: TransformBuffer,
    noise: Option<NoisyOdometry>,
    /// Odometry around what waits, in order of time; `passed` of it are given out.
    odometry: VecDeque<(Stamp, Pose2)>,
    waiting: VecDeque<(Stamp, Waiting)>,
    ready: VecDeque<Entry>,
    latest_scan: Option<Stamp>,
    latest_truth: Option<Stamp>,
    given: Stamp,
    ended: bool,
    last_stamp: Option<Stamp>,
    counts: Counts,
    data: Vec<u8>,
}

/// What waits for the odometry to pass it.
#[derive(Debug)]
enum Waiting {
    Scan(messages::LaserScan),
    Truth(Pose2),
}

/// What was passed over, and why.
#[derive(Debug, Default)]
struct Counts {
    scans: u64,
    unreadable: u64,
    why_unreadable: Option<String>,
    without_odometry: u64,
    without_transform: u64,
    why_without_transform: Option<Error>,
    out_of_order: u64,
    zero_stamps: u64,
    bad_transforms: usize,
}

impl Join {
    pub(super) fn new(
        bag: Box<dyn MessageReader>,
        preview: Preview,
        roles: Roles,
        options: &RosOptions,
    ) -> Result<Self> {
        Ok(Join {
            bag,
            roles,
            mounting: options.mounting,
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
            self.counts.unreadable += 1;
            self.counts.why_unreadable.get_or_insert(format!("{}: {error}", channel.topic));
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
        let late = self.odometry.back().is_some_and(|(latest, _)| stamp <= *latest);
        match pose {
            Some(pose) if !late && stamp > self.given => {
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
        let later = self.waiting.iter().rev().take_while(|(known, _)| *known > stamp).count();
        self.waiting.insert(self.waiting.len() - later, (stamp, what));
    }

    /// Up to this time nothing more is to come.
    fn watermark(&self) -> Option<Stamp> {
        let odometry = self.odometry.back().map(|(stamp, _)| *stamp);
        let mut latest = vec![odometry, self.latest_scan];
        if matches!(self.roles.reference, ReferenceFrom::Topic(_)) {
            latest.push(self.latest_truth);
        }
        let newest = latest.iter().flatten().max()?;
        let impatient = Stamp(newest.0.saturating_sub(PATIENCE));
        let common = latest.iter().copied().min()?;
        Some(common.map_or(impatient, |common| common.max(impatient)))
    }

    /// Gives out everything up to a time.
    fn give_until(&mut self, until: Option<Stamp>) {
        let Some(until) = until else { return };
        loop {
            let next_odometry =
                self.odometry.iter().map(|(stamp, _)| *stamp).find(|s| *s > self.given);
            let next_waiting = self.waiting.front().map(|(stamp, _)| *stamp);
            match (next_waiting, next_odometry) {
                (Some(waiting), odometry)
                    if waiting <= until && odometry.is_none_or(|odometry| waiting <= odometry) =>
                {
                    // The odometry after it is needed to go between.
                    if let Some((stamp, what)) = self.waiting.pop_front() {
                        self.give(stamp, what);
                    }
                }
                (_, Some(odometry)) if odometry <= until => {
                    self.given = odometry;
                    if let Some((_, pose)) = self.odometry.iter().find(|(s, _)| *s == odometry) {
                        let what = What::Odometry(*pose);
                        self.ready.push_back(Entry { stamp: odometry.seconds(), what });
                    }
                    while self.odometry.get(1).is_some_and(|(stamp, _)| *stamp <= odometry) {
                        self.odometry.pop_front();
                    }
                }
                _ => return,
            }
        }
    }

    /// Gives out what waited, with the odometry of its moment.
    fn give(&mut self, stamp: Stamp, what: Waiting) {
        if stamp < self.given {
            self.counts.out_of_order += 1;
            return;
        }
        let Some(odometry) = self.odometry_at(stamp) else {
            self.counts.without_odometry += u64::from(matches!(what, Waiting::Scan(_)));
            return;
        };
        let seconds = stamp.seconds();
        match what {
            Waiting::Truth(pose) => {
                self.ready.push_back(Entry { stamp: seconds, what: What::Odometry(odometry) });
                self.ready.push_back(Entry { stamp: seconds, what: What::Truth(pose) });
            }
            Waiting::Scan(scan) => match self.recorded(&scan, stamp, odometry) {
                Ok(scan) => {
                    self.ready.push_back(Entry { stamp: seconds, what: What::Scan(scan) });
                }
                Err(error @ Error::NoTransform { .. }) => {
                    self.counts.without_transform += 1;
                    self.counts.why_without_transform.get_or_insert(error);
                }
                Err(error) => {
                    self.counts.unreadable += 1;
                    self.counts.why_unreadable.get_or_insert(error.to_string());
                }
            },
        }
    }

    /// The odometry between the two poses around a time.
    fn odometry_at(&self, stamp: Stamp) -> Option<Pose2> {
        let after = self.odometry.partition_point(|(known, _)| *known < stamp);
        let (to, second) = *self.odometry.get(after)?;
        if to == stamp {
            return Some(second);
        }
        let (from, first) = *self.odometry.get(after.checked_sub(1)?)?;
        let gap = (to.0 - from.0) as f64 * 1e-9;
        let share = (stamp.0 - from.0) as f64 * 1e-9 / gap;
        let step = first.between(second);
        (gap <= LONGEST_GAP).then(|| first * Pose2::exp(&(share * step.log())))
    }

    /// A scan with the place of its laser and, where the transforms say it, of the robot.
    fn recorded(
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
        let counts = &self.counts;
        let count = |number: u64, what: String| (number > 0).then(|| format!("{number} {what}"));
        let because =
            |reason: Option<String>| reason.map_or(String::new(), |r| format!(", the first: {r}"));
        let transform = counts.why_without_transform.as_ref().map(ToString::to_string);
        let own = [
            match &self.roles.reference {
                ReferenceFrom::Nothing => None,
                ReferenceFrom::Topic(topic) => Some(format!("reference: {topic}")),
                ReferenceFrom::Transform(map) => Some(format!(
                    "reference: the recorded transform from {map}, itself an estimate"
                )),
            },
            count(
                counts.unreadable,
                format!("messages that cannot be used{}", because(counts.why_unreadable.clone())),
            ),
            count(counts.without_odometry, "scans without odometry before and after them".into()),
            count(
                counts.without_transform,
                format!("scans without the place of the laser{}", because(transform)),
            ),
            count(counts.out_of_order, "messages with a stamp not after the one before".into()),
            count(
                counts.zero_stamps,
                "messages with stamp 0, taken at the time of recording".into(),
            ),
            count(counts.bad_transforms as u64, "transforms that are no rigid motions".into()),
        ];
        self.bag.notes().into_iter().chain(own.into_iter().flatten()).collect()
    }
}

/// The place of a level laser seen from above, and whether it hangs upside down.
fn level(place: &Isometry3<f64>, frame: &str) -> Result<(Pose2, bool)> {
    let up = (place.rotation * Vector3::z()).z;
    if up.abs() < LEVEL {
        return Err(Error::Malformed {
            what: format!("frame {frame}"),
            expected: "a laser that is level to 10 degrees".into(),
            found: format!("one tilted by {:.1} degrees", up.clamp(-1.0, 1.0).acos().to_degrees()),
        });
    }
    let pose = messages::planar(place);
    Ok((Pose2::new(pose.x, pose.y, angle::wrap(pose.theta)), up < 0.0))
}

/// The library's form of a scan; one that hangs upside down turns the other way.
fn converted(scan: &messages::LaserScan, upside_down: bool) -> Result<LaserScan> {
    let sign = if upside_down { -1.0 } else { 1.0 };
    let numbers = |values: &[f32]| values.iter().map(|value| f64::from(*value)).collect();
    let mut intensities: Vec<f64> = numbers(&scan.intensities);
    if intensities.len() != scan.ranges.len() {
        // Some drivers send a few of them; nothing here needs them.
        intensities.clear();
    }
    let converted = LaserScan {
        angle_min: sign * f64::from(scan.angle_min),
        angle_max: sign * f64::from(scan.angle_max),
        angle_increment: sign * f64::from(scan.angle_increment),
        time_increment: scan.time_increment.into(),
        scan_time: scan.scan_time.into(),
        range_min: scan.range_min.into(),
        range_max: scan.range_max.into(),
        ranges: numbers(&scan.ranges),
        intensities,
    };
    converted.check()?;
    Ok(converted)
}

impl std::fmt::Debug for Join {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Join").field("path", &self.bag.path()).field("roles", &self.roles).finish()
    }
}
