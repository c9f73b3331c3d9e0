//! The measurement: a depth image, a colour image, a point cloud, a virtual laser scan.

use super::{DepthCamera, DepthCameraSpec};
use crate::check::in_range;
use crate::laser::LaserScan;
use crate::world::Rgb;
use crate::{Error, Result};
use loc_core::error::{finite, probability};
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

/// Converts a depth image to the scan of a laser scanner in the camera's place: for each direction
/// the range of the points at the heights of a robot. Estimators for scans so work with RGB-D
/// cameras.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct VirtualScan {
    /// Points below this height above the floor do not count \[m\].
    pub lower: f64,
    /// Points above this height above the floor do not count \[m\].
    pub upper: f64,
    /// Angle from one beam to the next \[rad\].
    pub angle_increment: f64,
    /// Which of a beam's points counts: 0 the nearest, safe for obstacles but too short by some
    /// standard deviations of the noise; 0.5 the mean of the middle half, right for walls.
    pub quantile: f64,
}

impl VirtualScan {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for heights in the wrong order, an increment that is not
    /// positive or too small for a scan, and a quantile outside \[0, 1\].
    pub fn check(&self) -> Result<()> {
        finite("lower height of a virtual scan [m]", self.lower)?;
        let above = |upper: f64| upper.is_finite() && upper > self.lower;
        let expected = "a finite number above the lower height";
        in_range("upper height of a virtual scan [m]", expected, self.upper, above)?;
        let coarse = |angle: f64| (1e-5..1.0).contains(&angle);
        in_range("angle between beams [rad]", "1e-5 to 1", self.angle_increment, coarse)?;
        probability("quantile of a beam's points", self.quantile)?;
        Ok(())
    }

    /// The scan in an image of `camera`, in the camera's frame; NaN in directions where nothing
    /// was measured (too near and too far look alike in the image).
    ///
    /// # Errors
    /// Those of [`VirtualScan::check`] and [`DepthCamera::check`].
    pub fn of(&self, image: &DepthImage, camera: &DepthCamera) -> Result<LaserScan> {
        self.check()?;
        camera.check()?;
        let half_fov = 0.5 * camera.spec.horizontal_fov;
        let side = (half_fov / self.angle_increment).floor();
        let angle_min = -side * self.angle_increment;
        let mut beams = vec![Vec::new(); 2 * side as usize + 1];
        let heights = (self.lower - camera.height)..=(self.upper - camera.height);
        let angles: Vec<f64> = camera.spec.column_slopes().into_iter().map(f64::atan).collect();
        for (column, _, point) in image.points(&camera.spec) {
            let beam = ((angles[column] - angle_min) / self.angle_increment).round();
            if heights.contains(&point.z)
                && let Some(ranges) = beams.get_mut(beam.max(0.0) as usize)
            {
                ranges.push(f64::hypot(point.x, point.y));
            }
        }
        let ranges = beams.iter_mut().map(|ranges| self.select(ranges)).collect();
        Ok(self.scan(angle_min, ranges, camera))
    }

    fn scan(&self, angle_min: f64, ranges: Vec<f64>, camera: &DepthCamera) -> LaserScan {
        LaserScan {
            angle_min,
            angle_max: -angle_min,
            angle_increment: self.angle_increment,
            time_increment: 0.0,
            scan_time: 1.0 / camera.spec.rate,
            range_min: camera.spec.range_min,
            range_max: camera.spec.range_max / (0.5 * camera.spec.horizontal_fov).cos(),
            ranges,
            intensities: Vec::new(),
        }
    }

    fn select(&self, ranges: &mut [f64]) -> f64 {
        if ranges.is_empty() {
            return f64::NAN;
        }
        ranges.sort_unstable_by(f64::total_cmp);
        // Depths come in steps; the mean about the quantile finds the place between two of them.
        let half_width = self.quantile.min(1.0 - self.quantile).min(0.25);
        let rank = |share: f64| (share * (ranges.len() - 1) as f64).round() as usize;
        let middle = &ranges[rank(self.quantile - half_width)..=rank(self.quantile + half_width)];
        middle.iter().sum::<f64>() / middle.len() as f64
    }
}

impl Default for VirtualScan {
    /// The middle of the points from 10 cm to 1 m above the floor, every quarter of a degree.
    fn default() -> Self {
        VirtualScan {
            lower: 0.1,
            upper: 1.0,
            angle_increment: 0.25_f64.to_radians(),
            quantile: 0.5,
        }
    }
}
