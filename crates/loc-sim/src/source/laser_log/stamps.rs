//! Stamps that can be relied on.

use super::{Entry, LaserLog};

/// Makes the stamps of a log rise. Where most scans share the stamp of the scan before, they are
/// of no use and give way to the number of the scan, 1 s apart; a single stamp that goes back
/// becomes that of the message before.
pub(super) fn mend(log: &mut LaserLog) {
    let stamps: Vec<f64> = log.entries.iter().filter(|e| e.is_scan()).map(|e| e.stamp).collect();
    let stuck = stamps.windows(2).filter(|pair| pair[1] <= pair[0]).count();
    if 2 * stuck > stamps.len().saturating_sub(1) {
        number(&mut log.entries);
        log.notes.push("its stamps are of no use: scans are taken as 1 s apart".into());
        return;
    }
    let (mut last, mut backwards) = (f64::NEG_INFINITY, 0);
    for entry in &mut log.entries {
        if entry.stamp < last {
            entry.stamp = last;
            backwards += 1;
        }
        last = entry.stamp;
    }
    if backwards > 0 {
        log.notes.push(format!("{backwards} messages with a stamp before the last one, set to it"));
    }
}

/// Gives every message the number of the scan that it comes with or after.
fn number(entries: &mut [Entry]) {
    let mut scans = 0_u32;
    for entry in entries {
        scans += u32::from(entry.is_scan());
        entry.stamp = f64::from(scans.saturating_sub(1));
    }
}
