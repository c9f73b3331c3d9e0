//! What a target has no place for.

use crate::source::Source;
use std::collections::BTreeMap;

/// Counts by kind.
#[derive(Debug, Default)]
pub(super) struct LeftOut(BTreeMap<String, u64>);

impl LeftOut {
    pub(super) fn count(&mut self, what: impl Into<String>) {
        *self.0.entry(what.into()).or_insert(0) += 1;
    }

    /// Lines for the user.
    pub(super) fn lines(self) -> Vec<String> {
        self.0.into_iter().map(|(what, count)| format!("{count} {what}")).collect()
    }

    /// The same, with what the source has passed over by itself.
    pub(super) fn with_notes(self, source: &dyn Source) -> Vec<String> {
        let mut lines = self.lines();
        lines.extend(source.notes());
        lines
    }
}
