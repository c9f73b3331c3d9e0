//! Generated worlds: buildings to test localization in, generated from a seed.
//!
//! A method that works in one building may fail in the next. These worlds come in any size and
//! number: equal settings give equal worlds on every machine, and each seed gives another one.
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
mod office;

pub use office::office;

use crate::grid::Occupancy;
use crate::{Bounds, Error, LandmarkMap, OccupancyGrid, Result};
use canvas::{Canvas, Mark, bounds};
use loc_core::Error::{Length, OutOfRange};
use loc_core::random::stream;
use nalgebra::Point2;
use rand::{Rng, RngExt};

/// The names that [`by_name`] knows.
pub const NAMES: [&str; 4] = ["office", "corridor", "soccer-field", "hall-of-mirrors"];

/// The largest number of cells of a world.
pub const MAX_WORLD_CELLS: usize = 100_000_000;

/// The smallest number of columns and of rows of a world.
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
    /// Seed of the random details: the same seed gives the same world.
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

/// A uniform draw from `low` to `high`; `low` where `high` is not above it.
fn between(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    low + rng.random::<f64>() * (high - low).max(0.0)
}

/// A draw that is true with this probability.
fn chance(rng: &mut impl Rng, probability: f64) -> bool {
    rng.random::<f64>() < probability
}

/// Width of the corridor, thickness of its walls, distance of its ends from the grid's border,
/// width of a door \[m\].
const CORRIDOR_WIDTH: f64 = 2.0;
const CORRIDOR_WALL: f64 = 0.2;
const CORRIDOR_MARGIN: f64 = 0.5;
const CORRIDOR_DOOR: f64 = 1.0;
/// How deep a closed door stands in the wall \[m\].
const DOOR_DEPTH: f64 = 0.12;
/// A niche: width along the wall and depth \[m\].
const NICHE: [f64; 2] = [1.8, 0.6];

/// A corridor 2 m wide along the whole grid, with closed doors on both sides.
///
/// The doors come at one distance of 3.5 m to 5 m, so a robot sees how far it is from the walls but
/// not which door it passes; only the ends, and up to three niches in place of doors, are unique.
/// There are no landmarks.
///
/// # Errors
/// As [`by_name`].
pub fn corridor(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let mut rng = stream(settings.seed, "world");
    let wall = canvas.margin(canvas.thickness(CORRIDOR_WALL));
    let ends = canvas.margin(CORRIDOR_MARGIN) + wall;
    let [from, to] = [ends, canvas.area().max.x - ends];
    let middle = canvas.area().center().y;
    // In a low grid the niches take three tenths of the height.
    let half = (CORRIDOR_WIDTH / 2.0).min(0.7 * (middle - ends));
    let deepest = middle - ends - half;
    let [low, high] = [middle - half, middle + half];

    let mut open = vec![bounds([from, to], [low, high])];
    let door_depth = canvas.thickness(DOOR_DEPTH);
    for (places, above) in places(from, to, &mut rng) {
        for Place { at, niche } in places {
            let [width, depth] = if niche { NICHE } else { [CORRIDOR_DOOR, door_depth] };
            let depth = depth.min(deepest);
            let side = if above { [high, high + depth] } else { [low - depth, low] };
            open.push(bounds([at - width / 2.0, at + width / 2.0], side));
        }
    }
    for part in &open {
        canvas.fill(&part.grown(wall), Occupancy::Occupied);
    }
    for part in &open {
        canvas.fill(part, Occupancy::Free);
    }
    canvas.into_world("corridor", &[])
}

/// A door, or a niche in place of one, by its middle \[m\].
struct Place {
    at: f64,
    niche: bool,
}

