//! How many beams of a scan end on the walls of a map: a judge where no true pose is known.

use crate::Result;
use loc_core::Pose2;
use loc_maps::{DistanceMap, OccupancyGrid};
use loc_sensors::laser::LaserScan;

/// The walls of a map, made ready to judge poses by what a laser sees there.
///
/// ```
/// use loc_core::Pose2;
/// use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
/// use loc_sensors::laser::LaserScan;
/// use loc_sim::metrics::BeamFit;
/// let mut map = OccupancyGrid::filled(GridFrame::new(60, 60, 0.1, Pose2::IDENTITY)?, 0);
/// (0..60).try_for_each(|row| map.set(Cell::new(40, row), 100))?;
/// let scan = LaserScan {
///     angle_min: 0.0,
///     angle_max: 0.1,
///     angle_increment: 0.1,
///     time_increment: 0.0,
///     scan_time: 0.1,
///     range_min: 0.1,
///     range_max: 9.0,
///     ranges: vec![2.05, 3.0],
///     intensities: Vec::new(),
/// };
/// let walls = BeamFit::new(&map)?;
/// // The first beam ends on the wall at x = 4.05 m, the second one behind it.
/// assert_eq!(walls.share(Pose2::new(2.0, 3.0, 0.0), &scan, Pose2::IDENTITY), Some(0.5));
/// # Ok::<(), loc_sim::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BeamFit {
    walls: DistanceMap,
}

impl BeamFit {
    /// A beam fits that ends within this of a wall \[m\].
    pub const WITHIN: f64 = 0.12;

    /// The walls are the occupied cells.
    ///
    /// # Errors
    /// [`loc_maps::Error`].
    pub fn new(map: &OccupancyGrid) -> Result<Self> {
        // The reach is in whole cells.
        let reach = BeamFit::WITHIN + 2.0 * map.frame().resolution();
        Ok(BeamFit { walls: DistanceMap::new(map, reach)? })
    }

    /// The share of the beams with a return whose end lies within [`BeamFit::WITHIN`] of a wall,
    /// from the centre of its cell to that of the wall's, in \[0, 1\]; for a robot at `pose` with
    /// its laser at `mounting` (`base_from_laser`). `None` for a scan without any return; the
    /// greatest range is none, and a beam that ends off the map does not fit.
    pub fn share(&self, pose: Pose2, scan: &LaserScan, mounting: Pose2) -> Option<f64> {
        let laser = pose * mounting;
        let (mut count, mut fitting) = (0_u32, 0_u32);
        for beam in scan.beams().filter(|beam| beam.range < scan.range_max) {
            let distance = self.walls.distance_at(&laser.transform(&beam.point()));
            count += 1;
            fitting += u32::from(distance.is_some_and(|distance| distance <= BeamFit::WITHIN));
        }
        (count > 0).then(|| f64::from(fitting) / f64::from(count))
    }
}
