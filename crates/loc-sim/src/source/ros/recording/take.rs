//! Messages taken in: each is decoded and waits for its turn.

use super::beside::sample;
use super::join::{Join, Waiting};
use super::preview::transforms;
use super::roles::{OdometryFrom, ReferenceFrom};
use crate::Result;
use crate::source::ros::bag::Channel;
use crate::source::ros::messages::{
    self, Imu, Message, MultiEchoLaserScan, NavSatFix, Odometry, PointCloud2, PoseStamped,
    PoseWithCovarianceStamped, Slice, Stamp, TfMessage,
};

impl Join {
    pub(super) fn take_message(
        &mut self,
        channel: &Channel,
        log_time: Stamp,
        data: &[u8],
    ) -> Result<()> {
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
        } else if self.roles.inertial.as_ref() == Some(topic) {
            let message = Imu::from_bytes(data, &channel.encoding)?;
            let what = sample(&message)?
                .map(|reading| Waiting::Inertial(message.header.frame_id.clone(), reading));
            self.take_beside(0, message.header.stamp, log_time, what);
        } else if self.roles.satellites.as_ref() == Some(topic) {
            let message = NavSatFix::from_bytes(data, &channel.encoding)?;
            let what = self.satellites.position(&message)?.map(Waiting::Position);
            self.take_beside(1, message.header.stamp, log_time, what);
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

    /// Takes what the sensor of this index among those beside the laser measured, if anything.
    fn take_beside(&mut self, sensor: usize, stamp: Stamp, log_time: Stamp, what: Option<Waiting>) {
        let stamp = self.stamp(stamp, log_time);
        let Some(what) = what else {
            self.counts.without_measurement += 1;
            return;
        };
        if let Some(latest) = self.latest_beside.get_mut(sensor) {
            if latest.is_some_and(|latest| stamp <= latest) {
                self.counts.out_of_order += 1;
                return;
            }
            *latest = Some(stamp);
        }
        self.wait(stamp, what);
    }

    /// The stamp of a message, or the time at which it was recorded where it has none.
    pub(super) fn stamp(&mut self, stamp: Stamp, log_time: Stamp) -> Stamp {
        if stamp != Stamp(0) {
            return stamp;
        }
        self.counts.zero_stamps += 1;
        log_time
    }

    fn wait(&mut self, stamp: Stamp, what: Waiting) {
        // Of what belongs to the same time, the pose that judges it comes last.
        let is_truth = matches!(what, Waiting::Truth(_));
        let after = |known: Stamp| known > stamp || (!is_truth && known == stamp);
        let later = self.waiting.iter().rev().take_while(|(known, _)| after(*known)).count();
        self.waiting.insert(self.waiting.len() - later, (stamp, what));
    }
}
