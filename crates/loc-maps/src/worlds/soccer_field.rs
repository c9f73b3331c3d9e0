//! The soccer field of the Aibo robots, with its six coloured landmarks.

use super::canvas::{Canvas, Mark, bounds};
use super::{World, WorldSettings};
use crate::Result;
use crate::grid::Occupancy;
use nalgebra::Point2;

/// Length and width of the field \[m\].
const FIELD: [f64; 2] = [4.2, 2.7];
const BORDER: f64 = 0.1;
/// Width and depth of a goal \[m\].
const GOAL: [f64; 2] = [0.8, 0.3];
/// Height of the coloured part of a landmark \[m\].
const HEIGHT: f64 = 0.3;
const MARGIN: f64 = 0.3;

/// The colours of the landmarks 1 to 6, upper one first: no two look the same.
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
/// As [`by_name`](super::by_name).
pub fn soccer_field(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let area = canvas.area();
    let border = canvas.margin(canvas.thickness(BORDER));
    let around = 2.0 * (canvas.margin(MARGIN) + border);
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
    let marks = places.map(|place| Mark { position: Point2::from(place) + middle, height: HEIGHT });
    canvas.into_world("soccer-field", &marks)
}
