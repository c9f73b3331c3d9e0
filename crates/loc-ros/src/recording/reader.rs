//! The second reading of a bag: decodes messages, keeps them until everything that belongs before
//! them has arrived, and gives them out in order of their stamps.

use super::roles::{OdometryFrom, Preview, ReferenceFrom, Roles, transforms};
use super::sensors::{
    NoisyOdometry, Satellites, at_base, converted, inertial_sample, planar_mounting,
};
use super::{Moment, RecordingOptions, unsuitable};
use crate::bag::{self, Channel, MessageReader};
use crate::messages::{
    self, Imu, Message, MultiEchoLaserScan, NavSatFix, Odometry, PointCloud2, PoseStamped,
    PoseWithCovarianceStamped, Slice, Stamp, TfMessage,
};
use crate::tf::{TransformBuffer, plain};
use crate::{Error, Result};
use loc_core::nalgebra::Isometry3;
use loc_core::{Gaussian, Pose2};
use loc_sensors::event::Measurement;
use loc_sensors::imu::ImuReading;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How long a transform of the laser holds beyond its stamp \[s\].
const HOLD: f64 = 1.0;

/// A message waits this long for those of other topics that belong before it \[ns\].
const PATIENCE: i64 = 5_000_000_000;

/// Gap of the odometry over which nothing is interpolated \[s\].
const MAX_GAP: f64 = 1.0;

/// A bag as a stream of moments in order of time. What is held in memory does not grow with the
/// bag.
pub struct Recording {
    known: Arc<Known>,
    bag: Box<dyn MessageReader>,
    frames: TransformBuffer,
    noise: Option<NoisyOdometry>,
    satellites: Satellites,
    odometry_delay: f64,
    delay_note: Option<String>,
    /// Odometry in order of time, from the last pose that was given out.
    odometry: VecDeque<(Stamp, Pose2)>,
    /// Messages in order of time that wait for the odometry to pass them.
    pending: VecDeque<(Stamp, Pending)>,
    ready: VecDeque<Moment>,
    latest_scan: Option<Stamp>,
    latest_truth: Option<Stamp>,
    /// Of the inertial unit and of the satellite receiver.
    latest_optional: [Option<Stamp>; 2],
    /// The odometry up to here has been given out.
    given_until: Stamp,
    ended: bool,
    skipped: Skipped,
    data: Vec<u8>,
}

/// What the first reading of the bag found.
#[derive(Debug)]
struct Known {
    path: PathBuf,
    options: RecordingOptions,
    roles: Roles,
    /// The fixed transforms.
    frames: TransformBuffer,
    last_stamp: Option<Stamp>,
}

/// A message that waits for the odometry to pass it.
#[derive(Debug)]
enum Pending {
    Scan(messages::LaserScan),
    Truth(Pose2),
    /// A sample with the frame of its unit.
    Inertial(String, ImuReading),
    Position(Gaussian<2>),
}

impl Recording {
    /// Reads a bag once to see what it holds, and opens it for the second reading.
    ///
    /// # Errors
    /// What is wrong with the bag; [`Error::Recording`] for one without scans or odometry, or with
    /// several of them and none chosen.
    pub fn open(path: &Path, options: &RecordingOptions) -> Result<Self> {
        let preview = Preview::of(path)?;
        let roles = Roles::choose(path, &preview, options)?;
        let delay = options.odometry_delay;
        let note = (delay.abs() > 0.0).then(|| format!("odometry moved in time by {delay:+.3} s"));
        Recording::start(
            Arc::new(Known {
                path: path.to_owned(),
                options: options.clone(),
                roles,
                frames: preview.frames,
                last_stamp: preview.last_stamp,
            }),
            delay,
            note,
        )
    }

    /// The same recording from its start, with another delay of the odometry \[s\] and a line for
    /// the user that says why.
    ///
    /// # Errors
    /// As [`Recording::open`].
    pub fn restarted(&self, odometry_delay: f64, note: Option<String>) -> Result<Self> {
        Recording::start(self.known.clone(), odometry_delay, note)
    }

