//! What each sensor measures of the states.

use super::state::{
    DRIFT_X, DRIFT_Y, GYRO_BIAS, LEFT_BIAS, RANGE_OFFSET, RANGE_SCALE, SPEED, STATES, State, THETA,
    TURN, X, Y,
};
use crate::extended::MeasurementModel;
use crate::landmark::RangeBearingModel;
use loc_core::angle;
use nalgebra::{Matrix1, Matrix2, Matrix2x3, Point2, SMatrix, Vector1, Vector2, Vector3};

/// Gradients of one number.
type Row = SMatrix<f64, 1, STATES>;
/// Gradients of two.
type Rows = SMatrix<f64, 2, STATES>;

fn pose(state: &State) -> Vector3<f64> {
    state.fixed_rows::<3>(0).into()
}

/// The wheels: speed and turn rate, `(v, omega)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelModel {
    /// Variances of speed \[m^2/s^2\] and turn rate \[rad^2/s^2\].
    pub variances: Vector2<f64>,
}

impl MeasurementModel<STATES, 2> for WheelModel {
    fn predict(&self, state: &State) -> Vector2<f64> {
        Vector2::new(state[SPEED], state[TURN])
    }

    fn jacobian(&self, _state: &State) -> Rows {
        let mut h = Rows::zeros();
        h[(0, SPEED)] = 1.0;
        h[(1, TURN)] = 1.0;
        h
    }

    fn noise(&self, _expected: &Vector2<f64>) -> Matrix2<f64> {
        Matrix2::from_diagonal(&self.variances)
    }
}

/// The gyroscope: `omega + b_g`; and the accelerometer that points left, which in a curve feels
/// `v omega + b_l`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialModel {
    /// Variances of turn rate \[rad^2/s^2\] and acceleration \[m^2/s^4\].
    pub variances: Vector2<f64>,
}

impl MeasurementModel<STATES, 2> for InertialModel {
    fn predict(&self, state: &State) -> Vector2<f64> {
        Vector2::new(state[TURN] + state[GYRO_BIAS], state[SPEED] * state[TURN] + state[LEFT_BIAS])
    }

    fn jacobian(&self, state: &State) -> Rows {
        let mut h = Rows::zeros();
        h[(0, TURN)] = 1.0;
        h[(0, GYRO_BIAS)] = 1.0;
        h[(1, SPEED)] = state[TURN];
        h[(1, TURN)] = state[SPEED];
        h[(1, LEFT_BIAS)] = 1.0;
        h
    }

    fn noise(&self, _expected: &Vector2<f64>) -> Matrix2<f64> {
        Matrix2::from_diagonal(&self.variances)
    }
}

/// The compass: the heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompassModel {
    /// Its variance \[rad^2\].
    pub variance: f64,
}

impl MeasurementModel<STATES, 1> for CompassModel {
    fn predict(&self, state: &State) -> Vector1<f64> {
        Vector1::new(state[THETA])
    }

    fn jacobian(&self, _state: &State) -> Row {
        let mut h = Row::zeros();
        h[THETA] = 1.0;
        h
    }

    fn noise(&self, _expected: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(self.variance)
    }

    fn residual(&self, z: &Vector1<f64>, expected: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(angle::difference(z.x, expected.x))
    }
}

/// The satellite receiver: the place of its antenna, off by the drift.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PositionModel {
    /// Place of the antenna on the robot \[m\].
    pub antenna: Point2<f64>,
    /// Covariance beside the drift \[m^2\].
    pub noise: Matrix2<f64>,
}

impl PositionModel {
    /// From the robot to its antenna, in the map.
    fn lever(&self, state: &State) -> Vector2<f64> {
        let (sin, cos) = state[THETA].sin_cos();
        let Point2 { coords } = self.antenna;
        Vector2::new(cos * coords.x - sin * coords.y, sin * coords.x + cos * coords.y)
    }
}

impl MeasurementModel<STATES, 2> for PositionModel {
    fn predict(&self, state: &State) -> Vector2<f64> {
        Vector2::new(state[X] + state[DRIFT_X], state[Y] + state[DRIFT_Y]) + self.lever(state)
    }

    fn jacobian(&self, state: &State) -> Rows {
        let lever = self.lever(state);
        let mut h = Rows::zeros();
        (h[(0, X)], h[(0, DRIFT_X)], h[(0, THETA)]) = (1.0, 1.0, -lever.y);
        (h[(1, Y)], h[(1, DRIFT_Y)], h[(1, THETA)]) = (1.0, 1.0, lever.x);
        h
    }

    fn noise(&self, _expected: &Vector2<f64>) -> Matrix2<f64> {
        self.noise
    }
}

/// Distance and direction of a landmark, the distance with the bias of its sensor:
/// `(s r + o, phi)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightModel(pub RangeBearingModel);

impl SightModel {
    fn whole(&self, state: &State) -> (Vector2<f64>, Rows) {
        let (true_sight, by_pose): (_, Matrix2x3<f64>) = self.0.linearize(&pose(state));
        let mut h = Rows::zeros();
        h.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_pose);
        for column in 0..3 {
            h[(0, column)] *= state[RANGE_SCALE];
        }
        h[(0, RANGE_SCALE)] = true_sight.x;
        h[(0, RANGE_OFFSET)] = 1.0;
        let range = state[RANGE_SCALE] * true_sight.x + state[RANGE_OFFSET];
        (Vector2::new(range, true_sight.y), h)
    }
}

impl MeasurementModel<STATES, 2> for SightModel {
    fn predict(&self, state: &State) -> Vector2<f64> {
        self.whole(state).0
    }

    fn jacobian(&self, state: &State) -> Rows {
        self.whole(state).1
    }

    fn linearize(&self, state: &State) -> (Vector2<f64>, Rows) {
        self.whole(state)
    }

    fn noise(&self, expected: &Vector2<f64>) -> Matrix2<f64> {
        self.0.noise(expected)
    }

    fn residual(&self, z: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        self.0.residual(z, expected)
    }
}

/// The distance alone, `s r + o`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistanceModel(pub SightModel);

impl MeasurementModel<STATES, 1> for DistanceModel {
    fn predict(&self, state: &State) -> Vector1<f64> {
        Vector1::new(self.0.whole(state).0.x)
    }

    fn jacobian(&self, state: &State) -> Row {
        self.0.whole(state).1.row(0).into()
    }

    fn noise(&self, expected: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(self.0.0.noise.range_sigma_at(expected.x).powi(2))
    }
}

/// The direction alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionModel(pub SightModel);

impl MeasurementModel<STATES, 1> for DirectionModel {
    fn predict(&self, state: &State) -> Vector1<f64> {
        Vector1::new(self.0.whole(state).0.y)
    }

    fn jacobian(&self, state: &State) -> Row {
        self.0.whole(state).1.row(1).into()
    }

    fn noise(&self, _expected: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(self.0.0.noise.bearing_sigma.powi(2))
    }

    fn residual(&self, z: &Vector1<f64>, expected: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(angle::difference(z.x, expected.x))
    }
}
