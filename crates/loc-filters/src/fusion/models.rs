//! The models of the fused filter: what each sensor measures of the states, and how the states move.

use super::FusionSettings;
use super::state::{
    DRIFT_X, DRIFT_Y, FORWARD_BIAS, GYRO_BIAS, LEFT_BIAS, RANGE_OFFSET, RANGE_SCALE, SPEED, STATES,
    Square, State, THETA, TURN, X, Y,
};
use crate::extended::{LinearizedMotion, MeasurementModel, MotionModel};
use crate::landmark::RangeBearingModel;
use loc_core::motion::{Integration, StepJacobians, VelocityNoise};
use loc_core::{Gaussian, Pose2, Twist2, angle};
use nalgebra::{Matrix1, Matrix2, Matrix2x3, Point2, SMatrix, Vector1, Vector2, Vector3};

/// Gradients of one number.
type Row = SMatrix<f64, 1, STATES>;
/// Gradients of two.
type Rows = SMatrix<f64, 2, STATES>;

/// Nearer than this \[m\] nothing is.
const NEAREST: f64 = 1e-3;

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

/// The gyroscope: `omega + b_g`; and the accelerometer that points left, which in a curve measures
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
///
/// A circle is no straight line: of a robot that is off by `d` across the line of sight, the
/// distance is longer by `d^2 / 2 r`. With the variance `w` across, distances are expected to be
/// longer by `w / 2 r` and to scatter by `(w / r)^2 / 2` more (the second-order filter of Bar-Shalom
/// et al. 2001, 10.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservationModel {
    /// The landmark as it would be seen without a bias.
    pub model: RangeBearingModel,
    /// Variance of the position across the line of sight, by the distance, `w / r` \[m\].
    pub bend: f64,
}

impl ObservationModel {
    /// The model for a belief.
    pub fn new(model: RangeBearingModel, belief: &Gaussian<STATES>) -> Self {
        let view = model.predict(&pose(&belief.mean));
        let direction = view.y + model.mounting.theta + belief.mean[THETA];
        let across = Vector2::new(-direction.sin(), direction.cos());
        let position = belief.covariance.fixed_view::<2, 2>(0, 0);
        let variance = across.dot(&(position * across));
        ObservationModel { model, bend: variance / view.x.max(variance.sqrt()).max(NEAREST) }
    }

    /// The model for a filter that sees the bend of a circle itself.
    pub fn straight(model: RangeBearingModel) -> Self {
        ObservationModel { model, bend: 0.0 }
    }

    /// Variance of the distance that the bend adds \[m^2\].
    fn scatter(&self) -> f64 {
        0.5 * self.bend * self.bend
    }

    fn whole(&self, state: &State) -> (Vector2<f64>, Rows) {
        let (true_observation, by_pose): (_, Matrix2x3<f64>) = self.model.linearize(&pose(state));
        let mut h = Rows::zeros();
        h.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_pose);
        for column in 0..3 {
            h[(0, column)] *= state[RANGE_SCALE];
        }
        h[(0, RANGE_SCALE)] = true_observation.x + 0.5 * self.bend;
        h[(0, RANGE_OFFSET)] = 1.0;
        let range =
            state[RANGE_SCALE] * (true_observation.x + 0.5 * self.bend) + state[RANGE_OFFSET];
        (Vector2::new(range, true_observation.y), h)
    }
}

impl MeasurementModel<STATES, 2> for ObservationModel {
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
        let mut noise = self.model.noise(expected);
        noise[(0, 0)] += self.scatter();
        noise
    }

    fn residual(&self, z: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        self.model.residual(z, expected)
    }
}

/// The distance alone, `s r + o`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DistanceModel(pub ObservationModel);

impl MeasurementModel<STATES, 1> for DistanceModel {
    fn predict(&self, state: &State) -> Vector1<f64> {
        Vector1::new(self.0.whole(state).0.x)
    }

    fn jacobian(&self, state: &State) -> Row {
        self.0.whole(state).1.row(0).into()
    }

    fn noise(&self, expected: &Vector1<f64>) -> Matrix1<f64> {
        let sigma = self.0.model.noise.range_sigma_at(expected.x);
        Matrix1::new(sigma * sigma + self.0.scatter())
    }
}

/// The direction alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DirectionModel(pub ObservationModel);

impl MeasurementModel<STATES, 1> for DirectionModel {
    fn predict(&self, state: &State) -> Vector1<f64> {
        Vector1::new(self.0.whole(state).0.y)
    }

    fn jacobian(&self, state: &State) -> Row {
        self.0.whole(state).1.row(1).into()
    }

    fn noise(&self, _expected: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(self.0.model.noise.bearing_sigma.powi(2))
    }

    fn residual(&self, z: &Vector1<f64>, expected: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(angle::difference(z.x, expected.x))
    }
}

