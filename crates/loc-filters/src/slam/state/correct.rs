//! The correction of robot and map by any number of scalar measurements together, and its invariant form.

use super::{LargeState, kernel};
use crate::{Error, Result};
use loc_core::gaussian::check_covariance;
use nalgebra::{SMatrix, SVector, Vector2};

/// One measured number, and how it depends on the robot and on one landmark or two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::slam) struct Row<const R: usize> {
    pub(in crate::slam) landmark: usize,
    /// Derivatives over the robot's numbers.
    pub(in crate::slam) by_robot: SVector<f64, R>,
    /// Derivatives over x and y of the landmark.
    pub(in crate::slam) by_landmark: [f64; 2],
    /// The same of a second landmark.
    pub(in crate::slam) other: Option<(usize, [f64; 2])>,
    /// What was measured minus what was expected.
    pub(in crate::slam) residual: f64,
    /// Variance of the measurement, independent of all others.
    pub(in crate::slam) variance: f64,
}

/// What a correction did, with `m` rows: `S = H P H^T + R = L L^T`, `W = P H^T L^-T`. The mean has
/// gone by `W L^-1 r`, the covariance by `-W W^T`.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::slam) struct Correction<const R: usize> {
    /// Rows of L up to their diagonal.
    pub(in crate::slam) factor: Vec<Vec<f64>>,
    /// `L^-1 r`.
    pub(in crate::slam) whitened: Vec<f64>,
    /// The robot's rows of W, one column after the other.
    pub(in crate::slam) robot_gain: Vec<SVector<f64, R>>,
    /// The map's rows of W, one column after the other.
    pub(in crate::slam) map_gain: Vec<f64>,
}

impl<const R: usize> LargeState<R> {
    /// Corrects with all rows together: one pass over the covariance, whose every element is read
    /// and written once for every four rows. Where the index of the robot's heading is given, the
    /// covariance follows the corrected estimate, see [`super::correct`].
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the state, [`Error::LostPositivity`] for any part of the covariance;
    /// the state is then as it was.
    // ANCHOR: correct
    pub(in crate::slam) fn correct(
        &mut self,
        rows: &[Row<R>],
        heading: Option<usize>,
    ) -> Result<Correction<R>> {
        let step = self.step + 1;
        let mut correction = self.project(rows)?;
        correction.solve();
        let mut corrected = Corrected::new(&correction, self);
        if let Some(heading) = heading {
            corrected.turn(&self.robot, &self.map, heading);
        }
        let Corrected { robot, robot_covariance, map, cross, left, right } = corrected;
        crate::innovation::finite("corrected state of the robot", &robot)?;
        check_covariance("covariance of the robot", &robot_covariance)
            .map_err(|_| self.lost("covariance of the robot", step, robot_covariance.as_slice()))?;
        let diagonal = self.triangle.diagonal_minus(&left, &right);
        self.check_diagonal(&diagonal, step)?;
        (self.step, self.robot, self.robot_covariance) = (step, robot, robot_covariance);
        (self.map, self.cross) = (map, cross);
        self.triangle.subtract(&left, &right, diagonal);
        Ok(correction)
    }
    // ANCHOR_END: correct

