//! Monte Carlo localization of a robot with lasers in an occupancy grid (M1).
//!
//! [`Mcl`] is the whole filter behind one settings struct: feed it the odometry's pose and what the
//! lasers measured there, and read the pose. Its update is the textbook's (sample the motion,
//! weigh, resample) with three additions: scans with a narrow likelihood are used in stages
//! ([`crate::tempering`]), scans that fit badly raise the probability that the robot is elsewhere
//! ([`crate::recovery`]), and then the whole map is searched ([`loc_maps::search`]).
//!
//! The files: this one has the filter, its update and its saved state; `belief` the particles with
//! prediction, correction and resampling; `scan` the scans and the map prepared for the sensor
//! model; `recovery` the search for the robot elsewhere; `range_offset` the estimate of a common
//! range offset; `localizer` the events; `models` the interface of a motion and a sensor model;
//! `settings` all settings; `standing` the scans while the odometry reports no motion; `state` what
//! is kept over a restart.
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
mod localizer;
mod models;
mod range_offset;
mod recovery;
mod scan;
mod settings;
mod standing;
mod state;

pub use models::{ModelStep, MotionModel, ScanModel, ScanView};
pub use range_offset::{RangeOffset, RangeOffsetEstimate};
pub use scan::{MountedScan, Observation};
pub use settings::{
    FieldSettings, MclSettings, MotionSettings, NoveltyFilter, RecoverySettings, SensorSettings,
    Weighting,
};
pub use state::MclState;

use crate::confidence::{LostMonitor, ScanRater};
use crate::estimate::Clusterer;
use crate::motion::DrivenPath;
use crate::recovery::{AugmentedMcl, Suspicion};
use crate::{Error, Estimate, Particles, Result, Transport};
use belief::{Belief, Step};
use loc_core::gaussian::check_covariance;
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Pose2};
use loc_maps::OccupancyGrid;
use loc_maps::likelihood_field::Endpoints;
use loc_sensors::laser::Beam;
use recovery::{Alternative, Spread};
use scan::{PreparedMap, check, endpoints, fingerprint, select};
use standing::Standing;

/// A robot with lasers in a known map, with a motion and a sensor model: those of the settings, or a
/// user's own ([`MotionModel`], [`ScanModel`]).
#[derive(Debug)]
pub struct Mcl<M = MotionSettings, S = SensorSettings> {
    settings: MclSettings,
    motion: M,
    sensor: S,
    map: PreparedMap,
    belief: Belief,
    /// The path of the odometry since the last update.
    path: Option<DrivenPath>,
    /// The initial pose distribution, until the first scan.
    start: Option<Gaussian<3>>,
    clusterer: Clusterer,
    estimate: Estimate,
    rater: ScanRater,
    monitor: LostMonitor,
    /// Another hypothesis about the pose, after a search.
    alternative: Option<Alternative>,
    /// The common offset between measured ranges and the walls of the map.
    offset: RangeOffsetEstimate,
    /// The ranges that were used last, as one number, and how often they came again on the move.
    last_ranges: Option<u64>,
    frozen: u64,
    standing: Standing,
    /// Updates in a row whose scans hardly end on the map.
    off_map: u32,
    /// Updates by scans that the robot has moved although its odometry stood still.
    moved_unnoticed: u64,
}

/// What [`Mcl::update`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Update {
    /// Only the odometry was recorded: the robot has not moved enough since the last update.
    StoodStill,
    /// The particles were moved and weighted.
    Done(UpdateReport),
}

/// Figures of an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UpdateReport {
    /// Number of times the particles were rated: 1 unless the update was tempered.
    pub stages: usize,
    /// Logarithm of the mean likelihood of the scans over the predicted particles.
    pub log_evidence: f64,
    /// Effective sample size at the end.
    pub effective_sample_size: f64,
    /// Whether the map was searched for the scan.
    pub searched: bool,
}

impl Mcl {
    /// A robot that may be anywhere in the map's free space; it draws from `rng`.
    ///
    /// # Errors
    /// Settings out of range, [`loc_maps::Error::NoFreeSpace`], [`crate::Error::Threads`].
    pub fn new(grid: &OccupancyGrid, settings: MclSettings, rng: ChaCha8Rng) -> Result<Self> {
        let (motion, sensor) = (settings.motion, settings.sensor);
        Mcl::with_models(grid, settings, motion, sensor, rng)
    }
}

