//! The measurement: one heading.

use crate::Result;
use loc_core::error::{finite, non_negative};

/// One heading as the compass reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CompassReading {
    /// Heading in the map, counter-clockwise from its x axis, in (-pi, pi] \[rad\].
    pub heading: f64,
    /// Strength of the horizontal field \[uT\]: far from that of the Earth, the heading is wrong.
    pub strength: f64,
}

impl CompassReading {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for NaN, infinity and a negative strength.
    pub fn check(&self) -> Result<()> {
        finite("heading of a compass [rad]", self.heading)?;
        non_negative("strength of the magnetic field [uT]", self.strength)?;
        Ok(())
    }
}
