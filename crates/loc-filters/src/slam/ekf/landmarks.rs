//! What is known of landmarks beside their position: birth, confirmation, removal.

use super::observation::{Bound, Place};
use super::{EkfSlam, Identities, Jacobians, Matrix2x5, NUMBERS, SlamOutcome};
use crate::Result;
use crate::association::{PairInnovation, Pairing};
use crate::slam::state::Row;
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::{Matrix2, Point2};

/// A landmark of the state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) id: u32,
    /// Its first estimate \[m\].
    pub(super) first: Point2<f64>,
    pub(super) observations: u32,
    /// How much speaks for it, see [`super::MapSettings`].
    pub(super) score: f64,
    pub(super) confirmed: bool,
    /// Step of the filter at its last observation.
    pub(super) seen_at: u64,
}

/// How far the camera has been seen to see. Landmarks well within it should be seen again.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Reach {
    range: f64,
    bearing: f64,
}

/// A score that is not above this is none.
const NO_SCORE: f64 = 1e-9;

impl Reach {
    /// The part of the view in which a landmark should be seen.
    const MIDDLE: f64 = 0.7;
    /// The least that a camera is taken to see \[m, rad\].
    const MIN_RANGE: f64 = 1.0;
    const MIN_BEARING: f64 = 0.25;
    /// A provisional landmark that is farther away than this, in ranges, has had its chance.
    const GONE: f64 = 1.5;

    pub(super) fn include(&mut self, place: &Place) {
        self.range = self.range.max(place.range);
        self.bearing = self.bearing.max(place.bearing.abs());
    }

    /// Area of what the camera has been seen to see \[m^2\]: where something new may be.
    pub(super) fn area(&self) -> f64 {
        self.range.max(Self::MIN_RANGE).powi(2) * self.bearing.max(Self::MIN_BEARING)
    }

    fn should_see(&self, from_camera: &Point2<f64>) -> bool {
        from_camera.coords.norm() < Self::MIDDLE * self.range
            && from_camera.y.atan2(from_camera.x).abs() < Self::MIDDLE * self.bearing
    }

    fn has_left(&self, from_camera: &Point2<f64>) -> bool {
        from_camera.coords.norm() > Self::GONE * self.range
    }
}

impl EkfSlam {
    /// Appends a landmark to the state, from where it was seen.
    pub(super) fn give_birth(&mut self, id: u32, place: &Place) -> Result<()> {
        let position = place.position;
        // As the robot turns, what it sees moves at a right angle to the way there.
        let from = match self.settings.jacobians {
            Jacobians::Current | Jacobians::Invariant => self.robot_pose(),
            Jacobians::First => self.anchor,
        };
        let (dx, dy) = (position.x - from.x, position.y - from.y);
        // The common errors of the observations are taken off the place.
        let axes = -place.axes(self);
        let by_robot =
            Matrix2x5::new(1.0, 0.0, -dy, axes.m11, axes.m12, 0.0, 1.0, dx, axes.m21, axes.m22);
        self.state.push(position, &by_robot, &place.noise(self))?;
        self.numbers.insert(id, self.entries.len());
        self.next_number = self.next_number.max(id.wrapping_add(1));
        let confirmed = self.settings.map.confirm_score <= 1.0;
        let seen_at = self.step();
        let first = position;
        self.entries.push(Entry { id, first, observations: 1, score: 1.0, confirmed, seen_at });
        Ok(())
    }

    /// An observation has spoken for a landmark.
    pub(super) fn praise(&mut self, landmark: usize) {
        let seen_at = self.step();
        let (map, entry) = (&self.settings.map, &mut self.entries[landmark]);
        entry.seen_at = seen_at;
        entry.observations = entry.observations.saturating_add(1);
        entry.score = (entry.score + 1.0).min(map.max_score);
        entry.confirmed |= entry.score >= map.confirm_score;
    }

    /// An observation has spoken against it.
    pub(super) fn blame(&mut self, landmark: usize, cost: f64) {
        self.entries[landmark].score -= cost;
        self.doubted = true;
    }

    /// Blames landmarks that should have been seen and were not, and removes those that no longer
    /// have anything to speak for them.
    pub(super) fn tidy(&mut self, seen: &[bool]) -> Result<()> {
        let camera = self.robot_pose() * self.settings.mounting;
        let back = camera.inverse();
        for index in self.state.in_hand() {
            let from_camera = back.transform(&self.state.position(index));
            if seen.get(index).is_some_and(|seen| !seen) && self.reach.should_see(&from_camera) {
                self.blame(index, self.settings.map.miss_cost);
            }
            if !self.entries[index].confirmed && self.reach.has_left(&from_camera) {
                self.blame(index, f64::INFINITY);
            }
        }
        self.remove_false()
    }

