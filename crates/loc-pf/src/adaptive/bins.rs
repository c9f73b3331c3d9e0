//! The set of bins that hold particles.

use crate::elementary::ROUND;
use loc_core::Pose2;
use std::f64::consts::TAU;

/// A set of bins: a table with open addressing, emptied in no time by a new stamp.
#[derive(Debug)]
pub(super) struct Bins {
    /// Bins per metre, and bins in a full turn over 2 pi.
    per_unit: [f64; 2],
    /// Bins in a full turn.
    headings: i32,
    /// Stamp and key of each slot, a power of two of them; a slot is taken if its stamp is the
    /// present one.
    slots: Vec<(u32, u64)>,
    stamp: u32,
    taken: usize,
}

impl Bins {
    /// No bins yet; `position` and `heading` are the widths of one \[m, rad\].
    pub(super) fn new(position: f64, heading: f64) -> Self {
        let headings = (TAU / heading - 1e-9).ceil().max(1.0);
        Bins {
            per_unit: [1.0 / position, headings / TAU],
            headings: headings as i32,
            slots: vec![(0, 0); 256],
            stamp: 1,
            taken: 0,
        }
    }

    /// Empties the set.
    pub(super) fn clear(&mut self) {
        self.taken = 0;
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.slots.fill((0, 0));
            self.stamp = 1;
        }
    }

    /// Number of bins in the set.
    pub(super) fn len(&self) -> usize {
        self.taken
    }

    /// Adds the bin of a pose; whether it was not there yet.
    pub(super) fn insert(&mut self, pose: Pose2) -> bool {
        let key = self.key(pose);
        let new = put(&mut self.slots, self.stamp, key);
        self.taken += usize::from(new);
        if 2 * self.taken > self.slots.len() {
            self.grow();
        }
        new
    }

    /// Bins are centred on multiples of their widths, one of them on the heading pi. Those further
    /// apart than 2^24 bins in x or y share a key: 8000 km at 0.5 m.
    fn key(&self, pose: Pose2) -> u64 {
        let [position, heading] = self.per_unit;
        // The low bits of the sum are the nearest whole number.
        let bits = |value: f64| (value + ROUND).to_bits();
        let (column, row) = (bits(pose.x * position), bits(pose.y * position));
        let heading = bits(pose.theta * heading) as u32 as i32;
        let heading = if heading < 0 { heading + self.headings } else { heading };
        (column & 0xff_ffff) << 40 | (row & 0xff_ffff) << 16 | (heading as u64 & 0xffff)
    }

    fn grow(&mut self) {
        let mut slots = vec![(0, 0); 2 * self.slots.len()];
        for &(_, key) in self.slots.iter().filter(|(stamp, _)| *stamp == self.stamp) {
            put(&mut slots, self.stamp, key);
        }
        self.slots = slots;
    }
}

/// Puts a key into the first free slot after its own; at least one is free.
fn put(slots: &mut [(u32, u64)], stamp: u32, key: u64) -> bool {
    let mask = slots.len() - 1;
    // Fibonacci hashing: the upper half of the product depends on every bit of the key.
    let mut slot = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
    while slots[slot].0 == stamp {
        if slots[slot].1 == key {
            return false;
        }
        slot = (slot + 1) & mask;
    }
    slots[slot] = (stamp, key);
    true
}
