//! The state of SLAM: a robot of `R` numbers and any number of landmarks in the plane.
//!
//! The covariance has three parts, after how they are used: the robot's own block, its rows with
//! the map, which motion touches, and the map's triangle, which only corrections touch.

mod correct;
pub(super) mod kernel;
mod submap;

pub(super) use correct::Row;
pub(super) use submap::MapState;

use crate::{Error, Gate, Innovation, Result};
use faer::{Mat, Side};
use kernel::SubtractProduct;
use loc_core::gaussian::check_covariance;
use nalgebra::{DMatrix, Matrix2, Point2, SMatrix, SVector};
use std::sync::Arc;

/// Mean and covariance of robot and map.
#[derive(Debug, Clone)]
pub(super) struct LargeState<const R: usize> {
    robot: SVector<f64, R>,
    robot_covariance: SMatrix<f64, R, R>,
    /// x and y of one landmark after the other.
    map: Vec<f64>,
    /// Of each of the robot's numbers its covariances with the map.
    cross: [Vec<f64>; R],
    triangle: Triangle,
    /// Motions and corrections so far.
    step: u64,
}

impl<const R: usize> LargeState<R> {
    /// A robot without a map.
    pub(super) fn new(robot: SVector<f64, R>, covariance: SMatrix<f64, R, R>) -> Result<Self> {
        crate::innovation::finite("state of the robot", &robot)?;
        check_covariance("covariance of the robot", &covariance)?;
        Ok(LargeState {
            robot,
            robot_covariance: covariance,
            map: Vec::new(),
            cross: std::array::from_fn(|_| Vec::new()),
            triangle: Triangle::default(),
            step: 0,
        })
    }

    /// Number of landmarks.
    pub(super) fn len(&self) -> usize {
        self.triangle.len()
    }

    pub(super) fn step(&self) -> u64 {
        self.step
    }

    pub(super) fn robot(&self) -> &SVector<f64, R> {
        &self.robot
    }

    pub(super) fn robot_mut(&mut self) -> &mut SVector<f64, R> {
        &mut self.robot
    }

    pub(super) fn robot_covariance(&self) -> &SMatrix<f64, R, R> {
        &self.robot_covariance
    }

    pub(super) fn position(&self, landmark: usize) -> Point2<f64> {
        Point2::new(self.map[2 * landmark], self.map[2 * landmark + 1])
    }

    /// Covariance of two landmarks, or of one.
    pub(super) fn block(&self, i: usize, j: usize) -> Matrix2<f64> {
        self.triangle.block(i, j)
    }

    /// Covariance of the robot and a landmark, R x 2.
    pub(super) fn cross(&self, landmark: usize) -> SMatrix<f64, R, 2> {
        SMatrix::from_fn(|r, c| self.cross[r][2 * landmark + c])
    }

    /// Moves the robot: `P_rr' = F P_rr F^T + Q`, `P_rm' = F P_rm`.
    pub(super) fn propagate(
        &mut self,
        moved: SVector<f64, R>,
        f: &SMatrix<f64, R, R>,
        noise: &SMatrix<f64, R, R>,
    ) -> Result<()> {
        crate::innovation::finite("predicted state of the robot", &moved)?;
        let covariance = f * self.robot_covariance * f.transpose() + noise;
        if !covariance.iter().all(|value| value.is_finite()) {
            return Err(self.lost("covariance of the robot", self.step + 1, covariance.as_slice()));
        }
        self.step += 1;
        self.robot = moved;
        self.robot_covariance = 0.5 * (covariance + covariance.transpose());
        for column in 0..self.map.len() {
            let before = SVector::<f64, R>::from_fn(|r, _| self.cross[r][column]);
            let after = f * before;
            for r in 0..R {
                self.cross[r][column] = after[r];
            }
        }
        Ok(())
    }

    /// Appends a landmark at `position`, which follows from the robot by `by_robot`, 2 x R, with
    /// independent noise of its own.
    pub(super) fn push(
        &mut self,
        position: Point2<f64>,
        by_robot: &SMatrix<f64, 2, R>,
        noise: &Matrix2<f64>,
    ) -> Result<()> {
        crate::innovation::finite("position of a new landmark", &position.coords)?;
        let with_robot = by_robot * self.robot_covariance;
        let own = with_robot * by_robot.transpose() + noise;
        check_covariance("covariance of a new landmark", &own)?;
        let [mut x, mut y] = [0, 1].map(|_| vec![0.0; self.map.len()]);
        for r in 0..R {
            kernel::add_scaled(&mut x, by_robot[(0, r)], &self.cross[r]);
            kernel::add_scaled(&mut y, by_robot[(1, r)], &self.cross[r]);
            self.cross[r].extend([with_robot[(0, r)], with_robot[(1, r)]]);
        }
        self.triangle.push(&x, &y, &own);
        self.map.extend([position.x, position.y]);
        Ok(())
    }

