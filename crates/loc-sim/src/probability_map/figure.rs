//! The probability map as images over the map.

use super::ProbabilityMap;
use crate::output::figures::FigureFile;
use crate::output::png;
use crate::output::ramp;
use crate::output::svg::{Backdrop, Frames, Role, Scene, Style};
use loc_maps::grid::{Cell, Occupancy};
use nalgebra::Point2;

/// Radius of the ring around the robot \[m\].
const RING: f64 = 0.4;

/// Both images, with the scan as it was taken.
pub(super) fn figure(map: &ProbabilityMap, title: &str, decades: f64) -> FigureFile {
    let bar = ramp::bar(-decades, 0.0, "log10 of the likelihood, relative to the highest");
    let frames = Frames::new(title)
        .subtitle(format!("one scan, {} beams; darker places are more likely", map.beams))
        .columns(2)
        .frame("with the heading that fits best", scene(map, &map.any_heading, decades))
        .frame("with the true heading", scene(map, &map.true_heading, decades))
        .bar(bar);
    FigureFile {
        file: "probability.svg".into(),
        caption: "How likely the scan is at each place of the map".into(),
        svg: frames.render(),
    }
}

fn scene(map: &ProbabilityMap, log_likelihoods: &[f64], decades: f64) -> Scene {
    let laser = map.truth * map.mounting;
    let ends = map.scan.beams().map(|beam| {
        let end = laser.transform(&beam.point());
        (end.x, end.y)
    });
    Scene::new("")
        .backdrop(image(map, log_likelihoods, decades))
        .dots(Style::from(Role::Method(5)).width(1.8), "the scan", ends)
        .ring("robot", RING, map.truth)
}

/// Likelihoods as colours; walls dark, unknown space grey.
fn image(map: &ProbabilityMap, log_likelihoods: &[f64], decades: f64) -> Backdrop {
    let frame = &map.frame;
    let (columns, rows) = (frame.width(), frame.height());
    let highest = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = -decades * std::f64::consts::LN_10;
    let mut pixels = Vec::with_capacity(columns * rows);
    for row in (0..rows).rev() {
        for column in 0..columns {
            let value = log_likelihoods[row * columns + column];
            let share = 1.0 - (value - highest) / lowest;
            let wall = touches_wall(map, Cell::new(column, row));
            pixels.push(match value.is_finite() {
                _ if wall => ramp::WALL,
                true => ramp::color(share),
                false => ramp::UNKNOWN,
            });
        }
    }
    // A turned map is drawn in its own frame.
    let (width, height) = (columns as f64 * frame.resolution(), rows as f64 * frame.resolution());
    let origin = frame.origin();
    Backdrop {
        min: (origin.x, origin.y),
        max: (origin.x + width, origin.y + height),
        data_uri: png::rgb(&pixels, columns),
    }
}

/// Whether any of a few places within a square is a wall.
fn touches_wall(map: &ProbabilityMap, cell: Cell) -> bool {
    let samples = (map.frame.resolution() / map.map.resolution()).ceil().clamp(1.0, 4.0) as usize;
    let inside = |k: usize| (k as f64 + 0.5) / samples as f64;
    (0..samples * samples).any(|k| {
        let (u, v) = (inside(k % samples), inside(k / samples));
        let place: Point2<f64> = map.frame.to_map(cell.column as f64 + u, cell.row as f64 + v);
        map.map.occupancy_at(&place) == Occupancy::Occupied
    })
}
