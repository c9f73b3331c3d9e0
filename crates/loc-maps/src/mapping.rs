//! Building an occupancy grid from scans whose poses are known (C1).
//!
//! Every beam is evidence that the cells along it are free and that the cell at its end is
//! occupied. A [`GridMapper`] sums this evidence in each cell as log-odds (Moravec and Elfes, 1985;
//! Probabilistic Robotics, 9.2) and converts it to a grid on request.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::Occupancy;
//! use loc_maps::mapping::{GridMapper, InverseSensorModel};
//! use loc_sensors::laser::{LaserScan, LaserScanner, LaserSpec};
//! use loc_sensors::world::Room;
//! # use nalgebra::Point2;
//!
//! let room = Room::new([-2.0, -1.5], [2.0, 1.5])?;
//! let scanner = LaserScanner::new(LaserSpec::hokuyo_ust_10lx())?;
//! let mut rng = loc_core::random::stream(1, "laser");
//! let scan = scanner.scan(&room, Pose2::IDENTITY, &mut rng);
//! let grid = GridMapper::map(&[(Pose2::IDENTITY, scan)], 0.05, InverseSensorModel::default())?;
//! assert_eq!(grid.occupancy_at(&Point2::new(1.0, 0.0)), Occupancy::Free);
//! # Ok::<(), loc_maps::Error>(())
//! ```

use crate::grid::{Cell, GridFrame, OccupancyGrid};
use crate::raycast::{GridRay, Traversal};
use crate::{Bounds, Result};
use loc_core::Pose2;
use loc_core::error::{finite, non_negative, positive, probability};
use loc_sensors::laser::LaserScan;
use nalgebra::{Point2, Vector2};

/// The inverse sensor model: how much a beam changes the log-odds of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct InverseSensorModel {
    /// Log-odds that the cell at a beam's end gains; also known as l_occ.
    pub hit: f64,
    /// Log-odds that a cell along a beam loses; also known as l_free, with its sign turned.
    pub miss: f64,
    /// Largest log-odds, of either sign, so that a cell can still change.
    pub limit: f64,
    /// Beams are followed no farther than this \[m\].
    pub max_range: f64,
    /// Length of the free cells along a beam without a return \[m\]; 0 for not at all.
    pub clear_without_return: f64,
    /// Probability from which on a cell is occupied.
    pub occupied: f64,
    /// Probability up to which a cell is free.
    pub free: f64,
}

impl InverseSensorModel {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for values that are negative or not finite, probabilities
    /// outside \[0, 1\], and a free threshold above the occupied one.
    pub fn check(&self) -> Result<()> {
        positive("log-odds of a hit", self.hit)?;
        positive("log-odds of a miss", self.miss)?;
        positive("limit of the log-odds", self.limit)?;
        positive("longest beam [m]", self.max_range)?;
        non_negative("way cleared without return [m]", self.clear_without_return)?;
        probability("probability of an occupied cell", self.occupied)?;
        probability("probability of a free cell", self.free)?;
        finite("probabilities", self.occupied - self.free)?;
        non_negative("occupied minus free threshold", self.occupied - self.free)?;
        Ok(())
    }
}

impl Default for InverseSensorModel {
    /// A hit weighs twice as much as a miss; one beam decides a cell without other evidence, and
    /// a hit and a miss leave a cell undecided.
    fn default() -> Self {
        InverseSensorModel {
            hit: 0.85,
            miss: 0.4,
            limit: 10.0,
            max_range: 30.0,
            clear_without_return: 0.0,
            occupied: 0.65,
            free: 0.45,
        }
    }
}

/// A grid of log-odds that scans are added to.
#[derive(Debug, Clone)]
pub struct GridMapper {
    frame: GridFrame,
    model: InverseSensorModel,
    log_odds: Vec<f32>,
    /// The last scan that updated a cell, and whether by a hit: a scan counts once in a cell.
    touched: Vec<u32>,
    scans: u32,
}

impl GridMapper {
    /// A mapper without scans.
    ///
    /// # Errors
    /// Those of [`InverseSensorModel::check`].
    pub fn new(frame: GridFrame, model: InverseSensorModel) -> Result<Self> {
        model.check()?;
        let cells = frame.cell_count();
        Ok(GridMapper {
            frame,
            model,
            log_odds: vec![0.0; cells],
            touched: vec![0; cells],
            scans: 0,
        })
    }

