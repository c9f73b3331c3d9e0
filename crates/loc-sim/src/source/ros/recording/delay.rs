//! How late the odometry of a bag is.

use super::join::Join;
use crate::Result;
use crate::source::OdometryTiming;
use loc_pf::delay::{DelayEstimate, DelayEstimator, DelaySettings};

/// How much of a bag is looked through \[s\].
const WINDOW: f64 = 600.0;

/// What is added to the stamps of the odometry, and why.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeasuredDelay {
    /// \[s\]
    pub(super) used: f64,
    looked: Option<Option<DelayEstimate>>,
}

impl MeasuredDelay {
    pub(super) fn known(used: f64) -> Self {
        MeasuredDelay { used, looked: None }
    }

    /// What the scans of a bag say, read with its stamps as they are.
    pub(super) fn of(mut join: Join) -> Result<Self> {
        let mut estimator = DelayEstimator::new(DelaySettings::default())?;
        let mut start = None;
        while let Some(entry) = join.next_entry()? {
            let begin = *start.get_or_insert(entry.stamp);
            if estimator.has_enough() || entry.stamp > begin + WINDOW {
                break;
            }
            if let Some((scan, mounting)) = entry.scan() {
                estimator.scan(entry.stamp, scan, mounting);
            } else if let Some(pose) = entry.odometry() {
                estimator.odometry(entry.stamp, pose);
            }
        }
        let found = estimator.estimate();
        let significant = found.filter(DelayEstimate::is_significant);
        let used = significant.map_or(0.0, |found| found.delay);
        Ok(MeasuredDelay { used, looked: Some(found) })
    }

    pub(super) fn timing(&self) -> OdometryTiming {
        let found = self.looked.flatten();
        OdometryTiming {
            delay_s: self.used,
            estimated_s: found.map(|found| found.delay),
            sigma_s: found.map(|found| found.sigma),
            pairs: found.map_or(0, |found| found.pairs),
        }
    }

    /// A line for the user.
    pub(super) fn note(&self) -> Option<String> {
        let Some(looked) = self.looked else {
            let moved = self.used.abs() > 0.0;
            return moved.then(|| format!("odometry moved in time by {:+.3} s", self.used));
        };
        let Some(DelayEstimate { delay, sigma, pairs, .. }) = looked else {
            return Some("delay of the odometry not estimated: too few turns in the scans".into());
        };
        let by = format!("{delay:+.3} s, sigma {sigma:.3} s, by the turns of {pairs} scans");
        Some(match self.used.abs() > 0.0 {
            true => format!("odometry moved in time by {by} (--odom-delay 0 for not)"),
            false => format!("odometry left in time: not significant, {by}"),
        })
    }
}
