//! A grid as the image under a scene.

use loc_maps::grid::Occupancy;
use loc_maps::{Bounds, OccupancyGrid};
use loc_plot::color::{Image, Rgb, UNKNOWN, WALL};
use loc_plot::{Backdrop, color};
use nalgebra::Point2;

/// Longest side of the image \[px\].
const BACKDROP_SIDE: f64 = 1600.0;

/// The known part of a grid as an image: free white, occupied black, unknown grey. A grid whose
/// origin is turned is drawn turned.
///
/// `None` for a grid of which nothing is known.
pub fn backdrop(grid: &OccupancyGrid) -> Option<Backdrop> {
    let bounds = known(grid)?;
    let (width, height) = (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y);
    let pixel = grid.resolution().max(width.max(height) / BACKDROP_SIDE);
    let (columns, rows) = ((width / pixel).ceil() as usize, (height / pixel).ceil() as usize);
    let mut image = vec![GREY; columns * rows];
    paint(grid, &bounds, pixel, columns, &mut image);
    Some(Backdrop {
        min: (bounds.min.x, bounds.max.y - rows as f64 * pixel),
        max: (bounds.min.x + columns as f64 * pixel, bounds.max.y),
        data_uri: color::data_uri(&color::grey_png(&image, columns)),
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

/// Longest side of an image \[px\].
const CANVAS_SIDE: f64 = 400.0;

/// The pixels of an image of the known part of a grid, upright in the map, whose free cells get
/// colours that mean something.
pub(crate) struct Canvas {
    bounds: Bounds,
    /// Side of a pixel \[m\].
    pixel: f64,
    columns: usize,
    rows: usize,
}

impl Canvas {
    /// `None` for a grid of which nothing is known.
    pub(crate) fn new(map: &OccupancyGrid) -> Option<Self> {
        let bounds = known(map)?;
        let (width, height) = (bounds.max.x - bounds.min.x, bounds.max.y - bounds.min.y);
        let pixel = map.resolution().max(width.max(height) / CANVAS_SIDE);
        let (columns, rows) = ((width / pixel).ceil() as usize, (height / pixel).ceil() as usize);
        Some(Canvas { bounds, pixel, columns, rows })
    }

    /// The longer side \[m\].
    pub(crate) fn larger_side(&self) -> f64 {
        self.columns.max(self.rows) as f64 * self.pixel
    }

    /// The places in the middles of all pixels \[m\], row by row from the upper left.
    pub(crate) fn places(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        let at = |k: usize| (k as f64 + 0.5) * self.pixel;
        let place = move |index: usize| {
            let (column, row) = (index % self.columns, index / self.columns);
            Point2::new(self.bounds.min.x + at(column), self.bounds.max.y - at(row))
        };
        (0..self.columns * self.rows).map(place)
    }

    /// Paints free cells as `color` says, by the number of the pixel and its place; walls dark,
    /// unknown space grey.
    pub(crate) fn paint(
        &self,
        map: &OccupancyGrid,
        color: impl Fn(usize, &Point2<f64>) -> Rgb,
    ) -> Backdrop {
        let paint = |(index, place): (usize, Point2<f64>)| match map.occupancy_at(&place) {
            Occupancy::Occupied => WALL,
            Occupancy::Unknown => UNKNOWN,
            Occupancy::Free => color(index, &place),
        };
        let pixels = self.places().enumerate().map(paint).collect();
        let Bounds { min, max } = self.bounds;
        let (width, height) = (self.columns as f64 * self.pixel, self.rows as f64 * self.pixel);
        Backdrop {
            min: (min.x, max.y - height),
            max: (min.x + width, max.y),
            data_uri: Image { width: self.columns, pixels }.data_uri(),
        }
    }
}
