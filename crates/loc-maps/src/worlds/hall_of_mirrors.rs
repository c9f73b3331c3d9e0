//! A hall that looks the same from opposite places.

use super::canvas::{Canvas, bounds};
use super::{World, WorldSettings, between, chance};
use crate::grid::Occupancy;
use crate::{Bounds, Result};
use loc_core::random::stream;
use nalgebra::Point2;
use rand::Rng;

const MARGIN: f64 = 0.5;
const OUTER_WALL: f64 = 0.3;
const MIRROR: f64 = 0.1;
const DOOR: f64 = 1.0;
/// Between the places where a mirror or a pillar may stand \[m\].
const PITCH: f64 = 3.0;
/// The least hall with chambers \[m\].
const WITH_CHAMBERS: [f64; 2] = [14.0, 9.0];

/// A hall that equals itself turned by 180 degrees, cell for cell.
///
/// Free-standing walls (the mirrors) and round pillars stand in it, and in two opposite corners a
/// chamber with a door. For every pose there is one on the other side that sees the very same, so
/// global localization cannot tell which of the two it is; only a given start can. There are no
/// landmarks.
///
/// # Errors
/// As [`by_name`](super::by_name).
pub fn hall_of_mirrors(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let mut rng = stream(settings.seed, "world");
    let building = canvas.area().grown(-canvas.margin(MARGIN));
    let hall = building.grown(-canvas.margin(canvas.thickness(OUTER_WALL)));
    canvas.fill(&building, Occupancy::Occupied);
    canvas.fill(&hall, Occupancy::Free);
    let chamber = add_chamber(&mut canvas, &hall, &mut rng);
    add_mirrors(&mut canvas, &hall, &chamber, &mut rng);
    // All was drawn in the lower half; the upper one is its image.
    canvas.repeat_turned();
    canvas.into_world("hall-of-mirrors", &[])
}

/// A chamber in the lower-left corner, with a door in its upper wall; returns what to keep clear.
fn add_chamber(canvas: &mut Canvas, hall: &Bounds, rng: &mut impl Rng) -> Bounds {
    let Point2 { coords: corner } = hall.min;
    if hall.width() < WITH_CHAMBERS[0] || hall.height() < WITH_CHAMBERS[1] {
        return bounds([corner.x; 2], [corner.y; 2]);
    }
    let wall = canvas.thickness(MIRROR);
    let right = corner.x + between(rng, 3.5, 5.5);
    let top = corner.y + between(rng, 2.5, (hall.height() / 2.0 - 1.5).min(4.5));
    let door = between(rng, corner.x + 0.3, right - DOOR - 0.3);
    let inside = bounds([corner.x, right], [corner.y, top]);
    canvas.fill(&bounds([corner.x, right + wall], [corner.y, top + wall]), Occupancy::Occupied);
    canvas.fill(&inside, Occupancy::Free);
    canvas.fill(&bounds([door, door + DOOR], [top, top + wall]), Occupancy::Free);
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