impl<M: MotionModel, S: ScanModel> Mcl<M, S> {
    /// The same with models of motion and sensor that take the place of those of the settings.
    ///
    /// # Errors
    /// As for [`new`](Mcl::new).
    pub fn with_models(
        grid: &OccupancyGrid,
        settings: MclSettings,
        motion: M,
        sensor: S,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        settings.check()?;
        let map = PreparedMap::new(grid, &sensor, &settings)?;
        let mut belief = Belief::new(&settings, &sensor.field(), map.free_space.area(), rng)?;
        let workers = belief.filter.workers().clone();
        let mut clusterer = Clusterer::new(settings.clusters)?.with_workers(workers);
        let estimate = clusterer.estimate(&Particles::new());
        let rater = ScanRater::new(grid, belief.filter.rng_mut())?;
        let monitor = LostMonitor::new(settings.lost)?;
        let (path, start) = (None, None);
        let mut mcl = Mcl {
            settings,
            motion,
            sensor,
            map,
            belief,
            path,
            start,
            clusterer,
            estimate,
            rater,
            monitor,
            alternative: None,
            offset: RangeOffsetEstimate::default(),
            last_ranges: None,
            frozen: 0,
            standing: Standing::default(),
            off_map: 0,
            moved_unnoticed: 0,
        };
        mcl.start_anywhere();
        Ok(mcl)
    }

    /// Starts without knowledge of the pose (A2). With the search of
    /// [`RecoverySettings`] the first scan determines where the robot may be;
    /// without it particles are spread evenly over the free space.
    pub fn start_anywhere(&mut self) {
        let count = self.settings.particles.max_particles;
        let (free_space, rng) = (&self.map.free_space, self.belief.filter.rng_mut());
        let particles = Particles::from_poses((0..count).map(|_| free_space.draw(rng)));
        self.restart(particles, None);
    }

    /// Starts from an initial pose distribution (A1), with the maximum number of particles.
    ///
    /// # Errors
    /// [`loc_core::Error::NotACovariance`], and [`Error::OffMap`] for a mean that is not on the map
    /// (walls and unknown space are allowed: a map may be wrong there). The filter is then
    /// unchanged.
    pub fn start_at(&mut self, belief: &Gaussian<3>) -> Result<()> {
        let pose = belief.pose();
        check_covariance("covariance of the start pose", &belief.covariance)?;
        if !pose.is_finite() || !self.map.free_space.is_on_map(pose) {
            return Err(Error::OffMap { x: pose.x, y: pose.y });
        }
        let count = self.settings.particles.max_particles;
        let particles = Particles::from_gaussian(belief, count, self.belief.filter.rng_mut());
        self.restart(particles, Some(*belief));
        Ok(())
    }

    fn restart(&mut self, particles: Particles, start: Option<Gaussian<3>>) {
        let belief = &mut self.belief;
        *belief.filter.particles_mut() = particles;
        (self.path, self.start, self.alternative) = (None, start, None);
        (belief.has_seen, belief.is_anywhere) = (false, start.is_none());
        belief.updates_since_resampling = 0;
        belief.suspicion.iter_mut().for_each(Suspicion::clear);
        belief.augmented.iter_mut().for_each(AugmentedMcl::reset);
        self.monitor = LostMonitor::new(self.settings.lost).unwrap_or(self.monitor);
        (self.standing, self.off_map) = (Standing::default(), 0);
        self.cluster();
    }

    /// Records the pose of the odometry between two scans: the noise of a path depends on its
    /// length, which its ends alone do not determine.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a pose that is not finite, which is not recorded.
    pub fn odometry(&mut self, pose: Pose2) -> Result<()> {
        check(pose, &[])?;
        self.path.get_or_insert(DrivenPath::starting_at(pose)).extend(pose);
        Ok(())
    }

