//! Drives through simulated buildings, in which the robot knows its place or not.

use crate::robot::Robot;
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::motion::OdometryNoise;
use loc_core::random::{ChaCha8Rng, stream};
use loc_maps::grid::Occupancy;
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_maps::{LikelihoodField, OccupancyGrid};
use loc_pf::confidence::{ScanFit, ScanRater, Tolerance};
use loc_pf::estimate::{ClusterSettings, Clusterer};
use loc_pf::initial::FreeSpace;
use loc_pf::mcl::MountedScan;
use loc_pf::motion::DifferentialStep;
use loc_pf::sensor::FieldLikelihood;
use loc_pf::{ParticleFilter, Particles, Resampling};
use loc_sensors::laser::{LaserScan, LaserScanner};
use rand::RngExt;

/// How a drive begins and what happens on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Drive {
    Tracking,
    WrongStart,
    GlobalStart,
    /// Carried off after half of the drive.
    Kidnapped,
}

pub(crate) const DRIVES: [Drive; 4] =
    [Drive::Tracking, Drive::WrongStart, Drive::GlobalStart, Drive::Kidnapped];

/// The surroundings of some drives.
pub(crate) struct Conditions {
    /// What the robot knows of the building.
    pub(crate) map: OccupancyGrid,
    /// What it is like now.
    pub(crate) building: OccupancyGrid,
    pub(crate) laser: LaserScanner,
    /// Beams of a scan that are used.
    pub(crate) beams: usize,
    pub(crate) particles: usize,
    pub(crate) updates: usize,
    /// Power of the likelihood in the filter.
    pub(crate) exponent: f64,
    /// Share of the particles that is drawn anew from the free space in every update.
    pub(crate) injected: f64,
}

/// The input of a monitor in an update, and the truth.
#[derive(Debug, Clone)]
pub(crate) struct Sample {
    /// Here, blocked and near; `None` for a scan that measured nothing.
    pub(crate) shares: Option<[f64; 3]>,
    pub(crate) elsewhere: Vec<f64>,
    pub(crate) support: f64,
    pub(crate) lost: bool,
    pub(crate) since_kidnapping: Option<usize>,
}

impl Sample {
    pub(crate) fn scan(&self) -> Option<ScanFit<'_>> {
        let elsewhere = &self.elsewhere[..];
        self.shares.map(|[here, blocked, near]| ScanFit { here, elsewhere, blocked, near })
    }
}

/// Drives of every kind, `each` of them.
pub(crate) fn drives(conditions: &Conditions, each: usize, seed: u64) -> Vec<Vec<Sample>> {
    let field = LikelihoodField::new(&conditions.map, &LikelihoodFieldSettings::nav2()).unwrap();
    let free_space = FreeSpace::new(&conditions.map).unwrap();
    let mut robot = Robot::new(&conditions.building, conditions.laser, seed);
    let kinds = DRIVES.into_iter().flat_map(|kind| (0..each).map(move |k| (kind, k)));
    let mut run = |(number, (kind, _))| {
        let rng = stream(seed * 1000 + number as u64, "filter");
        carry_off(&mut robot, conditions);
        Run { conditions, field: &field, free_space: &free_space, robot: &mut robot }
            .drive(kind, rng)
    };
    kinds.enumerate().map(&mut run).collect()
}

/// Puts the robot where the map has free space too: a place that it does not know is none to be
/// lost at.
fn carry_off(robot: &mut Robot, conditions: &Conditions) {
    loop {
        robot.carry_off();
        let place = robot.truth.position();
        let free = |map: &OccupancyGrid| map.occupancy_at(&place) == Occupancy::Free;
        if free(&conditions.map) && free(&conditions.building) {
            return;
        }
    }
}

struct Run<'a> {
    conditions: &'a Conditions,
    field: &'a LikelihoodField,
    free_space: &'a FreeSpace,
    robot: &'a mut Robot,
}

impl Run<'_> {
    fn drive(&mut self, kind: Drive, mut rng: ChaCha8Rng) -> Vec<Sample> {
        let Conditions { particles, updates, .. } = *self.conditions;
        let cloud = self.start(kind, particles, &mut rng);
        let mut rater = ScanRater::new(&self.conditions.map, &mut rng).unwrap();
        let mut filter = ParticleFilter::new(cloud, rng);
        let mut clusterer = Clusterer::new(ClusterSettings::default()).unwrap();
        let mut samples = Vec::new();
        for update in 0..updates {
            if kind == Drive::Kidnapped && update == updates / 2 {
                carry_off(self.robot, self.conditions);
            }
            let scan = self.update(&mut filter);
            let reported = clusterer.estimate(filter.particles()).belief.pose();
            let scans = [MountedScan { scan: &scan, mounting: Pose2::IDENTITY }];
            let fit = rater.rate(reported, &scans);
            let (distance, turn) = self.robot.error(reported);
            samples.push(Sample {
                shares: fit.map(|fit| [fit.here, fit.blocked, fit.near]),
                elsewhere: fit.map_or(Vec::new(), |fit| fit.elsewhere.to_vec()),
                support: Tolerance::default().support(filter.particles(), reported),
                lost: distance > 0.5 || turn > 15_f64.to_radians(),
                since_kidnapping: (kind == Drive::Kidnapped)
                    .then(|| update.checked_sub(updates / 2))
                    .flatten(),
            });
            filter.resample(Resampling::Systematic, particles);
            self.inject(&mut filter);
        }
        samples
    }

    fn start(&self, kind: Drive, count: usize, rng: &mut ChaCha8Rng) -> Particles {
        let about = match kind {
            Drive::Tracking | Drive::Kidnapped => self.robot.truth,
            Drive::WrongStart => self.free_space.draw(rng),
            Drive::GlobalStart => {
                return Particles::from_poses((0..count).map(|_| self.free_space.draw(rng)));
            }
        };
        let belief = pose_belief(about, [0.2, 0.2, 0.1]);
        let start = Pose2::from_vector(&belief.sample(rng));
        Particles::from_gaussian(&pose_belief(start, [0.2, 0.2, 0.1]), count, rng)
    }

    fn update(&mut self, filter: &mut ParticleFilter) -> LaserScan {
        let before = self.robot.odometry;
        self.robot.drive();
        let noise = OdometryNoise { alpha1: 0.05, alpha2: 0.02, alpha3: 0.05, alpha4: 0.02 };
        let step = DifferentialStep::between(before, self.robot.odometry, &noise).unwrap();
        filter.predict(&step);
        let scan = self.robot.scan();
        let beams = scan.thinned(self.conditions.beams);
        let ends = beams.into_iter().map(|beam| <[f64; 2]>::from(beam.point().coords));
        let endpoints: Endpoints = ends.collect();
        let exponent = self.conditions.exponent;
        filter.weigh(&FieldLikelihood { field: self.field, endpoints: &endpoints, exponent });
        filter.normalize();
        scan
    }

    fn inject(&self, filter: &mut ParticleFilter) {
        let count = filter.particles().len();
        for index in 0..count {
            if filter.rng_mut().random::<f64>() < self.conditions.injected {
                let pose = self.free_space.draw(filter.rng_mut());
                filter.particles_mut().set_pose(index, pose);
            }
        }
    }
}
