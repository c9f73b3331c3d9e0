//! Scans while the odometry stands still: encoders stick, and a robot is pushed or carried.

/// Watches how scans fit while the odometry reports no motion.
///
/// Every few scans one is rated at the reported pose, and after a bad one the next. Where two in a
/// row fit much worse than when the odometry moved last, and badly, the robot has moved, whatever
/// the odometry says. From then on every scan is rated, and each that fits badly is a motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Standing {
    /// The shift of the log odds of being lost by the scan of the last update by odometry \[nats\].
    usual: Option<f64>,
    /// Scans since then.
    scans: u32,
    /// Ratings in a row that were bad.
    bad: u32,
    is_moving: bool,
}

/// One of this many scans is rated.
const EVERY: u32 = 5;

/// A scan fits much worse if it shifts the log odds by this much more \[nats\].
const WORSE: f64 = 1.5;

/// This many bad ratings in a row are evidence of a motion.
const ENOUGH: u32 = 2;

impl Standing {
    /// After an update by odometry, with the shift of the log odds by its scan.
    pub(super) fn updated(&mut self, shift: Option<f64>) {
        *self = Standing { usual: shift.or(self.usual), ..Standing::default() };
    }

    /// Whether the robot moves although its odometry stands still.
    pub(super) fn is_moving(&self) -> bool {
        self.is_moving
    }

    /// Whether to rate the next scan.
    pub(super) fn is_due(&mut self) -> bool {
        self.scans += 1;
        let is_suspected = self.is_moving || self.bad > 0;
        self.usual.is_some() && (is_suspected || self.scans.is_multiple_of(EVERY))
    }

    /// Whether the robot has moved, by the shift of the log odds by a scan.
    pub(super) fn has_moved(&mut self, shift: Option<f64>) -> bool {
        let usual = self.usual.unwrap_or(f64::INFINITY);
        let is_bad = shift.is_some_and(|shift| shift > 0.0 && shift > usual + WORSE);
        self.bad = if is_bad { self.bad + 1 } else { 0 };
        self.is_moving |= self.bad >= ENOUGH;
        self.is_moving && is_bad
    }
}
