//! The best poses met so far, and what a pose must have to be worth meeting.

use std::cmp::Reverse;
use std::sync::atomic::{AtomicU32, Ordering};

/// A pose of the search's grid with the sum of its codes.
///
/// In order of the sum; among equals that of the lower heading, and then of the lower place in
/// row-major order, is the greater. No two poses are equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Leaf {
    pub(super) sum: u32,
    /// Heading, and row-major place of the cell.
    pub(super) at: Reverse<[u32; 2]>,
}

/// The least sum that can still matter: it only rises, whoever raises it.
#[derive(Debug)]
pub(super) struct Floor {
    least: AtomicU32,
    /// How far below the best a pose may be.
    within: u32,
}

impl Floor {
    pub(super) fn new(least: u32, within: u32) -> Self {
        Floor { least: AtomicU32::new(least), within }
    }

    #[inline(always)]
    pub(super) fn get(&self) -> u32 {
        self.least.load(Ordering::Relaxed)
    }

    /// There is a pose with this sum.
    #[inline(always)]
    pub(super) fn met(&self, sum: u32) {
        self.raise(sum.saturating_sub(self.within));
    }

    #[inline(always)]
    fn raise(&self, least: u32) {
        if least > self.get() {
            self.least.fetch_max(least, Ordering::Relaxed);
        }
    }
}

/// Poses that may be among the answers.
#[derive(Debug, Default)]
pub(super) struct Leaves {
    leaves: Vec<Leaf>,
    /// So many are enough, however the search goes on.
    enough: usize,
}

impl Leaves {
    pub(super) fn new(enough: usize) -> Self {
        Leaves { leaves: Vec::new(), enough }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, leaf: Leaf, floor: &Floor) {
        self.leaves.push(leaf);
        floor.met(leaf.sum);
        if self.leaves.len() >= self.enough.max(512).saturating_mul(2) {
            self.shrink(floor);
        }
    }

    pub(super) fn enough(&self) -> usize {
        self.enough
    }

    /// Keeps the best ones only.
    fn shrink(&mut self, floor: &Floor) {
        let least = floor.get();
        self.leaves.retain(|leaf| leaf.sum >= least);
        if self.leaves.len() > self.enough {
            let place = self.enough - 1;
            let (_, last, _) = self.leaves.select_nth_unstable_by(place, |a, b| b.cmp(a));
            floor.raise(last.sum);
            self.leaves.truncate(self.enough);
        }
    }

    pub(super) fn append(&mut self, other: Leaves, floor: &Floor) {
        self.leaves.extend(other.leaves);
        self.shrink(floor);
    }

    /// Sorts them: the best last.
    pub(super) fn sort(&mut self) {
        self.leaves.sort_unstable();
    }

    /// The best one, once they are sorted.
    pub(super) fn best(&self) -> Option<Leaf> {
        self.leaves.last().copied()
    }

    pub(super) fn pop(&mut self) {
        self.leaves.pop();
    }
}
