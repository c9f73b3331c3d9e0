//! The landmarks of the map: initialization, scores, removal, merging, and the active submap.

use super::observation::{DistanceBound, LocatedObservation};
use super::{EkfSlam, Identities, Jacobians, MapLandmark, Matrix2x5, NUMBERS};
use crate::Result;
use crate::association::{PairInnovation, Pairing};
use crate::localizer::Outcome;
use crate::slam::state::Row;
use loc_core::Gaussian;
use loc_core::gaussian::check_covariance;
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::{Matrix2, Point2};

/// A score up to this counts as 0.
const NO_SCORE: f64 = 1e-9;

/// Number of recently observed landmarks that are compared with earlier ones.
const RECENT: usize = 10;

/// Variance of the measurement that two landmarks have the same position \[m^2\].
const SAME: f64 = 1e-6;

/// A landmark of the state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    pub(super) id: u32,
    /// Its first estimate \[m\].
    pub(super) first: Point2<f64>,
    pub(super) observations: u32,
    /// Its score, see [`super::MapSettings`].
    pub(super) score: f64,
    pub(super) confirmed: bool,
    /// Step of the filter at its last observation.
    pub(super) seen_at: u64,
}

/// The largest range and bearing observed so far. Landmarks well within them should be seen again.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ViewExtent {
    range: f64,
    bearing: f64,
}

impl ViewExtent {
    /// The part of the view in which a landmark should be seen.
    const MIDDLE: f64 = 0.7;
    /// Lower bounds of the view \[m, rad\].
    const MIN_RANGE: f64 = 1.0;
    const MIN_BEARING: f64 = 0.25;
    /// A provisional landmark farther away than this, in units of the range, is removed.
    const GONE: f64 = 1.5;

    pub(super) fn include(&mut self, located: &LocatedObservation) {
        self.range = self.range.max(located.range);
        self.bearing = self.bearing.max(located.bearing.abs());
    }

    /// Area of the view \[m^2\], over which new landmarks are uniformly distributed.
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

impl Entry {
    fn absorb(&mut self, gone: &Entry, max_score: f64) {
        self.observations = self.observations.saturating_add(gone.observations);
        self.score = (self.score + gone.score).min(max_score);
        self.confirmed |= gone.confirmed;
        self.seen_at = self.seen_at.max(gone.seen_at);
    }
}

/// The region whose landmarks are in the active submap.
#[derive(Debug, Clone, Copy)]
pub(super) struct ActiveRegion {
    center: Point2<f64>,
    radius: f64,
    /// The largest variance of a landmark outside \[m^2\]; corrections only make it smaller.
    outside_variance: f64,
}

impl EkfSlam {
    /// Number of landmarks in the state, provisional ones included.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The landmarks in the order of the state.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] where the covariance of one is none.
    pub fn landmarks(&self) -> Result<Vec<MapLandmark>> {
        (0..self.entries.len()).map(|index| self.describe(index)).collect()
    }

    /// The landmark with a number.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] where its covariance is none.
    pub fn landmark(&self, id: u32) -> Result<Option<MapLandmark>> {
        self.numbers.get(&id).map(|&index| self.describe(index)).transpose()
    }

    fn describe(&self, index: usize) -> Result<MapLandmark> {
        let Entry { id, observations, confirmed, .. } = self.entries[index];
        let (position, covariance) = self.state.landmark(index);
        check_covariance("covariance of a landmark", &covariance)
            .map_err(|error| self.state.robot_state().state_error(error))?;
        let position = Gaussian { mean: position.coords, covariance };
        Ok(MapLandmark { id, position, observations, confirmed })
    }

    /// Appends a landmark to the state, from where it was seen.
    pub(super) fn initialize_landmark(
        &mut self,
        id: u32,
        located: &LocatedObservation,
    ) -> Result<()> {
        let position = located.position;
        // As the robot turns, the landmark moves at a right angle to the line of sight.
        let from = match self.settings.jacobians {
            Jacobians::Current | Jacobians::Invariant => self.robot_pose(),
            Jacobians::First => self.first_pose,
        };
        let (dx, dy) = (position.x - from.x, position.y - from.y);
        // The common errors are subtracted from the observation.
        let axes = -located.axes(self);
        let by_robot =
            Matrix2x5::new(1.0, 0.0, -dy, axes.m11, axes.m12, 0.0, 1.0, dx, axes.m21, axes.m22);
        self.state.push(position, &by_robot, &located.noise(self))?;
        self.numbers.insert(id, self.entries.len());
        self.next_number = self.next_number.max(id.wrapping_add(1));
        let confirmed = self.settings.map.confirm_score <= 1.0;
        let seen_at = self.step();
        let first = position;
        self.entries.push(Entry { id, first, observations: 1, score: 1.0, confirmed, seen_at });
        Ok(())
    }

