//! The unscented Kalman filter (Julier and Uhlmann 1997): no derivatives, but points.
//!
//! Where a motion or a sensor bends, the tangent that the extended Kalman filter takes is wrong for
//! a belief that is wide. The unscented filter sends a few points of the belief, the sigma points,
//! through the model and takes mean and covariance of what comes out; up to the second order of the
//! bend that is right. It uses the same models as
//! [`ExtendedKalmanFilter`](crate::ExtendedKalmanFilter);
//! for linear ones the two are the same.
//!
//! The 2 N + 1 points stand in the mean and at `+- sqrt(N + kappa)` standard deviations, with
//! `kappa = 3 - N`, at least 0: no weight is negative, every covariance is a sum of squares. Angles
//! are averaged on the circle. Where an angle is so uncertain that its points would pass half a turn,
//! they stay nearer to the mean, and the slopes between them stand for the whole covariance: a
//! prediction never narrows.
//!
//! ```
//! use loc_core::Gaussian;
//! use loc_filters::{Gate, MeasurementModel, UnscentedKalmanFilter};
//! use nalgebra::{Matrix1, Matrix1x2, Matrix2, Vector1, Vector2};
//!
//! /// Distance from the origin, measured to 0.1.
//! struct Distance;
//! impl MeasurementModel<2, 1> for Distance {
//!     fn predict(&self, x: &Vector2<f64>) -> Vector1<f64> { Vector1::new(x.norm()) }
//!     fn jacobian(&self, x: &Vector2<f64>) -> Matrix1x2<f64> { x.normalize().transpose() }
//!     fn noise(&self, _: &Vector1<f64>) -> Matrix1<f64> { Matrix1::new(0.01) }
//! }
//!
//! // Far off across the line of sight: the distance is longer than that of the mean.
//! let start = Gaussian::new(Vector2::new(3.0, 0.0), Matrix2::identity())?;
//! let mut filter = UnscentedKalmanFilter::new(start)?;
//! let innovation = filter.correct(&Distance, &Vector1::new(4.0), &Gate::OPEN)?;
//! assert!(innovation.residual.x < 0.9 && filter.belief().mean.x > 3.7);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::extended::{MeasurementModel, MotionModel};
use crate::innovation::{Gate, Innovation, finite};
use crate::kalman::update;
use crate::kalman::update::wrapped;
use crate::smoother::Link;
use crate::{Error, Result};
use loc_core::Gaussian;
use nalgebra::{SMatrix, SVector};

/// A belief about `N` states, with its filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnscentedKalmanFilter<const N: usize> {
    belief: Gaussian<N>,
    angles: &'static [usize],
    steps: u64,
}

/// What a prediction did with the sigma points.
pub(crate) struct SigmaPrediction<const N: usize> {
    off: Points<SVector<f64, N>, N>,
    root: SMatrix<f64, N, N>,
    noise: SMatrix<f64, N, N>,
}

impl<const N: usize> SigmaPrediction<N> {
    /// How the states before and after are related, for the smoother.
    pub(crate) fn link(&self) -> Link<N> {
        let (slopes, bend) = self.off.slopes_and_bend();
        Link::Points { root: self.root, slopes, noise: self.noise + bend }
    }
}

impl<const N: usize> UnscentedKalmanFilter<N> {
    /// A filter that starts from a belief.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`].
    pub fn new(start: Gaussian<N>) -> Result<Self> {
        let belief = Gaussian::new(start.mean, start.covariance)?;
        Ok(UnscentedKalmanFilter { belief, angles: &[], steps: 0 })
    }

    /// Names the states that are angles, to be kept in (-pi, pi]; indices beyond the state are
    /// passed over.
    #[must_use]
    pub fn with_angles(mut self, angles: &'static [usize]) -> Self {
        self.angles = angles;
        self.belief.mean = self.wrapped(self.belief.mean);
        self
    }

    /// The current belief.
    pub fn belief(&self) -> &Gaussian<N> {
        &self.belief
    }

