//! Observations of landmarks by one particle: [`Linearized`] at a landmark of its map, [`Located`]
//! in the map, and the [`View`] of the camera.

use super::FastSlamSettings;
use loc_core::{Gaussian, Pose2};
use loc_filters::localizer::Outcome;
use loc_filters::{Error, Gate, Innovation, MeasurementModel, Result};
use loc_sensors::landmark_camera::Observed;
use nalgebra::{
    Matrix1, Matrix2, Matrix2x3, Matrix3x2, Point2, SMatrix, SVector, Vector1, Vector2,
};

/// Residual, derivatives and noise of distance and direction. A row that was not measured has a
/// residual and derivatives of zero, so that it carries no information.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linearized {
    pub(super) residual: Vector2<f64>,
    pub(super) by_robot: Matrix2x3<f64>,
    pub(super) by_landmark: Matrix2<f64>,
    pub(super) noise: Matrix2<f64>,
    measured: [bool; 2],
}

impl Linearized {
    /// An observation, from a robot at `pose`, of a landmark estimated at `landmark`.
    pub(super) fn new(
        settings: &FastSlamSettings,
        pose: &nalgebra::Vector3<f64>,
        landmark: &Vector2<f64>,
        observed: Observed,
    ) -> Self {
        let model = settings.model(Point2::from(*landmark));
        let (expected, mut by_robot) = model.linearize(pose);
        let measured = [observed.range().is_some(), observed.bearing().is_some()];
        let seen = Vector2::new(
            observed.range().unwrap_or(expected.x),
            observed.bearing().unwrap_or(expected.y),
        );
        let mut residual = model.residual(&seen, &expected);
        for (k, _) in measured.iter().enumerate().filter(|(_, measured)| !**measured) {
            residual[k] = 0.0;
            by_robot.row_mut(k).fill(0.0);
        }
        // Shifting robot and landmark together changes nothing.
        let by_landmark = -by_robot.fixed_columns::<2>(0);
        Linearized { residual, by_robot, by_landmark, noise: model.noise(&expected), measured }
    }

    /// The covariance of the residual by landmark and sensor noise alone, for a certain pose.
    pub(super) fn covariance_without_robot(&self, landmark: &Matrix2<f64>) -> Matrix2<f64> {
        self.by_landmark * landmark * self.by_landmark.transpose() + self.noise
    }

    /// Gates the measured part of the residual by its covariance.
    pub(super) fn score_residual(
        &self,
        covariance: Matrix2<f64>,
        gate: &Gate,
        step: u64,
    ) -> Result<Scored> {
        let one = |k: usize| {
            let residual = Vector1::new(self.residual[k]);
            innovation(residual, Matrix1::new(covariance[(k, k)]), gate, step)
        };
        Ok(match self.measured {
            [true, false] => Scored::of(&one(0)?),
            [false, true] => Scored::of(&one(1)?),
            _ => Scored::of(&innovation(self.residual, covariance, gate, step)?),
        })
    }

    /// Gain of the pose: `P H^T S^-1`, 3 x 2.
    pub(super) fn gain(
        &self,
        belief: &Gaussian<3>,
        covariance: &Matrix2<f64>,
    ) -> Option<Matrix3x2<f64>> {
        Some(belief.covariance * self.by_robot.transpose() * covariance.try_inverse()?)
    }
}

/// The outcome of an observation of a known landmark, and its likelihood.
pub(super) struct Scored {
    pub(super) outcome: Outcome,
    /// Log-likelihood. A rejected observation counts as one at the gate, so that rejecting
    /// observations does not raise the weight of a particle.
    pub(super) log_likelihood: f64,
}

impl Scored {
    fn of<const M: usize>(innovation: &Innovation<M>) -> Self {
        let surplus = (innovation.nis - innovation.threshold).max(0.0);
        let surplus = if surplus.is_finite() { surplus } else { 0.0 };
        let log_likelihood = innovation.log_likelihood() + 0.5 * surplus;
        Scored { outcome: Outcome::of_innovation(innovation), log_likelihood }
    }
}

/// The innovation of a residual with its covariance.
fn innovation<const M: usize>(
    residual: SVector<f64, M>,
    covariance: SMatrix<f64, M, M>,
    gate: &Gate,
    step: u64,
) -> Result<Innovation<M>> {
    let lost = || Error::LostPositivity {
        what: "covariance of an innovation",
        step,
        found: format!("{:?}", covariance.as_slice()),
    };
    let factor = loc_core::gaussian::cholesky("covariance of an innovation", &covariance);
    let factor = factor.map_err(|_| lost())?;
    let whitened = factor.l_dirty().solve_lower_triangular(&residual).ok_or_else(lost)?;
    let nis = whitened.norm_squared();
    if !nis.is_finite() {
        return Err(lost());
    }
    let determinant = factor.l_dirty().diagonal().iter().map(|d| d * d).product();
    let threshold = gate.threshold(M);
    let accepted = nis <= threshold;
    Ok(Innovation { residual, covariance, determinant, whitened, nis, threshold, accepted })
}

