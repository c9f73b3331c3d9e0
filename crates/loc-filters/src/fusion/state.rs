//! The states of the fused filter: the pose, its velocity, and the slowly varying errors of the sensors.

use super::FusionSettings;
use crate::Result;
use loc_core::{Gaussian, Pose2};
use nalgebra::{SMatrix, SVector};

/// Number of states.
pub const STATES: usize = 12;
/// A state or a measurement's gradient.
pub(super) type State = SVector<f64, STATES>;
/// A covariance or a Jacobian.
pub(super) type Square = SMatrix<f64, STATES, STATES>;

/// Position in the map, x \[m\].
pub const X: usize = 0;
/// Position in the map, y \[m\].
pub const Y: usize = 1;
/// Heading \[rad\].
pub const THETA: usize = 2;
/// Forward speed \[m/s\].
pub const SPEED: usize = 3;
/// Turn rate \[rad/s\].
pub const TURN: usize = 4;
/// Bias of the gyroscope \[rad/s\].
pub const GYRO_BIAS: usize = 5;
/// Bias of the accelerometer that points forward \[m/s^2\].
pub const FORWARD_BIAS: usize = 6;
/// Bias of the accelerometer that points left \[m/s^2\].
pub const LEFT_BIAS: usize = 7;
/// Factor by which ranges are too long.
pub const RANGE_SCALE: usize = 8;
/// By how much ranges are too long beside \[m\].
pub const RANGE_OFFSET: usize = 9;
/// How far the satellite receiver is off now, along the map's x axis \[m\].
pub const DRIFT_X: usize = 10;
/// How far the satellite receiver is off now, along the map's y axis \[m\].
pub const DRIFT_Y: usize = 11;

/// The belief about all states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FusedBelief(pub Gaussian<STATES>);

impl FusedBelief {
    /// The pose.
    pub fn pose(&self) -> Pose2 {
        Pose2::new(self.0.mean[X], self.0.mean[Y], self.0.mean[THETA])
    }

    /// The belief about (x, y, theta) \[m, m, rad\] alone.
    pub fn about_pose(&self) -> Gaussian<3> {
        Gaussian {
            mean: self.0.mean.fixed_rows::<3>(0).into(),
            covariance: self.0.covariance.fixed_view::<3, 3>(0, 0).into(),
        }
    }

    /// Mean and standard deviation of one state, such as [`GYRO_BIAS`]; `None` beyond the last.
    pub fn state(&self, index: usize) -> Option<(f64, f64)> {
        let mean = self.0.mean.get(index)?;
        let variance = self.0.covariance.get((index, index))?;
        Some((*mean, variance.max(0.0).sqrt()))
    }
}

/// The belief about all states, from that about (x, y, theta).
pub(super) fn belief(settings: &FusionSettings, pose: &Gaussian<3>) -> Result<Gaussian<STATES>> {
    let pose = Gaussian::new(pose.mean, pose.covariance)?;
    let mut mean = State::zeros();
    mean.fixed_rows_mut::<3>(0).copy_from(&pose.mean);
    mean[RANGE_SCALE] = 1.0;
    let sigmas = [
        (SPEED, settings.start_speed),
        (TURN, settings.start_turn),
        (GYRO_BIAS, settings.imu.gyroscope.start_bias),
        (FORWARD_BIAS, settings.imu.accelerometer.start_bias),
        (LEFT_BIAS, settings.imu.accelerometer.start_bias),
        (RANGE_SCALE, settings.range_bias.scale_sigma),
        (RANGE_OFFSET, settings.range_bias.offset_sigma),
        (DRIFT_X, settings.gnss.drift_sigma),
        (DRIFT_Y, settings.gnss.drift_sigma),
    ];
    let mut covariance = Square::zeros();
    covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.covariance);
    for (index, sigma) in sigmas {
        covariance[(index, index)] = sigma * sigma;
    }
    Ok(Gaussian { mean, covariance })
}
