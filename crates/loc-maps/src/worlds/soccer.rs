//! The soccer field: numbered landmarks, and a board round the field.

use super::WorldSize;
use super::canvas::{Canvas, WALL};
use crate::grid::OccupancyGrid;
use crate::{Landmark, LandmarkMap, Result};
use loc_core::Pose2;

/// Half the length and half the width of the field \[m\], as the RoboCup Standard Platform League
/// draws it.
const HALF: (f64, f64) = (4.5, 3.0);

/// From the field's lines to the board \[m\].
const BORDER: f64 = 0.7;

const GOAL_HALF_WIDTH: f64 = 0.75;
const POST_RADIUS: f64 = 0.05;

/// A field of 9 m x 6 m with its centre at the map's origin, in cells of `resolution` \[m\]: the
/// board round it and the goal posts as a grid, and landmarks: 1 to 4 the goal posts, 5 to 8 the
/// corners of the field, 9 and 10 the ends of the half-way line, each set counter-clockwise from
/// the first quadrant.
///
/// # Errors
/// [`loc_core::Error::OutOfRange`] for a resolution that is not above 0 and at most 7.5 cm.
pub fn soccer_field(resolution: f64) -> Result<(OccupancyGrid, LandmarkMap)> {
    loc_core::error::positive("resolution [m]", resolution)?;
    let half = (HALF.0 + BORDER + WALL, HALF.1 + BORDER + WALL);
    let cells = |half: f64| (2.0 * half / resolution).round() as usize;
    let size = WorldSize { columns: cells(half.0), rows: cells(half.1), resolution };
    // The middle of the grid is the middle of the field, whatever rounding left over.
    let middle = |cells: usize| 0.5 * cells as f64 * resolution;
    let (x, y) = (middle(size.columns), middle(size.rows));
    let mut canvas = Canvas::new(size, Pose2::new(-x, -y, 0.0), (1.0, 1.0))?;
    canvas.frame(canvas.whole(), 100);
    let corners = |x: f64, y: f64| [(x, y), (-x, y), (-x, -y), (x, -y)];
    let posts = corners(HALF.0, GOAL_HALF_WIDTH);
    for (post_x, post_y) in posts {
        canvas.disc(x + post_x, y + post_y, POST_RADIUS.max(0.75 * resolution), 100);
    }
    let places = posts.into_iter().chain(corners(HALF.0, HALF.1));
    let places = places.chain([(0.0, HALF.1), (0.0, -HALF.1)]);
    let landmarks = (1..).zip(places).map(|(id, (x, y))| Landmark::planar(id, x, y));
    Ok((canvas.into_grid(), LandmarkMap::new(landmarks)?))
}