    /// `P H^T` in place of the gains, the factor of S, and the residuals.
    fn project(&self, rows: &[Row<R>]) -> Result<Correction<R>> {
        let length = self.map.len();
        let mut map_gain = vec![0.0; rows.len() * length];
        let mut robot_gain = Vec::with_capacity(rows.len());
        let [mut x, mut y] = [0, 1].map(|_| vec![0.0; length]);
        let mut gathered = None;
        for (row, column) in rows.iter().zip(map_gain.chunks_exact_mut(length.max(1))) {
            if gathered != Some(row.landmark) {
                self.triangle.columns(row.landmark, &mut x, &mut y);
                gathered = Some(row.landmark);
            }
            for r in 0..R {
                kernel::add_scaled(column, row.by_robot[r], &self.cross[r]);
            }
            kernel::add_scaled(column, row.by_landmark[0], &x);
            kernel::add_scaled(column, row.by_landmark[1], &y);
            let by_landmark = Vector2::from(row.by_landmark);
            let mut gain =
                self.robot_covariance * row.by_robot + self.cross(row.landmark) * by_landmark;
            if let Some((other, by_other)) = row.other {
                self.triangle.columns(other, &mut x, &mut y);
                gathered = None;
                kernel::add_scaled(column, by_other[0], &x);
                kernel::add_scaled(column, by_other[1], &y);
                gain += self.cross(other) * Vector2::from(by_other);
            }
            robot_gain.push(gain);
        }
        let factor = factorize(rows, &robot_gain, &map_gain, length, self.step)?;
        let whitened = rows.iter().map(|row| row.residual).collect();
        Ok(Correction { factor, whitened, robot_gain, map_gain })
    }
}

impl<const R: usize> Correction<R> {
    /// Multiplies by `L^-T`, and the residuals by `L^-1`.
    fn solve(&mut self) {
        let length = self.map_gain.len() / self.factor.len().max(1);
        for (j, row) in self.factor.iter().enumerate() {
            let (before, column) = self.map_gain.split_at_mut(j * length);
            let column = &mut column[..length];
            for (k, factor) in row[..j].iter().enumerate() {
                kernel::add_scaled(column, -factor, &before[k * length..(k + 1) * length]);
                self.robot_gain[j] = self.robot_gain[j] - self.robot_gain[k] * *factor;
                self.whitened[j] -= factor * self.whitened[k];
            }
            let inverse = 1.0 / row[j];
            column.iter_mut().for_each(|value| *value *= inverse);
            self.robot_gain[j] *= inverse;
            self.whitened[j] *= inverse;
        }
    }
}

/// The Cholesky factor of `S = H P H^T + R`, row by row, from `P H^T`.
fn factorize<const R: usize>(
    rows: &[Row<R>],
    robot: &[SVector<f64, R>],
    map: &[f64],
    length: usize,
    step: u64,
) -> Result<Vec<Vec<f64>>> {
    let mut factor: Vec<Vec<f64>> = Vec::with_capacity(rows.len());
    for (i, row) in rows.iter().enumerate() {
        let mut new = Vec::with_capacity(i + 1);
        for j in 0..=i {
            let of = |landmark: usize, by: [f64; 2]| {
                let of_landmark = &map[j * length + 2 * landmark..];
                by[0] * of_landmark[0] + by[1] * of_landmark[1]
            };
            let mut s = row.by_robot.dot(&robot[j]) + of(row.landmark, row.by_landmark);
            s += row.other.map_or(0.0, |(other, by_other)| of(other, by_other));
            let before = factor.get(j).unwrap_or(&new);
            s -= before.iter().zip(&new).take(j).map(|(a, b)| a * b).sum::<f64>();
            if i != j {
                new.push(s / before[j]);
                continue;
            }
            let pivot = s + row.variance;
            if !(pivot > 0.0 && pivot.is_finite()) {
                let found = format!("the pivot {pivot} in row {i}");
                return Err(Error::LostPositivity { what: "innovation covariance", step, found });
            }
            new.push(pivot.sqrt());
        }
        factor.push(new);
    }
    Ok(factor)
}

/// The state after a correction, before it is checked and accepted.
///
/// Its `turn` gives the invariant form of the filter (Barrau and Bonnabel 2015; Zhang et al. 2017).
/// An error of the heading turns the whole map with the robot. The error of a position `q` is
/// therefore counted as `xi = dq - J q dtheta` with `J` the quarter turn; in these coordinates no
/// observation depends on the heading, so that observations can never tell where north is, which is
/// true. The stored covariance is still that of x, y, theta and of the positions: it is transformed
/// from the estimate before a correction to that after it, `P' = A P A^T` with
/// `A = I + v e_theta^T` and `v = J (q' - q)`. The estimate follows the arc of the turn, not its
/// tangent.
pub(super) struct Corrected<const R: usize> {
    pub(super) robot: SVector<f64, R>,
    pub(super) robot_covariance: SMatrix<f64, R, R>,
    pub(super) map: Vec<f64>,
    pub(super) cross: [Vec<f64>; R],
    /// The triangle loses the products of these.
    pub(super) left: Vec<f64>,
    pub(super) right: Vec<f64>,
}

