//! FastSLAM 2.0: particles with a map each (I2 to I4).
//!
//! EKF-SLAM keeps the full covariance of robot and landmarks, and makes one decision on the
//! association of each observation. FastSLAM factors the posterior: *given the path of the robot*,
//! the landmarks are independent, and each needs only a Kalman filter of two numbers. So a particle
//! is a hypothesis of the path, with the map that belongs to it; resampling copies particles whose
//! map fits the observations. Each particle has its own data association, and those with a wrong
//! one are resampled away.
//!
//! Version 2.0 (Montemerlo, Thrun, Koller and Wegbreit 2003) draws the new pose not from odometry
//! alone, but from odometry and observations together. For a particle whose pose has mean `x` and
//! covariance `P` since it was drawn last, and an observation `z` of a landmark of covariance `S`,
//!
//! ```text
//! L = G_s P G_s^T + G_m S G_m^T + R        covariance of the innovation z - h
//! K = P G_s^T L^-1                         x' = x + K (z - h),  P' = P - K L K^T
//! weight *= N(z; h, L)                     pose ~ N(x', P')
//! ```
//!
//! one observation after the other, and the landmarks are corrected from the pose that was drawn.
//! So precise observations do not leave few effective particles: all are drawn where the
//! observations are likely.
//!
//! [`FastSlam`] takes steps; [`FastSlamLocalizer`] around it takes stamped inputs as they come.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, Twist2, random::stream};
//! use loc_pf::fastslam::{FastSlam, FastSlamSettings};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
//! let mut slam = FastSlam::new(start, FastSlamSettings::default(), stream(1, "fastslam"))?;
//! let see = |range| LandmarkObservation { landmark: 7, observed: Observed::RangeBearing { range, bearing: 0.0 } };
//! slam.correct(&[see(4.0)])?;
//! slam.predict(Twist2::forward(1.0, 0.0), 1.0)?;
//! slam.correct(&[see(2.9)])?;
//! let (robot, landmarks) = (slam.pose()?, slam.landmarks()?);
//! assert!(robot.mean.x > 1.0 && (landmarks[0].position.mean.x - 3.95).abs() < 0.05);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod landmark_map;
mod localizer;
mod observation;
mod particle;
mod settings;

pub use localizer::FastSlamLocalizer;
pub use settings::FastSlamSettings;

use crate::log_weights::{Mass, divide};
use crate::{Particles, Result, Workers};
use loc_core::gaussian::check_covariance;
use loc_core::motion::dead_reckon;
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Pose2, Twist2, angle};
use loc_filters::Gate;
use loc_filters::RobotSettings;
use loc_filters::association::{AssociationSettings, Associator};
use loc_filters::localizer::Outcome;
use loc_filters::slam::{Identities, MapLandmark};
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use observation::{Located, View};
use particle::{Context, Particle, Report};
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;

/// The variance of the heading \[rad^2\] up to which a drive without observations is taken for a
/// normal distribution; beyond, the poses are drawn.
const MAX_HEADING_VARIANCE: f64 = 0.01;

/// Particles over the path of the robot, each with a map of its own, in the frame of the start.
///
/// Copies of the filter, as of its particles, share all landmarks that they have in common.
#[derive(Debug, Clone)]
pub struct FastSlam {
    settings: FastSlamSettings,
    gate: Gate,
    new_landmark_gate: f64,
    associator: Associator,
    particles: Vec<Particle>,
    /// Logarithms of the weights, which add up to 1.
    log_weights: Vec<f64>,
    /// The particle that had the largest weight when weights were last different.
    best: usize,
    /// Slot of each landmark number.
    numbers: BTreeMap<u32, usize>,
    view: View,
    moment: u64,
    step: u64,
    rng: ChaCha8Rng,
    workers: Workers,
}

