//! Least squares with few unknowns: the method of Levenberg and Marquardt, with robust losses by
//! reweighting.

use super::Loss;
use nalgebra::{SMatrix, SVector, SymmetricEigen};

/// Room for three coordinates (or x, y, heading) and scale and offset of the ranges.
pub(super) const UNKNOWNS: usize = 5;
/// Where the range scale stands among the unknowns.
pub(super) const SCALE: usize = 3;
/// Where the range offset stands.
pub(super) const OFFSET: usize = 4;

pub(super) type Unknowns = SVector<f64, UNKNOWNS>;
pub(super) type Square = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// Maximum number of steps: a handful where the terms fit, hundreds along a valley where they contradict each
/// other.
const STEPS: usize = 500;
/// A step this small beside the reach of an unknown ends the search.
const SETTLED: f64 = 1e-12;

/// One squared term of the cost.
pub(super) struct Row {
    /// What is squared.
    pub(super) residual: f64,
    /// Its derivative over the unknowns.
    pub(super) gradient: Unknowns,
    /// Its standard deviation under the noise.
    pub(super) sigma: f64,
    /// The part of its variance that it shares with no other term.
    pub(super) own_variance: f64,
    /// What it is divided by in the cost: its sigma for the most likely unknowns.
    pub(super) scale: f64,
    /// How much outliers cost.
    pub(super) loss: Loss,
}

impl Row {
    /// A term without residual whose noise is its own and which counts by it.
    pub(super) fn like(sigma: f64, loss: Loss) -> Self {
        let (own_variance, scale) = (sigma * sigma, sigma);
        Row { residual: 0.0, gradient: Unknowns::zeros(), sigma, own_variance, scale, loss }
    }
}

/// A sum of squares, or of robust losses.
pub(super) trait Problem {
    /// The terms of the sum at given unknowns.
    fn rows(&self, at: &Unknowns, visit: &mut dyn FnMut(&Row));
    /// What terms share of their noise, as the covariance of half the sum's gradient.
    fn shared_noise(&self, _at: &Unknowns) -> Square {
        Square::zeros()
    }
    /// How far each unknown can be off at most, in its unit; 0 for one that is known.
    fn reach(&self) -> Unknowns;
}

/// Where a sum is smallest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Minimum {
    pub(super) at: Unknowns,
    pub(super) cost: f64,
    pub(super) covariance: Square,
}

/// The sum with its derivatives: half gradient, Gauss-Newton matrix, and the noise in the former.
#[derive(Clone, Copy)]
struct Sum {
    cost: f64,
    slope: Unknowns,
    information: Square,
    noise: Square,
}

impl Sum {
    fn of(problem: &dyn Problem, at: &Unknowns) -> Sum {
        let mut sum = Sum {
            cost: 0.0,
            slope: Unknowns::zeros(),
            information: Square::zeros(),
            noise: Square::zeros(),
        };
        problem.rows(at, &mut |row| {
            let (whitened, by_scale) = (row.residual / row.sigma, row.sigma / row.scale);
            let weight = row.loss.weight(whitened) / (row.scale * row.scale);
            sum.cost += by_scale * by_scale * row.loss.cost(whitened);
            sum.slope.axpy(weight * row.residual, &row.gradient, 1.0);
            sum.information.ger(weight, &row.gradient, &row.gradient, 1.0);
            // Reweighted residuals have the variance sigma^2 / weight.
            let variance = row.own_variance * weight / (row.scale * row.scale);
            sum.noise.ger(variance, &row.gradient, &row.gradient, 1.0);
        });
        sum
    }
}

/// The minimum that a start leads to; `None` where a number runs out of bounds.
pub(super) fn minimize(problem: &dyn Problem, start: Unknowns) -> Option<Minimum> {
    let reach = problem.reach();
    let (mut at, mut damping) = (start, 1e-4);
    let mut here = Sum::of(problem, &at);
    for _ in 0..STEPS {
        let step = damped_step(&here, &reach, damping)?;
        let there = at + step;
        let next = Sum::of(problem, &there);
        let small = (0..UNKNOWNS).all(|k| step[k].abs() <= SETTLED * reach[k]);
        if next.cost <= here.cost {
            (at, here) = (there, next);
            damping = f64::max(0.1 * damping, 1e-12);
        } else {
            damping *= 10.0;
        }
        if small || damping > 1e12 {
            break;
        }
    }
    let all_finite = at.iter().all(|value| value.is_finite()) && here.cost.is_finite();
    let covariance = all_finite.then(|| covariance(problem, &at, &here, &reach))?;
    Some(Minimum { at, cost: here.cost, covariance })
}

