//! Global search: where in the map a scan fits.

use crate::Result;
use crate::free_space::FreeSpace;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::likelihood_field::Endpoints;
use loc_maps::{LikelihoodField, OccupancyGrid};

/// Settings of [`GlobalSearch`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    /// How many places are wanted.
    pub candidates: usize,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings { candidates: 64 }
    }
}

/// A place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Where.
    pub pose: Pose2,
    /// How well the scan fits.
    pub log_likelihood: f64,
}

/// A search.
#[derive(Debug)]
pub struct GlobalSearch {
    field: LikelihoodField,
    free: FreeSpace,
    settings: SearchSettings,
}

impl GlobalSearch {
    /// A search.
    ///
    /// # Errors
    /// No free space.
    pub fn new(
        map: &OccupancyGrid,
        field: LikelihoodField,
        settings: SearchSettings,
    ) -> Result<Self> {
        Ok(GlobalSearch { field, free: FreeSpace::new(map)?, settings })
    }

    /// Searches.
    pub fn search(&self, endpoints: &Endpoints) -> Vec<Candidate> {
        let mut rng = stream(1, "search");
        let mut all: Vec<Candidate> = (0..400_000)
            .map(|_| {
                let pose = self.free.draw(&mut rng);
                Candidate { pose, log_likelihood: self.field.log_likelihood(pose, endpoints) }
            })
            .collect();
        all.sort_by(|a, b| b.log_likelihood.total_cmp(&a.log_likelihood));
        let mut best: Vec<Candidate> = Vec::new();
        for c in all {
            if best.len() == self.settings.candidates {
                break;
            }
            if best.iter().all(|b| {
                b.pose.distance(c.pose) > 0.3
                    || loc_core::angle::difference(b.pose.theta, c.pose.theta).abs() > 0.2
            }) {
                best.push(c);
            }
        }
        best
    }
}
