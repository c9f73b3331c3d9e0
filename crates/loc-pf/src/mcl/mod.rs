//! Monte Carlo localization of a robot with lasers in an occupancy grid (M1).
//!
//! [`Mcl`] is the whole filter behind one settings struct: feed it the odometry's pose and what the
//! lasers measured there, and read the pose. Its update is the textbook's (sample the motion,
//! weigh, resample) with three additions: sharp scans are taken in by degrees ([`crate::tempering`]),
//! scans that fit badly raise the suspicion that the robot is elsewhere ([`crate::recovery`]), and
//! then the whole map is searched ([`crate::global`]).
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_maps::RayCaster;
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_pf::mcl::MountedScan;
//! use loc_pf::{Mcl, MclSettings};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! let map = worlds::office(&WorldSettings { width: 300, height: 300, ..Default::default() })?.grid;
//! let mut mcl = Mcl::new(&map, MclSettings::default(), stream(1, "mcl"))?;
//! let (truth, odometry) = (Pose2::new(7.5, 7.5, 0.4), Pose2::IDENTITY);
//! mcl.start_at(&pose_belief(Pose2::new(7.4, 7.6, 0.35), [0.2, 0.2, 0.1]))?;
//! let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
//! let scan = laser.scan(&RayCaster::new(&map), truth, &mut stream(1, "laser"));
//! mcl.update(odometry, &[MountedScan { scan: &scan, mounting: Pose2::IDENTITY }])?;
//! assert!(mcl.pose().distance(truth) < 0.05);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod belief;
mod challenger;
mod elsewhere;
mod field;
mod observation;
#[cfg(feature = "serde")]
mod optional;
mod range_offset;
mod recover;
mod settings;
mod start;
mod state;
mod step;
mod surroundings;
mod update;

pub use observation::MountedScan;
pub use range_offset::{RangeOffset, RangeOffsetEstimate};
pub use settings::{
    FieldSettings, MclSettings, MotionSettings, NoveltyFilter, RecoverySettings, SensorSettings,
    Weighting,
};
pub use state::MclState;
pub use update::{Update, UpdateReport};

use crate::confidence::{LostMonitor, ScanRater};
use crate::estimate::Clusterer;
use crate::motion::DrivenPath;
use crate::{Estimate, Particles, Result};
use belief::Belief;
use challenger::Challenger;
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Pose2};
use loc_maps::OccupancyGrid;
use surroundings::Surroundings;

/// A robot with lasers in a known map.
#[derive(Debug)]
pub struct Mcl {
    settings: MclSettings,
    surroundings: Surroundings,
    belief: Belief,
    /// The way since the last update.
    path: Option<DrivenPath>,
    /// The belief about the start, until the first scan.
    start: Option<Gaussian<3>>,
    clusterer: Clusterer,
    estimate: Estimate,
    rater: ScanRater,
    monitor: LostMonitor,
    /// Where else the robot may be, after a search.
    challenger: Option<Challenger>,
    /// How much the ranges are short of the map's walls.
    offset: RangeOffsetEstimate,
}

impl Mcl {
    /// A robot that may be anywhere in the map's free space; it draws from `rng`.
    ///
    /// # Errors
    /// Settings out of range, [`loc_maps::Error::NoFreeSpace`], [`crate::Error::Threads`].
    pub fn new(map: &OccupancyGrid, settings: MclSettings, rng: ChaCha8Rng) -> Result<Self> {
        settings.validate()?;
        let surroundings = Surroundings::new(map, &settings)?;
        let mut belief = Belief::new(&settings, surroundings.free_space.area(), rng)?;
        let workers = belief.filter.workers().clone();
        let mut clusterer = Clusterer::new(settings.clusters)?.with_workers(workers);
        let estimate = clusterer.estimate(&Particles::new());
        let rater = ScanRater::new(map, belief.filter.rng_mut())?;
        let monitor = LostMonitor::new(settings.lost)?;
        let (path, start) = (None, None);
        let mut mcl = Mcl {
            settings,
            surroundings,
            belief,
            path,
            start,
            clusterer,
            estimate,
            rater,
            monitor,
            challenger: None,
            offset: RangeOffsetEstimate::default(),
        };
        mcl.start_anywhere();
        Ok(mcl)
    }

    /// The settings.
    pub fn settings(&self) -> &MclSettings {
        &self.settings
    }

    /// The cloud.
    pub fn particles(&self) -> &Particles {
        self.belief.filter.particles()
    }

    /// What the cloud says about the pose at the last update.
    pub fn estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// The pose of the robot in the map now: that of the last update, carried along by the odometry
    /// since.
    pub fn pose(&self) -> Pose2 {
        let since = self.path.map_or(Pose2::IDENTITY, |path| path.step());
        self.estimate.belief.pose() * since
    }

    /// The pose now with its covariance, which grows on the way since the last update.
    pub fn belief(&self) -> Gaussian<3> {
        let noise = self.settings.motion.path_noise();
        let belief = self.estimate.belief;
        self.path.map_or(belief, |path| noise.belief_after(&path, &belief))
    }

    /// The pose of the odometry's frame in the map (`map_from_odom`), `None` before the first
    /// update.
    pub fn map_from_odom(&self) -> Option<Pose2> {
        self.path.map(|path| self.estimate.belief.pose() * path.start().inverse())
    }

    /// What is added to every range that a laser measures \[m\]: fixed by the settings, or
    /// estimated and significant.
    pub fn range_offset(&self) -> f64 {
        match self.settings.range_offset {
            RangeOffset::Fixed(offset) => offset,
            RangeOffset::Estimated => {
                self.offset.significant(self.surroundings.field.frame().resolution())
            }
        }
    }

    /// What the scans said about that, see [`RangeOffset::Estimated`].
    pub fn range_offset_estimate(&self) -> &RangeOffsetEstimate {
        &self.offset
    }

    /// The probability that the robot is not where the last update put it, to within
    /// [`LostSettings`](crate::confidence::LostSettings): calibrated over simulated drives, see
    /// [`crate::confidence`].
    pub fn lost(&self) -> f64 {
        self.monitor.probability()
    }
}