    /// Counts an accepted observation of a landmark.
    pub(super) fn raise_score(&mut self, landmark: usize) {
        let seen_at = self.step();
        let (map, entry) = (&self.settings.map, &mut self.entries[landmark]);
        entry.seen_at = seen_at;
        entry.observations = entry.observations.saturating_add(1);
        entry.score = (entry.score + 1.0).min(map.max_score());
        entry.confirmed |= entry.score >= map.confirm_score;
    }

    /// Counts a contradiction to a landmark.
    pub(super) fn lower_score(&mut self, landmark: usize, cost: f64) {
        self.entries[landmark].score -= cost;
        self.score_lowered = true;
    }

    /// Lowers the score of landmarks that should have been observed and were not, and removes those
    /// without a score.
    pub(super) fn score_missed(&mut self, seen: &[bool]) -> Result<()> {
        let camera = self.robot_pose() * self.settings.robot.mounting;
        let back = camera.inverse();
        for index in self.state.active() {
            let from_camera = back.transform(&self.state.position(index));
            if seen.get(index).is_some_and(|seen| !seen) && self.view.should_see(&from_camera) {
                self.lower_score(index, self.settings.map.miss_cost);
            }
            if !self.entries[index].confirmed && self.view.has_left(&from_camera) {
                self.lower_score(index, f64::INFINITY);
            }
        }
        self.remove_unsupported()
    }

    /// Removes the landmarks without a score.
    pub(super) fn remove_unsupported(&mut self) -> Result<()> {
        if !std::mem::take(&mut self.score_lowered) {
            return Ok(());
        }
        let keep: Vec<bool> = self.entries.iter().map(|entry| entry.score > NO_SCORE).collect();
        if keep.iter().all(|keep| *keep) {
            return Ok(());
        }
        self.state.retain(&keep)?;
        self.region = None;
        self.entries.retain(|entry| entry.score > NO_SCORE);
        self.numbers =
            self.entries.iter().enumerate().map(|(index, entry)| (entry.id, index)).collect();
        Ok(())
    }

    /// Merges landmarks that are the same; the earlier one is kept.
    pub(super) fn merge(&mut self, outcomes: &mut [Outcome]) -> Result<()> {
        let recent = self.recent();
        let others = self.state.active().into_iter();
        let earlier: Vec<usize> = others.filter(|index| !recent.contains(index)).collect();
        if earlier.is_empty() {
            return Ok(());
        }
        let duplicates = Duplicates { slam: self, recent, earlier };
        let association = self.merger.associate(&duplicates);
        let association =
            association.map_err(|error| self.state.robot_state().state_error(error))?;
        let partners = association.partners.iter().enumerate();
        let pairs: Vec<(usize, usize)> =
            partners.filter_map(|(a, b)| b.map(|b| duplicates.pair((a, b)))).collect();
        let rows: Vec<Row<NUMBERS>> = pairs.iter().flat_map(|&pair| self.same(pair)).collect();
        self.apply(&rows)?;
        for &(recent, earlier) in &pairs {
            let gone = self.entries[recent];
            self.lower_score(recent, f64::INFINITY);
            self.entries[earlier].absorb(&gone, self.settings.map.max_score());
            let kept = self.entries[earlier].id;
            let changed = outcomes.iter_mut().filter(|outcome| outcome.landmark == Some(gone.id));
            changed.for_each(|outcome| outcome.landmark = Some(kept));
        }
        self.remove_unsupported()
    }

    /// The most recently observed landmarks, all of them active.
    pub(super) fn recent(&self) -> Vec<usize> {
        let mut recent = self.state.active();
        recent.sort_by_key(|&index| std::cmp::Reverse((self.entries[index].seen_at, index)));
        recent.truncate(RECENT);
        recent
    }

    /// How far apart two landmarks may be that are the same \[m\], from the sum of their variances
    /// \[m^2\]; the variance of a difference is at most twice that.
    pub(super) fn duplicate_distance(&self, variance: f64) -> f64 {
        (2.0 * self.new_landmark_gate * variance).sqrt()
    }

    /// The measurement that two landmarks are at one position.
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

