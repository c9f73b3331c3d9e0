//! A submap: a part of the map that is corrected on behalf of the whole (Guivant and Nebot 2001).
//!
//! While the robot stays among a few landmarks, its motions and observations update those alone. Their
//! effect on the rest of the map is linear in the covariance between submap and rest at the time when
//! the submap was made. The submap has a state of its own, and three small matrices accumulate the
//! pending updates of the rest:
//!
//! * `phi`: the covariance of the submap with the rest is `phi` times the initial one,
//! * `psi`: the covariance of the rest has lost `U^T psi U`, and
//! * `theta`: its mean has moved by `U^T theta`,
//!
//! with U the initial covariance of the submap with the rest. The cost of a step depends on the size
//! of the submap only; the pending updates are applied when the robot leaves.

use super::correct::{Correction, Row};
use super::{LargeState, Triangle, kernel};
use crate::Result;
use nalgebra::{DMatrix, Matrix2, Point2, SMatrix, SVector, Vector2};

/// Robot and map. Landmarks are indexed through the whole map, active or not; only active ones can be
/// corrected.
#[derive(Debug, Clone)]
pub(in crate::slam) struct MapState<const R: usize> {
    whole: LargeState<R>,
    part: Option<Submap<R>>,
}

/// Index of a landmark in the active state or in the whole one.
enum Location {
    Active(usize),
    Outside(usize),
}

impl<const R: usize> MapState<R> {
    pub(in crate::slam) fn new(whole: LargeState<R>) -> Self {
        MapState { whole, part: None }
    }

    /// The state that motions and corrections act on.
    fn active_state(&self) -> &LargeState<R> {
        self.part.as_ref().map_or(&self.whole, |part| &part.state)
    }

    /// The active state, read for the robot.
    pub(in crate::slam) fn robot_state(&self) -> &LargeState<R> {
        self.active_state()
    }

    pub(in crate::slam) fn robot(&self) -> &SVector<f64, R> {
        self.active_state().robot()
    }

    pub(in crate::slam) fn robot_mut(&mut self) -> &mut SVector<f64, R> {
        match &mut self.part {
            Some(part) => part.state.robot_mut(),
            None => self.whole.robot_mut(),
        }
    }

    pub(in crate::slam) fn robot_covariance(&self) -> &SMatrix<f64, R, R> {
        self.active_state().robot_covariance()
    }

    /// Number of landmarks.
    pub(in crate::slam) fn len(&self) -> usize {
        self.whole.len() + self.part.as_ref().map_or(0, |p| p.state.len() - p.members.len())
    }

    fn at(&self, landmark: usize) -> Location {
        let Some(part) = &self.part else { return Location::Active(landmark) };
        if landmark >= self.whole.len() {
            return Location::Active(part.members.len() + landmark - self.whole.len());
        }
        part.members.binary_search(&landmark).map_or(Location::Outside(landmark), Location::Active)
    }

    pub(in crate::slam) fn is_active(&self, landmark: usize) -> bool {
        matches!(self.at(landmark), Location::Active(_))
    }

    /// The active landmarks, in ascending order.
    pub(in crate::slam) fn active(&self) -> Vec<usize> {
        match &self.part {
            None => (0..self.whole.len()).collect(),
            Some(part) => {
                part.members.iter().copied().chain(self.whole.len()..self.len()).collect()
            }
        }
    }

    /// Mean and covariance of any landmark.
    pub(in crate::slam) fn landmark(&self, landmark: usize) -> (Point2<f64>, Matrix2<f64>) {
        match (self.at(landmark), &self.part) {
            (Location::Outside(landmark), Some(part)) => part.outside(&self.whole, landmark),
            (Location::Active(k) | Location::Outside(k), _) => {
                (self.active_state().position(k), self.active_state().block(k, k))
            }
        }
    }

    /// Index in the active state; an observed landmark is always there.
    fn index(&self, landmark: usize) -> usize {
        match self.at(landmark) {
            Location::Active(k) | Location::Outside(k) => k,
        }
    }

    /// Position of an active landmark \[m\].
    pub(in crate::slam) fn position(&self, landmark: usize) -> Point2<f64> {
        self.active_state().position(self.index(landmark))
    }

    /// Covariance of two active landmarks.
    pub(in crate::slam) fn block(&self, i: usize, j: usize) -> Matrix2<f64> {
        self.active_state().block(self.index(i), self.index(j))
    }

    /// Covariance of the robot and an active landmark, R x 2.
    pub(in crate::slam) fn cross(&self, landmark: usize) -> SMatrix<f64, R, 2> {
        self.active_state().cross(self.index(landmark))
    }