/// The places along both sides, below and above.
fn places(from: f64, to: f64, rng: &mut impl Rng) -> [(Vec<Place>, bool); 2] {
    let step = between(rng, 3.5, 5.0);
    let first = from + between(rng, 1.5, step);
    // Across from a door is another one, or the wall between two.
    let shift = if chance(rng, 0.5) { step / 2.0 } else { 0.0 };
    let count = ((to - 1.5 - first - shift) / step).floor() + 1.0;
    let count = count as usize;
    let niches = [0, 1, 2].map(|_| (between(rng, 0.0, count as f64) as usize, chance(rng, 0.5)));
    [(0.0, false), (shift, true)].map(|(shift, above)| {
        let place = |k: usize| Place {
            at: first + shift + step * k as f64,
            niche: niches.contains(&(k, above)),
        };
        ((0..count).map(place).collect(), above)
    })
}

/// Length and width of the field \[m\].
const FIELD: [f64; 2] = [4.2, 2.7];
/// Thickness of the border \[m\].
const FIELD_BORDER: f64 = 0.1;
/// Width and depth of a goal \[m\].
const GOAL: [f64; 2] = [0.8, 0.3];
/// Height of the coloured part of a landmark \[m\].
const LANDMARK_HEIGHT: f64 = 0.3;
/// Distance of the border from the border of the grid \[m\].
const FIELD_MARGIN: f64 = 0.3;

/// The colours of the landmarks 1 to 6, upper one first: all pairs differ.
///
/// They stand around the field counter-clockwise, 1 at the lower-left corner.
pub const LANDMARK_COLORS: [[&str; 2]; 6] = [
    ["pink", "yellow"],
    ["pink", "green"],
    ["pink", "sky blue"],
    ["sky blue", "pink"],
    ["green", "pink"],
    ["yellow", "pink"],
];

/// The field of four-legged robot soccer (M10): 4.2 m x 2.7 m with a low border, a goal at each
/// end, and six landmarks at its edge, at the corners and at the middle of the long sides.
///
/// It lies in the middle of the grid, smaller where the grid is, in the same proportions. The
/// border is low: a camera sees over it, the robot does not cross it. Nothing about the field is
/// random, so all seeds give the same.
///
/// # Errors
/// As [`by_name`].
pub fn soccer_field(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let area = canvas.area();
    let border = canvas.margin(canvas.thickness(FIELD_BORDER));
    let around = 2.0 * (canvas.margin(FIELD_MARGIN) + border);
    let scale = ((area.width() - around) / (FIELD[0] + 2.0 * GOAL[1]))
        .min((area.height() - around) / FIELD[1])
        .min(1.0);
    let [length, width] = FIELD.map(|side| side * scale / 2.0);
    let Point2 { coords: middle } = area.center();
    let goal = GOAL.map(|side| side * scale);

    let field = bounds([-length, length], [-width, width]);
    let goals = bounds([-length - goal[1], length + goal[1]], [-goal[0] / 2.0, goal[0] / 2.0]);
    let parts = [field, goals].map(|part| {
        bounds(
            [middle.x + part.min.x, middle.x + part.max.x],
            [middle.y + part.min.y, middle.y + part.max.y],
        )
    });
    for part in &parts {
        canvas.fill(&part.grown(border), Occupancy::Occupied);
    }
    for part in &parts {
        canvas.fill(part, Occupancy::Free);
    }
    let [x, y] = [length + border / 2.0, width + border / 2.0];
    let places = [[-x, -y], [0.0, -y], [x, -y], [x, y], [0.0, y], [-x, y]];
    let marks = places
        .map(|place| Mark { position: Point2::from(place) + middle, height: LANDMARK_HEIGHT });
    canvas.into_world("soccer-field", &marks)
}

/// Distance of the hall from the grid's border, thickness of its walls and of the walls in it,
/// width of a door \[m\].
const HALL_MARGIN: f64 = 0.5;
const HALL_WALL: f64 = 0.3;
const MIRROR: f64 = 0.1;
const HALL_DOOR: f64 = 1.0;
/// Distance between the squares that hold a mirror or a pillar \[m\].
const PITCH: f64 = 3.0;
/// The smallest hall with chambers \[m\].
const WITH_CHAMBERS: [f64; 2] = [14.0, 9.0];

