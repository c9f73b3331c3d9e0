//! The simulated camera: what each column of the picture shows, measured with noise.

use super::{ColorImage, DepthCameraSpec, DepthImage, Frame};
use crate::Result;
use crate::check::finite_pose;
use crate::world::{Rgb, WallWorld};
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
    /// Range of the colour image \[m\].
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

/// What a stretch of a column shows.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Surface {
    /// A wall with its inverse depth \[1/m\].
    Wall {
        /// 1 / depth.
        inverse_depth: f64,
        /// Its colour.
        color: Rgb,
    },
    /// The floor, whose depth is that of the row.
    Floor,
    /// Nothing in reach.
    Nothing,
}

/// A column as stretches (first row, surface), read from the top of the picture down.
#[derive(Debug, Clone)]
struct Column {
    /// The stretches that are still to come, the next one last.
    ahead: Vec<(usize, Surface)>,
    now: Surface,
}

impl Column {
    /// What a row shows; the rows of successive calls must not decrease.
    fn at(&mut self, row: usize) -> Surface {
        while let Some((_, surface)) = self.ahead.pop_if(|(from, _)| *from <= row) {
            self.now = surface;
        }
        self.now
    }
}

/// View of a level camera at height `height` \[m\], one column of the picture at a time.
///
/// The optical axis is level, so all pixels of a column look along one planar ray, and every wall
/// on it has one depth over its full height. From the bottom of the picture upwards a column shows
/// the floor, the nearest wall, above its edge the floor behind it, the next wall, and so on.
struct View<'a> {
    pose: Pose2,
    height: f64,
    reach: f64,
    /// How far up the rays of each row go per metre of depth, from the upper edge on.
    row_slopes: &'a [f64],
}

impl View<'_> {
    /// The column whose rays go `slope` to the left per metre of depth.
    fn column(&self, world: &(impl WallWorld + ?Sized), slope: f64) -> Column {
        let direction = self.pose.theta + slope.atan();
        let secant = f64::hypot(1.0, slope);
        let mut ahead = Vec::with_capacity(4);
        // Rows from `free` on are taken.
        let mut free = self.row_slopes.len();
        let mut show = |from: usize, surface: Surface| {
            if from < free {
                ahead.push((from, surface));
                free = from;
            }
            free > 0
        };
        world.visit_walls(&self.pose.position(), direction, self.reach * secant, &mut |wall| {
            let inverse_depth = secant / wall.range;
            let foot = self.row_below(-self.height * inverse_depth);
            let top = self.row_below((wall.height - self.height) * inverse_depth);
            show(foot, Surface::Floor)
                && show(top, Surface::Wall { inverse_depth, color: wall.color })
        });
        show(self.row_below(0.0), Surface::Floor);
        show(0, Surface::Nothing);
        Column { ahead, now: Surface::Nothing }
    }

    /// The first row, from the top, whose rays point lower than `slope`.
    fn row_below(&self, slope: f64) -> usize {
        self.row_slopes.partition_point(|row| *row >= slope)
    }
}