    fn start(known: Arc<Known>, odometry_delay: f64, delay_note: Option<String>) -> Result<Self> {
        let noise = known.options.odometry_noise;
        Ok(Recording {
            bag: bag::open(&known.path)?,
            frames: known.frames.clone(),
            noise: noise.map(|(noise, seed)| NoisyOdometry::new(noise, seed)),
            satellites: Satellites::default(),
            odometry_delay,
            delay_note,
            odometry: VecDeque::new(),
            pending: VecDeque::new(),
            ready: VecDeque::new(),
            latest_scan: None,
            latest_truth: None,
            latest_optional: [None; 2],
            given_until: Stamp(i64::MIN),
            ended: false,
            skipped: Skipped::default(),
            data: Vec::new(),
            known,
        })
    }

    /// The next moment in order of time, `None` at the end.
    ///
    /// # Errors
    /// [`Error::Recording`] with the byte at which the bag cannot be what it claims.
    pub fn next_moment(&mut self) -> Result<Option<Moment>> {
        loop {
            if let Some(moment) = self.ready.pop_front() {
                return Ok(Some(moment));
            }
            if self.ended {
                return Ok(None);
            }
            let Some(message) = self.bag.next_message()? else {
                self.ended = true;
                self.give_until(Some(Stamp(i64::MAX)));
                continue;
            };
            let (channel, log_time) = (message.channel, message.log_time);
            self.data.clear();
            self.data.extend_from_slice(message.data);
            let Some(channel) = self.bag.channels().get(channel).cloned() else { continue };
            let data = std::mem::take(&mut self.data);
            let result = self.insert(&channel, Stamp(log_time), &data);
            self.data = data;
            if let Err(error) = result {
                self.skipped.unreadable(format!("{}: {error}", channel.topic));
            }
            self.give_until(self.watermark());
        }
    }

    /// Decodes a message and puts it among those that wait.
    fn insert(&mut self, channel: &Channel, log_time: Stamp, data: &[u8]) -> Result<()> {
        let topic = &channel.topic;
        let known = self.known.clone();
        let roles = &known.roles;
        if let Some(moving) = transforms(channel) {
            let message = TfMessage::from_bytes(data, &channel.encoding)?;
            if let OdometryFrom::Transform(parent) = &roles.odometry {
                let of_base = message.transforms.iter().filter(|transform| {
                    plain(&transform.header.frame_id) == *parent
                        && plain(&transform.child_frame_id) == roles.base
                });
                for transform in of_base {
                    let pose = transform.transform.planar();
                    self.insert_odometry(transform.header.stamp, log_time, pose);
                }
            }
            self.skipped.bad_transforms += self.frames.insert_all(&message, moving);
        } else if *topic == roles.scans {
            self.insert_scan(channel, log_time, data)?;
        } else if OdometryFrom::Topic(topic.clone()) == roles.odometry {
            let message = Odometry::from_bytes(data, &channel.encoding)?;
            self.insert_odometry(message.header.stamp, log_time, message.pose.pose.planar());
        } else if ReferenceFrom::Topic(topic.clone()) == roles.reference {
            self.insert_truth(channel, log_time, data)?;
        } else if roles.inertial.as_ref() == Some(topic) {
            let message = Imu::from_bytes(data, &channel.encoding)?;
            let sample = inertial_sample(&message)?
                .map(|reading| Pending::Inertial(message.header.frame_id.clone(), reading));
            self.insert_optional(0, message.header.stamp, log_time, sample);
        } else if roles.satellites.as_ref() == Some(topic) {
            let message = NavSatFix::from_bytes(data, &channel.encoding)?;
            let position = self.satellites.position(&message)?.map(Pending::Position);
            self.insert_optional(1, message.header.stamp, log_time, position);
        }
        Ok(())
    }

