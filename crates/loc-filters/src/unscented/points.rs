//! The sigma points and what can be learnt from them.

use nalgebra::{SMatrix, SVector};

/// Something at each of the 2 N + 1 sigma points: in the middle, and on both sides along each
/// column of the covariance's root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Points<T, const N: usize> {
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

/// N + kappa, the square of the points' distance in standard deviations.
fn reach<const N: usize>() -> f64 {
    (N as f64).max(3.0)
}

/// The weight of the middle, and that of each other point.
fn weights<const N: usize>() -> (f64, f64) {
    (1.0 - N as f64 / reach::<N>(), 0.5 / reach::<N>())
}

impl<const N: usize> Points<SVector<f64, N>, N> {
    /// The points of a belief with this root of its covariance.
    pub(super) fn about(mean: &SVector<f64, N>, root: &SMatrix<f64, N, N>) -> Self {
        let distance = reach::<N>().sqrt();
        let along = |k: usize| root.column(k) * distance;
        Points {
            middle: *mean,
            ahead: std::array::from_fn(|k| mean + along(k)),
            behind: std::array::from_fn(|k| mean - along(k)),
        }
    }
}

impl<T, const N: usize> Points<T, N> {
    /// What a function makes of each point.
    pub(super) fn map<U>(&self, mut f: impl FnMut(&T) -> U) -> Points<U, N> {
        Points {
            middle: f(&self.middle),
            ahead: std::array::from_fn(|k| f(&self.ahead[k])),
            behind: std::array::from_fn(|k| f(&self.behind[k])),
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &T> {
        std::iter::once(&self.middle).chain(&self.ahead).chain(&self.behind)
    }
}

impl<const M: usize, const N: usize> Points<SVector<f64, M>, N> {
    /// The weighted mean. `difference` takes the second vector from the first and wraps angles; the
    /// mean is the place from which the differences add up to nothing.
    pub(super) fn mean(
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

    /// The weighted sum of their squares.
    pub(super) fn second_moment(&self) -> SMatrix<f64, M, M> {
        let (w0, w) = weights::<N>();
        let mut sum = self.middle * self.middle.transpose() * w0;
        for point in self.ahead.iter().chain(&self.behind) {
            sum += point * point.transpose() * w;
        }
        sum
    }

    /// What was measured, taken as a line plus noise: the slope along each column of the root, and
    /// the covariance of what the line leaves over, a sum of squares.
    pub(super) fn slopes_and_bend(&self) -> (SMatrix<f64, M, N>, SMatrix<f64, M, M>) {
        let (w0, w) = weights::<N>();
        let mut slopes = SMatrix::<f64, M, N>::zeros();
        let mut bend = self.middle * self.middle.transpose() * w0;
        let per_root = w * reach::<N>().sqrt();
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
pub(super) fn factor<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
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