    pub(in crate::slam) fn propagate(
        &mut self,
        moved: SVector<f64, R>,
        f: &SMatrix<f64, R, R>,
        noise: &SMatrix<f64, R, R>,
    ) -> Result<()> {
        match &mut self.part {
            Some(part) => part.propagate(moved, f, noise),
            None => self.whole.propagate(moved, f, noise),
        }
    }

    pub(in crate::slam) fn push(
        &mut self,
        position: Point2<f64>,
        by_robot: &SMatrix<f64, 2, R>,
        noise: &Matrix2<f64>,
    ) -> Result<()> {
        match &mut self.part {
            Some(part) => part.push(position, by_robot, noise),
            None => self.whole.push(position, by_robot, noise),
        }
    }

    /// Corrects by rows of active landmarks; `heading` as for [`LargeState::correct`], used where all of
    /// the map is active.
    pub(in crate::slam) fn correct(
        &mut self,
        rows: &[Row<R>],
        heading: Option<usize>,
    ) -> Result<()> {
        let own = |row: &Row<R>| Row {
            landmark: self.index(row.landmark),
            other: row.other.map(|(other, by_other)| (self.index(other), by_other)),
            ..*row
        };
        let rows: Vec<Row<R>> = rows.iter().map(own).collect();
        match &mut self.part {
            Some(part) => part.correct(&rows),
            None => self.whole.correct(&rows, heading).map(|_| ()),
        }
    }

    /// Writes the submap back into the whole state, so that all landmarks are active.
    pub(in crate::slam) fn write_back(&mut self) -> Result<()> {
        self.part.take().map_or(Ok(()), |part| part.write_back(&mut self.whole))
    }

    /// Makes a submap of landmarks, in ascending order.
    pub(in crate::slam) fn take(&mut self, members: Vec<usize>) -> Result<()> {
        self.write_back()?;
        self.part = Some(Submap::new(&self.whole, members));
        Ok(())
    }

    /// Keeps the landmarks for which `keep` holds.
    pub(in crate::slam) fn retain(&mut self, keep: &[bool]) -> Result<()> {
        self.write_back()?;
        self.whole.retain(keep);
        Ok(())
    }

    pub(in crate::slam) fn checked_covariance(&self) -> Result<DMatrix<f64>> {
        let mut written = self.clone();
        written.write_back()?;
        written.whole.checked_covariance()
    }
}

/// The active part of the map, with the pending updates of the rest.
#[derive(Debug, Clone)]
pub(super) struct Submap<const R: usize> {
    /// Landmarks of the whole map that belong to the submap, in ascending order. Those that were
    /// initialized later follow them in the submap's state.
    pub(super) members: Vec<usize>,
    pub(super) state: LargeState<R>,
    /// For each state of the submap a row of `width`.
    phi: Vec<f64>,
    /// `width` rows of `width`.
    psi: Vec<f64>,
    theta: Vec<f64>,
    /// Number of states of the submap when it was made.
    width: usize,
}

impl<const R: usize> Submap<R> {
    pub(super) fn new(whole: &LargeState<R>, members: Vec<usize>) -> Self {
        let width = R + 2 * members.len();
        let mut phi = vec![0.0; width * width];
        phi.iter_mut().step_by(width + 1).for_each(|one| *one = 1.0);
        Submap {
            state: whole.part(&members),
            members,
            phi,
            psi: vec![0.0; width * width],
            theta: vec![0.0; width],
            width,
        }
    }

    pub(super) fn propagate(
        &mut self,
        moved: SVector<f64, R>,
        f: &SMatrix<f64, R, R>,
        noise: &SMatrix<f64, R, R>,
    ) -> Result<()> {
        self.state.propagate(moved, f, noise)?;
        for column in 0..self.width {
            let at = |r: usize| r * self.width + column;
            let before = SVector::<f64, R>::from_fn(|r, _| self.phi[at(r)]);
            let after = f * before;
            (0..R).for_each(|r| self.phi[at(r)] = after[r]);
        }
        Ok(())
    }

    pub(super) fn push(
        &mut self,
        position: Point2<f64>,
        by_robot: &SMatrix<f64, 2, R>,
        noise: &Matrix2<f64>,
    ) -> Result<()> {
        self.state.push(position, by_robot, noise)?;
        for row in by_robot.row_iter() {
            let mut new = vec![0.0; self.width];
            for (factor, robot) in row.iter().zip(self.phi.chunks_exact(self.width)) {
                kernel::add_scaled(&mut new, *factor, robot);
            }
            self.phi.extend(new);
        }
        Ok(())
    }

