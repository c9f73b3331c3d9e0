//! One observation held against one landmark of the state.

use super::{EkfSlam, Jacobians, Matrix2x5, NUMBERS, SlamOutcome, SlamVerdict};
use crate::association::{PairInnovation, Pairing};
use crate::landmark::RangeBearingModel;
use crate::slam::state::Row;
use crate::{Gate, MeasurementModel, Result};
use loc_core::angle;
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix1, Matrix2, Matrix2x3, Point2, RowVector2, SVector, Vector1, Vector2};
use std::f64::consts::TAU;

/// Residual, derivatives and noise of distance and direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    pub(super) landmark: usize,
    pub(super) residual: Vector2<f64>,
    pub(super) by_robot: Matrix2x5,
    pub(super) by_landmark: Matrix2<f64>,
    pub(super) noise: Matrix2<f64>,
}

impl EkfSlam {
    fn model(&self, landmark: Point2<f64>) -> RangeBearingModel {
        let (mounting, noise) = (self.settings.mounting, self.settings.observation_noise);
        RangeBearingModel { landmark, mounting, noise }
    }

    /// Holds a distance and a direction against a landmark. What is not measured may be any number.
    pub(super) fn look(&self, landmark: usize, range: f64, bearing: f64) -> Look {
        let seen = Vector2::new(range, bearing);
        let share = self.settings.common_share;
        let model = self.model(self.state.position(landmark));
        let robot = self.state.robot();
        match self.settings.jacobians {
            Jacobians::Current | Jacobians::Invariant => {
                Look::new(landmark, &model, robot, seen, share)
            }
            Jacobians::First => {
                let mut look = Look::new(landmark, &model, robot, seen, share);
                let first = self.model(self.entries[landmark].first);
                look.linearize(&first.jacobian(&self.anchor.to_vector()));
                look
            }
        }
    }

    /// `H_a P H_b^T` of two looks.
    // ANCHOR: covariance-between
    pub(super) fn covariance_between(&self, a: &Look, b: &Look) -> Matrix2<f64> {
        let robot = self.state.robot_covariance();
        let (with_a, with_b) = (self.state.cross(a.landmark), self.state.cross(b.landmark));
        let map = self.state.block(a.landmark, b.landmark);
        a.by_robot * (robot * b.by_robot.transpose() + with_b * b.by_landmark.transpose())
            + a.by_landmark
                * (with_a.transpose() * b.by_robot.transpose() + map * b.by_landmark.transpose())
    }
    // ANCHOR_END: covariance-between

    /// The covariance of a look's innovation.
    pub(super) fn innovation_covariance(&self, look: &Look) -> Matrix2<f64> {
        self.covariance_between(look, look) + look.noise
    }

    /// Judges an observation of a landmark; the rows of the correction are appended to `rows` where it
    /// is believed.
    pub(super) fn judge(
        &self,
        landmark: usize,
        sight: Observed,
        gate: &Gate,
        rows: &mut Vec<Row<NUMBERS>>,
    ) -> Result<SlamOutcome> {
        let (range, bearing) = (sight.range().unwrap_or(0.0), sight.bearing().unwrap_or(0.0));
        let look = self.look(landmark, range, bearing);
        let covariance = self.innovation_covariance(&look);
        let one = |k: usize| {
            let residual = Vector1::new(look.residual[k]);
            self.state.robot_state().innovation(residual, Matrix1::new(covariance[(k, k)]), gate)
        };
        let verdict = match sight {
            Observed::RangeBearing { .. } => SlamVerdict::RangeBearing(
                self.state.robot_state().innovation(look.residual, covariance, gate)?,
            ),
            Observed::Range { .. } => SlamVerdict::Range(one(0)?),
            Observed::Bearing { .. } => SlamVerdict::Bearing(one(1)?),
        };
        let outcome = SlamOutcome { landmark: Some(self.entries[landmark].id), verdict };
        if outcome.accepted() {
            let measured = [sight.range().is_some(), sight.bearing().is_some()];
            rows.extend([0, 1].into_iter().filter(|&k| measured[k]).map(|k| look.row(k)));
        }
        Ok(outcome)
    }

    /// Where an observation puts its landmark, from a robot that is right about itself \[m\]; `None`
    /// where it has no place.
    pub(super) fn place(&self, observation: &LandmarkObservation) -> Option<Place> {
        let Observed::RangeBearing { range, bearing } = observation.sight else { return None };
        if range < Place::NEAREST {
            return None;
        }
        let camera = self.robot_pose() * self.settings.mounting;
        let (true_range, true_bearing) = self.without_common_errors(range, bearing);
        let (sin, cos) = true_bearing.sin_cos();
        let position = camera.transform(&Point2::new(true_range * cos, true_range * sin));
        Some(Place { range, bearing, direction: camera.theta + true_bearing, position })
    }
}

/// An observation with distance and direction, and where it puts its landmark.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) range: f64,
    pub(super) bearing: f64,
    /// Direction from the camera, in the map \[rad\].
    direction: f64,
    pub(super) position: Point2<f64>,
}

impl Place {
    /// Nearer than this \[m\] a landmark has no direction.
    const NEAREST: f64 = 1e-3;

    /// The sensor's part of the position's covariance, 2 x 2.
    pub(super) fn noise(&self, slam: &EkfSlam) -> Matrix2<f64> {
        let axes = self.axes(slam);
        axes * axes.transpose() * (1.0 - slam.settings.common_share)
    }

    /// How far one standard deviation of the distance, and one of the direction, carry it \[m\].
    pub(super) fn axes(&self, slam: &EkfSlam) -> Matrix2<f64> {
        let noise = slam.settings.observation_noise;
        let (along, across) = (noise.range_sigma_at(self.range), noise.bearing_sigma * self.range);
        let (sin, cos) = self.direction.sin_cos();
        Matrix2::new(along * cos, -across * sin, along * sin, across * cos)
    }
}

impl Look {
    fn new(
        landmark: usize,
        model: &RangeBearingModel,
        robot: &SVector<f64, NUMBERS>,
        seen: Vector2<f64>,
        common_share: f64,
    ) -> Self {
        let (mut expected, by_pose) = model.linearize(&robot.fixed_rows::<3>(0).into_owned());
        let noise = model.noise(&expected);
        // In standard deviations, as the common errors are counted.
        let sigmas = noise.map(f64::sqrt);
        expected += sigmas * robot.fixed_rows::<2>(3);
        let residual = Vector2::new(seen.x - expected.x, angle::difference(seen.y, expected.y));
        let mut by_robot = Matrix2x5::zeros();
        by_robot.fixed_columns_mut::<2>(3).copy_from(&sigmas);
        let noise = noise * (1.0 - common_share);
        let mut look = Look { landmark, residual, by_robot, by_landmark: Matrix2::zeros(), noise };
        look.linearize(&by_pose);
        look
    }

    /// Landmark and robot shifted alike look the same.
    fn linearize(&mut self, by_pose: &Matrix2x3<f64>) {
        self.by_robot.fixed_columns_mut::<3>(0).copy_from(by_pose);
        self.by_landmark = -by_pose.fixed_columns::<2>(0);
    }

    fn row(&self, k: usize) -> Row<NUMBERS> {
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

// LandmarkObservations without numbers, held against the landmarks of the state.

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
