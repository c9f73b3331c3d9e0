//! A past that grows at its end, and of which copies share what they have in common.
//!
//! Filters are copied often: to try something out, to come back when an input is late. A copy of a
//! chain costs nothing, however long it is.

use std::fmt;
use std::sync::Arc;

/// Values in the order in which they were pushed.
pub(super) struct Chain<T> {
    last: Option<Arc<Entry<T>>>,
    len: usize,
}

struct Entry<T> {
    value: T,
    before: Option<Arc<Entry<T>>>,
}

impl<T> Chain<T> {
    pub(super) const EMPTY: Self = Chain { last: None, len: 0 };

    pub(super) fn push(&mut self, value: T) {
        let before = self.last.take();
        self.last = Some(Arc::new(Entry { value, before }));
        self.len += 1;
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The values, the last one first.
    pub(super) fn backwards(&self) -> impl Iterator<Item = &T> {
        let entries = std::iter::successors(self.last.as_deref(), |entry| entry.before.as_deref());
        entries.map(|entry| &entry.value)
    }
}

impl<T> Clone for Chain<T> {
    fn clone(&self) -> Self {
        Chain { last: self.last.clone(), len: self.len }
    }
}

/// One entry after the other: left to the compiler, a long chain would overflow the stack.
impl<T> Drop for Chain<T> {
    fn drop(&mut self) {
        let mut next = self.last.take();
        while let Some(mut entry) = next.and_then(Arc::into_inner) {
            next = entry.before.take();
        }
    }
}

impl<T> fmt::Debug for Chain<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} moments", self.len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn copies_share_what_was_before_and_go_their_own_way() {
        let mut one = Chain::EMPTY;
        one.push(1);
        one.push(2);
        let mut other = one.clone();
        one.push(3);
        other.push(4);
        assert_eq!(one.backwards().copied().collect::<Vec<_>>(), [3, 2, 1]);
        assert_eq!(other.backwards().copied().collect::<Vec<_>>(), [4, 2, 1]);
        drop(one);
        assert_eq!(other.backwards().copied().collect::<Vec<_>>(), [4, 2, 1]);
        assert_eq!(other.len(), 3);
    }

    #[test]
    fn a_long_past_is_forgotten_without_trouble() {
        let mut chain = Chain::EMPTY;
        (0..1_000_000).for_each(|k| chain.push(k));
        let copy = chain.clone();
        drop(chain);
        assert_eq!(copy.backwards().count(), 1_000_000);
    }
}
