//! Initial particles: drawn from the free space of a map, or around the candidates of a global
//! search ([`loc_maps::search`]).

use crate::{Particles, Result};
use loc_core::Pose2;
use loc_core::error::{non_negative, positive};
use loc_core::sampling::box_muller;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame, Occupancy};
use loc_maps::search::Candidate;
use rand::{Rng, RngExt};
use std::f64::consts::PI;

/// The free cells of a map, where a robot can be; to draw poses from.
#[derive(Debug, Clone)]
pub struct FreeSpace {
    frame: GridFrame,
    /// Row-major indices of the free cells, in order; 4 bytes a free cell.
    cells: Vec<u32>,
}

impl FreeSpace {
    /// The free cells of a map.
    ///
    /// # Errors
    /// [`loc_maps::Error::NoFreeSpace`] where there are none.
    pub fn new(map: &OccupancyGrid) -> Result<Self> {
        let frame = *map.frame();
        let values = map.values().iter().enumerate();
        let free = values.filter(|&(_, &value)| Occupancy::of(value) == Occupancy::Free);
        // A grid has at most 2^28 cells.
        let cells: Vec<u32> = free.map(|(index, _)| index as u32).collect();
        if cells.is_empty() {
            let (width, height) = (frame.width(), frame.height());
            return Err(loc_maps::Error::NoFreeSpace { width, height }.into());
        }
        Ok(FreeSpace { frame, cells })
    }

    /// Free area \[m^2\].
    pub fn area(&self) -> f64 {
        self.cells.len() as f64 * self.frame.resolution().powi(2)
    }

    /// A pose drawn evenly from the free area and all headings.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> Pose2 {
        let index = self.cells[rng.random_range(0..self.cells.len())] as usize;
        let cell = Cell::new(index % self.frame.width(), index / self.frame.width());
        let [u, v]: [f64; 2] = [rng.random(), rng.random()];
        let at = self.frame.to_map(cell.column as f64 + u, cell.row as f64 + v);
        Pose2::new(at.x, at.y, PI * (2.0 * rng.random::<f64>() - 1.0))
    }

    /// Whether a pose lies within the map's rectangle, free or not.
    pub fn is_on_map(&self, pose: Pose2) -> bool {
        self.frame.cell_at(&pose.position()).is_some()
    }

    /// Whether a pose stands in a free cell.
    pub fn contains(&self, pose: Pose2) -> bool {
        let cell = self.frame.cell_at(&pose.position());
        let index = cell.and_then(|cell| self.frame.index(cell));
        index.is_some_and(|index| self.cells.binary_search(&(index as u32)).is_ok())
    }
}

/// How particles are spread over the candidates of a search.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SeedSettings {
    /// Standard deviation of the position about a candidate, along each axis \[m\].
    pub position: f64,
    /// Standard deviation of the heading \[rad\].
    pub heading: f64,
    /// Power to which the likelihoods are raised. The beams of a scan depend on each other, so
    /// that the likelihood of 180 of them is overconfident; low powers keep less likely
    /// candidates.
    pub exponent: f64,
}

impl Default for SeedSettings {
    fn default() -> Self {
        SeedSettings { position: 0.1, heading: 0.03, exponent: 0.1 }
    }
}

impl SeedSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn check(&self) -> loc_core::Result<()> {
        non_negative("position [m]", self.position)?;
        non_negative("heading [rad]", self.heading)?;
        positive("exponent", self.exponent)?;
        Ok(())
    }
}

/// A particle set of `count` particles of equal weight about the candidates: each has a share in
/// proportion to its likelihood to the power of `exponent`, exact but for one particle, and spreads
/// it as a Gaussian.
///
/// ```
/// use loc_core::{Pose2, random::stream};
/// use loc_maps::search::Candidate;
/// use loc_pf::initial::{SeedSettings, seed_particles};
/// let here = Candidate { pose: Pose2::new(5.0, 5.0, 0.0), log_likelihood: -20.0 };
/// let there = Candidate { pose: Pose2::new(9.0, 5.0, 3.1), log_likelihood: -30.0 };
/// let mut rng = stream(1, "filter");
/// let particles = seed_particles(&[here, there], 1000, &SeedSettings::default(), &mut rng)?;
/// let at_first = particles.poses().x.iter().filter(|x| **x < 7.0).count();
/// assert!(at_first.abs_diff(731) <= 1, "e : 1");
/// # Ok::<(), loc_pf::Error>(())
/// ```
///
/// # Errors
/// Settings out of range, and [`loc_core::Error::Length`] without candidates.
pub fn seed_particles<R: Rng + ?Sized>(
    candidates: &[Candidate],
    count: usize,
    settings: &SeedSettings,
    rng: &mut R,
) -> Result<Particles> {
    settings.check()?;
    let best = candidates.iter().map(|candidate| candidate.log_likelihood).reduce(f64::max);
    let Some(best) = best else {
        let (what, expected) = ("candidates", "at least 1");
        return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
    };
    let weight = |c: &Candidate| (settings.exponent * (c.log_likelihood - best)).exp();
    let total: f64 = candidates.iter().map(weight).sum();
    // Low-variance resampling: one draw decides all shares.
    let offset: f64 = rng.random();
    let (mut sum, mut drawn, mut poses) = (0.0, 0, Vec::with_capacity(count));
    for (number, candidate) in candidates.iter().enumerate() {
        sum += weight(candidate) / total * count as f64;
        let last = number + 1 == candidates.len();
        let until = if last { count } else { ((sum + offset) as usize).min(count) };
        poses.extend((drawn..until).map(|_| spread(candidate.pose, settings, rng)));
        drawn = drawn.max(until);
    }
    Ok(Particles::from_poses(poses))
}

fn spread<R: Rng + ?Sized>(at: Pose2, settings: &SeedSettings, rng: &mut R) -> Pose2 {
    let ((x, y), (turn, _)) = (box_muller(rng), box_muller(rng));
    let SeedSettings { position, heading, .. } = settings;
    Pose2::new(at.x + position * x, at.y + position * y, at.theta + heading * turn)
}
