//! Places found in an occupancy grid: rooms, corridors, and the doors between them.
//!
//! A watershed on the distance transform of the free floor: the distance to the nearest wall is the
//! depth, rooms are basins, doors the shallow thresholds between them. The floor is flooded from
//! the deepest points; where two basins meet, they are merged, unless the threshold is as narrow as
//! a door and clearly narrower than both sides.
//!
//! Before that, furniture (small islands) is removed, and so is free space too narrow for a robot,
//! such as beams that left through a window.

mod inside;
mod regions;

use super::{Edge, Place, PlaceKind, TopologicalMap, path_length};
use crate::grid::{GridFrame, Occupancy, OccupancyGrid};
use crate::{DistanceMap, Result};
use inside::Inside;
use loc_core::error::{non_negative, positive, probability};
use regions::{NONE, Passage, renumber};
use std::collections::BTreeMap;

/// Criteria for rooms, corridors and doors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtractSettings {
    /// Widest door \[m\]; wider passages join two parts of one place.
    pub max_door_width: f64,
    /// A door is at most this share of the width of the places on both sides, in \[0, 1\].
    pub narrowing: f64,
    /// Two places joined by several passages are one if these make up more than this share of the
    /// wall between the outermost of them, in \[0, 1\].
    pub openness: f64,
    /// Minimum width of a place \[m\]; what is narrower belongs to its neighbour.
    pub min_width: f64,
    /// Minimum area of a place \[m^2\]; what is smaller belongs to its neighbour.
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
        non_negative("minimum width of a place [m]", self.min_width)?;
        non_negative("minimum area of a place [m^2]", self.min_area)?;
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
        join_open(&floor, settings, &mut labels);
        let passages = regions::between(&floor, &labels, settings);
        let regions = inside::measure(&floor, &labels, &passages);
        assemble(&floor, &regions, &passages, settings)
    }
}

/// Builds the map: names the places and joins them by edges.
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
            let via = regions[region].paths.get(&number).cloned().unwrap_or_default();
            let ends = [places[region].position, position];
            let path = [ends[0]].into_iter().chain(via.iter().copied()).chain([ends[1]]);
            edges.push(Edge { between: [region, door], length: path_length(path), via });
        }
    }
    TopologicalMap::new(places, edges)
}

/// The floor on which a robot can move, with the clearance of every cell.
struct Floor {
    frame: GridFrame,
    /// Squared distance to the nearest cell that is no floor \[cells^2\], 0 there.
    clearance: Vec<u32>,
    /// The same with the furniture in place.
    furnished: Vec<u32>,
    /// Squared radius of the robot \[cells^2\].
    robot: u32,
}

impl Floor {
    fn of(grid: &OccupancyGrid, settings: &ExtractSettings) -> Result<Floor> {
        let cell = grid.resolution();
        let free = without_clutter(grid, settings.max_clutter / cell);
        let frame = *grid.frame();
        let room = clearance(frame, &free)?;
        let radius = squared(settings.robot_radius / cell);
        // Where the robot's middle may be, and from there everything that it covers.
        let middles: Vec<bool> = room.iter().map(|&far| far > 0 && far >= radius).collect();
        let covered = distances(frame, &middles, true)?;
        let both = covered.iter().zip(&middles);
        let floor: Vec<bool> = both.map(|(&far, &middle)| middle || far < radius).collect();
        let floor: Vec<bool> = floor.iter().zip(&free).map(|(&a, &b)| a && b).collect();
        let free = |&value: &i8| Occupancy::of(value) == Occupancy::Free;
        let free: Vec<bool> = grid.values().iter().map(free).collect();
        let furnished = clearance(frame, &free)?;
        Ok(Floor { clearance: clearance(frame, &floor)?, furnished, robot: radius, frame })
    }

    /// A squared distance in cells as a distance \[m\].
    fn metres(&self, squared: u32) -> f64 {
        f64::from(squared).sqrt() * self.frame.resolution()
    }
}

/// The square of a distance in cells, as far as it goes.
fn squared(cells: f64) -> u32 {
    // The cast saturates.
    (cells * cells) as u32
}

/// Squared distances to what is no floor; beyond the grid there is none.
fn clearance(frame: GridFrame, floor: &[bool]) -> Result<Vec<u32>> {
    let mut clearance = distances(frame, floor, false)?;
    let (width, height) = (frame.width(), frame.height());
    for (index, far) in clearance.iter_mut().enumerate() {
        let (column, row) = (index % width, index / width);
        let border = (column + 1).min(row + 1).min(width - column).min(height - row);
        *far = (*far).min(u32::try_from(border * border).unwrap_or(u32::MAX));
    }
    Ok(clearance)
}

