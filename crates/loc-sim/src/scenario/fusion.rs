//! Settings of `fusion`, in the units of configuration files.

use crate::Result;
use loc_filters::fusion::FusionSettings;
use serde::Deserialize;

/// What `fusion` is told beside the noise of odometry, ranges and simulated sensors. What is left
/// out has the default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FusionConfig {
    /// Standard deviation of the range scale; 0 for ranges that are right.
    pub scale_sigma: Option<f64>,
    /// Standard deviation of the range offset.
    pub offset_sigma_m: Option<f64>,
    /// How fast the speed changes while no accelerometer measures it, per root of a second.
    pub speed_walk_m_s: Option<f64>,
    /// How fast the turn rate changes, per root of a second.
    pub turn_walk_deg_s: Option<f64>,
}

impl FusionConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<FusionSettings> {
        let mut settings = FusionSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.range_bias.scale_sigma, self.scale_sigma);
        put(&mut settings.range_bias.offset_sigma, self.offset_sigma_m);
        put(&mut settings.speed_walk, self.speed_walk_m_s);
        put(&mut settings.turn_walk, self.turn_walk_deg_s.map(f64::to_radians));
        settings.check()?;
        Ok(settings)
    }
}
