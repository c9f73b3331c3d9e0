//! What a scanner measures of a line of the map: its distance, and the direction of its normal.

use crate::extended::MeasurementModel;
use loc_core::{Pose2, angle};
use loc_maps::line::NormalForm;
use nalgebra::{Matrix2, Matrix2x3, Vector2, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

/// (r, alpha) of a line of the map in the frame of a scanner on the robot (H4).
///
/// With the line `X cos A + Y sin A = R` of the map and a scanner at `(x_l, y_l, theta_l)`,
/// `h = (R - x_l cos A - y_l sin A, A - theta_l)`. It is linear in the pose but for the way that
/// the scanner swings about the robot's centre as it turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineModel {
    normal: NormalForm,
    mounting: Pose2,
    facing: Option<f64>,
    noise: Matrix2<f64>,
}

impl LineModel {
    /// The model of a line of the map, given by its normal form there, and a scanner at `mounting`
    /// (`base_from_laser`). r is at least 0, and there is no noise.
    pub fn new(normal: NormalForm, mounting: Pose2) -> Self {
        LineModel { normal, mounting, facing: None, noise: Matrix2::zeros() }
    }

    /// The same for one measurement: its alpha \[rad\], and the covariance of (r, alpha).
    ///
    /// A wall close by may be measured on one side of the scanner and expected on the other. The
    /// expectation is then given on the side that `alpha` says, with a negative r.
    #[must_use]
    pub fn measured(self, alpha: f64, noise: Matrix2<f64>) -> Self {
        LineModel { facing: Some(alpha), noise, ..self }
    }

    /// The scanner's place from the robot's, in the map's directions \[m\].
    fn lever(&self, theta: f64) -> Vector2<f64> {
        let (sin, cos) = theta.sin_cos();
        let Pose2 { x, y, .. } = self.mounting;
        Vector2::new(cos * x - sin * y, sin * x + cos * y)
    }

    /// Signed distance of the line from the scanner along its normal in the map \[m\], and 1 where
    /// (r, alpha) looks the way of that normal, -1 where it looks back.
    fn distance_and_side(&self, state: &Vector3<f64>) -> (f64, f64) {
        let (sin, cos) = self.normal.alpha.sin_cos();
        let lever = self.lever(state.z);
        let distance = self.normal.r - (state.x + lever.x) * cos - (state.y + lever.y) * sin;
        let alpha = self.normal.alpha - state.z - self.mounting.theta;
        let turned = match self.facing {
            None => distance < 0.0,
            Some(facing) => angle::difference(alpha, facing).abs() > FRAC_PI_2,
        };
        (distance, if turned { -1.0 } else { 1.0 })
    }
}

impl MeasurementModel<3, 2> for LineModel {
    fn predict(&self, state: &Vector3<f64>) -> Vector2<f64> {
        let (distance, side) = self.distance_and_side(state);
        let turn = if side < 0.0 { PI } else { 0.0 };
        let alpha = self.normal.alpha - state.z - self.mounting.theta + turn;
        Vector2::new(side * distance, angle::wrap(alpha))
    }

    /// Rows `[-cos A, -sin A, .]`, whose last column is the scanner's swing, and `[0, 0, -1]`.
    // ANCHOR: line-jacobian
    fn jacobian(&self, state: &Vector3<f64>) -> Matrix2x3<f64> {
        let (_, side) = self.distance_and_side(state);
        let (sin, cos) = self.normal.alpha.sin_cos();
        let lever = self.lever(state.z);
        let swing = lever.y * cos - lever.x * sin;
        Matrix2x3::new(-side * cos, -side * sin, side * swing, 0.0, 0.0, -1.0)
    }
    // ANCHOR_END: line-jacobian

    fn noise(&self, _expected: &Vector2<f64>) -> Matrix2<f64> {
        self.noise
    }

    fn residual(&self, z: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(z.x - expected.x, angle::difference(z.y, expected.y))
    }
}
