//! How many cells have bounds of which height, and from which height on they matter.

/// Height of a level \[nat\].
const HEIGHT: f32 = 0.25;

/// How many levels there are: 64 nat.
const COUNT: usize = 256;

/// How far below the share that may be passed over the lowest level begins \[nat\].
const BELOW: f64 = 24.0;

/// Cells counted by the logarithm of the share that they can have at most.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    /// Key at which the lowest level begins.
    lowest: f32,
    /// The same as a share of the whole.
    lowest_share: f64,
    below: usize,
    counts: Vec<usize>,
}

impl Levels {
    /// Counts the keys that are above minus infinity, given the logarithm of the whole and the share
    /// of it that may be passed over, above 0.
    pub(super) fn of(keys: &[f32], log_total: f64, negligible: f64) -> Self {
        let lowest_share = (negligible.ln() - BELOW).exp();
        let lowest = (log_total + lowest_share.ln()) as f32;
        let mut levels = Levels { lowest, lowest_share, below: 0, counts: vec![0; COUNT] };
        for &key in keys.iter().filter(|key| **key > f32::NEG_INFINITY) {
            match levels.level(key) {
                Some(level) => levels.counts[level] += 1,
                None => levels.below += 1,
            }
        }
        levels
    }

    fn level(&self, key: f32) -> Option<usize> {
        let level = (key - self.lowest) / HEIGHT;
        // The highest level has no end.
        (level >= 0.0).then_some((level as usize).min(COUNT - 1))
    }

    /// Whether a key is in this level or a higher one.
    pub(super) fn is_in(&self, key: f32, level: usize) -> bool {
        key > f32::NEG_INFINITY && self.level(key).is_some_and(|of_key| of_key >= level)
    }

    /// The lowest level that is needed if all below may have the share `negligible` together, and
    /// the share that they can have at most.
    pub(super) fn needed(&self, negligible: f64) -> (usize, f64) {
        let mut passed_over = self.below as f64 * self.lowest_share;
        for (level, &count) in self.counts.iter().enumerate() {
            let upper = self.lowest_share * f64::from((level + 1) as f32 * HEIGHT).exp();
            let share = passed_over + count as f64 * upper;
            if share > negligible && count > 0 {
                return (level, passed_over);
            }
            passed_over = share;
        }
        (COUNT, passed_over)
    }

    /// The level from which on there are about so many cells, at least one if there are any.
    pub(super) fn of_about(&self, most: usize) -> usize {
        let mut above = 0;
        for (level, &count) in self.counts.iter().enumerate().rev() {
            above += count;
            if above > most {
                // A level alone may hold more.
                let alone = above == count;
                return if alone { level } else { level + 1 };
            }
        }
        0
    }
}