/// A hall that equals itself turned by 180 degrees, cell for cell.
///
/// It has free-standing walls (the mirrors), round pillars, and in two opposite corners a chamber
/// with a door. Every pose has a twin on the other side with the same view, so global localization
/// cannot tell the two apart; only a given initial pose can. There are no landmarks.
///
/// # Errors
/// As [`by_name`].
pub fn hall_of_mirrors(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let mut rng = stream(settings.seed, "world");
    let building = canvas.area().grown(-canvas.margin(HALL_MARGIN));
    let hall = building.grown(-canvas.margin(canvas.thickness(HALL_WALL)));
    canvas.fill(&building, Occupancy::Occupied);
    canvas.fill(&hall, Occupancy::Free);
    let chamber = add_chamber(&mut canvas, &hall, &mut rng);
    add_mirrors(&mut canvas, &hall, &chamber, &mut rng);
    // Everything so far is in the lower half; the upper half is its copy, turned by 180 degrees.
    canvas.repeat_turned();
    canvas.into_world("hall-of-mirrors", &[])
}

/// A chamber in the lower-left corner, with a door in its upper wall; returns the box to keep
/// clear.
fn add_chamber(canvas: &mut Canvas, hall: &Bounds, rng: &mut impl Rng) -> Bounds {
    let Point2 { coords: corner } = hall.min;
    if hall.width() < WITH_CHAMBERS[0] || hall.height() < WITH_CHAMBERS[1] {
        return bounds([corner.x; 2], [corner.y; 2]);
    }
    let wall = canvas.thickness(MIRROR);
    let right = corner.x + between(rng, 3.5, 5.5);
    let top = corner.y + between(rng, 2.5, (hall.height() / 2.0 - 1.5).min(4.5));
    let door = between(rng, corner.x + 0.3, right - HALL_DOOR - 0.3);
    let inside = bounds([corner.x, right], [corner.y, top]);
    canvas.fill(&bounds([corner.x, right + wall], [corner.y, top + wall]), Occupancy::Occupied);
    canvas.fill(&inside, Occupancy::Free);
    canvas.fill(&bounds([door, door + HALL_DOOR], [top, top + wall]), Occupancy::Free);
    inside.grown(1.0 + wall)
}

/// Mirrors and pillars in the lower half, one at most in each square of about [`PITCH`].
fn add_mirrors(canvas: &mut Canvas, hall: &Bounds, chamber: &Bounds, rng: &mut impl Rng) {
    let half = bounds([hall.min.x, hall.max.x], [hall.min.y, hall.center().y]);
    let counts = [half.width(), half.height()].map(|side| (side / PITCH).floor());
    let pitch = [half.width() / counts[0], half.height() / counts[1]];
    let thickness = canvas.thickness(MIRROR);
    for row in 0..counts[1] as usize {
        for column in 0..counts[0] as usize {
            let x = half.min.x + column as f64 * pitch[0] + between(rng, 1.2, pitch[0] - 1.2);
            let y = half.min.y + row as f64 * pitch[1] + between(rng, 1.2, pitch[1] - 1.2);
            let center = Point2::new(x, y);
            let (kind, upright) = (between(rng, 0.0, 1.0), chance(rng, 0.5));
            let length = between(rng, 1.0, 1.6);
            if chamber.contains(&center) {
                continue;
            }
            // Every piece keeps 0.4 m from the border of its square.
            if kind < 0.3 {
                canvas.disc(center, length / 5.0, Occupancy::Occupied);
            } else if kind < 0.75 {
                let [along, across] = [length / 2.0, thickness / 2.0];
                let [u, v] = if upright { [across, along] } else { [along, across] };
                let mirror = bounds([x - u, x + u], [y - v, y + v]);
                canvas.fill(&mirror, Occupancy::Occupied);
            }
        }
    }
}