    /// The states that are angles.
    pub(crate) fn angles(&self) -> &'static [usize] {
        self.angles
    }

    /// Prediction: mean and covariance of the moved sigma points, plus the noise that the model
    /// has at the mean.
    ///
    /// # Errors
    /// [`Error::NotFinite`] where the model leads to NaN or infinity, [`Error::LostPositivity`]
    /// where the covariance is none any more; the belief is kept.
    pub fn predict(&mut self, motion: &impl MotionModel<N>) -> Result<()> {
        self.predict_points(motion).map(|_| ())
    }

    /// Prediction; the answer are the moved points, about their mean, the root of the covariance that
    /// they stood along, and the noise of the motion.
    pub(crate) fn predict_points(
        &mut self,
        motion: &impl MotionModel<N>,
    ) -> Result<SigmaPrediction<N>> {
        let (points, root) = self.points()?;
        let moved = points.map(|state| motion.predict(state));
        moved.iter().try_for_each(|state| finite("predicted state", state))?;
        let mean = moved.mean(|state, center| self.wrapped(state - center));
        let off = moved.map(|state| self.wrapped(state - mean));
        let noise = motion.linearize(&self.belief.mean).noise;
        let covariance = off.covariance() + noise;
        if !covariance.iter().all(|value| value.is_finite()) {
            let found = format!("{:?}", covariance.as_slice());
            return Err(Error::NotFinite { what: "predicted covariance", found });
        }
        self.belief = Gaussian { mean: self.wrapped(mean), covariance };
        self.steps += 1;
        Ok(SigmaPrediction { off, root, noise })
    }

    /// Correction with a measurement `z`, unless the gate rejects it.
    ///
    /// With the square root L of the covariance and the sigma points' measurements, the state in
    /// units of L is measured through a matrix G^T, and what the points deviate from a line is
    /// noise beside that of the sensor. The correction is then Joseph's, in these units; it equals
    /// the textbook's `P - K S K^T` and cannot become negative.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the measurement or what the model expects,
    /// [`Error::LostPositivity`] for a covariance that is none any more, and
    /// [`loc_core::Error::NotACovariance`] for that of the innovation; the belief is kept.
    // ANCHOR: correct
    pub fn correct<const M: usize>(
        &mut self,
        sensor: &impl MeasurementModel<N, M>,
        z: &SVector<f64, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        finite("measurement", z)?;
        let (points, root) = self.points()?;
        let seen = points.map(|state| sensor.predict(state));
        seen.iter().try_for_each(|seen| finite("expected measurement", seen))?;
        let expected = seen.mean(|seen, center| sensor.residual(seen, center));
        let off = seen.map(|seen| sensor.residual(seen, &expected));
        let (gain, bend) = off.slopes_and_bend();
        let noise = sensor.noise(&expected) + bend;
        let residual = sensor.residual(z, &expected);
        let mut unit = Gaussian { mean: SVector::zeros(), covariance: SMatrix::identity() };
        let innovation = update::correct(&mut unit, residual, &gain, &noise, gate)?;
        if innovation.accepted {
            let mean = self.wrapped(self.belief.mean + root * unit.mean);
            let covariance = update::propagate(&root, &unit.covariance, &SMatrix::zeros());
            self.belief = Gaussian { mean, covariance };
        }
        self.steps += 1;
        Ok(innovation)
    }
    // ANCHOR_END: correct

    /// The sigma points, and the square root L of the covariance that they stand along.
    fn points(&self) -> Result<(Points<SVector<f64, N>, N>, SMatrix<f64, N, N>)> {
        let root = factor(&self.belief.covariance).ok_or_else(|| Error::LostPositivity {
            what: "covariance of an unscented filter",
            step: self.steps,
            found: format!("{:?}", self.belief.covariance.as_slice()),
        })?;
        let widest = self.angles.iter().filter(|&&angle| angle < N);
        let widest = widest.map(|&angle| root.row(angle).amax()).fold(0.0, f64::max);
        let distance = usual_distance::<N>().min(MAX_TURN / widest);
        Ok((Points::about(&self.belief.mean, &root, distance), root))
    }

    fn wrapped(&self, state: SVector<f64, N>) -> SVector<f64, N> {
        wrapped(state, self.angles)
    }
}

/// Something at each of the 2 N + 1 sigma points: in the middle, and on both sides along each
/// column of the covariance's root.
#[derive(Debug, Clone, Copy)]
struct Points<T, const N: usize> {
    /// How far the points are from the middle, in columns of the root.
    distance: f64,
    middle: T,
    ahead: [T; N],
    behind: [T; N],
}

/// A mean on a circle is looked for in so many rounds; on a line the first one finds it.
const ROUNDS: usize = 4;
/// Directions whose variance is smaller than this share of a coordinate's are certain.
const CERTAIN: f64 = 1e-14;
/// Rounding may make a variance negative by this share.
const ROUNDING: f64 = 1e-9;

/// An angle of a sigma point is at most this far from that of the middle \[rad\].
const MAX_TURN: f64 = 0.95 * std::f64::consts::PI;

/// N + kappa, the square of the points' usual distance in standard deviations.
fn reach<const N: usize>() -> f64 {
    (N as f64).max(3.0)
}

