//! Rotary encoders (B1, B2): how far a shaft has turned, in counts.
//!
//! On a wheel the counts since the last readout give the distance rolled: [`WheelEncoder`] keeps
//! the fraction of a count, so that rounding errors do not add up. On the steering of a car the
//! count is the steering angle: [`SteeringEncoder`] has backlash, a zero offset and noise. Both
//! round to whole counts, [`WheelTicks`] and [`SteeringCount`].
//!
//! ```
//! use loc_sensors::encoder::{WheelEncoder, WheelTicks};
//! let mut left = WheelEncoder::new(2048, 0.05)?;
//! let WheelTicks(ticks) = left.roll(1.0);
//! assert_eq!(ticks, 6518); // 1 m / (2 pi 0.05 m) turns
//! assert!((left.distance(WheelTicks(ticks)) - 1.0).abs() < 1e-3);
//! # Ok::<(), loc_core::Error>(())
//! ```

use crate::Result;
use crate::check::in_range;
use loc_core::error::{finite, non_negative, positive};
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{PI, TAU};

/// Counts since the last readout, negative backwards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WheelTicks(pub i64);

/// An incremental encoder on a wheel. Rounding to whole counts is its only error; slip, bumps and
/// worn tyres are those of the wheel ([`crate::wheel::WheelFaults`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelEncoder {
    meters_per_tick: f64,
    /// Distance rolled since the last full count, in counts, in \[0, 1).
    rest: f64,
}

/// Largest count of one readout that an `f64` represents exactly.
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
        positive("distance of one count [m]", meters_per_tick)?;
        Ok(WheelEncoder { meters_per_tick, rest: 0.0 })
    }

    /// Distance of one count \[m\]; the error of the distance in one step is at most this.
    pub fn resolution(&self) -> f64 {
        self.meters_per_tick
    }

    /// The counts while the rim rolls `distance` \[m\]; the fraction of a count that
    /// remains is added to the next step. A distance that is NaN, or too large, gives no counts.
    pub fn roll(&mut self, distance: f64) -> WheelTicks {
        let turned = self.rest + distance / self.meters_per_tick;
        if turned.is_nan() || turned.abs() >= MAX_TICKS {
            return WheelTicks(0);
        }
        self.rest = turned - turned.floor();
        WheelTicks(turned.floor() as i64)
    }

    /// The distance of a number of counts \[m\].
    pub fn distance(&self, ticks: WheelTicks) -> f64 {
        ticks.0 as f64 * self.meters_per_tick
    }
}

/// Count of an absolute encoder, 0 straight ahead, positive to the left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SteeringCount(pub i32);

/// Errors between the angle of the wheels and the count.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SteeringNoise {
    /// Standard deviation of the wheels' angle against the column (soft joints) \[rad\].
    pub sigma: f64,
    /// Angle that is reported straight ahead \[rad\].
    pub zero_offset: f64,
    /// Play: the wheels turn by this after a change of direction before the encoder does \[rad\].
    pub backlash: f64,
}

impl SteeringNoise {
    /// A perfect steering.
    pub const NONE: SteeringNoise = SteeringNoise { sigma: 0.0, zero_offset: 0.0, backlash: 0.0 };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values (the offset may be), NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of the steering angle [rad]", self.sigma)?;
        finite("offset of the steering angle [rad]", self.zero_offset)?;
        non_negative("backlash of the steering [rad]", self.backlash)?;
        Ok(())
    }
}

/// An absolute encoder that turns with the steered wheels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteeringEncoder {
    counts_per_turn: u32,
    noise: SteeringNoise,
    /// Angle of the encoder, within the play of the wheels' \[rad\].
    encoder: f64,
}

impl SteeringEncoder {
    /// An encoder with `counts_per_turn` counts in a full turn of the wheels' angle (those of the
    /// shaft times the ratio of the gear), without noise, straight ahead.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for fewer than 4 counts, or more than 2^30.
    pub fn new(counts_per_turn: u32) -> Result<Self> {
        let max = f64::from(1_u32 << 30);
        let sound = |count: f64| (4.0..=max).contains(&count);
        in_range("counts of a turn", "4 to 2^30", f64::from(counts_per_turn), sound)?;
        Ok(SteeringEncoder { counts_per_turn, noise: SteeringNoise::NONE, encoder: 0.0 })
    }

    /// Sets the errors.
    ///
    /// # Errors
    /// Those of [`SteeringNoise::check`].
    pub fn with_noise(mut self, noise: SteeringNoise) -> Result<Self> {
        noise.check()?;
        self.noise = noise;
        Ok(self)
    }

    /// Angle of one count \[rad\]; rounding errs by half of it at most.
    pub fn resolution(&self) -> f64 {
        TAU / f64::from(self.counts_per_turn)
    }

    /// The count while the wheels stand at the true angle `steering`, counter-clockwise, cut to
    /// half a turn either way \[rad\].
    pub fn measure<R: Rng + ?Sized>(&mut self, steering: f64, rng: &mut R) -> SteeringCount {
        let error: f64 = StandardNormal.sample(rng);
        let half_play = 0.5 * self.noise.backlash;
        let wheels = steering.clamp(-PI, PI);
        // The wheels push the encoder along at either end of the play.
        self.encoder = self.encoder.max(wheels - half_play).min(wheels + half_play);
        let angle = self.encoder + self.noise.zero_offset + self.noise.sigma * error;
        SteeringCount((angle / self.resolution()).round() as i32)
    }

    /// The steering angle of a count \[rad\].
    pub fn angle(&self, count: SteeringCount) -> f64 {
        f64::from(count.0) * self.resolution()
    }
}
