//! What is known before the first measurement.

use super::FusionSettings;
use super::state::{
    DRIFT_X, DRIFT_Y, FORWARD_BIAS, GYRO_BIAS, LEFT_BIAS, RANGE_OFFSET, RANGE_SCALE, SPEED, STATES,
    Square, State, TURN,
};
use crate::Result;
use loc_core::Gaussian;

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