    fn insert_scan(&mut self, channel: &Channel, log_time: Stamp, data: &[u8]) -> Result<()> {
        self.skipped.scans += 1;
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
            self.skipped.out_of_order += 1;
            return Ok(());
        }
        self.latest_scan = Some(stamp);
        self.wait(stamp, Pending::Scan(scan));
        Ok(())
    }

    fn insert_odometry(&mut self, stamp: Stamp, log_time: Stamp, pose: Option<Pose2>) {
        let stamp = self.stamp(stamp, log_time);
        let stamp = Stamp(stamp.0.saturating_add(Stamp::from_seconds(self.odometry_delay).0));
        let late = self.odometry.back().is_some_and(|(latest, _)| stamp <= *latest);
        match pose {
            Some(pose) if !late && stamp > self.given_until => {
                let pose = pose * self.known.roles.base_in_odometry;
                let pose = self.noise.as_mut().map_or(pose, |noise| noise.next(pose));
                self.odometry.push_back((stamp, pose));
            }
            _ => self.skipped.out_of_order += 1,
        }
    }

    fn insert_truth(&mut self, channel: &Channel, log_time: Stamp, data: &[u8]) -> Result<()> {
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
                self.wait(stamp, Pending::Truth(pose));
            }
            _ => self.skipped.out_of_order += 1,
        }
        Ok(())
    }

    /// What the inertial unit (sensor 0) or the satellite receiver (1) measured, if anything.
    fn insert_optional(
        &mut self,
        sensor: usize,
        stamp: Stamp,
        log_time: Stamp,
        measured: Option<Pending>,
    ) {
        let stamp = self.stamp(stamp, log_time);
        let Some(measured) = measured else {
            self.skipped.without_measurement += 1;
            return;
        };
        if let Some(latest) = self.latest_optional.get_mut(sensor) {
            if latest.is_some_and(|latest| stamp <= latest) {
                self.skipped.out_of_order += 1;
                return;
            }
            *latest = Some(stamp);
        }
        self.wait(stamp, measured);
    }

    /// The stamp of a message, or the time at which it was recorded where it has none.
    fn stamp(&mut self, stamp: Stamp, log_time: Stamp) -> Stamp {
        if stamp != Stamp(0) {
            return stamp;
        }
        self.skipped.zero_stamps += 1;
        log_time
    }

    fn wait(&mut self, stamp: Stamp, message: Pending) {
        // Of what belongs to the same time, the pose that judges it comes last.
        let is_truth = matches!(message, Pending::Truth(_));
        let after = |known: Stamp| known > stamp || (!is_truth && known == stamp);
        let later = self.pending.iter().rev().take_while(|(known, _)| after(*known)).count();
        self.pending.insert(self.pending.len() - later, (stamp, message));
    }

    /// Up to this time nothing more is to come.
    fn watermark(&self) -> Option<Stamp> {
        let roles = &self.known.roles;
        let odometry = self.odometry.back().map(|(stamp, _)| *stamp);
        let mut latest = vec![odometry, self.latest_scan];
        if matches!(roles.reference, ReferenceFrom::Topic(_)) {
            latest.push(self.latest_truth);
        }
        let topics = [&roles.inertial, &roles.satellites];
        let optional = self.latest_optional.iter().zip(topics);
        latest.extend(optional.filter(|(_, topic)| topic.is_some()).map(|(stamp, _)| *stamp));
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
                self.odometry.iter().map(|(stamp, _)| *stamp).find(|s| *s > self.given_until);
            let next_pending = self.pending.front().map(|(stamp, _)| *stamp);
            match (next_pending, next_odometry) {
                (Some(pending), odometry)
                    if pending <= until && odometry.is_none_or(|odometry| pending <= odometry) =>
                {
                    // The odometry after it is needed to interpolate.
                    if let Some((stamp, message)) = self.pending.pop_front() {
                        self.give(stamp, message);
                    }
                }
                (_, Some(odometry)) if odometry <= until => {
                    self.given_until = odometry;
                    if let Some((_, pose)) = self.odometry.iter().find(|(s, _)| *s == odometry) {
                        let pose = *pose;
                        self.give_moment(odometry, Some(pose), None, None);
                    }
                    while self.odometry.get(1).is_some_and(|(stamp, _)| *stamp <= odometry) {
                        self.odometry.pop_front();
                    }
                }
                _ => return,
            }
        }
    }

    /// Gives out a message that waited, with the odometry of its moment.
    fn give(&mut self, stamp: Stamp, message: Pending) {
        if stamp < self.given_until {
            self.skipped.out_of_order += 1;
            return;
        }
        match message {
            Pending::Inertial(frame, reading) => match self.inertial(&frame, &reading, stamp) {
                Ok(reading) => {
                    self.give_moment(stamp, None, Some(Measurement::Inertial(reading)), None);
                }
                Err(error) => self.skipped.unreadable(error.to_string()),
            },
            Pending::Position(position) => {
                self.give_moment(stamp, None, Some(Measurement::Position(position)), None);
            }
            Pending::Truth(pose) => {
                if let Some(odometry) = self.odometry_at(stamp) {
                    self.give_moment(stamp, Some(odometry), None, None);
                    self.give_moment(stamp, None, None, Some(pose));
                }
            }
            Pending::Scan(scan) => {
                let Some(odometry) = self.odometry_at(stamp) else {
                    self.skipped.without_odometry += 1;
                    return;
                };
                match self.scan_with_truth(&scan, stamp) {
                    Ok((scan, truth)) => {
                        self.give_moment(stamp, Some(odometry), Some(scan), truth);
                    }
                    Err(error @ Error::NoTransform { .. }) => {
                        self.skipped.without_transform += 1;
                        self.skipped.why_without_transform.get_or_insert(error);
                    }
                    Err(error) => self.skipped.unreadable(error.to_string()),
                }
            }
        }
    }

    fn give_moment(
        &mut self,
        stamp: Stamp,
        odometry: Option<Pose2>,
        measurement: Option<Measurement>,
        truth: Option<Pose2>,
    ) {
        let stamp = stamp.seconds();
        self.ready.push_back(Moment { stamp, odometry, measurement, truth });
    }

    /// The odometry between the two poses around a time.
    fn odometry_at(&self, stamp: Stamp) -> Option<Pose2> {
        let after = self.odometry.partition_point(|(known, _)| *known < stamp);
        let (to, second) = *self.odometry.get(after)?;
        if to == stamp {
            return Some(second);
        }
        let (from, first) = *self.odometry.get(after.checked_sub(1)?)?;
        let gap = to.seconds_since(from);
        let share = stamp.seconds_since(from) / gap;
        let step = first.between(second);
        (gap <= MAX_GAP).then(|| first * Pose2::exp(&(share * step.log())))
    }

    /// A scan with the pose of its laser and, where the transforms say it, the robot's in the map.
    fn scan_with_truth(
        &self,
        scan: &messages::LaserScan,
        stamp: Stamp,
    ) -> Result<(Measurement, Option<Pose2>)> {
        let roles = &self.known.roles;
        let (mounting, upside_down) = match self.known.options.mounting {
            Some(mounting) => (mounting, false),
            None => {
                let frame = &scan.header.frame_id;
                planar_mounting(&self.frames.lookup(&roles.base, frame, stamp, HOLD)?, frame)?
            }
        };
        let truth = match &roles.reference {
            ReferenceFrom::Transform(map) => {
                let place = self.frames.lookup(map, &roles.base, stamp, HOLD).ok();
                place.map(|place| messages::planar(&place))
            }
            _ => None,
        };
        let scan = Arc::new(converted(scan, upside_down)?);
        Ok((Measurement::Scan { scan, mounting }, truth))
    }

    /// A sample at the robot's middle; a unit without a frame is taken to be there.
    fn inertial(&self, frame: &str, reading: &ImuReading, stamp: Stamp) -> Result<ImuReading> {
        let place = match frame {
            "" => Isometry3::identity(),
            frame => self.frames.lookup(&self.known.roles.base, frame, stamp, HOLD)?,
        };
        let reading = at_base(reading, &place);
        reading.check()?;
        Ok(reading)
    }

    /// The file or folder.
    pub fn path(&self) -> &Path {
        &self.known.path
    }

    /// Whether the bag holds true poses, or estimates to be taken for them.
    pub fn has_reference(&self) -> bool {
        self.known.roles.reference != ReferenceFrom::Nothing
    }

    /// The last stamp of the bag \[s\], 0 for one without odometry and moving transforms.
    pub fn end(&self) -> f64 {
        self.known.last_stamp.map_or(0.0, Stamp::seconds)
    }

    /// What is added to the stamps of the odometry \[s\].
    pub fn odometry_delay(&self) -> f64 {
        self.odometry_delay
    }

    /// The error of a recording that was read to its end without a scan.
    pub fn no_scans(&mut self) -> Error {
        if let Some(error) = self.skipped.why_without_transform.take() {
            return error;
        }
        let expected = "laser scans to use, with odometry before and after them";
        let mut found = format!("{} messages on {}", self.skipped.scans, self.known.roles.scans);
        for note in self.notes() {
            found.push_str("; ");
            found.push_str(&note);
        }
        unsuitable(self.bag.path(), expected, found)
    }

    /// What was chosen, repaired and passed over, as lines for the user.
    pub fn notes(&self) -> Vec<String> {
        let roles = &self.known.roles;
        let reference = match &roles.reference {
            ReferenceFrom::Nothing => None,
            ReferenceFrom::Topic(topic) => Some(format!("reference: {topic}")),
            ReferenceFrom::Transform(map) => {
                Some(format!("reference: the recorded transform from {map}, itself an estimate"))
            }
        };
        let mut notes = self.bag.notes();
        notes.extend(reference);
        notes.extend(self.delay_note.clone());
        notes.extend(self.satellites.note());
        notes.extend(roles.notes.iter().cloned());
        notes.extend(self.skipped.notes());
        notes
    }
}

