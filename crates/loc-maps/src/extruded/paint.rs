//! What colour a wall has: so that one sees its shape.

use crate::grid::{Cell, OccupancyGrid};
use loc_sensors::world::Rgb;
use nalgebra::{Point2, Vector2};

/// How far around a cell one looks for the way that its wall faces \[cells\].
const AROUND: isize = 4;
/// Width of the panels of walls \[m\].
const PANEL: f64 = 1.0;
/// Where the light comes from, as a direction \[rad\].
const LIGHT: f64 = 0.9;

const WALL: [f64; 3] = [236.0, 230.0, 214.0];
const FURNITURE: [[f64; 3]; 6] = [
    [206.0, 92.0, 60.0],
    [72.0, 126.0, 176.0],
    [94.0, 150.0, 84.0],
    [222.0, 172.0, 70.0],
    [140.0, 98.0, 164.0],
    [80.0, 160.0, 158.0],
];

/// The colour of the surface that is met in a cell at a place \[m\]; `furniture` is the number of
/// its body.
pub(super) fn color(
    grid: &OccupancyGrid,
    cell: Cell,
    place: &Point2<f64>,
    furniture: Option<u32>,
) -> Rgb {
    let facing = facing(grid, cell);
    let light = Vector2::new(LIGHT.cos(), LIGHT.sin());
    let shade = 0.74 + 0.24 * facing.dot(&light);
    let panel = |coordinate: f64| (coordinate / PANEL).floor() as i64;
    let base = match furniture {
        Some(body) => FURNITURE[hash(body) as usize / 7 % FURNITURE.len()],
        None if (panel(place.x) + panel(place.y)).rem_euclid(2) == 0 => WALL,
        None => WALL.map(|value| 0.9 * value),
    };
    // A cast of a float to an integer saturates.
    base.map(|value| (value * shade).round() as u8)
}

/// The direction from the wall into the free space before it, a unit vector; zero for a cell that
/// walls or free cells surround evenly.
fn facing(grid: &OccupancyGrid, cell: Cell) -> Vector2<f64> {
    let mut sum = Vector2::zeros();
    for dy in -AROUND..=AROUND {
        for dx in -AROUND..=AROUND {
            let (column, row) =
                (cell.column.checked_add_signed(dx), cell.row.checked_add_signed(dy));
            let (Some(column), Some(row)) = (column, row) else { continue };
            let free = grid.value(Cell::new(column, row)).is_some_and(|v| !super::occupied(v));
            if free && dx * dx + dy * dy <= AROUND * AROUND {
                sum += Vector2::new(dx as f64, dy as f64);
            }
        }
    }
    let in_map = grid.origin().rotation() * sum;
    in_map.try_normalize(1e-9).unwrap_or_default()
}

/// Scatters small numbers (Knuth's multiplicative hash).
pub(super) fn hash(value: u32) -> u32 {
    value.wrapping_mul(2_654_435_769) >> 16
}