    /// Corrects the submap by rows of its own landmarks.
    pub(super) fn correct(&mut self, rows: &[Row<R>]) -> Result<()> {
        let correction = self.state.correct(rows, None)?;
        let pending = self.pending(rows, &correction);
        let Correction { whitened, robot_gain, map_gain, .. } = &correction;
        let length = map_gain.len() / rows.len().max(1);
        for (k, v) in pending.chunks_exact(self.width).enumerate() {
            let map = &map_gain[k * length..(k + 1) * length];
            let gains = robot_gain[k].iter().chain(map);
            for (row, gain) in self.phi.chunks_exact_mut(self.width).zip(gains) {
                kernel::add_scaled(row, -gain, v);
            }
            for (row, factor) in self.psi.chunks_exact_mut(self.width).zip(v) {
                kernel::add_scaled(row, *factor, v);
            }
            kernel::add_scaled(&mut self.theta, whitened[k], v);
        }
        Ok(())
    }

    /// `V = L^-1 H phi`, one row of `width` after the other.
    fn pending(&self, rows: &[Row<R>], correction: &Correction<R>) -> Vec<f64> {
        let mut pending: Vec<f64> = Vec::with_capacity(rows.len() * self.width);
        for (row, factor) in rows.iter().zip(&correction.factor) {
            let mut v = vec![0.0; self.width];
            let landmark = R + 2 * row.landmark;
            let robot = row.by_robot.iter().copied().enumerate();
            let other = row.other.into_iter();
            let other = other.flat_map(|(other, by_other)| (R + 2 * other..).zip(by_other));
            let terms = robot.chain((landmark..).zip(row.by_landmark)).chain(other);
            for (number, derivative) in terms {
                let phi = &self.phi[number * self.width..(number + 1) * self.width];
                kernel::add_scaled(&mut v, derivative, phi);
            }
            let (last, before) = (factor.last().copied().unwrap_or(1.0), pending.iter().as_slice());
            for (known, factor) in before.chunks_exact(self.width).zip(factor) {
                kernel::add_scaled(&mut v, -factor, known);
            }
            v.iter_mut().for_each(|value| *value /= last);
            pending.extend(v);
        }
        pending
    }

    /// The covariance of a landmark of the rest with the submap: its two columns of U.
    fn columns(&self, whole: &LargeState<R>, landmark: usize) -> DMatrix<f64> {
        let mut columns = DMatrix::zeros(self.width, 2);
        columns.fixed_view_mut::<R, 2>(0, 0).copy_from(&whole.cross(landmark));
        for (k, &member) in self.members.iter().enumerate() {
            let block = whole.block(member, landmark);
            columns.fixed_view_mut::<2, 2>(R + 2 * k, 0).copy_from(&block);
        }
        columns
    }

    /// Mean and covariance of a landmark of the rest, as they are now.
    pub(super) fn outside(
        &self,
        whole: &LargeState<R>,
        landmark: usize,
    ) -> (Point2<f64>, Matrix2<f64>) {
        let columns = self.columns(whole, landmark);
        let moved = columns.tr_mul(&DMatrix::from_column_slice(self.width, 1, &self.theta));
        let psi = DMatrix::from_column_slice(self.width, self.width, &self.psi);
        let lost = columns.tr_mul(&(psi * &columns));
        let lost = Matrix2::new(lost[(0, 0)], lost[(1, 0)], lost[(1, 0)], lost[(1, 1)]);
        let position = whole.position(landmark) + Vector2::new(moved[0], moved[1]);
        (position, whole.block(landmark, landmark) - lost)
    }

    /// Applies the pending updates: the whole state becomes what it would be without a submap.
    pub(super) fn write_back(self, whole: &mut LargeState<R>) -> Result<()> {
        let length = whole.map.len();
        let u = self.all_columns(whole);
        let product = |rows: &[f64]| {
            let mut product = vec![0.0; rows.len() / self.width * length];
            let pairs = product.chunks_exact_mut(length.max(1)).zip(rows.chunks_exact(self.width));
            for (sum, row) in pairs {
                for (factor, u) in row.iter().zip(u.chunks_exact(length)) {
                    kernel::add_scaled(sum, *factor, u);
                }
            }
            product
        };
        let psi_u = product(&self.psi);
        let mut diagonal = whole.triangle.diagonal_minus(&psi_u, &u);
        for (k, &member) in self.members.iter().enumerate() {
            let block = self.state.block(k, k);
            diagonal[member] = [block.m11, block.m21, block.m22];
        }
        let step = self.state.step;
        whole.check_diagonal(&diagonal, step)?;
        for (factor, u) in self.theta.iter().zip(u.chunks_exact(length.max(1))) {
            kernel::add_scaled(&mut whole.map, *factor, u);
        }
        whole.triangle.subtract(&psi_u, &u, diagonal);
        whole.step = step;
        let with_rest = product(&self.phi);
        self.write_members(whole, &with_rest, length);
        self.write_initialized(whole, &with_rest, length);
        Ok(())
    }