    /// The grid of a whole set of scans with their poses, `map_from_sensor`, in a frame that is
    /// just large enough for all of them, aligned to whole cells.
    ///
    /// # Errors
    /// Those of [`InverseSensorModel::check`] and [`GridFrame::new`], and for scans that are not
    /// valid.
    pub fn map(
        scans: &[(Pose2, LaserScan)],
        resolution: f64,
        model: InverseSensorModel,
    ) -> Result<OccupancyGrid> {
        let mut mapper = GridMapper::new(frame_around(scans, resolution, &model)?, model)?;
        for (pose, scan) in scans {
            mapper.add(*pose, scan)?;
        }
        Ok(mapper.grid())
    }

    /// Adds a scan taken at `map_from_sensor`. Cells beyond the frame are passed over.
    ///
    /// # Errors
    /// Those of [`LaserScan::check`], and [`loc_core::Error::OutOfRange`] for a pose that is not
    /// finite.
    // ANCHOR: add
    pub fn add(&mut self, map_from_sensor: Pose2, scan: &LaserScan) -> Result<()> {
        scan.check()?;
        for value in [map_from_sensor.x, map_from_sensor.y, map_from_sensor.theta] {
            loc_core::error::finite("pose of a scan [m, m, rad]", value)?;
        }
        self.scans += 1;
        // Ends first: where one beam ends, another one of the same scan clears nothing.
        let longest = self.model.max_range;
        for beam in scan.beams().filter(|beam| beam.range <= longest) {
            let end = map_from_sensor.transform(&beam.point());
            if let Some(cell) = self.frame.cell_at(&end) {
                self.touch(cell, self.model.hit);
            }
        }
        for (index, &range) in scan.ranges.iter().enumerate() {
            let length = self.cleared(scan, range);
            if length > 0.0 {
                self.clear(map_from_sensor, scan.angle(index), length);
            }
        }
        Ok(())
    }
    // ANCHOR_END: add

    /// The length along a beam that its range shows to be free \[m\].
    fn cleared(&self, scan: &LaserScan, range: f64) -> f64 {
        if scan.is_valid(range) {
            // The cell at the end is left to the hit.
            (range - 0.5 * self.frame.resolution()).min(self.model.max_range)
        } else if range == f64::INFINITY {
            self.model.clear_without_return
        } else {
            0.0
        }
    }

    fn clear(&mut self, sensor: Pose2, angle: f64, length: f64) {
        let (sin, cos) = (sensor.theta + angle).sin_cos();
        let Some(ray) = GridRay::new(&self.frame, &sensor.position(), [cos, sin], length) else {
            return;
        };
        let frame = self.frame;
        for cell in Traversal::new(&frame, &ray) {
            self.touch(cell, -self.model.miss);
        }
    }

    fn touch(&mut self, cell: Cell, change: f64) {
        let Some(index) = self.frame.index(cell) else { return };
        if self.touched[index] == self.scans {
            return;
        }
        self.touched[index] = self.scans;
        let sum = f64::from(self.log_odds[index]) + change;
        self.log_odds[index] = sum.clamp(-self.model.limit, self.model.limit) as f32;
    }

    /// The current grid: 100 occupied, 0 free, -1 undecided or never seen.
    pub fn grid(&self) -> OccupancyGrid {
        let value = |(&log_odds, &touched): (&f32, &u32)| {
            let probability = 1.0 / (1.0 + (-f64::from(log_odds)).exp());
            match touched {
                0 => -1,
                _ if probability >= self.model.occupied => 100,
                _ if probability <= self.model.free => 0,
                _ => -1,
            }
        };
        let cells = self.log_odds.iter().zip(&self.touched).map(value).collect();
        OccupancyGrid::from_valid(self.frame, cells)
    }
}

/// The frame that holds every sensor and every beam's end.
fn frame_around(
    scans: &[(Pose2, LaserScan)],
    resolution: f64,
    model: &InverseSensorModel,
) -> Result<GridFrame> {
    loc_core::error::positive("resolution [m]", resolution)?;
    let places = scans.iter().flat_map(|(pose, scan)| {
        let ends = scan.beams().filter(|beam| beam.range <= model.max_range);
        let ends = ends.map(|beam| pose.transform(&beam.point()));
        ends.chain(std::iter::once(pose.position()))
    });
    let bounds = Bounds::around(places).ok_or(loc_core::Error::Length {
        what: "scans",
        expected: "at least one",
        found: scans.len(),
    })?;
    let margin = Vector2::new(resolution, resolution);
    let cells = |point: Point2<f64>| (point.coords / resolution).map(f64::floor);
    let (min, max) = (cells(bounds.min - margin), cells(bounds.max + margin));
    let size = max - min;
    let origin = Pose2::new(min.x * resolution, min.y * resolution, 0.0);
    GridFrame::new(size.x as usize + 1, size.y as usize + 1, resolution, origin)
}