impl<const R: usize> Corrected<R> {
    pub(super) fn new(correction: &Correction<R>, state: &super::LargeState<R>) -> Self {
        let Correction { whitened, robot_gain, map_gain, .. } = correction;
        let gains = || robot_gain.iter().zip(whitened);
        let robot = gains().fold(state.robot, |sum, (w, y)| sum + w * *y);
        let gone: SMatrix<f64, R, R> = robot_gain.iter().map(|w| w * w.transpose()).sum();
        let (mut map, mut cross) = (state.map.clone(), state.cross.clone());
        let columns = map_gain.chunks_exact(map.len().max(1));
        for (column, (robot, y)) in columns.zip(gains()) {
            super::kernel::add_scaled(&mut map, *y, column);
            for r in 0..R {
                super::kernel::add_scaled(&mut cross[r], -robot[r], column);
            }
        }
        Corrected {
            robot,
            robot_covariance: state.robot_covariance - gone,
            map,
            cross,
            left: map_gain.clone(),
            right: map_gain.clone(),
        }
    }

    /// Transforms the covariance to the corrected estimate. The robot's numbers begin with its
    /// position; `heading` is the index of its heading.
    pub(super) fn turn(&mut self, before: &SVector<f64, R>, old: &[f64], heading: usize) {
        let angle = self.robot[heading] - before[heading];
        let mut robot_way = SVector::<f64, R>::zeros();
        let way = bend(Vector2::new(self.robot[0] - before[0], self.robot[1] - before[1]), angle);
        (self.robot[0], self.robot[1]) = (before[0] + way.x, before[1] + way.y);
        (robot_way[0], robot_way[1]) = (-way.y, way.x);
        let mut ways = Vec::with_capacity(old.len());
        for (new, old) in self.map.chunks_exact_mut(2).zip(old.chunks_exact(2)) {
            let way = bend(Vector2::new(new[0] - old[0], new[1] - old[1]), angle);
            (new[0], new[1]) = (old[0] + way.x, old[1] + way.y);
            ways.extend([-way.y, way.x]);
        }
        let variance = self.robot_covariance[(heading, heading)];
        let column: SVector<f64, R> = self.robot_covariance.column(heading).into();
        // d = P e_theta + v P_theta theta / 2, so that P' = P + v d^T + d v^T.
        let with_heading = self.cross[heading].iter().zip(&ways);
        let half: Vec<f64> = with_heading.map(|(c, v)| c + 0.5 * variance * v).collect();
        let robot_half = column + robot_way * (0.5 * variance);
        for r in 0..R {
            let (v, d) = (robot_way[r], robot_half[r]);
            let terms = ways.iter().zip(&half);
            for (cross, (way, half)) in self.cross[r].iter_mut().zip(terms) {
                *cross += v * half + d * way;
            }
        }
        let turned = robot_way * robot_half.transpose();
        self.robot_covariance += turned + turned.transpose();
        self.left.extend_from_slice(&ways);
        self.left.extend_from_slice(&half);
        self.right.extend(half.iter().chain(&ways).map(|value| -value));
    }
}

/// `J q`: by a quarter turn to the left.
fn quarter(q: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-q.y, q.x)
}

/// The chord of an arc that begins along `way` and turns by `angle` \[rad\] on it.
fn bend(way: Vector2<f64>, angle: f64) -> Vector2<f64> {
    let (along, across) = if angle.abs() < 1e-4 {
        (1.0 - angle * angle / 6.0, 0.5 * angle)
    } else {
        (angle.sin() / angle, (1.0 - angle.cos()) / angle)
    };
    way * along + quarter(way) * across
}
