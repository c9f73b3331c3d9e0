//! The office: corridors with rooms on both sides, doors, and furniture.

use super::WorldSize;
use super::canvas::{Canvas, Rect, WALL};
use crate::Result;
use crate::grid::OccupancyGrid;
use loc_core::Pose2;
use loc_core::random::{ChaCha8Rng, stream};
use rand::RngExt;

const CORRIDOR: f64 = 2.4;
const DOOR: f64 = 1.0;

/// Two rows of rooms and the corridor between them take about this \[m\].
const WING: f64 = 14.0;

/// An office: wings of rooms along corridors, which cross corridors join.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] for less than 8 m x 8 m and for cells of more than 7.5 cm,
/// which would have holes in the walls.
pub fn office(size: WorldSize, seed: u64) -> Result<OccupancyGrid> {
    let mut canvas = Canvas::new(size, Pose2::IDENTITY, (8.0, 8.0))?;
    let mut rng = stream(seed, "world/office");
    let wings = (canvas.height / WING).round().max(1.0);
    let (width, wing) = (canvas.width, canvas.height / wings);
    let blocks = blocks(width, wings as usize);
    for k in 0..wings as usize {
        let bottom = k as f64 * wing;
        let depth = 0.5 * (wing - CORRIDOR);
        for &(left, right) in &blocks {
            let lower = Rect { left, bottom, right, top: bottom + depth };
            let upper = Rect { bottom: bottom + wing - depth, top: bottom + wing, ..lower };
            row_of_rooms(&mut canvas, lower, true, &mut rng);
            row_of_rooms(&mut canvas, upper, false, &mut rng);
        }
    }
    canvas.frame(canvas.whole(), 100);
    Ok(canvas.into_grid())
}

/// The blocks of rooms, left and right ends; cross corridors run between them.
fn blocks(width: f64, wings: usize) -> Vec<(f64, f64)> {
    let crossings = match (width, wings) {
        (..12.0, _) | (_, 1) if width < 40.0 => 0,
        _ => (width / 40.0).round().max(1.0) as usize,
    };
    let block = (width - crossings as f64 * CORRIDOR) / (crossings + 1) as f64;
    let left = |k: usize| k as f64 * (block + CORRIDOR);
    (0..=crossings).map(|k| (left(k), left(k) + block)).collect()
}

/// Rooms side by side whose doors open to a corridor above them, or below.
fn row_of_rooms(canvas: &mut Canvas, row: Rect, corridor_above: bool, rng: &mut ChaCha8Rng) {
    let mut left = row.left;
    while left < row.right - 0.1 {
        let rest = row.right - left;
        let wanted: f64 = rng.random_range(3.0..8.0);
        // What is too narrow for another room goes to this one.
        let width = if rest - wanted < 3.0 { rest } else { wanted };
        let room = Rect { left, right: left + width, ..row };
        draw_room(canvas, room, corridor_above, rng);
        left += width;
    }
}

fn draw_room(canvas: &mut Canvas, room: Rect, corridor_above: bool, rng: &mut ChaCha8Rng) {
    // Walls reach half into the neighbouring room, so that both share one.
    canvas.frame(room.inset(-0.5 * WALL), 100);
    let at = rng.random_range(room.left + 0.4..room.right - DOOR - 0.4);
    let wall = if corridor_above { room.top } else { room.bottom };
    canvas.fill(Rect::new(at, wall - WALL, DOOR, 2.0 * WALL), 0);
    let way_in = Rect::new(at - 0.2, wall - 1.2, DOOR + 0.4, 2.4);
    let pieces = (room.width() * room.height() / 7.0) as usize;
    for _ in 0..rng.random_range(pieces / 2..=pieces + 1) {
        furnish(canvas, room.inset(0.5 * WALL), way_in, rng);
    }
}

/// One piece of furniture, unless it would stand in the way.
fn furnish(canvas: &mut Canvas, room: Rect, way_in: Rect, rng: &mut ChaCha8Rng) {
    let kind = rng.random_range(0..4);
    let (mut long, mut deep) = match kind {
        0 => (1.6, 0.8),
        1 => (rng.random_range(0.8..2.4), 0.4),
        2 => (rng.random_range(0.4..0.7), rng.random_range(0.4..0.7)),
        _ => (0.7, 0.7),
    };
    if rng.random() {
        (long, deep) = (deep, long);
    }
    if long > room.width() - 0.4 || deep > room.height() - 0.4 {
        return;
    }
    let mut x = rng.random_range(room.left..room.right - long);
    let mut y = rng.random_range(room.bottom..room.top - deep);
    if kind < 2 {
        // Desks and shelves stand at a wall.
        if long > deep {
            y = if rng.random() { room.bottom } else { room.top - deep };
        } else {
            x = if rng.random() { room.left } else { room.right - long };
        }
    }
    let piece = Rect::new(x, y, long, deep);
    match kind {
        _ if piece.overlaps(&way_in) => {}
        3 => canvas.disc(x + 0.35, y + 0.35, rng.random_range(0.15..0.35), 100),
        _ => canvas.fill(piece, 100),
    }
}
