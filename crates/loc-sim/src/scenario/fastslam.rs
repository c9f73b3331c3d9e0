//! Settings of `fastslam`, in the units of configuration files.

use crate::Result;
use loc_filters::association::Rule;
use loc_pf::FastSlamSettings;
use serde::Deserialize;

/// What `fastslam` is told beside the noise of odometry and camera, and beside what `[filter.slam]`
/// says of identities and the size of the map. What is left out has the default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FastSlamConfig {
    /// Number of particles.
    pub particles: Option<usize>,
    /// `nearest-neighbor`, `maximum-likelihood` or `joint-compatibility`.
    pub association: Option<Rule>,
    /// Share of right pairs that the gate of the association lets pass.
    pub association_probability: Option<f64>,
    /// How much likelier than any other explanation a pair must be.
    pub min_ratio: Option<f64>,
    /// Share of observations that are expected to be of something new.
    pub new_share: Option<f64>,
    /// Probability that a landmark in the middle of the view is not seen.
    pub miss_share: Option<f64>,
    /// Share of effective particles below which they are drawn anew.
    pub resample_below: Option<f64>,
    /// Number of threads.
    pub threads: Option<usize>,
}

impl FastSlamConfig {
    /// The library's form; what all methods among landmarks share is put in by the method.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`].
    pub(super) fn settings(&self) -> Result<FastSlamSettings> {
        let mut settings = FastSlamSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.association.gate_probability, self.association_probability);
        put(&mut settings.association.min_ratio, self.min_ratio);
        put(&mut settings.new_share, self.new_share);
        put(&mut settings.miss_share, self.miss_share);
        put(&mut settings.resample_below, self.resample_below);
        settings.association.rule = self.association.unwrap_or(settings.association.rule);
        settings.particles = self.particles.unwrap_or(settings.particles);
        settings.threads = self.threads.unwrap_or(settings.threads);
        settings.validate()?;
        Ok(settings)
    }
}
