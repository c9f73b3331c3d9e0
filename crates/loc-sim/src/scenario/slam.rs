//! Settings of `ekf-slam`, in the units of configuration files.

use crate::Result;
use crate::source::ObservationNoiseConfig;
use loc_filters::association::Rule;
use loc_filters::slam::{Identities, Jacobians, SlamSettings};
use serde::Deserialize;

/// What `ekf-slam` is told beside the noise of odometry and camera. What is left out has the
/// default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlamConfig {
    /// `known` where numbers are read off the landmarks, `unknown` where the method must find out.
    pub identities: Identities,
    /// `invariant`, `current`, or `first` for first estimates.
    pub jacobians: Jacobians,
    /// How far observations are believed to be off, where that is not as for the other methods.
    pub camera: Option<ObservationNoiseConfig>,
    /// Share of the variance of observations that those of one moment have in common.
    pub common_share: Option<f64>,
    /// How long that lasts.
    pub common_time_s: Option<f64>,
    /// `nearest-neighbor`, `maximum-likelihood` or `joint-compatibility`.
    pub association: Rule,
    /// Share of right pairs that the gate of the association lets pass.
    pub association_probability: Option<f64>,
    /// How much likelier than any other explanation a pair must be.
    pub min_ratio: Option<f64>,
    /// The same for two landmarks that become one.
    pub merge_ratio: Option<f64>,
    /// The most landmarks in the map.
    pub max_landmarks: Option<usize>,
    /// The score from which on a landmark is no longer provisional: 1 for one observation.
    pub confirm_score: Option<f64>,
    /// What an observation that contradicts a landmark takes from its score.
    pub contradiction_cost: Option<f64>,
    /// Works on the landmarks within this radius at a time.
    pub submap_radius_m: Option<f64>,
}

impl SlamConfig {
    /// The library's form; noise, mounting and gate are put in by the method.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<SlamSettings> {
        let mut settings = SlamSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        settings.identities = self.identities;
        settings.jacobians = self.jacobians;
        if let Some(noise) = &self.camera {
            settings.observation_noise = noise.noise()?;
        }
        put(&mut settings.common_share, self.common_share);
        put(&mut settings.common_time, self.common_time_s);
        settings.association.rule = self.association;
        put(&mut settings.association.gate_probability, self.association_probability);
        put(&mut settings.association.min_ratio, self.min_ratio);
        put(&mut settings.map.merge_ratio, self.merge_ratio);
        put(&mut settings.map.confirm_score, self.confirm_score);
        put(&mut settings.map.contradiction_cost, self.contradiction_cost);
        settings.map.max_landmarks = self.max_landmarks.unwrap_or(settings.map.max_landmarks);
        settings.submap_radius = self.submap_radius_m;
        settings.check()?;
        Ok(settings)
    }
}