/// The step of Levenberg and Marquardt. Unknowns are measured by their reach, so that metres and
/// radians count alike, and those that are known stay.
fn damped_step(sum: &Sum, reach: &Unknowns, damping: f64) -> Option<Unknowns> {
    let mut matrix = scaled(&sum.information, reach);
    let slope = sum.slope.component_mul(reach);
    let floor = 1e-12 * matrix.diagonal().max();
    for k in 0..UNKNOWNS {
        matrix[(k, k)] += damping * matrix[(k, k)] + floor;
        if reach[k] <= 0.0 {
            matrix[(k, k)] = 1.0;
        }
    }
    Some(-matrix.cholesky()?.solve(&slope).component_mul(reach))
}

fn scaled(matrix: &Square, by: &Unknowns) -> Square {
    Square::from_fn(|i, j| matrix[(i, j)] * by[i] * by[j])
}

/// The covariance of the unknowns at a minimum.
///
/// To first order it is `H^-1 N H^-1` with the Gauss-Newton matrix H and the noise N of its
/// gradient; for the most likely unknowns that is `H^-1`. Along directions in which the sum is not
/// a parabola over one such standard deviation (two circles that just touch, say), one standard
/// deviation is how far the sum needs to grow by 1, and no more than the reach of the unknowns.
fn covariance(problem: &dyn Problem, at: &Unknowns, sum: &Sum, reach: &Unknowns) -> Square {
    let axes = SymmetricEigen::new(scaled(&sum.information, reach));
    let noise = scaled(&(sum.noise + problem.shared_noise(at)), reach);
    // Below rounding a curvature is none.
    let flat = 1e-12 * axes.eigenvalues.max();
    let mut inverse = Square::zeros();
    let mut beyond = Square::zeros();
    for k in 0..UNKNOWNS {
        let axis = Unknowns::from(axes.eigenvectors.column(k));
        // A known unknown is an axis of its own, without extent.
        let direction = axis.component_mul(reach);
        if direction.amax() <= 0.0 {
            continue;
        }
        let curvature =
            Some(axes.eigenvalues[k]).filter(|curvature| *curvature > flat).unwrap_or(0.0);
        let of_noise = axis.dot(&(noise * axis)).max(0.0);
        let first_order = if curvature > 0.0 { of_noise.sqrt() / curvature } else { 1.0 };
        let sigma = f64::min(first_order, 1.0);
        let grown = growth(problem, at, sum.cost, &(direction * sigma));
        // What a parabola would have grown by.
        let expected = f64::max(curvature * sigma * sigma, f64::MIN_POSITIVE);
        if first_order < 1.0 && grown <= 2.0 * expected {
            inverse.ger(1.0 / curvature, &direction, &axis, 1.0);
        } else {
            let sigma = profile(problem, at, sum.cost, &direction, sigma);
            beyond.ger(sigma * sigma, &direction, &direction, 1.0);
        }
    }
    let covariance = inverse * noise * inverse.transpose() + beyond;
    0.5 * (covariance + covariance.transpose())
}

/// By how much the sum grows over a step to either side, the mean of both.
fn growth(problem: &dyn Problem, at: &Unknowns, cost: f64, step: &Unknowns) -> f64 {
    let there = |at: Unknowns| Sum::of(problem, &at).cost - cost;
    0.5 * (there(at + step) + there(at - step))
}

/// The share of `direction`, at most `max_share`, over which the sum grows by 1.
fn profile(
    problem: &dyn Problem,
    at: &Unknowns,
    cost: f64,
    direction: &Unknowns,
    most: f64,
) -> f64 {
    let (mut low, mut high) = (0.0, most);
    if growth(problem, at, cost, &(direction * high)) <= 1.0 {
        return high;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if growth(problem, at, cost, &(direction * middle)) <= 1.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}