impl FastSlam {
    /// A filter without landmarks, from a belief over (x, y, theta) \[m, m, rad\]. The start may be
    /// certain: then it is the origin of the maps.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief or settings that are not valid, [`crate::Error::Threads`].
    pub fn new(start: Gaussian<3>, settings: FastSlamSettings, rng: ChaCha8Rng) -> Result<Self> {
        settings.check()?;
        let gate = settings.robot.gate()?;
        let mut start = Gaussian::new(start.mean, start.covariance)?;
        start.mean.z = loc_core::angle::wrap(start.mean.z);
        let count = settings.particles;
        let new_landmark_gate = Gate::probability(settings.map.new_landmark_probability)?;
        Ok(FastSlam {
            gate,
            new_landmark_gate: new_landmark_gate.threshold(2),
            associator: Associator::new(settings.association)?,
            particles: vec![Particle::new(start); count],
            log_weights: vec![-(count as f64).ln(); count],
            best: 0,
            numbers: BTreeMap::new(),
            view: View::default(),
            moment: 0,
            step: 0,
            rng,
            workers: Workers::new(settings.threads)?,
            settings,
        })
    }

    /// The settings.
    pub fn settings(&self) -> &FastSlamSettings {
        &self.settings
    }

    /// Number of motions and corrections so far.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Predicts with velocity `twist` over `dt` \[s\]. Poses are drawn with the next observations.
    ///
    /// # Errors
    /// [`loc_filters::Error::NotFinite`] for the velocity, [`loc_core::Error::OutOfRange`] for a
    /// negative time, [`loc_filters::Error::LostPositivity`] where the covariance grows beyond all
    /// numbers.
    pub fn predict(&mut self, twist: Twist2, dt: f64) -> Result<()> {
        Ok(self.drive(twist, dt)?)
    }

    fn drive(&mut self, twist: Twist2, dt: f64) -> loc_filters::Result<()> {
        finite_twist(twist)?;
        loc_core::error::non_negative("time step [s]", dt)?;
        let RobotSettings { integration, odometry, .. } = self.settings.robot;
        let step = self.step + 1;
        let drive =
            |particle: &Particle| dead_reckon(&particle.belief, twist, dt, integration, &odometry);
        let driven: Vec<Gaussian<3>> = self.particles.iter().map(drive).collect();
        driven.iter().try_for_each(|belief| check(belief, step))?;
        self.step = step;
        for (particle, belief) in self.particles.iter_mut().zip(driven) {
            particle.belief = belief;
        }
        if self
            .particles
            .iter()
            .any(|particle| particle.belief.covariance.m33 > MAX_HEADING_VARIANCE)
        {
            let normals = self.normals();
            let pairs = self.particles.iter_mut().zip(&normals);
            pairs.for_each(|(particle, normals)| particle.draw(normals));
        }
        Ok(())
    }

    /// Three draws for each particle: always as many, and one after the other, so that the number
    /// of threads changes nothing.
    fn normals(&mut self) -> Vec<Vector3<f64>> {
        let mut normal = || StandardNormal.sample(&mut self.rng);
        (0..self.particles.len()).map(|_| Vector3::new(normal(), normal(), normal())).collect()
    }

    /// The poses of the particles with their weights.
    pub fn particles(&self) -> Particles {
        let mut particles = Particles::new();
        for (particle, &log_weight) in self.particles.iter().zip(&self.log_weights) {
            particles.push(particle.pose(), log_weight);
        }
        particles
    }

    /// Corrects with all observations of one time, any number of them. Returns an outcome for each,
    /// that of the particle with the largest weight.
    ///
    /// Observations are processed in groups of [`AssociationSettings::GROUP`]; the poses are drawn
    /// with the first group, and the others weight them.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for an observation that is not finite or has a negative range:
    /// none is then used. [`loc_filters::Error::LostPositivity`], with the step: the filter cannot
    /// continue.
    pub fn correct(&mut self, observations: &[LandmarkObservation]) -> Result<Vec<Outcome>> {
        Ok(self.update(observations)?)
    }

    fn update(
        &mut self,
        observations: &[LandmarkObservation],
    ) -> loc_filters::Result<Vec<Outcome>> {
        for observation in observations {
            observation.observed.check()?;
        }
        if observations.is_empty() {
            return Ok(Vec::new());
        }
        self.moment += 1;
        self.step += 1;
        let mut outcomes = Vec::with_capacity(observations.len());
        for group in observations.chunks(AssociationSettings::GROUP) {
            self.include(group);
            outcomes.extend(self.update_group(group)?);
        }
        self.prune();
        self.resample();
        Ok(outcomes)
    }

