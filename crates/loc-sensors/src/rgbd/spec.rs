//! What a data sheet says of an RGB-D camera.

use crate::Result;
use crate::check::{count, in_range, reach};
use loc_core::error::{non_negative, positive, probability};
use std::f64::consts::PI;

/// Picture, view, reach and noise of an RGB-D camera. Pixels are square, or nearly so: each axis
/// follows from its own angle of view.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DepthCameraSpec {
    /// Pixels in a row.
    pub width: usize,
    /// Pixels in a column.
    pub height: usize,
    /// Angle of view from left to right \[rad\].
    pub horizontal_fov: f64,
    /// Angle of view from top to bottom \[rad\].
    pub vertical_fov: f64,
    /// Smallest depth \[m\].
    pub range_min: f64,
    /// Largest depth \[m\].
    pub range_max: f64,
    /// Pictures per second \[Hz\].
    pub rate: f64,
    /// Distance from projector to camera \[m\].
    pub base: f64,
    /// Errors of the disparity.
    pub noise: DisparityNoise,
}

impl DepthCameraSpec {
    /// More pixels in a row or column than this no camera has.
    pub const MAX_PIXELS: usize = 10_000;

    /// Asus Xtion PRO: 640 x 480 at 30 Hz, 58 x 45 deg, 0.8 m to 3.5 m.
    ///
    /// The data sheet gives no errors. The design is that of the Kinect: base 75 mm, disparity
    /// in eighths of a pixel, half of one as its standard deviation after rounding (Khoshelham and
    /// Elberink 2012), which makes 6 mm at 2 m and 18 mm at 3.5 m.
    pub fn xtion_pro() -> Self {
        let step = 0.125;
        DepthCameraSpec {
            width: 640,
            height: 480,
            horizontal_fov: 58_f64.to_radians(),
            vertical_fov: 45_f64.to_radians(),
            range_min: 0.8,
            range_max: 3.5,
            rate: 30.0,
            base: 0.075,
            noise: DisparityNoise {
                // Half a step in all, a twelfth of its square by rounding.
                sigma: step * (0.25_f64 - 1.0 / 12.0).sqrt(),
                step,
                dropout: 0.0,
            },
        }
    }

    /// Focal length in pixels, horizontally.
    pub fn focal_length(&self) -> f64 {
        0.5 * self.width as f64 / (0.5 * self.horizontal_fov).tan()
    }

    /// Disparity times depth \[px m\].
    pub fn disparity_depth(&self) -> f64 {
        self.focal_length() * self.base
    }

    /// Standard deviation of a depth \[m\].
    pub fn sigma_at(&self, depth: f64) -> f64 {
        depth * depth / self.disparity_depth() * self.noise.rounded_sigma()
    }

    /// For each column, how far to the left its rays go per metre of depth, from the left edge on.
    pub fn column_slopes(&self) -> Vec<f64> {
        slopes(self.width, self.horizontal_fov)
    }

    /// For each row, how far up its rays go per metre of depth, from the upper edge on.
    pub fn row_slopes(&self) -> Vec<f64> {
        slopes(self.height, self.vertical_fov)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Length`] for no pixels or too many, [`crate::Error::OutOfRange`] for angles
    /// of view outside (0, pi), depths in the wrong order, a rate or base that is not positive,
    /// and bad noise.
    pub fn check(&self) -> Result<()> {
        count("pixels in a row", "1 to 10000", Self::MAX_PIXELS, self.width)?;
        count("pixels in a column", "1 to 10000", Self::MAX_PIXELS, self.height)?;
        let open = |fov: f64| fov > 0.0 && fov < PI;
        in_range("horizontal angle of view [rad]", "between 0 and pi", self.horizontal_fov, open)?;
        in_range("vertical angle of view [rad]", "between 0 and pi", self.vertical_fov, open)?;
        reach(self.range_min, self.range_max)?;
        positive("pictures per second [Hz]", self.rate)?;
        positive("distance from projector to camera [m]", self.base)?;
        self.noise.check()
    }
}

impl Default for DepthCameraSpec {
    /// The [`DepthCameraSpec::xtion_pro`].
    fn default() -> Self {
        DepthCameraSpec::xtion_pro()
    }
}

/// Slopes of the middles of `pixels` pixels, positive first.
fn slopes(pixels: usize, fov: f64) -> Vec<f64> {
    let (half, edge) = (0.5 * pixels as f64, (0.5 * fov).tan());
    (0..pixels.min(DepthCameraSpec::MAX_PIXELS))
        .map(|k| (1.0 - (k as f64 + 0.5) / half) * edge)
        .collect()
}

/// Errors of the disparity, from which those of the depth follow:
/// `sigma_z = z^2 / (f b) sigma_disparity` with focal length f and base b (Khoshelham and Elberink
/// 2012).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct DisparityNoise {
    /// Standard deviation of the disparity before it is rounded \[px\].
    pub sigma: f64,
    /// What the disparity is rounded to \[px\]; 0 for not at all.
    pub step: f64,
    /// Probability that a pixel measures nothing.
    pub dropout: f64,
}

impl DisparityNoise {
    /// A perfect camera.
    pub const NONE: DisparityNoise = DisparityNoise { sigma: 0.0, step: 0.0, dropout: 0.0 };

    /// Standard deviation of the disparity after rounding \[px\].
    pub fn rounded_sigma(&self) -> f64 {
        (self.sigma * self.sigma + self.step * self.step / 12.0).sqrt()
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity, rounding to more than a
    /// pixel, and a probability outside \[0, 1\].
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of the disparity [px]", self.sigma)?;
        let fine = |step: f64| (0.0..=1.0).contains(&step);
        in_range("step of the disparity [px]", "a number in [0, 1]", self.step, fine)?;
        probability("probability that a pixel measures nothing", self.dropout)?;
        Ok(())
    }
}