/// Squared distances to the cells where a mask has a value.
fn distances(frame: GridFrame, mask: &[bool], value: bool) -> Result<Vec<u32>> {
    let cell = |&is: &bool| {
        let class = if is == value { Occupancy::Occupied } else { Occupancy::Free };
        class.value()
    };
    let grid = OccupancyGrid::new(frame, mask.iter().map(cell).collect())?;
    Ok(DistanceMap::new(&grid, f64::INFINITY)?.squared().to_vec())
}

/// Which cells are floor: the free ones, and islands of others
/// that are at most `longest` cells long and wide.
fn without_clutter(grid: &OccupancyGrid, longest: f64) -> Vec<bool> {
    let (width, height) = (grid.width(), grid.height());
    let free = |&value: &i8| Occupancy::of(value) == Occupancy::Free;
    let mut floor: Vec<bool> = grid.values().iter().map(free).collect();
    let mut seen = floor.clone();
    let mut island = Vec::new();
    for start in 0..floor.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        island.clear();
        island.push(start);
        let mut next = 0;
        while let Some(&index) = island.get(next) {
            next += 1;
            for other in around(index, width, height) {
                if !seen[other] {
                    seen[other] = true;
                    island.push(other);
                }
            }
        }
        if extent(&island, width) as f64 <= longest {
            island.iter().for_each(|&index| floor[index] = true);
        }
    }
    floor
}

/// The longer side of the box around some cells \[cells\].
fn extent(cells: &[usize], width: usize) -> usize {
    let span = |places: &mut dyn Iterator<Item = usize>| {
        let (low, high) = places.fold((usize::MAX, 0), |(low, high), k| (low.min(k), high.max(k)));
        high.saturating_sub(low) + 1
    };
    let columns = span(&mut cells.iter().map(|index| index % width));
    columns.max(span(&mut cells.iter().map(|index| index / width)))
}

/// The up to eight neighbours of a cell, by index in row-major order.
#[inline]
fn around(index: usize, width: usize, height: usize) -> impl Iterator<Item = usize> {
    let (column, row) = (index % width, index / width);
    let rows = row.saturating_sub(1)..=(row + 1).min(height - 1);
    let columns = column.saturating_sub(1)..=(column + 1).min(width - 1);
    let cells = rows.flat_map(move |row| columns.clone().map(move |c| row * width + c));
    cells.filter(move |&other| other != index)
}

/// Maximum number of rounds of joining.
const ROUNDS: usize = 10;

/// Joins regions between which there is more gap than `settings.openness` allows: furniture seems
/// to divide a place, as a row of cupboards leaves gaps that look like doors.
fn join_open(floor: &Floor, settings: &ExtractSettings, labels: &mut [usize]) {
    for _ in 0..ROUNDS {
        let mut gaps: BTreeMap<[usize; 2], Vec<Passage>> = BTreeMap::new();
        for passage in regions::between(floor, labels, settings) {
            gaps.entry(passage.between).or_default().push(passage);
        }
        gaps.retain(|_, passages| openness(floor, passages) > settings.openness);
        if gaps.is_empty() {
            return;
        }
        let regions = labels.iter().filter(|label| **label != NONE).max().map_or(0, |max| max + 1);
        let mut becomes: Vec<usize> = (0..regions).collect();
        for [low, high] in gaps.into_keys() {
            let (a, b) = (root(&becomes, low), root(&becomes, high));
            becomes[a.max(b)] = a.min(b);
        }
        for label in labels.iter_mut().filter(|label| **label != NONE) {
            *label = root(&becomes, *label);
        }
        renumber(labels);
    }
}

fn root(becomes: &[usize], mut label: usize) -> usize {
    while becomes[label] != label {
        label = becomes[label];
    }
    label
}

/// The share of several passages in the wall from the first to the last of them; 0 for a single
/// one, which is a door.
fn openness(floor: &Floor, passages: &[Passage]) -> f64 {
    if passages.len() < 2 {
        return 0.0;
    }
    let widths: f64 = passages.iter().map(|passage| passage.width(floor)).sum();
    let apart = |a: &Passage, b: &Passage| {
        nalgebra::distance(&floor.frame.center(a.cell), &floor.frame.center(b.cell))
    };
    let pairs = passages.iter().flat_map(|a| passages.iter().map(move |b| apart(a, b)));
    let span = pairs.fold(0.0, f64::max) + widths / passages.len() as f64;
    widths / span
}