impl Iterator for Recording {
    type Item = Result<Moment>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_moment().transpose()
    }
}

impl std::fmt::Debug for Recording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (path, roles) = (self.bag.path(), &self.known.roles);
        f.debug_struct("Recording").field("path", &path).field("roles", roles).finish()
    }
}

/// Messages that were passed over, by reason.
#[derive(Debug, Default)]
struct Skipped {
    /// All messages with scans, used or not.
    scans: u64,
    unreadable: u64,
    why_unreadable: Option<String>,
    without_odometry: u64,
    without_transform: u64,
    why_without_transform: Option<Error>,
    without_measurement: u64,
    out_of_order: u64,
    zero_stamps: u64,
    bad_transforms: usize,
}

impl Skipped {
    fn unreadable(&mut self, why: String) {
        self.unreadable += 1;
        self.why_unreadable.get_or_insert(why);
    }

    /// Lines for the user.
    fn notes(&self) -> Vec<String> {
        let first = |reason: Option<String>| {
            reason.map_or(String::new(), |reason| format!(", the first: {reason}"))
        };
        let why = first(self.why_unreadable.clone());
        let place = first(self.why_without_transform.as_ref().map(ToString::to_string));
        let counts = [
            (self.unreadable, format!("messages that cannot be used{why}")),
            (self.without_odometry, "scans without odometry before and after them".into()),
            (self.without_transform, format!("scans without the place of the laser{place}")),
            (
                self.without_measurement,
                "messages without a fix, or of half an inertial unit".into(),
            ),
            (self.out_of_order, "messages with a stamp not after the one before".into()),
            (self.zero_stamps, "messages with stamp 0, taken at the time of recording".into()),
            (self.bad_transforms as u64, "transforms that are no rigid motions".into()),
        ];
        let counts = counts.into_iter().filter(|(count, _)| *count > 0);
        counts.map(|(count, what)| format!("{count} {what}")).collect()
    }
}