    /// Updates with the pose of the odometry and the scans taken there. The first scan after a
    /// start is used in any case, later ones when the robot has moved enough.
    ///
    /// A jump of the odometry is a motion like any other: the particles follow it, and if no scan
    /// confirms it the robot is searched for. Without valid beams the particles are only moved.
    ///
    /// # Errors
    /// A scan that is not valid ([`LaserScan::check`](loc_sensors::laser::LaserScan::check)) and a
    /// pose that is not finite; the filter is then unchanged.
    pub fn update(&mut self, odometry: Pose2, scans: &[MountedScan<'_>]) -> Result<Update> {
        check(odometry, scans)?;
        self.odometry(odometry)?;
        let step = self.path.map_or(Pose2::IDENTITY, |path| path.step());
        if self.belief.has_seen
            && f64::hypot(step.x, step.y) < self.settings.update_distance
            && step.theta.abs() < self.settings.update_turn
        {
            if !self.has_moved_unnoticed(scans) {
                return Ok(Update::StoodStill);
            }
            self.moved_unnoticed += 1;
            return self.process(scans, Some(UNNOTICED));
        }
        // A scanner that repeats its last scan to the bit says nothing about where the robot is.
        let ranges = fingerprint(scans);
        let is_frozen = ranges.is_some() && ranges == self.last_ranges && self.has_moved(step);
        self.last_ranges = ranges;
        self.frozen += u64::from(is_frozen);
        self.process(if is_frozen { &[] } else { scans }, None)
    }

    /// Whether scans show that the robot has moved although its odometry stands still.
    fn has_moved_unnoticed(&mut self, scans: &[MountedScan<'_>]) -> bool {
        if !self.standing.is_due() {
            return false;
        }
        let fit = self.rater.rate(self.pose(), scans);
        self.standing.has_moved(fit.map(|fit| self.settings.lost.shift(&fit)))
    }

    /// Whether a step is more than jitter.
    fn has_moved(&self, step: Pose2) -> bool {
        let MclSettings { update_distance, update_turn, .. } = self.settings;
        f64::hypot(step.x, step.y) > update_distance.min(MIN_MOVE)
            || step.theta.abs() > update_turn.min(MIN_MOVE)
    }

    /// Updates with scans although the robot may not have moved since the last update.
    ///
    /// # Errors
    /// As for [`update`](Mcl::update).
    pub fn update_standing(
        &mut self,
        odometry: Pose2,
        scans: &[MountedScan<'_>],
    ) -> Result<Update> {
        self.belief.has_seen = false;
        self.update(odometry, scans)
    }

    /// One update: sample the motion, weight by the scans, resample (M1); then the estimate, the
    /// probability of being lost and, where the robot may be elsewhere, the search for it.
    ///
    /// A robot that has moved unnoticed is anywhere within a `spread` of where it was.
    fn process(&mut self, scans: &[MountedScan<'_>], spread: Option<Spread>) -> Result<Update> {
        let workers = self.belief.filter.workers().clone();
        workers.within(|| self.process_within(scans, spread)).map(Update::Done)
    }

    fn process_within(
        &mut self,
        scans: &[MountedScan<'_>],
        spread: Option<Spread>,
    ) -> Result<UpdateReport> {
        let path = self.path.unwrap_or(DrivenPath::starting_at(Pose2::IDENTITY));
        let noise = &self.settings.robot.path;
        let predicted = match &self.start {
            Some(belief) => belief.pose() * path.step(),
            None => self.estimate.belief.pose() * path.step(),
        };
        let step = match (self.start.take(), spread) {
            (Some(belief), _) => Step::from_start(&path, &belief, noise),
            (None, Some(spread)) => Step::Spread(spread),
            (None, None) => Step::Model(self.motion.step(&path, &self.settings.robot)?),
        };
        self.path = Some(DrivenPath::starting_at(path.end()));
        let beams = self.without_novel(&step, scans, self.select(scans))?;
        let exponent = self.map.exponent(beams.iter().map(Vec::len).sum());
        let has_jumped = path.step().position().coords.norm() > JUMP;
        let beams = if has_jumped { beams } else { self.on_map(predicted, scans, beams) };
        let offset = self.range_offset();
        let endpoints = self.without_skipped(&step, endpoints(scans, &beams, offset));
        let report = {
            let view = ScanView { exponent, ..self.map.view(scans, &beams, &endpoints) };
            let scan = self.sensor.likelihood(&view)?;
            self.belief.update(&step, &scan, &endpoints, exponent, &self.map)
        };
        self.cluster();
        let particles = self.belief.filter.particles();
        let pose = self.estimate.belief.pose();
        let (rater, tolerance) = (&mut self.rater, self.monitor.settings().tolerance);
        let workers = self.belief.filter.workers();
        let (fit, support) = workers.both(
            || rater.rate_by(workers, pose, scans, !has_jumped),
            || tolerance.support(particles, pose),
        );
        let has_fit = fit.is_some();
        self.monitor.update(fit, support);
        if spread.is_none() {
            self.standing.updated(fit.map(|fit| self.settings.lost.shift(&fit)));
        }
        self.off_map = if has_fit || scans.is_empty() { 0 } else { self.off_map + 1 };
        let searched = report.searched || self.update_alternative(&step, scans)?;
        if self.estimates_range_offset() && !searched && self.lost() < MAX_LOST {
            self.offset.update(&self.map.field, scans, &beams, pose, offset);
        }
        Ok(UpdateReport { searched, ..report })
    }

    /// Clusters the particles, and estimates the pose.
    fn cluster(&mut self) {
        self.estimate = self.clusterer.estimate(self.belief.filter.particles());
        self.belief.is_divided = self.estimate.share() < MAX_SHARE;
    }

    /// Whether the filter estimates how much the ranges are short.
    fn estimates_range_offset(&self) -> bool {
        self.sensor.is_field_product() && self.settings.range_offset == RangeOffset::Estimated
    }

    /// Numbers of the beams to use, for each scan.
    fn select(&self, scans: &[MountedScan<'_>]) -> Vec<Vec<usize>> {
        scans.iter().map(|s| select(s.scan, &self.sensor, &self.settings)).collect()
    }

    /// The beams without those that the novelty filter drops (K3).
    fn without_novel(
        &self,
        step: &Step<M::Step>,
        scans: &[MountedScan<'_>],
        beams: Vec<Vec<usize>>,
    ) -> Result<Vec<Vec<usize>>> {
        match &self.settings.novelty {
            Some(filter) if !self.belief.awaits_first_scan() => {
                self.map.without_novel(scans, beams, &self.predicted(step), filter)
            }
            _ => Ok(beams),
        }
    }

    /// The beams without those that end where the map knows nothing, seen from a pose: they neither
    /// pull nor raise suspicion.
    fn on_map(
        &self,
        predicted: Pose2,
        scans: &[MountedScan<'_>],
        mut beams: Vec<Vec<usize>>,
    ) -> Vec<Vec<usize>> {
        if self.belief.awaits_first_scan() {
            return beams;
        }
        for (MountedScan { scan, mounting }, beams) in scans.iter().zip(&mut beams) {
            let laser = predicted * *mounting;
            beams.retain(|&index| {
                let beam = Beam { index, angle: scan.angle(index), range: scan.ranges[index] };
                !scan.is_valid(beam.range) || !self.rater.leaves_map(laser, &beam)
            });
        }
        beams
    }

    /// The ends of the beams without those that beam skipping drops.
    fn without_skipped(&self, step: &Step<M::Step>, endpoints: Endpoints) -> Endpoints {
        match self.sensor.beam_skip() {
            Some(skip) => skip.apply(&self.map.field, self.predicted(step).poses(), &endpoints),
            None => endpoints,
        }
    }

    /// The particles after the step, without its noise.
    fn predicted(&self, step: &Step<M::Step>) -> Particles {
        let particles = self.belief.filter.particles();
        let mut predicted = Particles::new();
        for (pose, weight) in particles.poses().iter().zip(particles.log_weights()) {
            predicted.push(step.moved(pose, [0.0; 4]), *weight);
        }
        predicted
    }

    /// The settings.
    pub fn settings(&self) -> &MclSettings {
        &self.settings
    }

    /// The particle set.
    pub fn particles(&self) -> &Particles {
        self.belief.filter.particles()
    }

    /// The estimate of the pose at the last update, with its clusters.
    pub fn last_estimate(&self) -> &Estimate {
        &self.estimate
    }

    /// The pose of the robot in the map now: that of the last update, moved by the odometry
    /// since.
    pub fn pose(&self) -> Pose2 {
        let since = self.path.map_or(Pose2::IDENTITY, |path| path.step());
        self.estimate.belief.pose() * since
    }

    /// The pose now with its covariance, which grows along the path since the last update. Of
    /// several clusters it is that of all of them about the pose
    /// ([`Estimate::whole`](crate::Estimate::whole)).
    pub fn belief(&self) -> Gaussian<3> {
        let noise = self.settings.robot.path;
        let divided = self.belief.is_divided.then(|| self.estimate.whole());
        let mut belief = divided.unwrap_or(self.estimate.belief);
        if self.standing.is_moving() {
            belief.covariance += UNNOTICED.covariance();
        }
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
            RangeOffset::Estimated => self.offset.significant(self.map.field.frame().resolution()),
        }
    }

    /// The estimate of that offset, see [`RangeOffset::Estimated`].
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

/// A robot has moved if its odometry says at least this much \[m, rad\].
const MIN_MOVE: f64 = 0.05;

/// How far a robot gets between two ratings of scans while its odometry stands still.
const UNNOTICED: Spread = Spread([0.2, 0.2, 0.1]);

/// A robot does not drive this far from one update to the next \[m\]: its odometry jumps.
const JUMP: f64 = 5.0;

/// A belief is divided if its heaviest cluster has less than this share.
const MAX_SHARE: f64 = 0.99;

/// Scans are used for the range offset while the probability of being lost is below this.
const MAX_LOST: f64 = 0.1;
