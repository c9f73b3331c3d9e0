//! Errors that observations of one moment have in common.
//!
//! A camera whose scale is off sees everything too far away, and one whose images come late sees
//! everything to the same side in a turn. Such errors last; a filter that takes each observation for
//! a new witness believes them after a while, and one that is told of wide noise instead cannot tell
//! two landmarks apart that stand side by side. So the filter keeps the two common errors, of
//! distance and of direction, beside the pose, counted in standard deviations of an observation. They
//! fade with a time constant `tau` while new ones come (a Gauss-Markov process):
//! `s' = e^(-dt/tau) s`, `var' = e^(-2 dt/tau) var + (1 - e^(-2 dt/tau)) share`.

use super::{EkfSlam, SlamSettings};
use crate::Result;
use crate::slam::state::LargeState;
use loc_core::{Gaussian, Pose2};
use nalgebra::{Matrix3, SMatrix, SVector};

/// The robot's numbers: x, y, theta, and the common errors of distance and direction.
pub(super) const NUMBERS: usize = 5;

/// Index of the robot's heading among its numbers.
pub(super) const HEADING: usize = 2;

/// Derivatives of two numbers over those of the robot.
pub(super) type Matrix2x5 = SMatrix<f64, 2, NUMBERS>;

type Square = SMatrix<f64, NUMBERS, NUMBERS>;

/// The state without a map, from a belief over the pose.
pub(super) fn start(pose: &Gaussian<3>, settings: &SlamSettings) -> Result<LargeState<NUMBERS>> {
    let mut covariance = Square::identity() * settings.common_share;
    covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.covariance);
    let mut mean = SVector::<f64, NUMBERS>::zeros();
    mean.fixed_rows_mut::<3>(0).copy_from(&pose.mean);
    LargeState::new(mean, covariance)
}

impl EkfSlam {
    /// The estimate of the robot's pose.
    pub(super) fn robot_pose(&self) -> Pose2 {
        Pose2::from_vector(&self.state.robot().fixed_rows::<3>(0).into_owned())
    }

    /// The motion of all numbers of the robot, from that of its pose: where to, by what derivatives,
    /// with what noise.
    pub(super) fn with_common_errors(
        &self,
        moved: Pose2,
        by_pose: &Matrix3<f64>,
        pose_noise: &Matrix3<f64>,
        dt: f64,
    ) -> (SVector<f64, NUMBERS>, Square, Square) {
        let kept = (-dt / self.settings.common_time).exp();
        let mut state = self.state.robot() * kept;
        state.fixed_rows_mut::<3>(0).copy_from(&moved.to_vector());
        let mut by_state = Square::identity() * kept;
        by_state.fixed_view_mut::<3, 3>(0, 0).copy_from(by_pose);
        let mut noise = Square::identity() * ((1.0 - kept * kept) * self.settings.common_share);
        noise.fixed_view_mut::<3, 3>(0, 0).copy_from(pose_noise);
        (state, by_state, noise)
    }

    /// A distance and a direction without the common errors, as far as these are known.
    pub(super) fn without_common_errors(&self, range: f64, bearing: f64) -> (f64, f64) {
        let (robot, noise) = (self.state.robot(), self.settings.observation_noise);
        let range = (range - robot[3] * noise.range_sigma_at(range)).max(0.0);
        (range, bearing - robot[4] * noise.bearing_sigma)
    }
}
