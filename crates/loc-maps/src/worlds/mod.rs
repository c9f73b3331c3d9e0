//! Generated worlds: buildings to test localization in, each made anew from a seed.
//!
//! A method that works in one building may fail in the next. These worlds are made in any size and
//! number: the same settings give the same world on every machine, and another seed another one.
//!
//! | name | what it is for |
//! |---|---|
//! | `office` | a floor with corridors, rooms, doors, furniture, and door plates as landmarks |
//! | `corridor` | a long corridor, the same every few metres: the place along it is ambiguous |
//! | `soccer-field` | the field of the Aibo robots (M10) with six coloured landmarks |
//! | `hall-of-mirrors` | the same from opposite sides: every pose has a twin |
//!
//! Lengths are those of real buildings (corridors 2 m, doors 1 m) whatever the resolution, so one
//! seed gives one building at any resolution. What lies outside of it is unknown.
//!
//! ```
//! use loc_maps::worlds::{self, WorldSettings};
//! let settings = WorldSettings { width: 400, height: 300, resolution: 0.05, seed: 7 };
//! let world = worlds::by_name("office", &settings)?;
//! assert_eq!((world.grid.width(), world.grid.height()), (400, 300));
//! assert!(world.grid.counts().free > 60_000);
//! assert!(worlds::by_name("castle", &settings).is_err());
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod canvas;
mod corridor;
mod furniture;
mod hall_of_mirrors;
mod office;
mod plan;
mod soccer_field;

pub use corridor::corridor;
pub use hall_of_mirrors::hall_of_mirrors;
pub use office::office;
pub use soccer_field::{LANDMARK_COLORS, soccer_field};

use crate::{Error, LandmarkMap, OccupancyGrid, Result};
use loc_core::Error::{Length, OutOfRange};
use rand::{Rng, RngExt};

/// The names that [`by_name`] knows.
pub const NAMES: [&str; 4] = ["office", "corridor", "soccer-field", "hall-of-mirrors"];

/// The most cells that a world may have.
pub const MAX_WORLD_CELLS: usize = 100_000_000;

/// The fewest columns and rows that a world may have.
pub const MIN_SIDE: usize = 20;

/// A generated world.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// The name of its kind, one of [`NAMES`].
    pub name: &'static str,
    /// Its walls and its floor.
    pub grid: OccupancyGrid,
    /// Its landmarks; empty where the kind has none.
    pub landmarks: LandmarkMap,
}

/// How large a world is, how fine, and which one of its kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorldSettings {
    /// Number of columns, at least [`MIN_SIDE`].
    pub width: usize,
    /// Number of rows, at least [`MIN_SIDE`].
    pub height: usize,
    /// Side of a cell \[m\], 0.001 to 0.25.
    pub resolution: f64,
    /// What to draw the details from: the same seed gives the same world.
    pub seed: u64,
}

impl Default for WorldSettings {
    /// 40 m x 30 m at 5 cm.
    fn default() -> Self {
        WorldSettings { width: 800, height: 600, resolution: 0.05, seed: 1 }
    }
}

impl WorldSettings {
    /// A size that suits a kind of world: a floor of 40 m x 30 m, a corridor of 60 m, a hall of
    /// 20 m x 14 m, a soccer field of 4.2 m x 2.7 m.
    ///
    /// # Errors
    /// [`Error::UnknownWorld`] for a name that is not one of [`NAMES`].
    pub fn suited_to(name: &str) -> Result<Self> {
        let (width, height, resolution) = match name {
            "office" => (800, 600, 0.05),
            "corridor" => (1200, 100, 0.05),
            "soccer-field" => (280, 180, 0.02),
            "hall-of-mirrors" => (400, 280, 0.05),
            _ => return Err(Error::UnknownWorld { found: name.to_owned() }),
        };
        Ok(WorldSettings { width, height, resolution, ..WorldSettings::default() })
    }

    fn checked(&self) -> Result<()> {
        let shorter = self.width.min(self.height);
        if shorter < MIN_SIDE {
            let expected = "a width and a height of at least 20";
            return Err(Length { what: "side of the world", expected, found: shorter }.into());
        }
        let found = self.width.saturating_mul(self.height);
        if found > MAX_WORLD_CELLS {
            let expected = "at most 10^8 cells";
            return Err(Length { what: "world", expected, found }.into());
        }
        if !(0.001..=0.25).contains(&self.resolution) {
            let (what, expected) = ("resolution of the world [m]", "a number from 0.001 to 0.25");
            return Err(OutOfRange { what, expected, found: self.resolution }.into());
        }
        Ok(())
    }
}

/// The world of a name out of [`NAMES`].
///
/// # Errors
/// [`Error::UnknownWorld`] for any other name, and [`loc_core::Error`] for sizes and resolutions
/// outside what [`WorldSettings`] and [`MAX_WORLD_CELLS`] say.
pub fn by_name(name: &str, settings: &WorldSettings) -> Result<World> {
    match name {
        "office" => office(settings),
        "corridor" => corridor(settings),
        "soccer-field" => soccer_field(settings),
        "hall-of-mirrors" => hall_of_mirrors(settings),
        _ => Err(Error::UnknownWorld { found: name.to_owned() }),
    }
}

/// A number between two; the lower one where there is no room between them.
fn between(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low + rng.random::<f64>() * (high - low).max(0.0)
}

/// Whether an event of this probability happens.
fn chance(rng: &mut impl Rng, probability: f64) -> bool {
    rng.random::<f64>() < probability
}
