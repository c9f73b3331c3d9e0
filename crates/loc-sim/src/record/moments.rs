//! The scans that corrected a pose most, for figures.

use loc_core::Stamped;
use loc_filters::line_matching::LineUpdate;

/// Of each part of a run the update that moved the pose most.
#[derive(Debug, Clone, PartialEq)]
pub struct LineMoments {
    start: f64,
    end: f64,
    parts: [Option<Stamped<LineUpdate>>; Self::PARTS],
}

/// A turn of 1 rad counts as much as a way of so many metres.
const LEVER: f64 = 3.0;

impl LineMoments {
    /// Number of parts.
    pub const PARTS: usize = 6;

    /// None yet, of a run between two times \[s\].
    pub fn new(start: f64, end: f64) -> Self {
        LineMoments { start, end, parts: Default::default() }
    }

    /// Offers an update at a time \[s\].
    pub fn offer(&mut self, stamp: f64, update: &LineUpdate) {
        let share = (stamp - self.start) / (self.end - self.start);
        // The cast saturates, NaN becomes 0.
        let part = ((share * Self::PARTS as f64) as usize).min(Self::PARTS - 1);
        let kept = self.parts[part].as_ref().map(|kept| correction(&kept.value));
        if kept.is_none_or(|kept| correction(update) > kept) {
            self.parts[part] = Some(Stamped { stamp, value: update.clone() });
        }
    }

    /// The updates in order of time.
    pub fn iter(&self) -> impl Iterator<Item = &Stamped<LineUpdate>> {
        self.parts.iter().flatten()
    }
}

/// How far an update moved the pose \[m\].
fn correction(update: &LineUpdate) -> f64 {
    let (before, after) = (update.before.pose(), update.after.pose());
    f64::hypot(before.distance(after), LEVER * before.between(after).theta)
}
