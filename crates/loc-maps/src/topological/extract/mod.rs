//! Places found in an occupancy grid: rooms, corridors, and the doors between them.
//!
//! Think of the free floor as a landscape in which the distance to the nearest wall is the depth.
//! Rooms are basins, doors the shallow thresholds between them. Water let in at the deepest points
//! rises; where two basins meet, they become one, unless the threshold is as narrow as a door and
//! clearly narrower than what lies on both sides (a watershed on the distance transform).
//!
//! Before that, furniture (small islands) is taken away, and so is free space too narrow for a
//! robot, like beams that left through a window.

mod clear;
mod floor;
mod inside;
mod open;
mod outline;
mod passages;
mod regions;

use super::place::way_length;
use super::{Edge, Place, PlaceKind, TopologicalMap};
use crate::Result;
use crate::grid::OccupancyGrid;
use floor::Floor;
use inside::Inside;
use loc_core::error::{non_negative, positive, probability};
use passages::Passage;

/// What counts as a room and what as a door.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtractSettings {
    /// Widest door \[m\]; wider passages join two parts of one place.
    pub max_door_width: f64,
    /// A door is at most this share of the width of the places on both sides, in \[0, 1\].
    pub narrowing: f64,
    /// Two places joined by several passages are one if these make up more than this share of the
    /// wall between the outermost of them, in \[0, 1\].
    pub openness: f64,
    /// Least width of a place \[m\]; what is narrower belongs to its neighbour.
    pub min_width: f64,
    /// Least area of a place \[m^2\]; what is smaller belongs to its neighbour.
    pub min_area: f64,
    /// Longest side of an obstacle that is furniture \[m\]: standing alone, it divides no room.
    pub max_clutter: f64,
    /// Radius of the robot \[m\]: free space in which it does not fit is none.
    pub robot_radius: f64,
    /// A place with two doors or more is a corridor if it is this many times as long as wide (on
    /// average).
    pub elongation: f64,
}

impl Default for ExtractSettings {
    /// For offices: doors up to 1.5 m, rooms from 1.2 m and 3 m^2 on, furniture up to 1.5 m.
    fn default() -> Self {
        ExtractSettings {
            max_door_width: 1.5,
            narrowing: 0.75,
            openness: 0.4,
            min_width: 1.2,
            min_area: 3.0,
            max_clutter: 1.5,
            robot_radius: 0.2,
            elongation: 3.5,
        }
    }
}

impl ExtractSettings {
    fn checked(&self) -> Result<()> {
        positive("widest door [m]", self.max_door_width)?;
        probability("narrowing of a door", self.narrowing)?;
        probability("openness of a wall", self.openness)?;
        non_negative("least width of a place [m]", self.min_width)?;
        non_negative("least area of a place [m^2]", self.min_area)?;
        non_negative("largest furniture [m]", self.max_clutter)?;
        non_negative("radius of the robot [m]", self.robot_radius)?;
        non_negative("elongation of a corridor", self.elongation)?;
        Ok(())
    }
}

impl TopologicalMap {
    /// The rooms, corridors and doors of a grid, with their outlines and widths.
    ///
    /// Places are named `room 1`, `corridor 1`, `door 1` and so on, from the bottom of the grid up.
    /// Each door is a place between the two that it joins; the edges lead around obstacles.
    /// Unknown space is not entered.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for settings that are negative or no numbers.
    pub fn from_grid(grid: &OccupancyGrid, settings: &ExtractSettings) -> Result<Self> {
        settings.checked()?;
        let floor = Floor::of(grid, settings)?;
        let mut labels = regions::label(&floor, settings);
        open::join_open(&floor, settings, &mut labels);
        let passages = passages::between(&floor, &labels, settings);
        let regions = inside::measure(&floor, &labels, &passages);
        assemble(&floor, &regions, &passages, settings)
    }
}

/// Names everything and joins it.
fn assemble(
    floor: &Floor,
    regions: &[Inside],
    passages: &[Passage],
    settings: &ExtractSettings,
) -> Result<TopologicalMap> {
    let mut places = Vec::new();
    let (mut rooms, mut corridors) = (0, 0);
    for region in regions {
        let kind = region.kind(settings);
        let number = if kind == PlaceKind::Room { &mut rooms } else { &mut corridors };
        *number += 1;
        let name = format!("{} {number}", kind.name());
        let position = floor.frame.center(region.center);
        let width = Some(region.width(floor));
        places.push(Place { name, kind, position, width, outline: region.outline.clone() });
    }
    let mut edges = Vec::new();
    for (number, passage) in passages.iter().enumerate() {
        let position = floor.frame.center(passage.cell);
        let name = format!("door {}", number + 1);
        let width = Some(passage.width(floor));
        let door = places.len();
        places.push(Place { name, kind: PlaceKind::Door, position, width, outline: Vec::new() });
        for region in passage.between {
            let via = regions[region].ways.get(&number).cloned().unwrap_or_default();
            let ends = [places[region].position, position];
            let way = [ends[0]].into_iter().chain(via.iter().copied()).chain([ends[1]]);
            edges.push(Edge { between: [region, door], length: way_length(way), via });
        }
    }
    TopologicalMap::new(places, edges)
}
