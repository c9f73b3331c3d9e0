//! Landmarks that are in the map twice.
//!
//! A robot that comes back from a long way is off by so much that it cannot tell which of the
//! landmarks of old it sees; it takes them for new ones. But the new ones keep their distances from
//! each other, and when a few of them lie as a few of the old ones do, they are the same.

use super::common::NUMBERS;
use super::entries::Entry;
use super::{EkfSlam, SlamOutcome};
use crate::Result;
use crate::association::{PairInnovation, Pairing};
use crate::slam::state::Row;
use nalgebra::Matrix2;

/// So many of the landmarks seen last are held against those of old.
const RECENT: usize = 10;

/// Two landmarks that are the same are apart by no more than this variance \[m^2\].
const SAME: f64 = 1e-6;

/// Recent landmarks held against earlier ones.
struct Twins<'a> {
    slam: &'a EkfSlam,
    recent: Vec<usize>,
    earlier: Vec<usize>,
}

impl Twins<'_> {
    fn pair(&self, (recent, earlier): (usize, usize)) -> (usize, usize) {
        (self.recent[recent], self.earlier[earlier])
    }

    /// Covariance of two differences.
    fn covariance(&self, (a, b): (usize, usize), (c, d): (usize, usize)) -> Matrix2<f64> {
        let state = &self.slam.state;
        state.block(a, c) - state.block(a, d) - state.block(b, c) + state.block(b, d)
    }
}

impl Pairing<2> for Twins<'_> {
    fn observations(&self) -> usize {
        self.recent.len()
    }

    fn landmarks(&self) -> usize {
        self.earlier.len()
    }

    fn innovation(&self, recent: usize, earlier: usize) -> Option<PairInnovation<2>> {
        let (a, b) = self.pair((recent, earlier));
        let (entries, state) = (&self.slam.entries, &self.slam.state);
        // Numbers are given in order of birth.
        if entries[b].id > entries[a].id {
            return None;
        }
        let residual = state.position(a) - state.position(b);
        let variance = state.block(a, a).trace() + state.block(b, b).trace();
        if residual.norm() > self.slam.twin_distance(variance) {
            return None;
        }
        let same = Matrix2::identity() * SAME;
        Some(PairInnovation { residual, covariance: self.covariance((a, b), (a, b)) + same })
    }

    fn elsewhere(&self, _recent: usize) -> f64 {
        1.0 / self.slam.reach.area()
    }

    fn cross_covariance(&self, p: (usize, usize), q: (usize, usize)) -> Matrix2<f64> {
        self.covariance(self.pair(p), self.pair(q))
    }
}

impl EkfSlam {
    /// Makes one of landmarks that are surely the same; the earlier one stays.
    pub(super) fn merge(&mut self, outcomes: &mut [SlamOutcome]) -> Result<()> {
        let recent = self.recent();
        let others = self.state.in_hand().into_iter();
        let earlier: Vec<usize> = others.filter(|index| !recent.contains(index)).collect();
        if earlier.is_empty() {
            return Ok(());
        }
        let twins = Twins { slam: self, recent, earlier };
        let association = self.merger.associate(&twins);
        let association = association.map_err(|error| self.state.robot_state().blamed(error))?;
        let partners = association.partners.iter().enumerate();
        let pairs: Vec<(usize, usize)> =
            partners.filter_map(|(a, b)| b.map(|b| twins.pair((a, b)))).collect();
        let rows: Vec<Row<NUMBERS>> = pairs.iter().flat_map(|&pair| self.same(pair)).collect();
        self.apply(&rows)?;
        for &(recent, earlier) in &pairs {
            let gone = self.entries[recent];
            self.blame(recent, f64::INFINITY);
            self.entries[earlier].take_over(&gone, self.settings.map.max_score);
            let kept = self.entries[earlier].id;
            let changed = outcomes.iter_mut().filter(|outcome| outcome.landmark == Some(gone.id));
            changed.for_each(|outcome| outcome.landmark = Some(kept));
        }
        self.remove_false()
    }

    /// The landmarks seen last, all of them in hand.
    pub(super) fn recent(&self) -> Vec<usize> {
        let mut recent = self.state.in_hand();
        recent.sort_by_key(|&index| std::cmp::Reverse((self.entries[index].seen_at, index)));
        recent.truncate(RECENT);
        recent
    }

    /// How far apart two landmarks may be that are the same \[m\], from the sum of their variances
    /// \[m^2\]; the variance of a difference is at most twice that.
    pub(super) fn twin_distance(&self, variance: f64) -> f64 {
        (2.0 * self.new_landmark_gate * variance).sqrt()
    }

    /// The measurement that two landmarks are at one place.
    fn same(&self, (landmark, other): (usize, usize)) -> [Row<NUMBERS>; 2] {
        let difference = self.state.position(landmark) - self.state.position(other);
        [([1.0, 0.0], difference.x), ([0.0, 1.0], difference.y)].map(|(along, difference)| Row {
            landmark,
            by_robot: nalgebra::SVector::zeros(),
            by_landmark: along,
            other: Some((other, along.map(|value: f64| -value))),
            residual: -difference,
            variance: SAME,
        })
    }
}

impl Entry {
    fn take_over(&mut self, gone: &Entry, max_score: f64) {
        self.observations = self.observations.saturating_add(gone.observations);
        self.score = (self.score + gone.score).min(max_score);
        self.confirmed |= gone.confirmed;
        self.seen_at = self.seen_at.max(gone.seen_at);
    }
}