    /// Changes the submap where an observation may be of a landmark that is not active.
    pub(super) fn update_submap(&mut self, observations: &[LandmarkObservation]) -> Result<()> {
        let Some(radius) = self.settings.submap_radius else { return Ok(()) };
        let numbered = self.settings.identities == Identities::Known;
        let known = |seen: &LandmarkObservation| self.numbers.get(&seen.landmark).copied();
        let named: Vec<usize> =
            if numbered { observations.iter().filter_map(known).collect() } else { Vec::new() };
        let located = if numbered { &[] } else { observations };
        let located: Vec<LocatedObservation> =
            located.iter().filter_map(|seen| self.locate(seen)).collect();
        let center = Point2::from(self.state.robot().xy());
        if let Some(region) = &self.region {
            let near = nalgebra::distance(&center, &region.center) <= 0.5 * region.radius;
            let active = named.iter().all(|&landmark| self.state.is_active(landmark));
            if near
                && active
                && self.distance_to_cover(&region.center, &located, region) <= region.radius
            {
                return Ok(());
            }
        }
        self.state.write_back()?;
        self.activate_around(center, radius, &named, &located)
    }

    /// Makes the landmarks around a position active, and those that are named.
    fn activate_around(
        &mut self,
        center: Point2<f64>,
        radius: f64,
        named: &[usize],
        located: &[LocatedObservation],
    ) -> Result<()> {
        let variance = |landmark: usize| self.state.block(landmark, landmark).trace();
        let widest = (0..self.entries.len()).map(variance).fold(0.0, f64::max);
        let mut region = ActiveRegion { center, radius, outside_variance: widest };
        // Wide enough that the submap changes rarely.
        region.radius = radius.max(2.0 * self.distance_to_cover(&center, located, &region));
        let near = |landmark: &usize| {
            let position = self.state.position(*landmark);
            nalgebra::distance(&center, &position) <= region.radius || named.contains(landmark)
        };
        let members: Vec<usize> = (0..self.entries.len()).filter(near).collect();
        self.state.take(members)?;
        self.region = Some(region);
        Ok(())
    }

    /// How far from the centre a landmark outside may be that one of the observations fits, or that may
    /// be the same as one seen lately \[m\].
    fn distance_to_cover(
        &self,
        center: &Point2<f64>,
        located: &[LocatedObservation],
        region: &ActiveRegion,
    ) -> f64 {
        let farthest = |located: &LocatedObservation| {
            let bound = DistanceBound::new(self, located).distance(region.outside_variance);
            nalgebra::distance(center, &located.position) + bound
        };
        let of_observations = located.iter().map(farthest).fold(0.0, f64::max);
        if self.settings.identities == Identities::Known {
            return of_observations;
        }
        let farthest = |recent: usize| {
            let position = self.state.position(recent);
            let variance = self.state.block(recent, recent).trace();
            let bound = self.duplicate_distance(variance + region.outside_variance);
            nalgebra::distance(center, &position) + bound
        };
        self.recent().into_iter().map(farthest).fold(of_observations, f64::max)
    }
}

/// Recently observed landmarks paired with earlier ones, to find landmarks that are in the map twice.
///
/// After a long path the pose error may be too large for an observation to be associated with an old
/// landmark; a second landmark is initialized instead. The new ones keep their distances from each
/// other: where several of them match several old ones jointly, they are the same.
struct Duplicates<'a> {
    slam: &'a EkfSlam,
    recent: Vec<usize>,
    earlier: Vec<usize>,
}

impl Duplicates<'_> {
    fn pair(&self, (recent, earlier): (usize, usize)) -> (usize, usize) {
        (self.recent[recent], self.earlier[earlier])
    }

    /// Covariance of two differences.
    fn covariance(&self, (a, b): (usize, usize), (c, d): (usize, usize)) -> Matrix2<f64> {
        let state = &self.slam.state;
        state.block(a, c) - state.block(a, d) - state.block(b, c) + state.block(b, d)
    }
}

impl Pairing<2> for Duplicates<'_> {
    fn observations(&self) -> usize {
        self.recent.len()
    }

    fn landmarks(&self) -> usize {
        self.earlier.len()
    }

    fn innovation(&self, recent: usize, earlier: usize) -> Option<PairInnovation<2>> {
        let (a, b) = self.pair((recent, earlier));
        let (entries, state) = (&self.slam.entries, &self.slam.state);
        // Numbers ascend in the order of initialization.
        if entries[b].id > entries[a].id {
            return None;
        }
        let residual = state.position(a) - state.position(b);
        let variance = state.block(a, a).trace() + state.block(b, b).trace();
        if residual.norm() > self.slam.duplicate_distance(variance) {
            return None;
        }
        let same = Matrix2::identity() * SAME;
        Some(PairInnovation { residual, covariance: self.covariance((a, b), (a, b)) + same })
    }

    fn elsewhere(&self, _recent: usize) -> f64 {
        1.0 / self.slam.view.area()
    }

    fn cross_covariance(&self, p: (usize, usize), q: (usize, usize)) -> Matrix2<f64> {
        self.covariance(self.pair(p), self.pair(q))
    }
}