    /// Extends the view by the observations, and assigns slots to new numbers.
    fn include(&mut self, group: &[LandmarkObservation]) {
        for seen in group {
            // Distance and direction do not depend on where the robot is.
            let Some(located) = Located::new(&self.settings, Pose2::IDENTITY, seen.observed) else {
                continue;
            };
            self.view.include(&located);
            let slot = self.numbers.len();
            let numbered = self.settings.identities == Identities::Known;
            if numbered && slot < self.settings.map.max_landmarks {
                self.numbers.entry(seen.landmark).or_insert(slot);
            }
        }
    }

    fn update_group(&mut self, group: &[LandmarkObservation]) -> loc_filters::Result<Vec<Outcome>> {
        let normals = self.normals();
        let mut particles = std::mem::take(&mut self.particles);
        let parts = particles.chunks_mut(CHUNK).zip(normals.chunks(CHUNK));
        let context = self.context();
        let reports = self.workers.map(parts, |(particles, normals)| {
            let both = particles.iter_mut().zip(normals);
            both.map(|(particle, normals)| particle.update(&context, group, normals)).collect()
        });
        self.particles = particles;
        let reports: Vec<Report> =
            reports.into_iter().flat_map(|part: Vec<_>| part).collect::<Result<_, _>>()?;
        for (weight, report) in self.log_weights.iter_mut().zip(&reports) {
            *weight += report.log_likelihood;
        }
        self.normalize();
        Ok(reports.into_iter().nth(self.best).map(|report| report.outcomes).unwrap_or_default())
    }