/// An observation with distance and direction, and the position of its landmark in the map (inverse
/// observation model).
#[derive(Debug, Clone, Copy)]
pub(super) struct Located {
    pub(super) range: f64,
    pub(super) bearing: f64,
    /// In the map \[m\], with the covariance by the sensor alone.
    pub(super) position: Gaussian<2>,
}

impl Located {
    /// Minimum distance of a landmark with a direction \[m\].
    const MIN_RANGE_WITH_BEARING: f64 = 1e-3;

    /// `None` for an observation without distance or direction.
    pub(super) fn new(
        settings: &FastSlamSettings,
        pose: Pose2,
        observed: Observed,
    ) -> Option<Self> {
        let Observed::RangeBearing { range, bearing } = observed else { return None };
        if range < Self::MIN_RANGE_WITH_BEARING {
            return None;
        }
        let camera = pose * settings.robot.mounting;
        let (sin, cos) = bearing.sin_cos();
        let mean = camera.transform(&Point2::new(range * cos, range * sin)).coords;
        let sigmas = settings.observation_variances(range).map(f64::sqrt);
        let (sin, cos) = (camera.theta + bearing).sin_cos();
        let (along, across) = (sigmas.x, sigmas.y * range);
        let axes = Matrix2::new(along * cos, -across * sin, along * sin, across * cos);
        let position = Gaussian { mean, covariance: axes * axes.transpose() };
        Some(Located { range, bearing, position })
    }
}

/// The field of view of the camera, from the observations so far. Landmarks well within it should
/// be seen again.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct View {
    range: f64,
    bearing: f64,
}

impl View {
    /// The part of the view in which a landmark should be seen.
    const MIDDLE: f64 = 0.7;
    /// Minimum field of view \[m, rad\].
    const MIN_RANGE: f64 = 1.0;
    const MIN_BEARING: f64 = 0.25;
    /// A provisional landmark beyond this distance is removed \[ranges\].
    const FAR: f64 = 1.5;

    pub(super) fn include(&mut self, located: &Located) {
        self.range = self.range.max(located.range);
        self.bearing = self.bearing.max(located.bearing.abs());
    }

    /// Density in distance and direction of something new that is anywhere in the view, for an
    /// observation at distance `range` \[m\]: in polar coordinates the density grows with distance.
    pub(super) fn density(&self, range: f64) -> f64 {
        let (farthest, widest) =
            (self.range.max(Self::MIN_RANGE), self.bearing.max(Self::MIN_BEARING));
        range / (farthest * farthest * widest)
    }

    pub(super) fn should_see(&self, from_camera: &Point2<f64>) -> bool {
        from_camera.coords.norm() < Self::MIDDLE * self.range
            && from_camera.y.atan2(from_camera.x).abs() < Self::MIDDLE * self.bearing
    }

    pub(super) fn is_out_of_range(&self, from_camera: &Point2<f64>) -> bool {
        from_camera.coords.norm() > Self::FAR * self.range
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use loc_filters::RobotSettings;
    use nalgebra::Vector3;

    #[test]
    fn jacobians_are_the_slopes_of_the_residual() {
        let mounting = Pose2::new(0.2, -0.1, 0.4);
        let settings =
            FastSlamSettings::default().robot(RobotSettings::default().mounting(mounting));
        let (pose, located) = (Vector3::new(1.0, -2.0, 0.7), Vector2::new(3.1, 0.4));
        let observed = Observed::RangeBearing { range: 2.0, bearing: 0.3 };
        let at =
            |pose: Vector3<f64>, located| Linearized::new(&settings, &pose, &located, observed);
        let (linearized, step) = (at(pose, located), 1e-6);
        for k in 0..3 {
            let mut shift = Vector3::zeros();
            shift[k] = step;
            let [a, b] = [at(pose + shift, located), at(pose - shift, located)];
            // The residual falls as the expectation rises.
            let slope = (b.residual - a.residual) / (2.0 * step);
            assert!((slope - linearized.by_robot.column(k)).norm() < 1e-8, "{k}");
        }
        for k in 0..2 {
            let mut shift = Vector2::zeros();
            shift[k] = step;
            let [a, b] = [at(pose, located + shift), at(pose, located - shift)];
            let slope = (b.residual - a.residual) / (2.0 * step);
            assert!((slope - linearized.by_landmark.column(k)).norm() < 1e-8, "{k}");
        }
    }
}
