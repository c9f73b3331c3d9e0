//! Mean and covariance of weighted poses.

use loc_core::{Gaussian, Pose2, angle};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// Variance of a heading that may be anything, about whatever mean \[rad^2\].
const ANY_HEADING: f64 = PI * PI / 3.0;

/// Sums over weighted poses, from which mean and covariance follow.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    weight: f64,
    x: f64,
    y: f64,
    cos: f64,
    sin: f64,
}

impl Sums {
    pub(super) fn add(&mut self, pose: Pose2, weight: f64) {
        self.add_any_heading([pose.x, pose.y], weight);
        let (sin, cos) = pose.theta.sin_cos();
        self.cos += weight * cos;
        self.sin += weight * sin;
    }

    /// Adds a place of which all headings are equally likely.
    pub(super) fn add_any_heading(&mut self, [x, y]: [f64; 2], weight: f64) {
        self.weight += weight;
        self.x += weight * x;
        self.y += weight * y;
    }

    /// The mean; headings are averaged as directions. `None` without weight.
    fn mean(&self) -> Option<Pose2> {
        let Sums { weight, x, y, cos, sin } = *self;
        let any = weight > 0.0 && weight.is_finite();
        any.then(|| Pose2 { x: x / weight, y: y / weight, theta: angle::wrap(sin.atan2(cos)) })
    }

    /// The deviations from the mean, to be filled with the same poses again; `None` without
    /// weight.
    pub(super) fn spread(&self) -> Option<Spread> {
        Some(Spread { mean: self.mean()?, weight: self.weight, covariance: Matrix3::zeros() })
    }

    /// Mean and covariance over (x, y, theta) of poses which each stand for a cell with this side
    /// \[m\] and sector \[rad\]; `None` without weight.
    pub(super) fn gaussian<I: Iterator<Item = (Pose2, f64)>>(
        poses: impl Fn() -> I,
        cell: f64,
        sector: f64,
    ) -> Option<(f64, Gaussian<3>)> {
        let mut sums = Sums::default();
        poses().for_each(|(pose, weight)| sums.add(pose, weight));
        let mut spread = sums.spread()?;
        poses().for_each(|(pose, weight)| spread.add(pose, weight));
        Some((sums.weight, spread.gaussian(cell, sector)))
    }
}

/// Deviations from a mean.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    mean: Pose2,
    weight: f64,
    covariance: Matrix3<f64>,
}

impl Spread {
    pub(super) fn add(&mut self, pose: Pose2, weight: f64) {
        let turned = angle::difference(pose.theta, self.mean.theta);
        self.add_deviation(
            Vector3::new(pose.x - self.mean.x, pose.y - self.mean.y, turned),
            weight,
        );
    }

    pub(super) fn add_any_heading(&mut self, [x, y]: [f64; 2], weight: f64) {
        self.add_deviation(Vector3::new(x - self.mean.x, y - self.mean.y, 0.0), weight);
        self.covariance[(2, 2)] += weight / self.weight * ANY_HEADING;
    }

    fn add_deviation(&mut self, off: Vector3<f64>, weight: f64) {
        self.covariance += off * off.transpose() * (weight / self.weight);
    }

    /// With the variance of a pose within its cell \[m\] and sector \[rad\], which is as likely in
    /// all of their extent.
    pub(super) fn gaussian(&self, cell: f64, sector: f64) -> Gaussian<3> {
        let of_cell = Vector3::new(cell * cell, cell * cell, sector * sector) / 12.0;
        let covariance = self.covariance + Matrix3::from_diagonal(&of_cell);
        Gaussian { mean: self.mean.to_vector(), covariance }
    }
}
