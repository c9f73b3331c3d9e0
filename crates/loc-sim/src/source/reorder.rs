//! A queue that gives events back in order of arrival.

use loc_sensors::event::Event;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Events in order of arrival; of equal ones the first in is the first out.
#[derive(Debug, Default)]
pub(super) struct Reorder {
    heap: BinaryHeap<Waiting>,
    count: u64,
}

#[derive(Debug)]
struct Waiting {
    event: Event,
    number: u64,
}

impl Reorder {
    pub(super) fn push(&mut self, event: Event) {
        self.heap.push(Waiting { event, number: self.count });
        self.count += 1;
    }

    /// The first event, if none that arrives later than `until` \[s\] could still precede it.
    pub(super) fn pop(&mut self, until: f64) -> Option<Event> {
        let first = self.heap.peek()?;
        if first.event.arrival < until {
            self.heap.pop().map(|waiting| waiting.event)
        } else {
            None
        }
    }
}

impl Ord for Waiting {
    /// Reversed, since the heap gives its greatest element first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.event.order(&self.event).then(other.number.cmp(&self.number))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Waiting {}
