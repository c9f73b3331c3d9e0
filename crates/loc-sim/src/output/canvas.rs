//! The known part of a grid as an image whose free cells have colours that mean something.

use super::backdrop::known;
use super::png;
use super::ramp::{Rgb, UNKNOWN, WALL};
use super::svg::Backdrop;
use loc_maps::grid::Occupancy;
use loc_maps::{Bounds, OccupancyGrid};
use nalgebra::Point2;

/// Longest side of an image \[px\].
const LARGEST: f64 = 400.0;

/// The pixels of an image of the known part of a grid, upright in the map.
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
        let pixel = map.resolution().max(width.max(height) / LARGEST);
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
        let pixels: Vec<Rgb> = self.places().enumerate().map(paint).collect();
        let Bounds { min, max } = self.bounds;
        let (width, height) = (self.columns as f64 * self.pixel, self.rows as f64 * self.pixel);
        Backdrop {
            min: (min.x, max.y - height),
            max: (min.x + width, max.y),
            data_uri: png::rgb(&pixels, self.columns),
        }
    }
}
