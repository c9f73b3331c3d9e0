//! Settings of `mcl` among landmarks, in the units of configuration files.

use crate::Result;
use loc_pf::LandmarkMclSettings;
use serde::Deserialize;

/// What `mcl` is told beside the noise of odometry and camera. What is left out has the default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LandmarkMclConfig {
    /// Number of particles.
    pub particles: Option<usize>,
    /// Share of observations that say nothing, such as misread numbers.
    pub outlier_share: Option<f64>,
    /// Distance within which the wrong ones lie.
    pub outlier_range_m: Option<f64>,
    /// How far the robot may be outside of the box around the landmarks.
    pub margin_m: Option<f64>,
    /// Decay of the slow average of how well observations fit.
    pub alpha_slow: Option<f64>,
    /// Decay of the fast one; 0 for no recovery.
    pub alpha_fast: Option<f64>,
    /// Number of threads.
    pub threads: Option<usize>,
}

impl LandmarkMclConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<LandmarkMclSettings> {
        let mut settings = LandmarkMclSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.sights.outlier_share, self.outlier_share);
        put(&mut settings.sights.outlier_range, self.outlier_range_m);
        put(&mut settings.margin, self.margin_m);
        put(&mut settings.recovery.alpha_slow, self.alpha_slow);
        put(&mut settings.recovery.alpha_fast, self.alpha_fast);
        settings.particles = self.particles.unwrap_or(settings.particles);
        settings.threads = self.threads.unwrap_or(settings.threads);
        settings.validate()?;
        Ok(settings)
    }
}
