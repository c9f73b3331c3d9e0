//! The systematic causes of wrong odometry (E7).

use crate::Result;
use loc_core::error::{non_negative, positive, probability};

/// What stands between the wheels' turns and the way driven. [`WheelFaults::NONE`] is a perfect
/// drive.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct WheelFaults {
    /// True radius of the left wheel, as a share of the nominal one (unequal wheel diameters).
    pub left_radius: f64,
    /// True radius of the right wheel, as a share of the nominal one.
    pub right_radius: f64,
    /// True distance between the contact points, as a share of the nominal track (contact point
    /// not at the middle of the wheel).
    pub track: f64,
    /// Share of both wheels' radii that sinks into soft ground.
    pub sinkage: f64,
    /// Share of a wheel's turning that is lost to slip while it accelerates ahead of the ground:
    /// the wheel reports `1/(1 - slip)` of the way.
    pub slip: f64,
    /// Probability per second that a wheel slips during a step.
    #[cfg_attr(feature = "serde", serde(rename = "slip_rate_per_s"))]
    pub slip_rate: f64,
    /// Extra way that a wheel rolls over a bump \[m\].
    #[cfg_attr(feature = "serde", serde(rename = "bump_m"))]
    pub bump: f64,
    /// Bumps per metre driven and wheel \[1/m\].
    pub bumps_per_m: f64,
}

impl WheelFaults {
    /// No faults.
    pub const NONE: WheelFaults = WheelFaults {
        left_radius: 1.0,
        right_radius: 1.0,
        track: 1.0,
        sinkage: 0.0,
        slip: 0.0,
        slip_rate: 0.0,
        bump: 0.0,
        bumps_per_m: 0.0,
    };

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for radii and tracks that are not positive, shares outside
    /// \[0, 1\], or negative rates.
    pub fn check(&self) -> Result<()> {
        positive("share of the left wheel's radius", self.left_radius)?;
        positive("share of the right wheel's radius", self.right_radius)?;
        positive("share of the wheel track", self.track)?;
        probability("sinkage", self.sinkage)?;
        positive("1 - sinkage", 1.0 - self.sinkage)?;
        probability("slip", self.slip)?;
        positive("1 - slip", 1.0 - self.slip)?;
        non_negative("slip rate [1/s]", self.slip_rate)?;
        non_negative("height of bumps [m]", self.bump)?;
        non_negative("bumps per metre", self.bumps_per_m)?;
        Ok(())
    }
}

impl Default for WheelFaults {
    fn default() -> Self {
        WheelFaults::NONE
    }
}
