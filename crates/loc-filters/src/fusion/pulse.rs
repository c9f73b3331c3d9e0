//! For how long a measurement holds.

/// What a sensor measured holds for so many of its periods.
const HOLDS: f64 = 1.5;
/// A sensor's period as long as only one reading is known, and the longest \[s\].
const FIRST_PERIOD: f64 = 0.1;
const LONGEST_PERIOD: f64 = 1.0;

/// A sensor that measures again and again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pulse {
    last: Option<f64>,
    /// When its last measurement ceases to hold \[s\].
    pub(super) until: f64,
}

impl Pulse {
    pub(super) const SILENT: Pulse = Pulse { last: None, until: f64::NEG_INFINITY };

    /// A measurement at `stamp` \[s\]; the answer is the time since the last one.
    pub(super) fn beat(&mut self, stamp: f64) -> f64 {
        let since = self.last.map(|last| stamp - last).filter(|since| *since > 0.0);
        let period = since.unwrap_or(FIRST_PERIOD).min(LONGEST_PERIOD);
        *self = Pulse { last: Some(stamp), until: stamp + HOLDS * period };
        period
    }

    pub(super) fn holds(&self, stamp: f64) -> bool {
        stamp < self.until
    }
}
