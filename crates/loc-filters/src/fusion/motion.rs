//! How the states move between two measurements.

use super::FusionSettings;
use super::state::{
    DRIFT_X, DRIFT_Y, FORWARD_BIAS, GYRO_BIAS, LEFT_BIAS, SPEED, STATES, Square, State, TURN,
};
use crate::extended::{LinearizedMotion, MotionModel};
use loc_core::motion::{Integration, StepJacobians, VelocityNoise};
use loc_core::{Pose2, Twist2};

/// A drive of some time on an arc (E2), at the speed that accelerometer and state give.
///
/// `v' = v + (a - b_a) T`, the pose moves at the mean of v and v', biases stay, the satellite
/// receiver's drift forgets itself. What the speed and the turn rate do beside, `Walked` adds.
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
        let (integration, noise) = (settings.integration, settings.motion_noise);
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
pub(super) struct Walked {
    pub(super) speed: f64,
    pub(super) turn: f64,
}

impl MotionModel<STATES> for Walked {
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
