//! Monte Carlo localization of a robot with a laser in an occupancy grid (M1).

use crate::estimate::moments;
use crate::free_space::FreeSpace;
use crate::motion::{DrivenPath, NoisyStep};
use crate::sensor::FieldLikelihood;
use crate::tempering::{Tempering, TemperingReport};
use crate::{Estimate, MclSettings, ParticleFilter, Particles, Result, Workers};
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Pose2};
use loc_maps::likelihood_field::Endpoints;
use loc_maps::{LikelihoodField, OccupancyGrid};
use loc_sensors::laser::LaserScan;
use nalgebra::Point2;

/// A scan with the place of its scanner on the robot.
#[derive(Debug, Clone, Copy)]
pub struct MountedScan<'a> {
    /// The scan.
    pub scan: &'a LaserScan,
    /// Where the scanner sits (`base_from_laser`).
    pub mounting: Pose2,
}

/// What [`Mcl::update`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Update {
    /// Nothing: the robot has not moved enough since the last update.
    StoodStill,
    /// The cloud was moved and weighed.
    Done(TemperingReport),
}

/// A robot with a laser in a known map.
#[derive(Debug)]
pub struct Mcl {
    settings: MclSettings,
    free_space: FreeSpace,
    field: LikelihoodField,
    filter: ParticleFilter,
    tempering: Tempering,
    /// The way since the last update.
    path: Option<DrivenPath>,
    /// Whether the cloud has seen a scan since it was spread.
    has_seen: bool,
}

impl Mcl {
    /// A robot that may be anywhere in the map's free space.
    ///
    /// # Errors
    /// Settings out of range, [`crate::Error::NoFreeSpace`].
    pub fn new(map: &OccupancyGrid, settings: MclSettings, rng: ChaCha8Rng) -> Result<Self> {
        settings.validate()?;
        let field = LikelihoodField::new(map, &settings.field)?;
        let free_space = FreeSpace::new(map)?;
        let workers = Workers::new(settings.threads)?;
        let filter = ParticleFilter::new(Particles::new(), rng).with_workers(workers);
        let tempering = Tempering::new(settings.tempering)?;
        let mut mcl =
            Mcl { settings, free_space, field, filter, tempering, path: None, has_seen: false };
        mcl.start_anywhere();
        Ok(mcl)
    }

    /// Starts from no idea of the pose (A2).
    pub fn start_anywhere(&mut self) {
        let count = self.settings.particles;
        let rng = self.filter.rng_mut();
        let cloud = Particles::from_poses((0..count).map(|_| self.free_space.draw(rng)));
        *self.filter.particles_mut() = cloud;
        (self.path, self.has_seen) = (None, false);
    }

    /// Starts from a belief about the pose (A1).
    pub fn start_at(&mut self, belief: &Gaussian<3>) {
        let count = self.settings.particles;
        let cloud = Particles::from_gaussian(belief, count, self.filter.rng_mut());
        *self.filter.particles_mut() = cloud;
        (self.path, self.has_seen) = (None, false);
    }

    /// Takes in the odometry's pose and what the lasers measured there.
    ///
    /// # Errors
    /// A scan that cannot be one, an odometry pose that is not finite.
    pub fn update(&mut self, odometry: Pose2, scans: &[MountedScan<'_>]) -> Result<Update> {
        let path = self.path.get_or_insert(DrivenPath::starting_at(odometry));
        path.extend(odometry);
        let step = path.step();
        if self.has_seen
            && f64::hypot(step.x, step.y) < self.settings.update_distance
            && step.theta.abs() < self.settings.update_turn
        {
            return Ok(Update::StoodStill);
        }
        let step = NoisyStep::new(path, &self.settings.motion);
        *path = DrivenPath::starting_at(odometry);
        let endpoints = self.endpoints(scans);
        let exponent = (self.settings.independent_beams / endpoints.len().max(1) as f64).min(1.0);
        let scan = FieldLikelihood { field: &self.field, endpoints: &endpoints, exponent };
        let count = self.settings.particles;
        let report = self.tempering.update(&mut self.filter, &step, &scan, count);
        self.has_seen = true;
        Ok(Update::Done(report))
    }

    /// Where the beams of all lasers end, in the robot's frame.
    fn endpoints(&self, scans: &[MountedScan<'_>]) -> Endpoints {
        let beams = scans.iter().flat_map(|mounted| {
            let beams = mounted.scan.thinned(self.settings.beams);
            beams.into_iter().map(move |beam| mounted.mounting.transform(&beam.point()))
        });
        beams.map(|Point2 { coords }| [coords.x, coords.y]).collect()
    }

    /// What the cloud says about the pose at the last update.
    pub fn estimate(&self) -> Estimate {
        Estimate { belief: moments(self.filter.particles()), clusters: Vec::new() }
    }

    /// The pose of the odometry's frame in the map (`map_from_odom`), `None` before the first
    /// update.
    pub fn map_from_odom(&self) -> Option<Pose2> {
        self.path.map(|path| self.estimate().belief.pose() * path.start().inverse())
    }

    /// The cloud.
    pub fn particles(&self) -> &Particles {
        self.filter.particles()
    }
}
