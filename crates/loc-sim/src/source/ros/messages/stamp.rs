//! Times and headers.

use crate::Result;
use crate::source::ros::serialization::{Decoder, Dialect, Encoder};

/// Nanoseconds in a second.
const SECOND: i64 = 1_000_000_000;

/// A time of a message, in nanoseconds since 1970 or since the start of a simulated clock.
///
/// Nanoseconds since 1970 do not fit into an `f64`, so that differences are taken before seconds
/// are made of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash)]
pub struct Stamp(pub i64);

impl Stamp {
    /// The nearest stamp to a time \[s\]; 0 for one that is not finite.
    pub fn from_seconds(seconds: f64) -> Self {
        let whole = seconds.floor();
        // A cast saturates, and makes 0 of NaN.
        let nanoseconds = ((seconds - whole) * SECOND as f64).round() as i64;
        Stamp((whole as i64).saturating_mul(SECOND).saturating_add(nanoseconds))
    }

    /// The time \[s\], to some hundred nanoseconds for one of our days.
    pub fn seconds(self) -> f64 {
        self.0.div_euclid(SECOND) as f64 + self.0.rem_euclid(SECOND) as f64 / SECOND as f64
    }

    /// How much later this is than another \[s\]. Times that lie farther apart than 292 years are
    /// taken to be that far.
    pub fn seconds_since(self, earlier: Stamp) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 * 1e-9
    }

    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        let seconds = match decoder.dialect() {
            Dialect::Ros1 => i64::from(decoder.u32("seconds of the stamp")?),
            _ => i64::from(decoder.i32("seconds of the stamp")?),
        };
        let nanoseconds = decoder.u32("nanoseconds of the stamp")?;
        Ok(Stamp(seconds * SECOND + i64::from(nanoseconds)))
    }

    pub(super) fn encode(self, encoder: &mut Encoder) {
        let seconds = self.0.div_euclid(SECOND);
        match encoder.dialect() {
            Dialect::Ros1 => encoder.u32(u32::try_from(seconds.max(0)).unwrap_or(u32::MAX)),
            _ => encoder.i32(seconds.clamp(i32::MIN.into(), i32::MAX.into()) as i32),
        }
        encoder.u32(self.0.rem_euclid(SECOND) as u32);
    }
}

/// When a message was measured, and in which frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Header {
    /// The time.
    pub stamp: Stamp,
    /// The frame.
    pub frame_id: String,
}

impl Header {
    /// A header.
    pub fn new(stamp: Stamp, frame_id: &str) -> Self {
        Header { stamp, frame_id: frame_id.into() }
    }

    pub(super) fn decode(decoder: &mut Decoder<'_>) -> Result<Self> {
        if decoder.dialect() == Dialect::Ros1 {
            decoder.u32("number of the message")?;
        }
        Ok(Header { stamp: Stamp::decode(decoder)?, frame_id: decoder.text("frame_id")? })
    }

    pub(super) fn encode(&self, encoder: &mut Encoder) {
        if encoder.dialect() == Dialect::Ros1 {
            encoder.u32(0);
        }
        self.stamp.encode(encoder);
        encoder.text(&self.frame_id);
    }
}