    /// Keeps the landmarks for which `keep` holds; the belief about the others is as it was.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        self.triangle.retain(keep);
        for vector in self.cross.iter_mut().chain([&mut self.map]) {
            let mut element = 0..;
            vector.retain(|_| element.next().is_some_and(|k: usize| keep[k / 2]));
        }
    }

    /// The whole covariance, (R + 2 n) x (R + 2 n), the robot first.
    pub(super) fn covariance(&self) -> DMatrix<f64> {
        let size = R + self.map.len();
        let mut whole = DMatrix::zeros(size, size);
        whole.fixed_view_mut::<R, R>(0, 0).copy_from(&self.robot_covariance);
        for i in 0..self.len() {
            let cross = self.cross(i);
            whole.fixed_view_mut::<R, 2>(0, R + 2 * i).copy_from(&cross);
            whole.fixed_view_mut::<2, R>(R + 2 * i, 0).copy_from(&cross.transpose());
            for j in 0..self.len() {
                whole.fixed_view_mut::<2, 2>(R + 2 * i, R + 2 * j).copy_from(&self.block(i, j));
            }
        }
        whole
    }

    /// The same, checked as [`check_covariance`] does it: at the scale of each variance, up to
    /// rounding.
    pub(super) fn checked_covariance(&self) -> Result<DMatrix<f64>> {
        let whole = self.covariance();
        let scales = whole.diagonal().map(|variance| variance.max(f64::MIN_POSITIVE).sqrt());
        let size = whole.nrows();
        let correlations = Mat::from_fn(size, size, |i, j| {
            if i == j { 1.0 + 1e-9 } else { whole[(i, j)] / (scales[i] * scales[j]) }
        });
        if whole.diagonal().iter().all(|variance| *variance >= 0.0)
            && correlations.llt(Side::Lower).is_ok()
        {
            return Ok(whole);
        }
        let diagonal: Vec<f64> = whole.diagonal().iter().copied().collect();
        Err(self.lost("whole covariance, with the diagonal", self.step, &diagonal))
    }

    /// Tests a residual against its covariance. The noise of a sensor is positive, so that a covariance
    /// that is not positive definite is an error of the state.
    pub(super) fn innovation<const M: usize>(
        &self,
        residual: SVector<f64, M>,
        covariance: SMatrix<f64, M, M>,
        gate: &Gate,
    ) -> Result<Innovation<M>> {
        match Innovation::new(residual, covariance, gate) {
            Ok((innovation, _)) => Ok(innovation),
            Err(error) => Err(self.state_error(error)),
        }
    }

    /// An error of an innovation's covariance as one of the state.
    pub(super) fn state_error(&self, error: impl Into<Error>) -> Error {
        match error.into() {
            Error::Core(loc_core::Error::NotACovariance { what, found, .. }) => {
                Error::LostPositivity { what, step: self.step, found }
            }
            other => other,
        }
    }

    /// Refuses blocks (xx, xy, yy) of the diagonal that are not positive.
    fn check_diagonal(&self, diagonal: &[[f64; 3]], step: u64) -> Result<()> {
        match diagonal.iter().find(|block| !is_positive(block)) {
            None => Ok(()),
            Some(block) => Err(self.lost("covariance (xx, xy, yy) of a landmark", step, block)),
        }
    }

    fn lost(&self, what: &'static str, step: u64, found: &[f64]) -> Error {
        Error::LostPositivity { what, step, found: format!("{found:?}") }
    }
}

/// Whether a block (xx, xy, yy) is positive semi-definite, up to rounding.
fn is_positive(&[xx, xy, yy]: &[f64; 3]) -> bool {
    xx >= 0.0 && yy >= 0.0 && (xy * xy) <= xx * yy * (1.0 + 1e-9) && xy.is_finite()
}

/// A symmetric matrix of 2 x 2 blocks, one row and column of blocks for each landmark.
///
/// New landmarks are appended at the end of both stores, so nothing moves when the map grows. The
/// large store is copied when it is written to while another copy of the filter still reads it.
#[derive(Debug, Clone, Default)]
struct Triangle {
    /// Of each block on the diagonal the elements xx, xy, yy.
    diagonal: Vec<[f64; 3]>,
    /// Below it, for block row j two rows of length 2 j, one after the other.
    below: Arc<Vec<f64>>,
}

