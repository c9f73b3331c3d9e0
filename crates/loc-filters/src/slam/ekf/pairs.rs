//! LandmarkObservations without numbers, held against the landmarks of the state.

use super::EkfSlam;
use super::look::{Look, Place};
use crate::association::{PairInnovation, Pairing};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::TAU;

/// The looks of all pairs that are not out of the question.
pub(super) struct Pairs<'a> {
    slam: &'a EkfSlam,
    /// Density of new landmarks in distance and direction, where each observation was.
    elsewhere: Vec<f64>,
    /// For each observation its looks, in order of their landmarks.
    looks: Vec<Vec<Look>>,
}

impl<'a> Pairs<'a> {
    pub(super) fn new(slam: &'a EkfSlam, places: &[Place]) -> Self {
        let in_hand = slam.state.in_hand();
        let near = |place: &Place| {
            let bound = Bound::new(slam, place);
            let near = in_hand.iter().filter(|&&landmark| bound.allows(slam, place, landmark));
            near.map(|&landmark| slam.look(landmark, place.range, place.bearing)).collect()
        };
        // The camera sees all places of its view alike; in polar coordinates far ones are denser.
        let elsewhere = |place: &Place| place.range / slam.reach.area();
        Pairs {
            slam,
            elsewhere: places.iter().map(elsewhere).collect(),
            looks: places.iter().map(near).collect(),
        }
    }

    /// Whether the observation is near a landmark that it would be recognised by, were it of that.
    /// Where the robot is far off, an observation can be near many, and tell nothing of any.
    pub(super) fn is_telling(&self, observation: usize) -> bool {
        let lead = self.slam.settings.association.min_ratio.ln();
        self.looks[observation].iter().any(|look| {
            let s = self.slam.innovation_covariance(look);
            let Some(inverse) = s.try_inverse() else { return false };
            let nis = look.residual.dot(&(inverse * look.residual));
            // A right observation has an NIS of 2.
            let usual = -1.0 - 0.5 * s.determinant().ln() - TAU.ln();
            nis <= self.slam.new_landmark_gate && usual - self.elsewhere[observation].ln() >= lead
        })
    }

    /// NIS of an observation with the nearest landmark that is not among those `taken` by others, in
    /// ascending order.
    pub(super) fn nearest_free(&self, observation: usize, taken: &[usize]) -> f64 {
        let looks = self.looks[observation].iter();
        let free = looks.filter(|look| taken.binary_search(&look.landmark).is_err());
        let nis = |look: &Look| {
            let s = self.slam.innovation_covariance(look);
            s.try_inverse().map_or(0.0, |inverse| look.residual.dot(&(inverse * look.residual)))
        };
        free.map(nis).fold(f64::INFINITY, f64::min)
    }

    fn look(&self, (observation, landmark): (usize, usize)) -> Option<&Look> {
        let looks = &self.looks[observation];
        let index = looks.binary_search_by_key(&landmark, |look| look.landmark).ok()?;
        looks.get(index)
    }
}

impl Pairing<2> for Pairs<'_> {
    fn observations(&self) -> usize {
        self.looks.len()
    }

    fn landmarks(&self) -> usize {
        self.slam.entries.len()
    }

    fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<2>> {
        let look = self.look((observation, landmark))?;
        let covariance = self.slam.innovation_covariance(look);
        Some(PairInnovation { residual: look.residual, covariance })
    }

    fn elsewhere(&self, observation: usize) -> f64 {
        self.elsewhere[observation]
    }

    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        match (self.look(a), self.look(b)) {
            (Some(a), Some(b)) => self.slam.covariance_between(a, b),
            _ => Matrix2::zeros(),
        }
    }
}

/// A cheap bound on how far from a landmark it may be seen, so that most pairs need no more than
/// the distance between two points.
pub(super) struct Bound {
    /// Largest variance that robot and sensor can give the place \[m^2\].
    variance: f64,
    /// The NIS that still matters.
    gate: f64,
}

impl Bound {
    /// Distance and direction are curved coordinates; the bound must hold in them too.
    const SLACK: f64 = 2.0;

    pub(super) fn new(slam: &EkfSlam, place: &Place) -> Self {
        let p = slam.state.robot_covariance();
        let robot: Vector2<f64> = slam.state.robot().xy();
        let squared = (place.position.coords - robot).norm_squared();
        let variance = p.m11 + p.m22 + squared * p.m33 + place.noise(slam).trace();
        Bound { variance, gate: slam.new_landmark_gate }
    }

    /// How far off a landmark of some variance \[m^2\] may be \[m\]. The variance of a difference
    /// is at most twice the sum of both.
    pub(super) fn distance(&self, variance: f64) -> f64 {
        (Self::SLACK * self.gate * 2.0 * (self.variance + variance)).sqrt()
    }

    fn allows(&self, slam: &EkfSlam, place: &Place, landmark: usize) -> bool {
        let own = slam.state.block(landmark, landmark);
        let squared = (place.position - slam.state.position(landmark)).norm_squared();
        squared <= self.distance(own.trace()).powi(2)
    }
}
