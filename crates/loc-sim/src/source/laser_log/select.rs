//! Which scans of a log are used.

use super::{Entry, LaserLog, What, unsuitable};
use crate::Result;

/// Which scans of a log to use, counted from 0 over all that it holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Scans {
    /// Every scan.
    #[default]
    All,
    /// 1, 3, 5, ..
    Odd,
    /// 0, 2, 4, ..
    Even,
}

impl Scans {
    /// Whether scan `index` is used.
    pub fn takes(self, index: usize) -> bool {
        match self {
            Scans::All => true,
            Scans::Odd => index % 2 == 1,
            Scans::Even => index.is_multiple_of(2),
        }
    }
}

/// Leaves out the scans that are not used. The odometry of one that is left out stays; its
/// reference goes.
pub(super) fn select(log: &mut LaserLog, scans: Scans) -> Result<()> {
    let (mut index, mut taken) = (0, 0);
    for entry in &mut log.entries {
        let What::Scan(scan) = &entry.what else { continue };
        if scans.takes(index) {
            taken += 1;
        } else {
            entry.what = What::Odometry(scan.odometry);
        }
        index += 1;
    }
    match taken {
        0 => Err(unsuitable(log, "laser scans to use", format!("none among its {index}"))),
        _ => Ok(()),
    }
}

/// Passes over what comes before the first scan: nothing localizes yet.
pub(super) fn start_at_first_scan(log: &mut LaserLog) {
    let first = log.entries.iter().position(Entry::is_scan).unwrap_or(0);
    log.entries.drain(..first);
}
