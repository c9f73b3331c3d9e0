//! Divergence of a filter: it is noticed by its rejections, and ended by its measurements.
//!
//! A gate keeps outliers out. A filter that has gone wrong by more than its covariance says takes
//! the right measurements for outliers, rejects all of them and stays wrong, as confident as
//! before. [`DivergenceMonitor`] watches the decisions of the gate: where most of the last ones are
//! rejections, which a consistent filter has once in many years, the belief is widened so far that the
//! rejected measurements fit, and they lead it back.
//!
//! ```
//! use loc_filters::divergence::DivergenceMonitor;
//! let mut monitor = DivergenceMonitor::default();
//! // One outlier in ten is no divergence; rejections one after the other are one.
//! assert!((0..1000).all(|k| !monitor.observe(k % 10 > 0)));
//! assert_eq!((0..12).filter(|_| monitor.observe(false)).count(), 1);
//! ```

/// Number of last decisions that are watched.
const WINDOW: u32 = 12;

/// Number of rejections among them from which on the filter has diverged.
const REJECTIONS: u32 = 9;

/// The last decisions of a gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DivergenceMonitor {
    /// Rejections as bits, the last decision lowest.
    recent: u32,
    restarts: u32,
}

impl DivergenceMonitor {
    /// Counts a decision; whether the filter has diverged and is to be widened now. The count starts
    /// anew then.
    pub fn observe(&mut self, accepted: bool) -> bool {
        self.recent = (self.recent << 1 | u32::from(!accepted)) & ((1 << WINDOW) - 1);
        let has_diverged = self.recent.count_ones() >= REJECTIONS;
        if has_diverged {
            self.recent = 0;
            self.restarts += 1;
        }
        has_diverged
    }

    /// How often the filter had diverged.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }
}
