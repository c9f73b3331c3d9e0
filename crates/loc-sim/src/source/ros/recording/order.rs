//! In which order messages are given out.

use super::join::{Join, Waiting};
use super::roles::ReferenceFrom;
use crate::Error;
use crate::source::laser_log::Entry;
use crate::source::ros::messages::Stamp;
use loc_core::Pose2;
use loc_sensors::event::Measurement;

/// A message waits this long for those of other topics that belong before it \[ns\].
const PATIENCE: i64 = 5_000_000_000;

/// Gap of the odometry over which nothing is interpolated \[s\].
const LONGEST_GAP: f64 = 1.0;

impl Join {
    /// Up to this time nothing more is to come.
    pub(super) fn watermark(&self) -> Option<Stamp> {
        let odometry = self.odometry.back().map(|(stamp, _)| *stamp);
        let mut latest = vec![odometry, self.latest_scan];
        if matches!(self.roles.reference, ReferenceFrom::Topic(_)) {
            latest.push(self.latest_truth);
        }
        let topics = [&self.roles.inertial, &self.roles.satellites];
        let beside = self.latest_beside.iter().zip(topics);
        latest.extend(beside.filter(|(_, topic)| topic.is_some()).map(|(stamp, _)| *stamp));
        let newest = latest.iter().flatten().max()?;
        let impatient = Stamp(newest.0.saturating_sub(PATIENCE));
        let common = latest.iter().copied().min()?;
        Some(common.map_or(impatient, |common| common.max(impatient)))
    }

    /// Gives out everything up to a time.
    pub(super) fn give_until(&mut self, until: Option<Stamp>) {
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
                        self.ready.push_back(Entry::of_odometry(odometry.seconds(), *pose));
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
        let beside = match &what {
            Waiting::Inertial(frame, reading) => Some(self.inertial(frame, reading, stamp)),
            Waiting::Position(position) => Some(Ok(Measurement::Position(*position))),
            Waiting::Scan(_) | Waiting::Truth(_) => None,
        };
        match beside {
            Some(Ok(measured)) => {
                let entry = Entry::of_measurement(stamp.seconds(), measured);
                return self.ready.push_back(entry);
            }
            Some(Err(error)) => return self.counts.unreadable(error.to_string()),
            None => {}
        }
        let Some(odometry) = self.odometry_at(stamp) else {
            self.counts.without_odometry += u64::from(matches!(what, Waiting::Scan(_)));
            return;
        };
        let seconds = stamp.seconds();
        match what {
            Waiting::Truth(pose) => {
                self.ready.push_back(Entry::of_odometry(seconds, odometry));
                self.ready.push_back(Entry::of_truth(seconds, pose));
            }
            Waiting::Scan(scan) => match self.recorded(&scan, stamp, odometry) {
                Ok(scan) => {
                    self.ready.push_back(Entry::of_scan(seconds, scan));
                }
                Err(error @ Error::NoTransform { .. }) => {
                    self.counts.without_transform += 1;
                    self.counts.why_without_transform.get_or_insert(error);
                }
                Err(error) => self.counts.unreadable(error.to_string()),
            },
            Waiting::Inertial(..) | Waiting::Position(_) => {}
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
        let gap = to.seconds_since(from);
        let share = stamp.seconds_since(from) / gap;
        let step = first.between(second);
        (gap <= LONGEST_GAP).then(|| first * Pose2::exp(&(share * step.log())))
    }
}
