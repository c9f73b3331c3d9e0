//! The hall of mirrors: a hall that looks the same from the other end.

use super::WorldSize;
use super::canvas::{Canvas, Rect, WALL};
use crate::Result;
use crate::grid::OccupancyGrid;
use loc_core::Pose2;
use loc_core::random::stream;
use rand::RngExt;

/// A hall whose four quarters mirror each other, cell by cell. Turned by half a circle it is the
/// same, so every pose has a twin that measures the same; a localizer that is honest keeps both.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] for less than 6 m x 6 m and for cells of more than 7.5 cm.
pub fn hall_of_mirrors(size: WorldSize, seed: u64) -> Result<OccupancyGrid> {
    let mut canvas = Canvas::new(size, Pose2::IDENTITY, (6.0, 6.0))?;
    let mut rng = stream(seed, "world/mirrors");
    canvas.frame(canvas.whole(), 100);
    let quarter = Rect::new(0.0, 0.0, 0.5 * canvas.width, 0.5 * canvas.height).inset(WALL + 0.8);
    for _ in 0..(quarter.width() * quarter.height() / 5.0) as usize + 2 {
        let x = rng.random_range(quarter.left..quarter.right);
        let y = rng.random_range(quarter.bottom..quarter.top);
        match rng.random_range(0..3) {
            0 => canvas.disc(x, y, rng.random_range(0.15..0.4), 100),
            1 => canvas.fill(Rect::new(x, y, rng.random_range(0.3..1.6), WALL), 100),
            _ => canvas.fill(Rect::new(x, y, WALL, rng.random_range(0.3..1.6)), 100),
        }
    }
    let drawn = canvas.into_grid();
    let (frame, last) = (*drawn.frame(), (size.columns - 1, size.rows - 1));
    let of_quarter = |cell: crate::grid::Cell| {
        let (column, row) =
            (cell.column.min(last.0 - cell.column), cell.row.min(last.1 - cell.row));
        drawn.row(row).get(column).copied().unwrap_or_default()
    };
    Ok(OccupancyGrid::from_valid(frame, frame.cells().map(of_quarter).collect()))
}
