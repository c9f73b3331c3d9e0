//! The simulated camera.

use super::image::{Column, Surface, View};
use super::{ColorImage, DepthCameraSpec, DepthImage, Frame};
use crate::Result;
use crate::check::finite_pose;
use crate::world::WallWorld;
use loc_core::Pose2;
use loc_core::error::positive;
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};

/// An RGB-D camera on a robot, its optical axis level.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct DepthCamera {
    /// The camera's planar pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Its height above the floor \[m\].
    pub height: f64,
    /// How far colours are seen \[m\].
    pub sight: f64,
    /// Its data sheet.
    pub spec: DepthCameraSpec,
}

impl DepthCamera {
    /// A camera in the middle of the robot, 0.5 m above the floor.
    ///
    /// # Errors
    /// Those of [`DepthCameraSpec::check`].
    pub fn new(spec: DepthCameraSpec) -> Result<Self> {
        spec.check()?;
        Ok(DepthCamera { spec, ..DepthCamera::default() })
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a mounting that is not finite, a height or sight
    /// that is not positive, and those of [`DepthCameraSpec::check`].
    pub fn check(&self) -> Result<()> {
        finite_pose("mounting of an RGB-D camera", self.mounting)?;
        positive("height of an RGB-D camera [m]", self.height)?;
        positive("how far an RGB-D camera sees colours [m]", self.sight)?;
        self.spec.check()
    }

    /// What the camera sees from a robot at `pose`.
    pub fn capture<R: Rng + ?Sized>(
        &self,
        world: &(impl WallWorld + ?Sized),
        pose: Pose2,
        rng: &mut R,
    ) -> Frame {
        let row_slopes = self.spec.row_slopes();
        let mut columns = self.columns(world, pose, &row_slopes);
        let pixels = columns.len() * row_slopes.len();
        let (mut depths, mut colors) = (Vec::with_capacity(pixels), Vec::with_capacity(pixels));
        let floor = world.floor_color();
        for (row, slope) in row_slopes.iter().enumerate() {
            let floor_depth = -slope / self.height;
            for column in &mut columns {
                let (inverse_depth, color) = match column.at(row) {
                    Surface::Wall { inverse_depth, color } => (inverse_depth, color),
                    Surface::Floor => (floor_depth, floor),
                    Surface::Nothing => (0.0, [0; 3]),
                };
                depths.push(self.measure(inverse_depth, rng));
                colors.push(color);
            }
        }
        let width = columns.len();
        Frame { depth: DepthImage { width, depths }, color: ColorImage { width, colors } }
    }

    /// What every column shows, from the left.
    fn columns(
        &self,
        world: &(impl WallWorld + ?Sized),
        pose: Pose2,
        row_slopes: &[f64],
    ) -> Vec<Column> {
        let depths = self.spec.range_max + 5.0 * self.spec.sigma_at(self.spec.range_max);
        let reach = depths.max(self.sight);
        let view = View { pose: pose * self.mounting, height: self.height, reach, row_slopes };
        self.spec.column_slopes().into_iter().map(|slope| view.column(world, slope)).collect()
    }

    /// The depth that a pixel reports of a true inverse depth \[1/m\], 0 for nothing in reach.
    ///
    /// Draws for every pixel, whatever it shows.
    fn measure<R: Rng + ?Sized>(&self, inverse_depth: f64, rng: &mut R) -> f32 {
        let noise = &self.spec.noise;
        let error: f64 = StandardNormal.sample(rng);
        let lost = noise.dropout > 0.0 && rng.random::<f64>() < noise.dropout;
        if lost || inverse_depth <= 0.0 {
            return f32::NAN;
        }
        let shift = self.spec.disparity_depth();
        let mut disparity = shift * inverse_depth + noise.sigma * error;
        if noise.step > 0.0 {
            disparity = noise.step * f64::from((disparity / noise.step + 0.5) as i32);
        }
        let depth = shift / disparity;
        let seen = (self.spec.range_min..=self.spec.range_max).contains(&depth);
        if seen { depth as f32 } else { f32::NAN }
    }
}

impl Default for DepthCamera {
    /// An Xtion PRO in the middle of the robot, 0.5 m above the floor; colours up to 20 m.
    fn default() -> Self {
        DepthCamera {
            mounting: Pose2::IDENTITY,
            height: 0.5,
            sight: 20.0,
            spec: DepthCameraSpec::xtion_pro(),
        }
    }
}
