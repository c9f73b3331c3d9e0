//! A robot with a laser, followed on the grid.

use super::belief::Belief;
use super::scan::Scan;
use super::sensor::Sensor;
use super::settings::GridSettings;
use super::space::PoseSpace;
use super::window::Window;
use crate::Result;
use loc_core::error::finite;
use loc_core::motion::DrivenPath;
use loc_core::{Gaussian, Pose2};
use loc_maps::OccupancyGrid;
use loc_sensors::laser::LaserScan;
use nalgebra::{Matrix3, Vector3};

/// A robot followed by a histogram over all of its poses.
#[derive(Debug, Clone)]
pub struct GridLocalizer {
    pub(super) settings: GridSettings,
    pub(super) space: PoseSpace,
    sensor: Sensor,
    pub(super) belief: Belief,
    pub(super) path: Option<DrivenPath>,
    /// Whether a scan was taken in since the start.
    has_seen: bool,
    /// The most likely place at the last update.
    pub(super) found: Found,
}

/// The most likely place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    pub(super) share: f64,
    pub(super) gaussian: Gaussian<3>,
}

/// What [`GridLocalizer::update`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GridUpdate {
    /// Nothing but noting the odometry: the robot has not moved enough since the last update.
    StoodStill,
    /// The belief was moved along, but no beam of the scan says anything.
    Blind,
    /// The belief was moved along and corrected.
    Done(GridReport),
}

/// How an update went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridReport {
    /// Logarithm of the mean likelihood of the scan over the predicted belief.
    pub log_evidence: f64,
    /// How many cells of the grid over the map were rated.
    pub rated: usize,
    /// The most that all the others can have of the belief.
    pub passed_over: f64,
}

impl GridLocalizer {
    /// A robot that may be anywhere on the free part of a map.
    ///
    /// # Errors
    /// Settings out of range; [`crate::Error::NoFreeSpace`], and [`loc_core::Error::Length`] for
    /// cells so small that the grid would not fit into memory.
    pub fn new(map: &OccupancyGrid, settings: GridSettings) -> Result<Self> {
        settings.validate()?;
        Window::size(&settings.fine)?;
        let space = PoseSpace::new(map, &settings)?;
        let sensor = Sensor::new(map, &space, &settings)?;
        let belief = Belief::anywhere(&space);
        let gaussian = Gaussian { mean: Vector3::zeros(), covariance: Matrix3::identity() };
        let found = Found { share: 0.0, gaussian };
        let mut localizer =
            GridLocalizer { settings, space, sensor, belief, path: None, has_seen: false, found };
        localizer.look();
        Ok(localizer)
    }

    /// What it was made with.
    pub fn settings(&self) -> &GridSettings {
        &self.settings
    }

    /// The robot is near a pose, with the uncertainty of `start` over (x, y, theta) \[m, m, rad\].
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief that is none, [`crate::Error::NoRoom`] where it has no free
    /// place in reach.
    pub fn start_at(&mut self, start: &Gaussian<3>) -> Result<()> {
        self.belief.start_near(start, &self.space, &self.settings)?;
        self.restart();
        Ok(())
    }

    /// Nobody knows where the robot is.
    pub fn start_anywhere(&mut self) {
        self.belief.forget();
        self.restart();
    }

    fn restart(&mut self) {
        self.look();
        self.has_seen = false;
        self.path = self.path.map(|path| DrivenPath::starting_at(path.end()));
    }

    /// Notes where the odometry is, between two scans: the noise of a way depends on how long it
    /// was, which its ends alone do not tell.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a pose that is not finite, which is not noted.
    pub fn odometry(&mut self, pose: Pose2) -> Result<()> {
        finite("x of the odometry [m]", pose.x)?;
        finite("y of the odometry [m]", pose.y)?;
        finite("heading of the odometry [rad]", pose.theta)?;
        self.path.get_or_insert(DrivenPath::starting_at(pose)).extend(pose);
        Ok(())
    }

    /// Takes in the odometry's pose and what the laser, which sits at `mounting` on the robot
    /// (`base_from_laser`), measured there. The first scan after a start counts in any case, later
    /// ones when the robot has moved enough.
    ///
    /// # Errors
    /// A scan that cannot be one ([`LaserScan::check`]) and a pose that is not finite; the belief
    /// stays as it was then.
    pub fn update(
        &mut self,
        odometry: Pose2,
        scan: &LaserScan,
        mounting: Pose2,
    ) -> Result<GridUpdate> {
        scan.check()?;
        finite("mounting of a laser", mounting.to_vector().sum())?;
        self.odometry(odometry)?;
        let Some(path) = self.path else { return Ok(GridUpdate::StoodStill) };
        let step = path.step();
        if self.has_seen
            && f64::hypot(step.x, step.y) < self.settings.update_distance
            && step.theta.abs() < self.settings.update_turn
        {
            return Ok(GridUpdate::StoodStill);
        }
        let GridLocalizer { settings, space, sensor, belief, .. } = self;
        belief.predict(&path, space, settings)?;
        self.path = Some(DrivenPath::starting_at(path.end()));
        self.has_seen = true;
        let mut update = GridUpdate::Blind;
        if let Some(scan) = Scan::new(scan, mounting, &sensor.field, space, settings) {
            let correction = belief.correct(&scan, sensor, space, settings.negligible);
            belief.focus(&correction, &scan, sensor, space, settings)?;
            update = GridUpdate::Done(GridReport {
                log_evidence: correction.log_evidence,
                rated: correction.cells.len(),
                passed_over: correction.passed_over,
            });
        }
        self.look();
        Ok(update)
    }
}
