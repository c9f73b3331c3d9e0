//! The landmarks of one particle.

use super::mark::Mark;
use super::shared::SharedList;

/// Landmarks in slots, of which some are empty. Copies share what they have in common.
#[derive(Debug, Clone, Default)]
pub(super) struct MarkMap {
    slots: SharedList<Option<Mark>>,
    /// How many slots hold a landmark.
    len: usize,
}

impl MarkMap {
    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn get(&self, slot: usize) -> Option<&Mark> {
        self.slots.get(slot)?.as_ref()
    }

    pub(super) fn get_mut(&mut self, slot: usize) -> Option<&mut Mark> {
        // An empty slot is left shared.
        self.get(slot)?;
        self.slots.get_mut(slot)?.as_mut()
    }

    /// Puts a landmark into the next slot.
    pub(super) fn push(&mut self, mark: Mark) {
        self.slots.push(Some(mark));
        self.len += 1;
    }

    /// Puts a landmark into an empty slot, which need not be there yet.
    pub(super) fn put(&mut self, slot: usize, mark: Mark) {
        while self.slots.len() <= slot {
            self.slots.push(None);
        }
        if let Some(place) = self.slots.get_mut(slot) {
            self.len += usize::from(place.is_none());
            *place = Some(mark);
        }
    }

    pub(super) fn remove(&mut self, slot: usize) {
        if self.get(slot).is_some() {
            self.len -= 1;
            if let Some(place) = self.slots.get_mut(slot) {
                *place = None;
            }
        }
    }

    /// Leaves the empty slots out, where they are more than half; the landmarks change their slots.
    pub(super) fn tighten(&mut self) {
        if self.slots.len() > 2 * self.len + 16 {
            let mut tight = MarkMap::default();
            self.visit(&mut |_, mark| tight.push(*mark));
            *self = tight;
        }
    }

    /// Shows all landmarks with their slots.
    pub(super) fn visit(&self, visitor: &mut impl FnMut(usize, &Mark)) {
        self.slots.visit(&mut |slot, mark| {
            if let Some(mark) = mark {
                visitor(slot, mark);
            }
        });
    }
}
