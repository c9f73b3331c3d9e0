//! The measurement: a depth image, a colour image, a point cloud.

use super::DepthCameraSpec;
use crate::world::Rgb;
use crate::{Error, Result};
use nalgebra::Point3;

/// Depth of every pixel: the distance along the optical axis, not along the ray \[m\]; NaN where
/// nothing was measured (REP-118).
///
/// Kept in `f32`: at 3.5 m that resolves 0.2 um, the camera 35 mm.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImage {
    pub(super) width: usize,
    pub(super) depths: Vec<f32>,
}

/// Colour of every pixel, each as seen by the pixel of the depth image in the same place.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorImage {
    pub(super) width: usize,
    pub(super) colors: Vec<Rgb>,
}

/// What the camera reports at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Depths.
    pub depth: DepthImage,
    /// Colours.
    pub color: ColorImage,
}

/// A point of a point cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CloudPoint {
    /// Place in the camera's frame: x forward, y left, z up \[m\].
    pub position: Point3<f64>,
    /// Its colour.
    pub color: Rgb,
}

impl DepthImage {
    /// An image from its width and its depths, row by row from the upper left \[m\].
    ///
    /// # Errors
    /// [`Error::Length`] for no pixels, or rows that are not full.
    pub fn new(width: usize, depths: Vec<f32>) -> Result<Self> {
        check_rows("depth image", width, depths.len())?;
        Ok(DepthImage { width, depths })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels in a column.
    pub fn height(&self) -> usize {
        self.depths.len() / self.width
    }

    /// All depths, row by row from the upper left \[m\].
    pub fn depths(&self) -> &[f32] {
        &self.depths
    }

    /// Depth in a column, counted from the left, and a row, counted from the top \[m\]; NaN
    /// outside the image.
    pub fn at(&self, column: usize, row: usize) -> f32 {
        if column >= self.width || row >= self.height() {
            return f32::NAN;
        }
        self.depths[row * self.width + column]
    }

    /// The pixels that measured something, as column, row, and place in the camera's frame (x
    /// forward, y left, z up) \[m\].
    pub fn points<'a>(
        &'a self,
        spec: &'a DepthCameraSpec,
    ) -> impl Iterator<Item = (usize, usize, Point3<f64>)> + 'a {
        let (left, up) = (spec.column_slopes(), spec.row_slopes());
        self.depths.iter().enumerate().filter_map(move |(k, &depth)| {
            let (column, row, depth) = (k % self.width, k / self.width, f64::from(depth));
            let (y, z) = (left.get(column)? * depth, up.get(row)? * depth);
            depth.is_finite().then(|| (column, row, Point3::new(depth, y, z)))
        })
    }
}

impl ColorImage {
    /// An image from its width and its colours, row by row from the upper left.
    ///
    /// # Errors
    /// [`Error::Length`] for no pixels, or rows that are not full.
    pub fn new(width: usize, colors: Vec<Rgb>) -> Result<Self> {
        check_rows("colour image", width, colors.len())?;
        Ok(ColorImage { width, colors })
    }

    /// Pixels in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels in a column.
    pub fn height(&self) -> usize {
        self.colors.len() / self.width
    }

    /// All colours, row by row from the upper left.
    pub fn colors(&self) -> &[Rgb] {
        &self.colors
    }
}

impl Frame {
    /// The coloured point cloud in the camera's frame.
    pub fn cloud<'a>(&'a self, spec: &'a DepthCameraSpec) -> impl Iterator<Item = CloudPoint> + 'a {
        self.depth.points(spec).filter_map(|(column, row, position)| {
            let color = *self.color.colors.get(row * self.color.width + column)?;
            Some(CloudPoint { position, color })
        })
    }
}

fn check_rows(what: &'static str, width: usize, pixels: usize) -> Result<()> {
    if width == 0 || pixels == 0 || !pixels.is_multiple_of(width) {
        return Err(Error::Length {
            what,
            expected: "at least one full row of pixels",
            found: pixels,
        });
    }
    Ok(())
}
