//! Monte Carlo localization of a robot with a laser in an occupancy grid (M1).

use crate::estimate::moments;
use crate::free_space::FreeSpace;
use crate::motion::DifferentialStep;
use crate::sensor::FieldLikelihood;
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
    Done {
        /// Effective sample size before resampling.
        effective_sample_size: f64,
        /// Whether the cloud was resampled.
        resampled: bool,
    },
}

/// A robot with a laser in a known map.
#[derive(Debug)]
pub struct Mcl {
    settings: MclSettings,
    free_space: FreeSpace,
    field: LikelihoodField,
    filter: ParticleFilter,
    /// The odometry at the last update.
    odometry: Option<Pose2>,
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
        let mut mcl = Mcl { settings, free_space, field, filter, odometry: None };
        mcl.start_anywhere();
        Ok(mcl)
    }

    /// Starts from no idea of the pose (A2).
    pub fn start_anywhere(&mut self) {
        let count = self.settings.particles;
        let rng = self.filter.rng_mut();
        let cloud = Particles::from_poses((0..count).map(|_| self.free_space.draw(rng)));
        *self.filter.particles_mut() = cloud;
        self.odometry = None;
    }

    /// Starts from a belief about the pose (A1).
    pub fn start_at(&mut self, belief: &Gaussian<3>) {
        let count = self.settings.particles;
        let cloud = Particles::from_gaussian(belief, count, self.filter.rng_mut());
        *self.filter.particles_mut() = cloud;
        self.odometry = None;
    }

    /// Takes in the odometry's pose and what the lasers measured there.
    ///
    /// # Errors
    /// A scan that cannot be one, an odometry pose that is not finite.
    pub fn update(&mut self, odometry: Pose2, scans: &[MountedScan<'_>]) -> Result<Update> {
        let last = *self.odometry.get_or_insert(odometry);
        let step = last.between(odometry);
        let first = last == odometry;
        if !first
            && f64::hypot(step.x, step.y) < self.settings.update_distance
            && step.theta.abs() < self.settings.update_turn
        {
            return Ok(Update::StoodStill);
        }
        self.filter.predict(&DifferentialStep::between(last, odometry, &self.settings.motion)?);
        self.odometry = Some(odometry);
        let endpoints = self.endpoints(scans);
        let exponent = self.settings.scan_exponent;
        self.filter.weigh(&FieldLikelihood { field: &self.field, endpoints: &endpoints, exponent });
        self.filter.normalize();
        let effective_sample_size = self.filter.particles().effective_sample_size();
        let resampled = effective_sample_size < 0.5 * self.settings.particles as f64;
        if resampled {
            self.filter.resample(self.settings.resampling, self.settings.particles);
        }
        Ok(Update::Done { effective_sample_size, resampled })
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
        Estimate { belief: moments(self.filter.particles()) }
    }

    /// The pose of the odometry's frame in the map (`map_from_odom`), `None` before the first
    /// update.
    pub fn map_from_odom(&self) -> Option<Pose2> {
        self.odometry.map(|odometry| self.estimate().belief.pose() * odometry.inverse())
    }

    /// The cloud.
    pub fn particles(&self) -> &Particles {
        self.filter.particles()
    }
}
