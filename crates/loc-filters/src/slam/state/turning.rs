//! What a correction of the heading does to the map: the invariant form of the filter.
//!
//! Whatever a robot learns about its heading, it learns about the direction of the whole map: the
//! two are wrong together. So the error of a position `q` is counted from where it goes as the
//! heading turns, `xi = dq - J q dtheta` with `J` the quarter turn, and in these coordinates no
//! observation depends on the heading (Barrau and Bonnabel 2015; Zhang et al. 2017). LandmarkObservations can then
//! never tell where north is, as is true. The covariance kept here is that of x, y, theta and of
//! the positions all the same: it is carried from the estimate before a correction to that after
//! it, `P' = A P A^T` with `A = I + v e_theta^T` and `v = J (q' - q)`. The estimate follows the arc
//! that belongs to the turn, not its tangent.

use super::correct::Correction;
use nalgebra::{SMatrix, SVector, Vector2};

/// State and cross covariances after a correction, before they are stored.
pub(super) struct Corrected<const R: usize> {
    pub(super) robot: SVector<f64, R>,
    pub(super) robot_covariance: SMatrix<f64, R, R>,
    pub(super) map: Vec<f64>,
    pub(super) cross: [Vec<f64>; R],
    /// The triangle loses the products of these.
    pub(super) left: Vec<f64>,
    pub(super) right: Vec<f64>,
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

impl<const R: usize> Corrected<R> {
    /// Carries the covariance to the corrected estimate. The robot's numbers begin with its
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
}
