//! A CARMEN log as a recording to replay.

use super::{CarmenLaser, CarmenLog, Message};
use crate::Result;
use crate::source::laser_log::{Entry, LaserLog, RecordedScan, What};
use loc_core::{Pose2, angle};
use std::sync::Arc;

/// Laser poses closer than this to what the mounting says are where it says \[m, rad\].
const ROUNDING: f64 = 1e-3;

/// How much a robot must turn to tell the place of its laser from a correction \[rad\].
const MIN_TURN: f64 = 0.1;

impl CarmenLog {
    /// The whole log, to be replayed.
    ///
    /// A laser that keeps its place on the robot is mounted there. Where the laser's pose differs
    /// from the odometry in any other way, the log was corrected, and the laser's pose is the
    /// reference. `TRUEPOS` messages go before it.
    ///
    /// # Errors
    /// What is wrong with the log, and where.
    pub fn laser_log(mut self) -> Result<LaserLog> {
        let messages: Vec<Message> = self.by_ref().collect::<Result<_>>()?;
        let lasers = || {
            messages.iter().filter_map(|message| match message {
                Message::Laser(laser) => Some(laser),
                _ => None,
            })
        };
        let kept_place = mounting(lasers());
        let mounting = kept_place.or(self.laser_offset()).unwrap_or_default();
        let is_truth = |message: &Message| matches!(message, Message::Truth(_));
        let corrected = kept_place.is_none() && !messages.iter().any(is_truth);
        let skipped = self.skipped();
        let notes = match skipped {
            0 => Vec::new(),
            _ => vec![format!("{skipped} messages of other kinds passed over")],
        };
        let entries = messages.into_iter().map(|message| match message {
            Message::Odometry(pose) => {
                Entry { stamp: pose.stamp, what: What::Odometry(pose.value) }
            }
            Message::Truth(pose) => Entry { stamp: pose.stamp, what: What::Truth(pose.value) },
            Message::Laser(laser) => Entry {
                stamp: laser.stamp,
                what: What::Scan(RecordedScan {
                    scan: Arc::new(laser.scan),
                    mounting,
                    odometry: laser.robot,
                    truth: corrected.then(|| laser.laser * mounting.inverse()),
                }),
            },
        });
        Ok(LaserLog { path: self.file().to_owned(), entries: entries.collect(), notes })
    }
}

/// Where the laser sits, if its pose follows from the odometry all along.
fn mounting<'a>(lasers: impl Iterator<Item = &'a CarmenLaser> + Clone) -> Option<Pose2> {
    let place = |laser: &CarmenLaser| laser.robot.between(laser.laser);
    let first = lasers.clone().next()?;
    let at_first = place(first);
    let is_there = |at: Pose2| {
        let turn = angle::difference(at.theta, at_first.theta);
        at.distance(at_first) < ROUNDING && turn.abs() < ROUNDING
    };
    if !lasers.clone().all(|laser| is_there(place(laser))) {
        return None;
    }
    let turned = lasers.map(|laser| angle::difference(laser.robot.theta, first.robot.theta).abs());
    let on_the_robot = at_first == Pose2::IDENTITY || turned.fold(0.0, f64::max) > MIN_TURN;
    on_the_robot.then_some(at_first)
}
