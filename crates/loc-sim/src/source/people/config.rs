//! How many people there are, and how they behave.

use crate::Result;
use crate::config::field;
use loc_core::error::{non_negative, positive};
use serde::Deserialize;

/// People in a building.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PeopleConfig {
    /// How many walk about the building.
    pub count: usize,
    /// Radius of a walker, as the laser sees it.
    pub radius_m: f64,
    /// How fast they walk.
    pub speed_m_s: f64,
    /// Share of the beams that visitors around the robot hide, in \[0, 0.9\].
    pub blocked_share: f64,
    /// How wide a visitor is, seen from the laser; adapted a little, so that they make up the share.
    pub visitor_deg: f64,
    /// How near visitors stand.
    pub distance_m: f64,
    /// How long a visitor stays at one side of the robot, on the average.
    pub stay_s: f64,
}

impl Default for PeopleConfig {
    /// Nobody; walkers and visitors of common size where there are any.
    fn default() -> Self {
        PeopleConfig {
            count: 0,
            radius_m: 0.25,
            speed_m_s: 1.0,
            blocked_share: 0.0,
            visitor_deg: 25.0,
            distance_m: 1.0,
            stay_s: 4.0,
        }
    }
}

impl PeopleConfig {
    /// More walkers than this no building holds.
    const MAX: usize = 10_000;

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub fn check(&self) -> Result<()> {
        if self.count > Self::MAX {
            return Err(field("tour.people.count", "at most 10000", &self.count.to_string()));
        }
        positive("tour.people.radius_m", self.radius_m)?;
        non_negative("tour.people.speed_m_s", self.speed_m_s)?;
        if !(0.0..=0.9).contains(&self.blocked_share) {
            let found = self.blocked_share.to_string();
            return Err(field("tour.people.blocked_share", "a share from 0 to 0.9", &found));
        }
        positive("tour.people.visitor_deg", self.visitor_deg)?;
        positive("tour.people.distance_m", self.distance_m)?;
        positive("tour.people.stay_s", self.stay_s)?;
        Ok(())
    }
}