    /// U: for each initial state of the submap its covariances with all landmarks of the whole.
    fn all_columns(&self, whole: &LargeState<R>) -> Vec<f64> {
        let length = whole.map.len();
        let mut u = vec![0.0; self.width * length];
        let (robot, members) = u.split_at_mut(R * length);
        for (row, cross) in robot.chunks_exact_mut(length.max(1)).zip(&whole.cross) {
            row.copy_from_slice(cross);
        }
        for (pair, &member) in members.chunks_exact_mut(2 * length.max(1)).zip(&self.members) {
            let (x, y) = pair.split_at_mut(length);
            whole.triangle.columns(member, x, y);
        }
        u
    }

    /// The robot, and the landmarks of the submap that the whole had before.
    fn write_members(&self, whole: &mut LargeState<R>, with_rest: &[f64], length: usize) {
        let part = &self.state;
        whole.robot = part.robot;
        whole.robot_covariance = part.robot_covariance;
        for (r, row) in with_rest.chunks_exact(length.max(1)).take(R).enumerate() {
            whole.cross[r].copy_from_slice(row);
        }
        let mut is_member = vec![false; length / 2];
        self.members.iter().for_each(|&member| is_member[member] = true);
        for (k, &member) in self.members.iter().enumerate() {
            let row = |a: usize| &with_rest[(R + 2 * k + a) * length..][..length];
            let (x, y) = (row(0), row(1));
            for other in (0..length / 2).filter(|&other| !is_member[other]) {
                let at = 2 * other;
                let block = Matrix2::new(x[at], x[at + 1], y[at], y[at + 1]);
                whole.triangle.set_block(member, other, &block);
            }
            for (l, &other) in self.members.iter().enumerate().take(k) {
                whole.triangle.set_block(member, other, &part.block(k, l));
            }
            let place = 2 * member..2 * member + 2;
            whole.map[place.clone()].copy_from_slice(&part.map[2 * k..2 * k + 2]);
            for r in 0..R {
                let cross = &part.cross[r][2 * k..2 * k + 2];
                whole.cross[r][place.clone()].copy_from_slice(cross);
            }
        }
    }

    /// The landmarks that were initialized in the submap.
    fn write_initialized(&self, whole: &mut LargeState<R>, with_rest: &[f64], length: usize) {
        let part = &self.state;
        for k in self.members.len()..part.len() {
            let row = |a: usize| with_rest[(R + 2 * k + a) * length..][..length].to_vec();
            let (mut x, mut y) = (row(0), row(1));
            let mut put = |at: usize, block: Matrix2<f64>| {
                x.resize(x.len().max(at + 2), 0.0);
                y.resize(y.len().max(at + 2), 0.0);
                x[at..at + 2].copy_from_slice(&[block.m11, block.m12]);
                y[at..at + 2].copy_from_slice(&[block.m21, block.m22]);
            };
            for (l, &member) in self.members.iter().enumerate() {
                put(2 * member, part.block(k, l));
            }
            for l in self.members.len()..k {
                put(length + 2 * (l - self.members.len()), part.block(k, l));
            }
            whole.triangle.push(&x, &y, &part.block(k, k));
            whole.map.extend_from_slice(&part.map[2 * k..2 * k + 2]);
            for r in 0..R {
                whole.cross[r].extend_from_slice(&part.cross[r][2 * k..2 * k + 2]);
            }
        }
    }
}

impl<const R: usize> LargeState<R> {
    /// The robot with some of the landmarks.
    fn part(&self, members: &[usize]) -> LargeState<R> {
        let mut part = LargeState {
            robot: self.robot,
            robot_covariance: self.robot_covariance,
            map: Vec::new(),
            cross: std::array::from_fn(|_| Vec::new()),
            triangle: Triangle::default(),
            step: self.step,
        };
        for (count, &member) in members.iter().enumerate() {
            let blocks = || members[..count].iter().map(|&other| self.block(member, other));
            let x: Vec<f64> = blocks().flat_map(|block| [block.m11, block.m12]).collect();
            let y: Vec<f64> = blocks().flat_map(|block| [block.m21, block.m22]).collect();
            part.triangle.push(&x, &y, &self.block(member, member));
            part.map.extend_from_slice(&self.map[2 * member..2 * member + 2]);
            for r in 0..R {
                part.cross[r].extend_from_slice(&self.cross[r][2 * member..2 * member + 2]);
            }
        }
        part
    }
}
