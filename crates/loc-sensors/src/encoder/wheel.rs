//! Counts of a wheel.

use crate::Result;
use crate::check::in_range;
use loc_core::error::positive;
use std::f64::consts::TAU;

/// Counts since the last reading, negative backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WheelTicks(pub i64);

/// An incremental encoder on a wheel. Rounding to whole counts is its only error; slip, bumps and
/// worn tyres are those of the wheel ([`crate::wheel::WheelFaults`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelEncoder {
    meters_per_tick: f64,
    /// Way that has rolled since the last full count, in counts, in \[0, 1).
    rest: f64,
}

/// Counts of one reading that a float still tells apart.
const MAX_TICKS: f64 = 9e15;

impl WheelEncoder {
    /// An encoder with `ticks_per_turn` counts (all four edges of a quadrature encoder count) on a
    /// wheel of `radius` \[m\].
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for no counts, or a radius that is not positive.
    pub fn new(ticks_per_turn: u32, radius: f64) -> Result<Self> {
        positive("radius of a wheel [m]", radius)?;
        let ticks = f64::from(ticks_per_turn);
        in_range("counts of a wheel's turn", "at least 1", ticks, |count| count >= 1.0)?;
        let meters_per_tick = TAU * radius / ticks;
        positive("way of one count [m]", meters_per_tick)?;
        Ok(WheelEncoder { meters_per_tick, rest: 0.0 })
    }

    /// Way of one count \[m\]. An error of the way in one step is at most this.
    pub fn resolution(&self) -> f64 {
        self.meters_per_tick
    }

    /// The counts while the rim rolls `distance` \[m\]; the part of a count that is left over
    /// counts next time. A way that is no number, or none a wheel can roll, gives no counts.
    pub fn roll(&mut self, distance: f64) -> WheelTicks {
        let turned = self.rest + distance / self.meters_per_tick;
        if turned.is_nan() || turned.abs() >= MAX_TICKS {
            return WheelTicks(0);
        }
        self.rest = turned - turned.floor();
        WheelTicks(turned.floor() as i64)
    }

    /// The way of a number of counts \[m\].
    pub fn distance(&self, ticks: WheelTicks) -> f64 {
        ticks.0 as f64 * self.meters_per_tick
    }
}
