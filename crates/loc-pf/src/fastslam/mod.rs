//! FastSLAM 2.0: particles that each draw a map of their own (I2 to I4).
//!
//! EKF-SLAM keeps the covariance of everything with everything, and makes up its mind once about
//! each observation. FastSLAM splits the question: *if the robot's way were known*, the landmarks
//! would have nothing to do with each other, and each would need but a Kalman filter of two
//! numbers. So a particle is one way that the robot may have come, with the map that goes with it;
//! a particle whose map fits what is seen has many children, others have none. Each decides for
//! itself which landmark it has seen, and those that were wrong die out.
//!
//! Version 2.0 (Montemerlo, Thrun, Koller and Wegbreit 2003) draws the new pose not from odometry
//! alone, but from odometry and observations together. For a particle whose pose has mean `x` and
//! covariance `P` since it was drawn last, and an observation `z` of a landmark of covariance `S`,
//!
//! ```text
//! L = G_s P G_s^T + G_m S G_m^T + R        how far z may be from its expectation
//! K = P G_s^T L^-1                         x' = x + K (z - h),  P' = P - K L K^T
//! weight *= N(z; h, L)                     pose ~ N(x', P')
//! ```
//!
//! one observation after the other, and the landmarks are corrected from the pose that was drawn. So
//! precise observations do not kill all particles but a few: they are where the observations are.
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
//! let see = |range| LandmarkObservation { landmark: 7, sight: Observed::RangeBearing { range, bearing: 0.0 } };
//! slam.correct(&[see(4.0)])?;
//! slam.predict(Twist2::forward(1.0, 0.0), 1.0)?;
//! slam.correct(&[see(2.9)])?;
//! let (robot, landmarks) = (slam.pose()?, slam.landmarks()?);
//! assert!(robot.mean.x > 1.0 && (landmarks[0].position.mean.x - 3.95).abs() < 0.05);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod correct;
mod estimate;
mod localizer;
mod look;
mod map;
mod mark;
mod pairs;
mod particle;
mod settings;
mod shared;
mod view;

pub use localizer::FastSlamLocalizer;
pub use settings::FastSlamSettings;

use crate::{Particles, Result, Workers};
use loc_core::motion::dead_reckon;
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Twist2};
use loc_filters::Gate;
use loc_filters::association::Associator;
use nalgebra::Vector3;
use particle::Particle;
use rand_distr::{Distribution, StandardNormal};
use std::collections::BTreeMap;
use view::View;

/// The variance of the heading \[rad^2\] up to which a drive without observations is taken for a
/// normal distribution; beyond, the poses are drawn.
const WIDEST_HEADING: f64 = 0.01;

/// Particles over the robot's way, each with a map of its own, in the frame of the start.
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
    /// Slot of each number that is read off landmarks.
    numbers: BTreeMap<u32, usize>,
    view: View,
    moment: u64,
    step: u64,
    rng: ChaCha8Rng,
    workers: Workers,
}

impl FastSlam {
    /// A filter without landmarks, from a belief over (x, y, theta) \[m, m, rad\]. The start may be
    /// certain: then it is the origin that the maps are drawn from.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief or settings that are not valid, [`crate::Error::Threads`].
    pub fn new(start: Gaussian<3>, settings: FastSlamSettings, rng: ChaCha8Rng) -> Result<Self> {
        settings.validate()?;
        let mut start = Gaussian::new(start.mean, start.covariance)?;
        start.mean.z = loc_core::angle::wrap(start.mean.z);
        let count = settings.particles;
        let new_landmark_gate = Gate::probability(settings.map.new_landmark_probability)?;
        Ok(FastSlam {
            gate: Gate::probability(settings.gate_probability)?,
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

    /// Motions and corrections so far.
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Drives on with velocity `twist` for `dt` \[s\]. Nothing is drawn before something is seen.
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
        let FastSlamSettings { integration, motion_noise, .. } = self.settings;
        let step = self.step + 1;
        let drive = |particle: &Particle| {
            dead_reckon(&particle.belief, twist, dt, integration, &motion_noise)
        };
        let driven: Vec<Gaussian<3>> = self.particles.iter().map(drive).collect();
        driven.iter().try_for_each(|belief| estimate::check(belief, step))?;
        self.step = step;
        for (particle, belief) in self.particles.iter_mut().zip(driven) {
            particle.belief = belief;
        }
        if self.particles.iter().any(|particle| particle.belief.covariance.m33 > WIDEST_HEADING) {
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
        let mut cloud = Particles::new();
        for (particle, &log_weight) in self.particles.iter().zip(&self.log_weights) {
            cloud.push(particle.pose(), log_weight);
        }
        cloud
    }
}

fn finite_twist(twist: Twist2) -> loc_filters::Result<()> {
    if twist.is_finite() {
        return Ok(());
    }
    let found = format!("{:?}", twist.to_vector().as_slice());
    Err(loc_filters::Error::NotFinite { what: "velocity", found })
}
