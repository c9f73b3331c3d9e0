//! What is known of landmarks beside their position: birth, confirmation, removal.

use super::EkfSlam;
use super::Jacobians;
use super::common::Matrix2x5;
use super::look::Place;
use crate::Result;
use nalgebra::Point2;

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
}
