//! Settings of `lateration`, in the units of configuration files.

use crate::Result;
use loc_filters::lateration::{Loss, SlidingSettings};
use serde::Deserialize;

/// What `lateration` is told beside the noise of odometry and ranges. What is left out has the
/// default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LaterationConfig {
    /// How many of the last ranges count.
    pub window: Option<usize>,
    /// Whether odometry carries older ranges to now.
    pub odometry: Option<bool>,
    /// Without odometry, how fast the robot may be.
    pub walk_m_s: Option<f64>,
    /// How much outliers cost: `quadratic`, `{ huber = 1.345 }` or `{ cauchy = 2.385 }`.
    pub loss: Option<Loss>,
    /// Standard deviation of the range scale; 0 for ranges that are right.
    pub scale_sigma: Option<f64>,
    /// Standard deviation of the range offset.
    pub offset_sigma_m: Option<f64>,
}

impl LaterationConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<SlidingSettings> {
        let mut settings = SlidingSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.walk, self.walk_m_s);
        put(&mut settings.bias.scale_sigma, self.scale_sigma);
        put(&mut settings.bias.offset_sigma, self.offset_sigma_m);
        settings.window = self.window.unwrap_or(settings.window);
        settings.odometry = self.odometry.unwrap_or(settings.odometry);
        settings.loss = self.loss.unwrap_or(settings.loss);
        settings.check()?;
        Ok(settings)
    }
}
