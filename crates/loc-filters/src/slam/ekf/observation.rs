//! Observations with their predictions, and the pairs of observations and landmarks for association.

use super::{EkfSlam, Matrix2x5, NUMBERS};
use crate::MeasurementModel;
use crate::association::{PairInnovation, Pairing};
use crate::landmark::RangeBearingModel;
use crate::slam::state::Row;
use loc_core::angle;
use nalgebra::{Matrix2, Matrix2x3, Point2, RowVector2, SVector, Vector2};
use std::f64::consts::TAU;

/// The observation of a landmark as it is predicted: residual, Jacobians and noise of range and bearing.
#[derive(Debug, Clone, Copy)]
pub(super) struct PredictedObservation {
    pub(super) landmark: usize,
    pub(super) residual: Vector2<f64>,
    pub(super) by_robot: Matrix2x5,
    pub(super) by_landmark: Matrix2<f64>,
    pub(super) noise: Matrix2<f64>,
}

impl PredictedObservation {
    pub(super) fn new(
        landmark: usize,
        model: &RangeBearingModel,
        robot: &SVector<f64, NUMBERS>,
        seen: Vector2<f64>,
        common_share: f64,
    ) -> Self {
        let (mut expected, by_pose) = model.linearize(&robot.fixed_rows::<3>(0).into_owned());
        let noise = model.noise(&expected);
        // The common errors are in standard deviations of an observation.
        let sigmas = noise.map(f64::sqrt);
        expected += sigmas * robot.fixed_rows::<2>(3);
        let residual = Vector2::new(seen.x - expected.x, angle::difference(seen.y, expected.y));
        let mut by_robot = Matrix2x5::zeros();
        by_robot.fixed_columns_mut::<2>(3).copy_from(&sigmas);
        let noise = noise * (1.0 - common_share);
        let mut prediction = PredictedObservation {
            landmark,
            residual,
            by_robot,
            by_landmark: Matrix2::zeros(),
            noise,
        };
        prediction.linearize(&by_pose);
        prediction
    }

    /// A shift of landmark and robot together leaves the observation as it is.
    pub(super) fn linearize(&mut self, by_pose: &Matrix2x3<f64>) {
        self.by_robot.fixed_columns_mut::<3>(0).copy_from(by_pose);
        self.by_landmark = -by_pose.fixed_columns::<2>(0);
    }

    pub(super) fn row(&self, k: usize) -> Row<NUMBERS> {
        let by_robot = self.by_robot.row(k).into_owned();
        let by_landmark: RowVector2<f64> = self.by_landmark.row(k).into();
        Row {
            landmark: self.landmark,
            by_robot: by_robot.transpose(),
            by_landmark: [by_landmark.x, by_landmark.y],
            other: None,
            residual: self.residual[k],
            variance: self.noise[(k, k)],
        }
    }
}

/// An observation with range and bearing, and the position that it gives of its landmark.
#[derive(Debug, Clone, Copy)]
pub(super) struct LocatedObservation {
    pub(super) range: f64,
    pub(super) bearing: f64,
    /// Direction from the camera, in the map \[rad\].
    pub(super) direction: f64,
    pub(super) position: Point2<f64>,
}

impl LocatedObservation {
    /// Nearer than this \[m\] a landmark has no direction.
    pub(super) const NEAREST: f64 = 1e-3;

    /// The sensor's part of the position's covariance, 2 x 2.
    pub(super) fn noise(&self, slam: &EkfSlam) -> Matrix2<f64> {
        let axes = self.axes(slam);
        axes * axes.transpose() * (1.0 - slam.settings.common_share)
    }

    /// The shifts by one standard deviation of the range and one of the bearing, as columns \[m\].
    pub(super) fn axes(&self, slam: &EkfSlam) -> Matrix2<f64> {
        let noise = slam.settings.robot.camera;
        let (along, across) = (noise.range_sigma_at(self.range), noise.bearing_sigma * self.range);
        let (sin, cos) = self.direction.sin_cos();
        Matrix2::new(along * cos, -across * sin, along * sin, across * cos)
    }
}

/// Observations with unknown association, paired with the active landmarks near them.
pub(super) struct ObservationPairs<'a> {
    slam: &'a EkfSlam,
    /// Density of new landmarks in distance and direction, where each observation was.
    elsewhere: Vec<f64>,
    /// For each observation its predictions, in order of their landmarks.
    predictions: Vec<Vec<PredictedObservation>>,
}

