//! An office floor: corridors, rooms along them, doors, furniture.

use super::canvas::{Canvas, Mark};
use super::furniture::furnish;
use super::plan::Plan;
use super::{World, WorldSettings};
use crate::Result;
use crate::grid::Occupancy;
use loc_core::random::stream;

const OUTER_WALL: f64 = 0.3;
const INNER_WALL: f64 = 0.15;
const MARGIN: f64 = 0.5;
const PLATE_HEIGHT: f64 = 1.5;

/// A floor of an office building, as large as the grid.
///
/// Corridors 2 m wide run along the building, a main one or more across them. Rooms of 3 m to 8 m,
/// now and then an open-plan one, lie on both sides, each with a door of 0.9 m to 1.1 m, some with
/// one to the next room. Desks, shelves, tables and round pillars leave a way of 0.8 m everywhere,
/// so that every free cell can be reached from every other. Beside each door of a corridor hangs
/// a plate at 1.5 m, which is a landmark.
///
/// Where there is no room for that, it gets simpler: below about 8 m one row of rooms along the
/// corridor, below about 5 m a row of rooms without one, and in the end a single room.
///
/// # Errors
/// As [`by_name`](super::by_name).
pub fn office(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let mut rng = stream(settings.seed, "world");
    let building = canvas.area().grown(-canvas.margin(MARGIN));
    let outer = canvas.margin(canvas.thickness(OUTER_WALL));
    let plan = Plan::new(building.grown(-outer), canvas.thickness(INNER_WALL), &mut rng);

    canvas.fill(&building, Occupancy::Occupied);
    let rooms = plan.rooms.iter().map(|room| &room.inside);
    for open in rooms.chain(&plan.corridors).chain(&plan.doors) {
        canvas.fill(open, Occupancy::Free);
    }
    for room in &plan.rooms {
        for piece in furnish(room, &mut rng) {
            piece.draw(&mut canvas);
        }
    }
    let plates = plan.plates.iter().map(|&position| Mark { position, height: PLATE_HEIGHT });
    canvas.into_world("office", &plates.collect::<Vec<_>>())
}