/// The points' distance in standard deviations, unless an angle limits it.
fn usual_distance<const N: usize>() -> f64 {
    reach::<N>().sqrt()
}

/// The weight of the middle, and that of each other point.
fn weights<const N: usize>() -> (f64, f64) {
    (1.0 - N as f64 / reach::<N>(), 0.5 / reach::<N>())
}

impl<const N: usize> Points<SVector<f64, N>, N> {
    /// The points of a belief with this root of its covariance.
    fn about(mean: &SVector<f64, N>, root: &SMatrix<f64, N, N>, distance: f64) -> Self {
        let along = |k: usize| root.column(k) * distance;
        Points {
            distance,
            middle: *mean,
            ahead: std::array::from_fn(|k| mean + along(k)),
            behind: std::array::from_fn(|k| mean - along(k)),
        }
    }
}

impl<T, const N: usize> Points<T, N> {
    /// What a function makes of each point.
    fn map<U>(&self, mut f: impl FnMut(&T) -> U) -> Points<U, N> {
        Points {
            distance: self.distance,
            middle: f(&self.middle),
            ahead: std::array::from_fn(|k| f(&self.ahead[k])),
            behind: std::array::from_fn(|k| f(&self.behind[k])),
        }
    }

    fn iter(&self) -> impl Iterator<Item = &T> {
        std::iter::once(&self.middle).chain(&self.ahead).chain(&self.behind)
    }
}

impl<const M: usize, const N: usize> Points<SVector<f64, M>, N> {
    /// The weighted mean. `difference` takes the second vector from the first and wraps angles; the
    /// mean is the place from which the differences add up to nothing.
    fn mean(
        &self,
        difference: impl Fn(&SVector<f64, M>, &SVector<f64, M>) -> SVector<f64, M>,
    ) -> SVector<f64, M> {
        let (w0, w) = weights::<N>();
        let mut center = self.middle;
        for _ in 0..ROUNDS {
            let off = |point: &SVector<f64, M>| difference(point, &center);
            let sides: SVector<f64, M> = self.ahead.iter().chain(&self.behind).map(off).sum();
            let shift = off(&self.middle) * w0 + sides * w;
            center += shift;
            if shift.norm_squared() <= f64::EPSILON * f64::EPSILON * center.norm_squared() {
                break;
            }
        }
        center
    }

    /// The weighted sum of their squares; of points that are nearer than usual, that of the line
    /// through them and of what deviates from it.
    fn covariance(&self) -> SMatrix<f64, M, M> {
        if self.distance < usual_distance::<N>() {
            let (slopes, bend) = self.slopes_and_bend();
            return slopes * slopes.transpose() + bend;
        }
        let (w0, w) = weights::<N>();
        let mut sum = self.middle * self.middle.transpose() * w0;
        for point in self.ahead.iter().chain(&self.behind) {
            sum += point * point.transpose() * w;
        }
        sum
    }

    /// What was measured, taken as a line plus noise: the slope along each column of the root, and
    /// the covariance of what the line leaves over, a sum of squares.
    fn slopes_and_bend(&self) -> (SMatrix<f64, M, N>, SMatrix<f64, M, M>) {
        let (w0, w) = weights::<N>();
        let mut slopes = SMatrix::<f64, M, N>::zeros();
        let mut bend = self.middle * self.middle.transpose() * w0;
        let is_near = self.distance < usual_distance::<N>();
        let per_root = if is_near { 0.5 / self.distance } else { w * usual_distance::<N>() };
        for (k, (ahead, behind)) in self.ahead.iter().zip(&self.behind).enumerate() {
            slopes.set_column(k, &((ahead - behind) * per_root));
            let common = ahead + behind;
            bend += common * common.transpose() * (0.5 * w);
        }
        (slopes, bend)
    }
}

/// A lower triangular L with `L L^T = matrix`; a direction that is certain has a column of zeros.
/// `None` for a matrix that is not finite or has negative variances beyond rounding.
fn factor<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let mut l = SMatrix::<f64, N, N>::zeros();
    for j in 0..N {
        let own = matrix[(j, j)];
        let pivot = own - (0..j).map(|k| l[(j, k)] * l[(j, k)]).sum::<f64>();
        let allowed = own.is_finite() && own >= 0.0 && pivot >= -ROUNDING * own;
        if !allowed {
            return None;
        }
        if pivot <= CERTAIN * own {
            continue;
        }
        l[(j, j)] = pivot.sqrt();
        for i in j + 1..N {
            let rest = matrix[(i, j)] - (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            l[(i, j)] = rest / l[(j, j)];
        }
    }
    l.iter().all(|value| value.is_finite()).then_some(l)
}