    /// Removes the landmarks without a score.
    pub(super) fn remove_false(&mut self) -> Result<()> {
        if !std::mem::take(&mut self.doubted) {
            return Ok(());
        }
        let keep: Vec<bool> = self.entries.iter().map(|entry| entry.score > NO_SCORE).collect();
        if keep.iter().all(|keep| *keep) {
            return Ok(());
        }
        self.state.retain(&keep)?;
        self.focus = None;
        self.entries.retain(|entry| entry.score > NO_SCORE);
        self.numbers =
            self.entries.iter().enumerate().map(|(index, entry)| (entry.id, index)).collect();
        Ok(())
    }

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

    /// Makes sure that the observations can only be of landmarks in hand.
    pub(super) fn refocus(&mut self, observations: &[LandmarkObservation]) -> Result<()> {
        let Some(radius) = self.settings.submap_radius else { return Ok(()) };
        let numbered = self.settings.identities == Identities::Known;
        let known = |seen: &LandmarkObservation| self.numbers.get(&seen.landmark).copied();
        let named: Vec<usize> =
            if numbered { observations.iter().filter_map(known).collect() } else { Vec::new() };
        let places = if numbered { &[] } else { observations };
        let places: Vec<Place> = places.iter().filter_map(|seen| self.place(seen)).collect();
        let center = Point2::from(self.state.robot().xy());
        if let Some(focus) = &self.focus {
            let near = nalgebra::distance(&center, &focus.center) <= 0.5 * focus.radius;
            let in_hand = named.iter().all(|&landmark| self.state.is_in_hand(landmark));
            if near && in_hand && self.reach_from(&focus.center, &places, focus) <= focus.radius {
                return Ok(());
            }
        }
        self.state.settle()?;
        self.take_around(center, radius, &named, &places)
    }

    /// Takes the landmarks around a place in hand, and those that are named.
    fn take_around(
        &mut self,
        center: Point2<f64>,
        radius: f64,
        named: &[usize],
        places: &[Place],
    ) -> Result<()> {
        let variance = |landmark: usize| self.state.block(landmark, landmark).trace();
        let widest = (0..self.entries.len()).map(variance).fold(0.0, f64::max);
        let mut focus = Focus { center, radius, outside_variance: widest };
        // Wide enough to be left only after a while.
        focus.radius = radius.max(2.0 * self.reach_from(&center, places, &focus));
        let near = |landmark: &usize| {
            let position = self.state.position(*landmark);
            nalgebra::distance(&center, &position) <= focus.radius || named.contains(landmark)
        };
        let members: Vec<usize> = (0..self.entries.len()).filter(near).collect();
        self.state.take(members)?;
        self.focus = Some(focus);
        Ok(())
    }

    /// How far from the centre a landmark outside may be that one of the places fits, or that may
    /// be the same as one seen lately \[m\].
    fn reach_from(&self, center: &Point2<f64>, places: &[Place], focus: &Focus) -> f64 {
        let farthest = |place: &Place| {
            let bound = Bound::new(self, place).distance(focus.outside_variance);
            nalgebra::distance(center, &place.position) + bound
        };
        let of_observations = places.iter().map(farthest).fold(0.0, f64::max);
        if self.settings.identities == Identities::Known {
            return of_observations;
        }
        let farthest = |recent: usize| {
            let position = self.state.position(recent);
            let variance = self.state.block(recent, recent).trace();
            let bound = self.twin_distance(variance + focus.outside_variance);
            nalgebra::distance(center, &position) + bound
        };
        self.recent().into_iter().map(farthest).fold(of_observations, f64::max)
    }
}

// Landmarks that are in the map twice.
//
// A robot that comes back from a long way is off by so much that it cannot tell which of the
// landmarks of old it sees; it takes them for new ones. But the new ones keep their distances from
// each other, and when a few of them lie as a few of the old ones do, they are the same.

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

impl Entry {
    fn take_over(&mut self, gone: &Entry, max_score: f64) {
        self.observations = self.observations.saturating_add(gone.observations);
        self.score = (self.score + gone.score).min(max_score);
        self.confirmed |= gone.confirmed;
        self.seen_at = self.seen_at.max(gone.seen_at);
    }
}

// Which part of the map the filter works on, where it does not work on all of it.

/// The landmarks in hand: those around the place where they were taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Focus {
    center: Point2<f64>,
    radius: f64,
    /// The largest variance of a landmark outside \[m^2\]; corrections only make it smaller.
    outside_variance: f64,
}
