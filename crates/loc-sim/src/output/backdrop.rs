//! A grid as the image under a scene.

use super::svg::Backdrop;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ExtendedColorType, ImageEncoder};
use loc_maps::grid::Occupancy;
use loc_maps::{Bounds, OccupancyGrid};
use nalgebra::Point2;

/// Longest side of the image \[px\].
const LARGEST: f64 = 1600.0;

/// The known part of a grid as an image: free white, occupied black, unknown grey. A grid whose
/// origin is turned is drawn turned.
///
/// `None` for a grid of which nothing is known.
pub fn backdrop(grid: &OccupancyGrid) -> Option<Backdrop> {
    let bounds = known(grid)?;
    let (width, height) = (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y);
    let pixel = grid.resolution().max(width.max(height) / LARGEST);
    let (columns, rows) = ((width / pixel).ceil() as usize, (height / pixel).ceil() as usize);
    let mut image = vec![GREY; columns * rows];
    paint(grid, &bounds, pixel, columns, &mut image);
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    encoder.write_image(&image, columns as u32, rows as u32, ExtendedColorType::L8).ok()?;
    Some(Backdrop {
        min: (bounds.min.x, bounds.max.y - rows as f64 * pixel),
        max: (bounds.min.x + columns as f64 * pixel, bounds.max.y),
        data_uri: format!("data:image/png;base64,{}", STANDARD.encode(png)),
    })
}

const GREY: u8 = 205;
const WHITE: u8 = 255;
const BLACK: u8 = 0;

/// The box around the cells that are free or occupied.
pub(super) fn known(grid: &OccupancyGrid) -> Option<Bounds> {
    let half = 0.5 * grid.resolution();
    let cells = grid.iter().filter(|(_, value)| Occupancy::of(*value) != Occupancy::Unknown);
    let centers = cells.map(|(cell, _)| grid.frame().center(cell));
    let corners = centers
        .flat_map(|c| [[-half, -half], [half, half]].map(|d| c + nalgebra::Vector2::from(d)));
    Bounds::around(corners)
}

/// Asks the grid at a few places of each pixel; a wall in any of them makes it black.
fn paint(grid: &OccupancyGrid, bounds: &Bounds, pixel: f64, columns: usize, image: &mut [u8]) {
    let samples = (pixel / grid.resolution()).ceil().clamp(1.0, 8.0) as usize;
    for (index, shade) in image.iter_mut().enumerate() {
        let (column, row) = (index % columns, index / columns);
        for k in 0..samples * samples {
            let inside = |k: usize| (k as f64 + 0.5) / samples as f64;
            let place = Point2::new(
                bounds.min.x + (column as f64 + inside(k % samples)) * pixel,
                bounds.max.y - (row as f64 + inside(k / samples)) * pixel,
            );
            match grid.occupancy_at(&place) {
                Occupancy::Occupied => {
                    *shade = BLACK;
                    break;
                }
                Occupancy::Free => *shade = WHITE,
                Occupancy::Unknown => {}
            }
        }
    }
}
