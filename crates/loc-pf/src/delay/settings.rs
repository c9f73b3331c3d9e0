//! What a delay is looked for in.

use crate::Result;
use loc_core::error::positive;

/// Settings of [`DelayEstimator`](super::DelayEstimator); the defaults suit robots that turn at
/// walking pace and scanners of 5 Hz and more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DelaySettings {
    /// Longest delay, either way \[s\].
    pub longest: f64,
    /// Scans sooner after the one before are passed over \[s\].
    pub shortest_step: f64,
    /// Scans later after the one before are not matched with it \[s\].
    pub longest_step: f64,
    /// Least change of the rate of turn around a pair of scans that is worth matching them
    /// \[rad/s\].
    pub change_of_rate: f64,
    /// Most points of a scan that are matched.
    pub points: usize,
    /// Most pairs of scans.
    pub pairs: usize,
}

impl Default for DelaySettings {
    fn default() -> Self {
        DelaySettings {
            longest: 0.5,
            shortest_step: 0.08,
            longest_step: 0.5,
            change_of_rate: 0.1,
            points: 180,
            pairs: 400,
        }
    }
}

impl DelaySettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        positive("longest delay [s]", self.longest)?;
        positive("shortest step between scans [s]", self.shortest_step)?;
        positive("longest step between scans [s]", self.longest_step)?;
        positive("change of the rate of turn [rad/s]", self.change_of_rate)?;
        positive("points of a scan", self.points as f64)?;
        positive("pairs of scans", self.pairs as f64)?;
        Ok(())
    }
}