    fn context(&self) -> Context<'_> {
        Context {
            settings: &self.settings,
            gate: self.gate,
            new_landmark_gate: self.new_landmark_gate,
            associator: &self.associator,
            view: self.view,
            numbers: &self.numbers,
            moment: self.moment,
            step: self.step,
        }
    }

    /// Makes the weights add up to 1; weights that are all 0 become equal. The best particle is
    /// the first of those with the largest.
    fn normalize(&mut self) {
        match Mass::of(&self.log_weights).log_sum() {
            Some(sum) => divide(&mut self.log_weights, sum),
            None => self.log_weights.fill(-(self.particles.len() as f64).ln()),
        }
        let weights = self.log_weights.iter().enumerate();
        let largest = weights.rev().max_by(|a, b| a.1.total_cmp(b.1));
        self.best = largest.map_or(0, |(index, _)| index);
    }

    /// With unknown data association, removes false landmarks and weights by missed ones.
    fn prune(&mut self) {
        if self.settings.identities == Identities::Unknown {
            let mut particles = std::mem::take(&mut self.particles);
            let context = self.context();
            let missed: Vec<Vec<f64>> =
                self.workers.map(particles.chunks_mut(CHUNK), |particles| {
                    particles.iter_mut().map(|particle| particle.prune(&context)).collect()
                });
            self.particles = particles;
            for (weight, missed) in self.log_weights.iter_mut().zip(missed.iter().flatten()) {
                *weight += missed;
            }
            self.normalize();
        }
    }

    /// Draws particles by their weights, where these have become unequal.
    fn resample(&mut self) {
        let count = self.particles.len();
        let effective = Mass::of(&self.log_weights).effective_sample_size();
        if !self.settings.policy().is_due(1, effective, count) {
            return;
        }
        let mut drawn = Vec::new();
        self.settings.resampling.draw(&self.log_weights, count, &mut self.rng, &mut drawn);
        let parents = drawn.iter().map(|&parent| parent as usize);
        // The best one has the largest share, but multinomial resampling may not draw it.
        let best = parents.clone().position(|parent| parent == self.best);
        let children = parents.filter_map(|parent| self.particles.get(parent).cloned());
        self.particles = children.collect();
        self.log_weights.fill(-(count as f64).ln());
        self.best = best.unwrap_or(0);
    }

    /// The estimate of the pose: mean and covariance over all particles, each with its covariance
    /// by odometry since its pose was drawn.
    ///
    /// # Errors
    /// [`loc_filters::Error::LostPositivity`] for a covariance that is not positive, with the step.
    pub fn pose(&self) -> Result<Gaussian<3>> {
        Ok(self.belief()?)
    }

    fn belief(&self) -> loc_filters::Result<Gaussian<3>> {
        let about = self.particles[self.best].belief.mean;
        let off = |mean: &Vector3<f64>| {
            let mut off = mean - about;
            off.z = angle::wrap(off.z);
            off
        };
        let weighted = || self.particles.iter().zip(&self.log_weights).map(|(p, w)| (p, w.exp()));
        let shift: Vector3<f64> = weighted().map(|(p, w)| w * off(&p.belief.mean)).sum();
        let spread = |(p, w): (&Particle, f64)| {
            let d = off(&p.belief.mean) - shift;
            w * (p.belief.covariance + d * d.transpose())
        };
        let covariance: Matrix3<f64> = weighted().map(spread).sum();
        let mut belief = Gaussian { mean: about + shift, covariance };
        belief.mean.z = angle::wrap(belief.mean.z);
        check(&belief, self.step)?;
        Ok(belief)
    }

    /// The landmarks. With known data association, mean and covariance over the particles that have
    /// each, of landmarks that the majority has. With unknown association the landmarks of
    /// different particles do not correspond: then they are those of the particle with the largest
    /// weight, and their covariances are small, conditional on its path.
    ///
    /// # Errors
    /// [`loc_filters::Error::LostPositivity`] where the covariance of one is not positive.
    pub fn landmarks(&self) -> Result<Vec<MapLandmark>> {
        let mut landmarks = Vec::new();
        if self.settings.identities == Identities::Unknown {
            self.particles[self.best].map.visit(&mut |_, estimate| {
                let landmark_map::LandmarkEstimate {
                    id, position, observations, confirmed, ..
                } = *estimate;
                landmarks.push(MapLandmark { id, position, observations, confirmed });
            });
        } else {
            landmarks.extend(self.numbers.iter().filter_map(|(&id, &slot)| self.mixed(id, slot)));
        }
        for landmark in &landmarks {
            let what = "covariance of a landmark";
            check_covariance(what, &landmark.position.covariance).map_err(|_| {
                let found = format!("{:?}", landmark.position.covariance.as_slice());
                loc_filters::Error::LostPositivity { what, step: self.step, found }
            })?;
        }
        Ok(landmarks)
    }

    /// A landmark of known number over all particles; `None` where the majority does not have it.
    fn mixed(&self, id: u32, slot: usize) -> Option<MapLandmark> {
        let weighted = || {
            let all = self.particles.iter().zip(&self.log_weights);
            all.filter_map(|(p, w)| Some((p.map.get(slot)?, w.exp())))
        };
        let total: f64 = weighted().map(|(_, w)| w).sum();
        if total <= 0.5 {
            return None;
        }
        let mean: Vector2<f64> =
            weighted().map(|(estimate, w)| estimate.position.mean * (w / total)).sum();
        let covariance: Matrix2<f64> = weighted()
            .map(|(estimate, w)| {
                let d = estimate.position.mean - mean;
                (estimate.position.covariance + d * d.transpose()) * (w / total)
            })
            .sum();
        let confirmed: f64 = weighted().filter(|(m, _)| m.confirmed).map(|(_, w)| w).sum();
        Some(MapLandmark {
            id,
            position: Gaussian { mean, covariance },
            observations: weighted().map(|(estimate, _)| estimate.observations).max()?,
            confirmed: confirmed > 0.5 * total,
        })
    }
}

fn finite_twist(twist: Twist2) -> loc_filters::Result<()> {
    if twist.is_finite() {
        return Ok(());
    }
    let found = format!("{:?}", twist.to_vector().as_slice());
    Err(loc_filters::Error::NotFinite { what: "velocity", found })
}

/// Particles that a thread updates at a time.
const CHUNK: usize = 8;

/// Refuses a belief that is not positive or not finite.
fn check(belief: &Gaussian<3>, step: u64) -> loc_filters::Result<()> {
    let finite = belief.mean.iter().chain(belief.covariance.iter()).all(|v| v.is_finite());
    let what = "covariance of the robot";
    match check_covariance(what, &belief.covariance) {
        Ok(()) if finite => Ok(()),
        _ => {
            let found =
                format!("{:?} at {:?}", belief.covariance.as_slice(), belief.mean.as_slice());
            Err(loc_filters::Error::LostPositivity { what, step, found })
        }
    }
}
