//! The update: sample the motion, weigh, resample (M1).

use super::observation::{MountedScan, endpoints, select};
use super::step::Step;
use super::{FieldSettings, Mcl, SensorSettings};
use crate::motion::DrivenPath;
use crate::{Particles, Result, Transport};
use loc_core::Pose2;
use loc_core::error::finite;
use loc_maps::likelihood_field::Endpoints;

/// What [`Mcl::update`] did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Update {
    /// Nothing but noting the odometry: the robot has not moved enough since the last update.
    StoodStill,
    /// The cloud was moved and weighed.
    Done(UpdateReport),
}

/// How an update went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UpdateReport {
    /// How often the cloud was rated: once, unless the scan was taken in by degrees.
    pub stages: usize,
    /// Logarithm of the mean likelihood of the scans over the predicted cloud.
    pub log_evidence: f64,
    /// Effective sample size at the end.
    pub effective_sample_size: f64,
    /// Whether the map was searched for the scan.
    pub searched: bool,
}

impl Mcl {
    /// Notes where the odometry is, between two scans: the noise of a way depends on how long it
    /// was, which its ends alone do not tell.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a pose that is not finite, which is not noted.
    pub fn odometry(&mut self, pose: Pose2) -> Result<()> {
        check(pose, &[])?;
        self.path.get_or_insert(DrivenPath::starting_at(pose)).extend(pose);
        Ok(())
    }

    /// Takes in the odometry's pose and what the lasers measured there. The first scan after a
    /// start counts in any case, later ones when the robot has moved enough.
    ///
    /// A jump of the odometry is a motion like any other: the cloud follows it, and if no scan
    /// bears it out the robot is searched for. Without valid beams the cloud is moved only.
    ///
    /// # Errors
    /// A scan that cannot be one ([`LaserScan::check`](loc_sensors::laser::LaserScan::check)) and a
    /// pose that is not finite; the filter stays as it was then.
    pub fn update(&mut self, odometry: Pose2, scans: &[MountedScan<'_>]) -> Result<Update> {
        check(odometry, scans)?;
        self.odometry(odometry)?;
        let step = self.path.map_or(Pose2::IDENTITY, |path| path.step());
        if self.belief.has_seen
            && f64::hypot(step.x, step.y) < self.settings.update_distance
            && step.theta.abs() < self.settings.update_turn
        {
            return Ok(Update::StoodStill);
        }
        let workers = self.belief.filter.workers().clone();
        workers.within(|| self.take_in(scans)).map(Update::Done)
    }

    /// Takes in scans although the robot may not have moved since the last update.
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

    fn take_in(&mut self, scans: &[MountedScan<'_>]) -> Result<UpdateReport> {
        let path = self.path.unwrap_or(DrivenPath::starting_at(Pose2::IDENTITY));
        let motion = &self.settings.motion;
        let step = match self.start.take() {
            Some(belief) => Step::from_start(&path, &belief, &motion.path_noise()),
            None => Step::new(&path, motion)?,
        };
        self.path = Some(DrivenPath::starting_at(path.end()));
        let beams = scans.iter().map(|mounted| select(mounted.scan, &self.settings)).collect();
        let beams = self.familiar(&step, scans, beams)?;
        let offset = self.range_offset();
        let endpoints = self.agreeing(&step, endpoints(scans, &beams, offset));
        let scan = self.surroundings.observe(scans, &beams, &endpoints, &self.settings)?;
        let report = self.belief.update(&step, &scan, &endpoints, &self.surroundings);
        let particles = self.belief.filter.particles();
        self.estimate = self.clusterer.estimate(particles);
        let pose = self.estimate.belief.pose();
        let (rater, tolerance) = (&mut self.rater, self.monitor.settings().tolerance);
        let workers = self.belief.filter.workers();
        let (fit, support) = workers
            .both(|| rater.rate_by(workers, pose, scans), || tolerance.support(particles, pose));
        self.monitor.update(fit, support);
        let searched = report.searched || self.challenge(&step, scans)?;
        if self.settings.estimates_range_offset() && !searched && self.lost() < SURE {
            self.offset.update(&self.surroundings.field, scans, &beams, pose, offset);
        }
        Ok(UpdateReport { searched, ..report })
    }

    /// The beams without those that a filter against people drops.
    pub(super) fn familiar(
        &self,
        step: &Step,
        scans: &[MountedScan<'_>],
        beams: Vec<Vec<usize>>,
    ) -> Result<Vec<Vec<usize>>> {
        match &self.settings.novelty {
            Some(filter) if !self.belief.is_looking() => {
                self.surroundings.familiar(scans, beams, &self.predicted(step), filter)
            }
            _ => Ok(beams),
        }
    }

    /// The ends of beams without those that the settings let be skipped.
    pub(super) fn agreeing(&self, step: &Step, endpoints: Endpoints) -> Endpoints {
        match self.settings.sensor {
            SensorSettings::LikelihoodField(FieldSettings { beam_skip: Some(skip), .. }) => {
                skip.apply(&self.surroundings.field, self.predicted(step).poses(), &endpoints)
            }
            _ => endpoints,
        }
    }

    /// The cloud after the step, without its noise.
    fn predicted(&self, step: &Step) -> Particles {
        let cloud = self.belief.filter.particles();
        let mut predicted = Particles::new();
        for (pose, weight) in cloud.poses().iter().zip(cloud.log_weights()) {
            predicted.push(step.moved(pose, [0.0; 4]), *weight);
        }
        predicted
    }
}

/// A scan tells an offset of the ranges where the robot is lost with less than this probability.
const SURE: f64 = 0.1;

fn check(odometry: Pose2, scans: &[MountedScan<'_>]) -> Result<()> {
    finite("x of the odometry [m]", odometry.x)?;
    finite("y of the odometry [m]", odometry.y)?;
    finite("heading of the odometry [rad]", odometry.theta)?;
    scans.iter().try_for_each(|mounted| {
        finite("mounting of a laser", mounted.mounting.to_vector().sum())?;
        Ok(mounted.scan.check()?)
    })
}
