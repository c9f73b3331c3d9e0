//! The corridor: long, straight, and nearly the same everywhere.

use super::WorldSize;
use super::canvas::{Canvas, Rect, WALL};
use crate::Result;
use crate::grid::{OccupancyGrid, UNKNOWN};
use loc_core::Pose2;
use loc_core::random::stream;
use rand::RngExt;

const WIDTH: f64 = 2.4;
const NICHE: (f64, f64) = (1.0, 0.25);

/// A corridor of 2.4 m along the world's x axis, closed at both ends, with a door in a niche every
/// 5 m on each side; one niche in four is walled up, which is all that tells places apart. What
/// lies behind its walls is unknown.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] for less than 6 m x 3.5 m and for cells of more than 7.5 cm.
pub fn corridor(size: WorldSize, seed: u64) -> Result<OccupancyGrid> {
    let mut canvas = Canvas::new(size, Pose2::IDENTITY, (6.0, 3.5))?;
    let mut rng = stream(seed, "world/corridor");
    let (length, middle) = (canvas.width, 0.5 * canvas.height);
    canvas.fill(canvas.whole(), UNKNOWN);
    let hall = Rect::new(WALL, middle - 0.5 * WIDTH, length - 2.0 * WALL, WIDTH);
    let mut open = vec![hall];
    for k in 0..(length / 2.5) as usize {
        // Doors on the two sides take turns.
        let (along, above) = (2.5 * k as f64 + 1.0, k % 2 == 0);
        let bottom = if above { hall.top } else { hall.bottom - NICHE.1 };
        let niche = Rect::new(along, bottom, NICHE.0, NICHE.1);
        if !rng.random_bool(0.25) && niche.right < hall.right - WALL {
            open.push(niche);
        }
    }
    open.iter().for_each(|part| canvas.fill(part.inset(-WALL), 100));
    open.iter().for_each(|part| canvas.fill(*part, 0));
    Ok(canvas.into_grid())
}