/// A drive of some time on an arc (E2), at the speed that accelerometer and state give.
///
/// `v' = v + (a - b_a) T`, the pose moves at the mean of v and v', biases stay, the satellite
/// receiver's drift decays. The random walk of speed and turn rate is added by `RandomWalk`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FusedMotion {
    /// How long it lasts \[s\].
    pub dt: f64,
    /// Speed to the left, of a robot that can go sideways \[m/s\].
    pub sideways: f64,
    /// What the accelerometer measures forward \[m/s^2\]; `None` while it is silent.
    pub acceleration: Option<f64>,
    /// The rule that makes a pose of it.
    integration: Integration,
    noise: VelocityNoise,
    /// Variances that the three biases and the drift gain in this time.
    gained: [(usize, f64); 5],
    /// What is left of the drift after it.
    decay: f64,
}

impl FusedMotion {
    /// The motion over `dt` \[s\] with the settings' noise.
    pub fn new(
        settings: &FusionSettings,
        dt: f64,
        sideways: f64,
        acceleration: Option<f64>,
    ) -> Self {
        let accelerometer = settings.imu.accelerometer.bias_step_sigma(dt).powi(2);
        let gyroscope = settings.imu.gyroscope.bias_step_sigma(dt).powi(2);
        let decay = (-dt / settings.gnss.drift_time).exp();
        let drift = settings.gnss.drift_sigma.powi(2) * (1.0 - decay * decay);
        let gained = [
            (GYRO_BIAS, gyroscope),
            (FORWARD_BIAS, accelerometer),
            (LEFT_BIAS, accelerometer),
            (DRIFT_X, drift),
            (DRIFT_Y, drift),
        ];
        let (integration, noise) = (settings.robot.integration, settings.robot.odometry);
        FusedMotion { dt, sideways, acceleration, integration, noise, gained, decay }
    }

    /// Acceleration without its bias \[m/s^2\]; 0 while the accelerometer is silent.
    fn true_acceleration(&self, state: &State) -> f64 {
        self.acceleration.map_or(0.0, |measured| measured - state[FORWARD_BIAS])
    }

    fn step(&self, state: &State) -> (Twist2, Pose2, StepJacobians) {
        let speed = state[SPEED] + 0.5 * self.dt * self.true_acceleration(state);
        let twist = Twist2::new(speed, self.sideways, state[TURN]);
        let pose = Pose2::from_vector(&state.fixed_rows::<3>(0).into());
        let (moved, jacobians) = self.integration.step_with_jacobians(pose, twist, self.dt);
        (twist, moved, jacobians)
    }

    fn moved(&self, state: &State, pose: Pose2) -> State {
        let mut next = *state;
        next.fixed_rows_mut::<3>(0).copy_from(&pose.to_vector());
        next[SPEED] += self.dt * self.true_acceleration(state);
        next[DRIFT_X] *= self.decay;
        next[DRIFT_Y] *= self.decay;
        next
    }
}

impl MotionModel<STATES> for FusedMotion {
    fn predict(&self, state: &State) -> State {
        let (_, pose, _) = self.step(state);
        self.moved(state, pose)
    }

    fn linearize(&self, state: &State) -> LinearizedMotion<STATES> {
        let (twist, pose, by) = self.step(state);
        let mut jacobian = Square::identity();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&by.by_pose);
        jacobian.fixed_view_mut::<3, 1>(0, SPEED).copy_from(&by.by_twist.column(0));
        jacobian.fixed_view_mut::<3, 1>(0, TURN).copy_from(&by.by_twist.column(2));
        if self.acceleration.is_some() {
            let by_bias = by.by_twist.column(0) * (-0.5 * self.dt);
            jacobian.fixed_view_mut::<3, 1>(0, FORWARD_BIAS).copy_from(&by_bias);
            jacobian[(SPEED, FORWARD_BIAS)] = -self.dt;
        }
        jacobian[(DRIFT_X, DRIFT_X)] = self.decay;
        jacobian[(DRIFT_Y, DRIFT_Y)] = self.decay;
        let mut noise = Square::zeros();
        let slid = by.by_twist.column(1);
        let slip = slid * slid.transpose() * self.noise.variances(twist, self.dt).y;
        noise.fixed_view_mut::<3, 3>(0, 0).copy_from(&slip);
        for (index, variance) in self.gained {
            noise[(index, index)] += variance;
        }
        LinearizedMotion { state: self.moved(state, pose), jacobian, noise }
    }
}

/// What speed and turn rate have done on their own since they were measured last: variances
/// \[m^2/s^2, rad^2/s^2\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RandomWalk {
    pub(super) speed: f64,
    pub(super) turn: f64,
}

impl MotionModel<STATES> for RandomWalk {
    fn predict(&self, state: &State) -> State {
        *state
    }

    fn linearize(&self, state: &State) -> LinearizedMotion<STATES> {
        let mut noise = Square::zeros();
        noise[(SPEED, SPEED)] = self.speed;
        noise[(TURN, TURN)] = self.turn;
        LinearizedMotion { state: *state, jacobian: Square::identity(), noise }
    }
}