/// Where the rows of block row j begin.
fn start(j: usize) -> usize {
    2 * j * j.saturating_sub(1)
}

impl Triangle {
    /// Number of landmarks.
    fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// The block of landmarks `i` and `j`.
    fn block(&self, i: usize, j: usize) -> Matrix2<f64> {
        if i == j {
            let [xx, xy, yy] = self.diagonal[i];
            return Matrix2::new(xx, xy, xy, yy);
        }
        if i < j {
            return self.block(j, i).transpose();
        }
        let first = start(i) + 2 * j;
        let (x, y) = (&self.below[first..first + 2], &self.below[first + 2 * i..]);
        Matrix2::new(x[0], x[1], y[0], y[1])
    }

    /// Sets the block of landmarks `i` and `j`, and with it that of `j` and `i`.
    fn set_block(&mut self, i: usize, j: usize, block: &Matrix2<f64>) {
        if i == j {
            self.diagonal[i] = [block.m11, block.m21, block.m22];
        } else if i < j {
            self.set_block(j, i, &block.transpose());
        } else {
            let below = Arc::make_mut(&mut self.below);
            let first = start(i) + 2 * j;
            below[first..first + 2].copy_from_slice(&[block.m11, block.m12]);
            below[first + 2 * i..first + 2 * i + 2].copy_from_slice(&[block.m21, block.m22]);
        }
    }

    /// The two columns of landmark `j`, into vectors of two elements per landmark.
    fn columns(&self, j: usize, x: &mut [f64], y: &mut [f64]) {
        let row = &self.below[start(j)..start(j) + 4 * j];
        x[..2 * j].copy_from_slice(&row[..2 * j]);
        y[..2 * j].copy_from_slice(&row[2 * j..]);
        let [xx, xy, yy] = self.diagonal[j];
        x[2 * j..2 * j + 2].copy_from_slice(&[xx, xy]);
        y[2 * j..2 * j + 2].copy_from_slice(&[xy, yy]);
        for i in j + 1..self.len() {
            let first = start(i) + 2 * j;
            let second = first + 2 * i;
            (x[2 * i], y[2 * i]) = (self.below[first], self.below[first + 1]);
            (x[2 * i + 1], y[2 * i + 1]) = (self.below[second], self.below[second + 1]);
        }
    }

    /// Appends a landmark: its rows with all landmarks before it, and its own block.
    fn push(&mut self, x: &[f64], y: &[f64], own: &Matrix2<f64>) {
        let below = Arc::make_mut(&mut self.below);
        below.extend_from_slice(x);
        below.extend_from_slice(y);
        self.diagonal.push([own.m11, own.m21, own.m22]);
    }

    /// Keeps the landmarks for which `keep` holds.
    fn retain(&mut self, keep: &[bool]) {
        let kept: Vec<usize> = (0..self.len()).filter(|&i| keep[i]).collect();
        let mut below = Vec::with_capacity(start(kept.len()));
        for (count, &i) in kept.iter().enumerate() {
            for row in self.below[start(i)..start(i) + 4 * i].chunks_exact(2 * i.max(1)) {
                let blocks = kept[..count].iter();
                below.extend(blocks.flat_map(|&j| [row[2 * j], row[2 * j + 1]]));
            }
        }
        self.diagonal = kept.iter().map(|&i| self.diagonal[i]).collect();
        self.below = Arc::new(below);
    }

    /// The diagonal blocks after subtracting `sum_k left_k right_k^T`, symmetric by assumption.
    fn diagonal_minus(&self, left: &[f64], right: &[f64]) -> Vec<[f64; 3]> {
        let length = 2 * self.len();
        let mut diagonal = self.diagonal.clone();
        if length == 0 {
            return diagonal;
        }
        for (left, right) in left.chunks_exact(length).zip(right.chunks_exact(length)) {
            for (block, k) in diagonal.iter_mut().zip((0..).step_by(2)) {
                block[0] -= left[k] * right[k];
                block[1] -= left[k + 1] * right[k];
                block[2] -= left[k + 1] * right[k + 1];
            }
        }
        diagonal
    }

    /// Subtracts `sum_k left_k right_k^T` below the diagonal, whose new blocks are given.
    fn subtract(&mut self, left: &[f64], right: &[f64], diagonal: Vec<[f64; 3]>) {
        let length = 2 * self.len();
        self.diagonal = diagonal;
        let below = Arc::make_mut(&mut self.below).as_mut_slice();
        SubtractProduct { below, left, right, length }.run();
    }
}
