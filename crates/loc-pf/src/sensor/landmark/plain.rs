//! The likelihood of one pose, in double precision and as the formula stands.

use super::{LandmarkLikelihood, ObservationModel, Placed};
use loc_core::{Pose2, angle};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use std::f64::consts::TAU;

/// How far an observation is to be trusted, given a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trust {
    /// The observation.
    pub observation: LandmarkObservation,
    /// Probability that the observation is right; 0 where the map has no such landmark.
    pub probability: f64,
}

/// The parts of one observation's density.
struct Density {
    /// Logarithm of the density of a right observation, times the share of right ones.
    right: f64,
    /// The same of a wrong one.
    wrong: f64,
}

impl Density {
    fn ln(&self) -> f64 {
        let (less, more) = (self.right.min(self.wrong), self.right.max(self.wrong));
        if more > f64::NEG_INFINITY { more + (less - more).exp().ln_1p() } else { more }
    }
}

impl LandmarkLikelihood {
    /// `ln p(observations | pose)`, in double precision. Densities are per metre and radian, so that
    /// the logarithm may be positive.
    pub fn log_likelihood(&self, pose: Pose2) -> f64 {
        self.placed().iter().map(|placed| density(placed, self.model(), pose).ln()).sum()
    }

    /// The largest value that the log-likelihood could have: that of observations without any error.
    pub fn log_peak(&self) -> f64 {
        let without_error = |placed: &Placed| {
            let range = placed.observation.sight.range();
            let right = peak(range, placed, self.model());
            Density { right, wrong: wrong(placed, self.model()) }.ln()
        };
        self.placed().iter().map(without_error).sum()
    }

    /// How far each observation is to be trusted if the robot is at `pose`: the share of the right
    /// ones in the mixture there.
    pub fn trust(&self, pose: Pose2) -> impl Iterator<Item = Trust> + '_ {
        let known = self.placed().iter().map(move |placed| {
            let density = density(placed, self.model(), pose);
            let probability = (density.right - density.ln()).exp().min(1.0);
            Trust { observation: placed.observation, probability }
        });
        let unknown = self.unknown().iter();
        known.chain(unknown.map(|&observation| Trust { observation, probability: 0.0 }))
    }
}

// ANCHOR: density
fn density(placed: &Placed, model: &ObservationModel, pose: Pose2) -> Density {
    let camera = pose * model.mounting;
    let way = placed.landmark - camera.position();
    let (expected, sight) = (way.norm(), placed.observation.sight);
    let mut right = peak(Some(expected), placed, model);
    if let Some(range) = sight.range() {
        right -= 0.5 * ((range - expected) / model.noise.range_sigma_at(expected)).powi(2);
    }
    // At a landmark its direction says nothing.
    if let Some(bearing) = sight.bearing().filter(|_| expected > 0.0) {
        let turn = angle::difference(bearing, way.y.atan2(way.x) - camera.theta);
        right -= 0.5 * (turn / model.noise.bearing_sigma).powi(2);
    }
    Density { right, wrong: wrong(placed, model) }
}
// ANCHOR_END: density

/// Logarithm of the normal densities' product without error, times the share of right observations.
pub(super) fn peak(expected_range: Option<f64>, placed: &Placed, model: &ObservationModel) -> f64 {
    let normal = |sigma: f64| -sigma.ln() - 0.5 * TAU.ln();
    let range = || normal(model.noise.range_sigma_at(expected_range.unwrap_or(0.0)));
    let bearing = || normal(model.noise.bearing_sigma);
    (1.0 - model.outlier_share).ln()
        + match placed.observation.sight {
            Observed::RangeBearing { .. } => range() + bearing(),
            Observed::Range { .. } => range(),
            Observed::Bearing { .. } => bearing(),
        }
}

/// Logarithm of the even density of wrong observations, times their share.
pub(super) fn wrong(placed: &Placed, model: &ObservationModel) -> f64 {
    let reach = match placed.observation.sight {
        Observed::RangeBearing { .. } => model.outlier_range * TAU,
        Observed::Range { .. } => model.outlier_range,
        Observed::Bearing { .. } => TAU,
    };
    (model.outlier_share / reach).ln()
}
