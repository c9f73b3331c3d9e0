//! The rooms of the demonstration.

use crate::Result;
use crate::config::field;
use crate::demonstration::count;
use loc_core::error::positive;
use serde::Deserialize;

/// Rooms in which a robot measures distances to landmarks.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaterationConfig {
    /// Standard deviation of every distance.
    pub range_sigma_m: f64,
    /// How often the distances are measured anew, to see where the places scatter.
    pub draws: usize,
    /// The rooms.
    pub rooms: Vec<RoomConfig>,
}

/// A robot and its landmarks, in the plane (x, y) or in space (x, y, z).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomConfig {
    /// What is to be seen.
    pub name: String,
    /// The landmarks.
    pub landmarks_m: Vec<Vec<f64>>,
    /// Where the robot is.
    pub robot_m: Vec<f64>,
    /// Where it is believed to be beforehand; it decides between two places.
    pub start_m: Option<Vec<f64>>,
}

impl LaterationConfig {
    pub(in crate::demonstration) fn check(&self) -> Result<()> {
        positive("demonstration.range_sigma_m", self.range_sigma_m)?;
        count("demonstration.draws", self.draws, 100_000)?;
        count("demonstration.rooms", self.rooms.len(), 12)?;
        self.rooms.iter().try_for_each(RoomConfig::check)
    }
}

impl RoomConfig {
    /// Number of coordinates.
    pub(super) fn dimension(&self) -> usize {
        self.robot_m.len()
    }

    fn check(&self) -> Result<()> {
        let d = self.dimension();
        let found = |place: &[f64]| format!("{place:?} in {}", self.name);
        if !(2..=3).contains(&d) {
            let key = "demonstration.rooms.robot_m";
            return Err(field(key, "2 or 3 coordinates", &found(&self.robot_m)));
        }
        for place in self.landmarks_m.iter().chain(&self.start_m).chain([&self.robot_m]) {
            if place.len() != d || !place.iter().all(|value| value.is_finite()) {
                let expected = format!("places of {d} finite coordinates, as the robot has");
                return Err(field("demonstration.rooms", &expected, &found(place)));
            }
        }
        Ok(())
    }
}
