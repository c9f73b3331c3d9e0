//! A landmark of one particle: a Kalman filter of two numbers.
//!
//! Whoever knows the robot's way knows that no two landmarks have anything to do with each other:
//! given the way, the errors of all observations are independent. So a particle needs no covariance
//! between landmarks.

use super::look::{Look, Place};
use loc_core::Gaussian;
use loc_filters::slam::MapSettings;
use nalgebra::Matrix2;

/// A score that is not above this is none.
const NO_SCORE: f64 = 1e-9;

/// What a particle believes about a landmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mark {
    pub(super) id: u32,
    pub(super) position: Gaussian<2>,
    pub(super) observations: u32,
    /// How much speaks for it, see [`MapSettings`].
    pub(super) score: f64,
    pub(super) confirmed: bool,
    /// The moment of its last observation, counted by the filter.
    pub(super) seen_at: u64,
}

impl Mark {
    pub(super) fn born(id: u32, place: &Place, moment: u64, map: &MapSettings) -> Self {
        let confirmed = map.confirm_score <= 1.0;
        let position = place.position;
        Mark { id, position, observations: 1, score: 1.0, confirmed, seen_at: moment }
    }

    /// Corrects the position by a look from a pose that is taken for certain; `covariance` is that
    /// of the look's residual. In Joseph's form, which stays symmetric and positive.
    pub(super) fn correct(&mut self, look: &Look, covariance: &Matrix2<f64>) {
        let Some(inverse) = covariance.try_inverse() else { return };
        let p = self.position.covariance;
        let gain = p * look.by_landmark.transpose() * inverse;
        self.position.mean += gain * look.residual;
        let rest = Matrix2::identity() - gain * look.by_landmark;
        let corrected = rest * p * rest.transpose() + gain * look.noise * gain.transpose();
        self.position.covariance = 0.5 * (corrected + corrected.transpose());
    }

    /// An observation has spoken for it.
    pub(super) fn praise(&mut self, moment: u64, map: &MapSettings) {
        self.seen_at = moment;
        self.observations = self.observations.saturating_add(1);
        self.score = (self.score + 1.0).min(map.max_score);
        self.confirmed |= self.score >= map.confirm_score;
    }

    /// Something has spoken against it.
    pub(super) fn blame(&mut self, cost: f64) {
        self.score -= cost;
    }

    pub(super) fn is_false(&self) -> bool {
        self.score <= NO_SCORE
    }
}
