//! The state as the filters see it: whole, or with a part of the map in hand.

use super::LargeState;
use super::correct::Row;
use super::submap::Submap;
use crate::Result;
use nalgebra::{DMatrix, Matrix2, Point2, SMatrix, SVector};

/// A robot with its map. Landmarks are counted through the whole map, whether they are in hand or
/// not; those in hand are the ones that can be corrected.
#[derive(Debug, Clone)]
pub(in crate::slam) struct MapState<const R: usize> {
    whole: LargeState<R>,
    part: Option<Submap<R>>,
}

/// The place of a landmark.
enum At {
    InHand(usize),
    Outside(usize),
}

impl<const R: usize> MapState<R> {
    pub(in crate::slam) fn new(whole: LargeState<R>) -> Self {
        MapState { whole, part: None }
    }

    /// The state that motions and corrections act on.
    fn hand(&self) -> &LargeState<R> {
        self.part.as_ref().map_or(&self.whole, |part| &part.state)
    }

    /// The state in hand, for what concerns the robot.
    pub(in crate::slam) fn robot_state(&self) -> &LargeState<R> {
        self.hand()
    }

    pub(in crate::slam) fn robot(&self) -> &SVector<f64, R> {
        self.hand().robot()
    }

    pub(in crate::slam) fn robot_mut(&mut self) -> &mut SVector<f64, R> {
        match &mut self.part {
            Some(part) => part.state.robot_mut(),
            None => self.whole.robot_mut(),
        }
    }

    pub(in crate::slam) fn robot_covariance(&self) -> &SMatrix<f64, R, R> {
        self.hand().robot_covariance()
    }

    /// Number of landmarks.
    pub(in crate::slam) fn len(&self) -> usize {
        self.whole.len() + self.part.as_ref().map_or(0, |p| p.state.len() - p.members.len())
    }

    fn at(&self, landmark: usize) -> At {
        let Some(part) = &self.part else { return At::InHand(landmark) };
        if landmark >= self.whole.len() {
            return At::InHand(part.members.len() + landmark - self.whole.len());
        }
        part.members.binary_search(&landmark).map_or(At::Outside(landmark), At::InHand)
    }

    pub(in crate::slam) fn is_in_hand(&self, landmark: usize) -> bool {
        matches!(self.at(landmark), At::InHand(_))
    }

    /// The landmarks in hand, in ascending order.
    pub(in crate::slam) fn in_hand(&self) -> Vec<usize> {
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
            (At::Outside(landmark), Some(part)) => part.outside(&self.whole, landmark),
            (At::InHand(k) | At::Outside(k), _) => {
                (self.hand().position(k), self.hand().block(k, k))
            }
        }
    }

    /// Index in the state in hand; that of the robot's own observations is always there.
    fn index(&self, landmark: usize) -> usize {
        match self.at(landmark) {
            At::InHand(k) | At::Outside(k) => k,
        }
    }

    /// Position of a landmark in hand \[m\].
    pub(in crate::slam) fn position(&self, landmark: usize) -> Point2<f64> {
        self.hand().position(self.index(landmark))
    }

    /// Covariance of two landmarks in hand.
    pub(in crate::slam) fn block(&self, i: usize, j: usize) -> Matrix2<f64> {
        self.hand().block(self.index(i), self.index(j))
    }

    /// Covariance of the robot and a landmark in hand, R x 2.
    pub(in crate::slam) fn cross(&self, landmark: usize) -> SMatrix<f64, R, 2> {
        self.hand().cross(self.index(landmark))
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

    /// Corrects by rows of landmarks in hand; `heading` as for [`LargeState::correct`], where all
    /// of the map is in hand.
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

    /// Puts the part in hand back, so that all landmarks are at hand.
    pub(in crate::slam) fn settle(&mut self) -> Result<()> {
        self.part.take().map_or(Ok(()), |part| part.settle(&mut self.whole))
    }

    /// Takes a part in hand, of landmarks in ascending order.
    pub(in crate::slam) fn take(&mut self, members: Vec<usize>) -> Result<()> {
        self.settle()?;
        self.part = Some(Submap::new(&self.whole, members));
        Ok(())
    }

    /// Keeps the landmarks for which `keep` holds.
    pub(in crate::slam) fn retain(&mut self, keep: &[bool]) -> Result<()> {
        self.settle()?;
        self.whole.retain(keep);
        Ok(())
    }

    pub(in crate::slam) fn checked_covariance(&self) -> Result<DMatrix<f64>> {
        let mut settled = self.clone();
        settled.settle()?;
        settled.whole.checked_covariance()
    }
}