impl<'a> ObservationPairs<'a> {
    pub(super) fn new(slam: &'a EkfSlam, located: &[LocatedObservation]) -> Self {
        let active = slam.state.active();
        let near = |located: &LocatedObservation| {
            let bound = DistanceBound::new(slam, located);
            let near = active.iter().filter(|&&landmark| bound.allows(slam, located, landmark));
            near.map(|&landmark| slam.prediction(landmark, located.range, located.bearing))
                .collect()
        };
        // The camera sees all of its view evenly; in polar coordinates far ones are denser.
        let elsewhere = |located: &LocatedObservation| located.range / slam.view.area();
        ObservationPairs {
            slam,
            elsewhere: located.iter().map(elsewhere).collect(),
            predictions: located.iter().map(near).collect(),
        }
    }

    /// Whether the observation is near a landmark that a correct observation would be associated with.
    /// With a large pose error an observation is near many landmarks and distinguishes none.
    pub(super) fn is_distinctive(&self, observation: usize) -> bool {
        let lead = self.slam.settings.association.min_ratio.ln();
        self.predictions[observation].iter().any(|prediction| {
            let s = self.slam.innovation_covariance(prediction);
            let Some(inverse) = s.try_inverse() else { return false };
            let nis = prediction.residual.dot(&(inverse * prediction.residual));
            // The expected NIS of a correct observation is 2.
            let usual = -1.0 - 0.5 * s.determinant().ln() - TAU.ln();
            nis <= self.slam.new_landmark_gate && usual - self.elsewhere[observation].ln() >= lead
        })
    }

    /// NIS of an observation with the nearest landmark that is not among those `taken` by others, in
    /// ascending order.
    pub(super) fn nearest_free(&self, observation: usize, taken: &[usize]) -> f64 {
        let predictions = self.predictions[observation].iter();
        let free =
            predictions.filter(|prediction| taken.binary_search(&prediction.landmark).is_err());
        let nis = |prediction: &PredictedObservation| {
            let s = self.slam.innovation_covariance(prediction);
            s.try_inverse()
                .map_or(0.0, |inverse| prediction.residual.dot(&(inverse * prediction.residual)))
        };
        free.map(nis).fold(f64::INFINITY, f64::min)
    }

    fn prediction(&self, (observation, landmark): (usize, usize)) -> Option<&PredictedObservation> {
        let predictions = &self.predictions[observation];
        let index =
            predictions.binary_search_by_key(&landmark, |prediction| prediction.landmark).ok()?;
        predictions.get(index)
    }
}

impl Pairing<2> for ObservationPairs<'_> {
    fn observations(&self) -> usize {
        self.predictions.len()
    }

    fn landmarks(&self) -> usize {
        self.slam.entries.len()
    }

    fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<2>> {
        let prediction = self.prediction((observation, landmark))?;
        let covariance = self.slam.innovation_covariance(prediction);
        Some(PairInnovation { residual: prediction.residual, covariance })
    }

    fn elsewhere(&self, observation: usize) -> f64 {
        self.elsewhere[observation]
    }

    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        match (self.prediction(a), self.prediction(b)) {
            (Some(a), Some(b)) => self.slam.covariance_between(a, b),
            _ => Matrix2::zeros(),
        }
    }
}

/// A cheap bound on how far from a landmark it may be seen, so that most pairs need no more than
/// the distance between two points.
pub(super) struct DistanceBound {
    /// Largest variance that robot and sensor can give the position \[m^2\].
    variance: f64,
    /// The NIS that still matters.
    gate: f64,
}

impl DistanceBound {
    /// Distance and direction are curved coordinates; the bound must hold in them too.
    const SLACK: f64 = 2.0;

    pub(super) fn new(slam: &EkfSlam, located: &LocatedObservation) -> Self {
        let p = slam.state.robot_covariance();
        let robot: Vector2<f64> = slam.state.robot().xy();
        let squared = (located.position.coords - robot).norm_squared();
        let variance = p.m11 + p.m22 + squared * p.m33 + located.noise(slam).trace();
        DistanceBound { variance, gate: slam.new_landmark_gate }
    }

    /// How far off a landmark of some variance \[m^2\] may be \[m\]. The variance of a difference
    /// is at most twice the sum of both.
    pub(super) fn distance(&self, variance: f64) -> f64 {
        (Self::SLACK * self.gate * 2.0 * (self.variance + variance)).sqrt()
    }

    fn allows(&self, slam: &EkfSlam, located: &LocatedObservation, landmark: usize) -> bool {
        let own = slam.state.block(landmark, landmark);
        let squared = (located.position - slam.state.position(landmark)).norm_squared();
        squared <= self.distance(own.trace()).powi(2)
    }
}
