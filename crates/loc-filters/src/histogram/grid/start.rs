//! The belief of a robot whose start is known.

use super::belief::Belief;
use super::settings::GridSettings;
use super::space::PoseSpace;
use super::stack::Stack;
use super::window::Window;
use crate::{Error, Result};
use loc_core::{Gaussian, Pose2};
use nalgebra::{Matrix3, Vector3};

/// A normal distribution, with the extent of the cells that it is put into.
struct Density {
    start: Gaussian<3>,
    information: Matrix3<f64>,
}

impl Density {
    fn new(start: &Gaussian<3>, cell: f64, sector: f64) -> Result<Self> {
        let start = Gaussian::new(start.mean, start.covariance)?;
        let extent = Vector3::new(cell * cell, cell * cell, sector * sector) / 12.0;
        let covariance = start.covariance + Matrix3::from_diagonal(&extent);
        let inverse = covariance.cholesky().map(|factor| factor.inverse());
        let information = inverse.ok_or_else(|| loc_core::Error::NotACovariance {
            what: "covariance of the start",
            expected: "positive semi-definite",
            found: start.covariance.to_string(),
        })?;
        Ok(Density { start, information })
    }

    /// Logarithm of the density, but for a constant.
    fn log(&self, pose: Pose2) -> f64 {
        let off = self.start.pose_deviation(pose);
        -0.5 * off.dot(&(self.information * off))
    }
}

impl Belief {
    /// A robot near a pose; one that is known well goes into the fine grid.
    pub(super) fn start_near(
        &mut self,
        start: &Gaussian<3>,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Result<()> {
        let [x, y, theta] = [0, 1, 2].map(|k| 3.0 * start.covariance[(k, k)].sqrt());
        let mut stack = Stack::new(space.size());
        let mut window = None;
        if x.max(y) <= settings.fine.reach && theta <= settings.fine.turn {
            let mut fine = Window::at(start.pose(), &settings.fine)?;
            let density = Density::new(start, settings.fine.cell, settings.fine.heading)?;
            let rate = |layer, place| {
                let pose = fine.pose(layer, place);
                space.is_free_at(&pose.position()).then(|| density.log(pose))
            };
            let mut filled = Stack::new(fine.stack().size());
            fill(&mut filled, rate)?;
            *fine.stack_mut() = filled;
            window = Some(fine);
        } else {
            let (cell, sector) = (space.squares().resolution(), space.heading_step());
            let density = Density::new(start, cell, sector)?;
            let rate =
                |layer, place| space.has_room(place).then(|| density.log(space.pose(layer, place)));
            fill(&mut stack, rate)?;
        }
        (self.stack, self.window, self.anywhere) = (stack, window, 0.0);
        Ok(())
    }
}

/// Below this \[nat\] a cell has no part in a start: nearly eight standard deviations away.
const FAINT: f64 = -30.0;

/// Gives the cells that have a density a total of 1.
fn fill(stack: &mut Stack, log_density: impl Fn(usize, usize) -> Option<f64>) -> Result<()> {
    let size = stack.size();
    let cells = || (0..size.headings).flat_map(|layer| (0..size.layer()).map(move |k| (layer, k)));
    let rated =
        cells().filter_map(|(layer, place)| Some((layer, place, log_density(layer, place)?)));
    let rated: Vec<(usize, usize, f64)> = rated.collect();
    let highest = rated.iter().map(|cell| cell.2).fold(f64::NEG_INFINITY, f64::max);
    if highest.is_nan() || highest <= FAINT {
        return Err(Error::NoRoom { what: "start of the robot" });
    }
    let worthy = || rated.iter().filter(|cell| cell.2 - highest > FAINT);
    let total: f64 = worthy().map(|cell| (cell.2 - highest).exp()).sum();
    worthy()
        .for_each(|&(layer, place, log)| stack.add(layer, place, (log - highest).exp() / total));
    Ok(())
}
