//! One observation held against one landmark of the state.

use super::common::{Matrix2x5, NUMBERS};
use super::{EkfSlam, Jacobians};
use crate::landmark::RangeBearingModel;
use crate::slam::state::Row;
use crate::{Gate, MeasurementModel, Result};
use loc_core::angle;
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix1, Matrix2, Matrix2x3, Point2, RowVector2, SVector, Vector1, Vector2};

use super::{SlamOutcome, SlamVerdict};

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
