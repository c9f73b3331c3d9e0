//! Monte Carlo localization with landmarks at known positions (M5).
//!
//! A particle set drives as the odometry says, each with an error of its own; every observation
//! of a landmark favours those that would have seen it so. Unlike the extended Kalman filter it
//! needs no start pose, holds several possible places apart until an observation decides, and finds
//! back after it was carried away.
//!
//! ```
//! use loc_core::{Pose2, Twist2, gaussian::pose_belief, random::stream};
//! use loc_filters::Localizer;
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_pf::{LandmarkMcl, LandmarkMclSettings};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0), Landmark::planar(2, 0.0, 3.0)])?;
//! let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
//! let settings = LandmarkMclSettings::default();
//! let mut mcl = LandmarkMcl::new(map, settings, 0.0, &start, stream(1, "mcl"))?;
//! mcl.velocity(0.0, Twist2::forward(1.0, 0.0))?;
//! let observed = Observed::RangeBearing { range: 2.0, bearing: 0.0 };
//! mcl.update(2.0, &[LandmarkObservation { landmark: 1, observed }])?;
//! assert!((mcl.estimate(2.5)?.pose.x - 2.5).abs() < 0.2);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod settings;
mod update;
mod velocities;

pub use settings::{LandmarkMclSettings, RecoverySettings};
pub use update::ObservationUpdate;

use crate::estimate::moments;
use crate::{ParticleFilter, Particles, Result, Workers};
use loc_core::Gaussian;
use loc_core::error::finite;
use loc_core::motion::{Twist2, dead_reckon};
use loc_core::random::ChaCha8Rng;
use loc_filters::RobotSettings;
use loc_filters::delayed::{Clock, Sequential};
use loc_filters::localizer::{
    Decision, Estimate, Localizer, Outcome, ParticleSet, observed_position,
};
use loc_maps::{Bounds, LandmarkMap};
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::LandmarkObservation;
use std::sync::Arc;
use update::Fit;
use velocities::Velocities;

/// Monte Carlo localization with landmarks over time-stamped inputs in order;
/// [`Delayed`](loc_filters::delayed::Delayed) around it takes late ones: copies share the particles
/// until these move.
///
/// A velocity holds from its stamp until the next one. Observations may come between velocities,
/// several at one stamp, or not at all.
#[derive(Debug, Clone)]
pub struct LandmarkMcl {
    map: Arc<LandmarkMap>,
    settings: LandmarkMclSettings,
    /// Where the robot can be.
    region: Bounds,
    filter: Arc<ParticleFilter>,
    state: State,
    clock: Clock,
    /// The velocities that the particles have not been moved by yet.
    velocities: Velocities,
}

/// The state of the filter beside its particles.
#[derive(Debug, Clone, Copy)]
struct State {
    /// The time of the particles \[s\].
    stamp: f64,
    /// The estimate of the pose.
    belief: Gaussian<3>,
    fit: Fit,
    /// Whether the particles are uniform, before the first observation.
    anywhere: bool,
    /// Whether the particles were resampled with the last observations.
    resampled: bool,
}

impl LandmarkMcl {
    /// A robot that stands still at `stamp` \[s\] with a belief over (x, y, theta) (A1).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid, and for a map
    /// without landmarks.
    pub fn new(
        map: impl Into<Arc<LandmarkMap>>,
        settings: LandmarkMclSettings,
        stamp: f64,
        start: &Gaussian<3>,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        let mut mcl = LandmarkMcl::anywhere(map, settings, stamp, rng)?;
        let start = Gaussian::new(start.mean, start.covariance)?;
        let filter = Arc::make_mut(&mut mcl.filter);
        let cloud = Particles::from_gaussian(&start, settings.particles, filter.rng_mut());
        *filter.particles_mut() = cloud;
        mcl.state = State { belief: start, anywhere: false, ..mcl.state };
        Ok(mcl)
    }

    /// A robot that stands still at `stamp` \[s\] anywhere around the landmarks (A2). With the
    /// first observations the particles are drawn where those may have been seen from.
    ///
    /// # Errors
    /// As [`LandmarkMcl::new`].
    pub fn anywhere(
        map: impl Into<Arc<LandmarkMap>>,
        settings: LandmarkMclSettings,
        stamp: f64,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        settings.check()?;
        let (map, clock) = (map.into(), Clock::starting_at(stamp)?);
        let places = map.iter().map(|landmark| landmark.position.xy());
        let region = Bounds::around(places).map(|bounds| bounds.grown(settings.margin));
        let (what, expected) = ("landmarks of the map", "at least 1");
        let none = loc_core::Error::Length { what, expected, found: 0 };
        let region = region.ok_or(none)?;
        let workers = Workers::new(settings.threads)?;
        let mut filter = ParticleFilter::new(Particles::new(), rng).with_workers(workers);
        *filter.particles_mut() = update::uniform(&region, settings.particles, filter.rng_mut());
        let belief = moments(filter.particles());
        let state = State { stamp, belief, fit: Fit::default(), anywhere: true, resampled: false };
        let (filter, velocities) = (Arc::new(filter), Velocities::default());
        Ok(LandmarkMcl { map, settings, region, filter, state, clock, velocities })
    }

    /// Restarts from a belief; earlier observations are dropped, the velocity is kept.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief that is not valid.
    pub fn start_at(&mut self, start: &Gaussian<3>) -> Result<()> {
        let start = Gaussian::new(start.mean, start.covariance)?;
        let count = self.settings.particles;
        let filter = Arc::make_mut(&mut self.filter);
        *filter.particles_mut() = Particles::from_gaussian(&start, count, filter.rng_mut());
        let (fit, anywhere, resampled) = (Fit::default(), false, false);
        self.state = State { belief: start, fit, anywhere, resampled, ..self.state };
        Ok(())
    }

    /// The velocity from `stamp` \[s\] on.
    fn drive(&mut self, stamp: f64, twist: Twist2) -> Result<()> {
        for value in [twist.vx, twist.vy, twist.omega] {
            finite("velocity [m/s, rad/s]", value)?;
        }
        self.clock.advance("velocity", stamp)?;
        self.velocities.insert(stamp, twist);
        if let Some(end) = self.velocities.segment_end_before(self.clock.now()) {
            self.predict_to(end);
        }
        self.velocities.drop_before(self.state.stamp);
        Ok(())
    }

    /// Corrects with any number of landmarks observed at `stamp` \[s\], not before the last input.
    ///
    /// # Errors
    /// [`loc_filters::Error::TooLate`], and [`loc_core::Error::OutOfRange`] for observations that are
    /// not valid, none of which is then used.
    pub fn update(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<ObservationUpdate> {
        observations.iter().try_for_each(|observation| observation.observed.check().map(|_| ()))?;
        self.clock.advance("observations", stamp)?;
        self.correct_with(self.clock.now(), observations)
    }

    /// The belief at a time \[s\] not before the last input.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite.
    pub fn belief_at(&self, stamp: f64) -> Result<Gaussian<3>> {
        finite("stamp [s]", stamp)?;
        let State { stamp: from, belief, .. } = self.state;
        let RobotSettings { integration, odometry, .. } = &self.settings.robot;
        let drive = self.velocities.between(from, stamp);
        Ok(drive.fold(belief, |belief, interval| {
            dead_reckon(&belief, interval.twist, interval.duration, *integration, odometry)
        }))
    }

    /// The particles, at the time of the last observation.
    pub fn particles(&self) -> &Particles {
        self.filter.particles()
    }

    /// The particles with their weights by the last observations, if they were resampled then.
    pub fn weighed(&self) -> Option<&Particles> {
        Some(self.filter.resampled_from())
            .filter(|before| self.state.resampled && !before.is_empty())
    }

    /// How well observations fit, as shares of their likelihood without errors: long-term and
    /// short-term average. `None` before the first.
    pub fn fit(&self) -> Option<[f64; 2]> {
        self.state.fit.averages()
    }
}

/// Below this probability of being right an observation counts as rejected.
const TRUSTED: f64 = 0.5;

impl Localizer for LandmarkMcl {
    fn predict(&mut self, stamp: f64, control: &Control) -> loc_filters::Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        Ok(self.drive(stamp, *twist)?)
    }

    fn correct(
        &mut self,
        stamp: f64,
        measurement: &Measurement,
    ) -> loc_filters::Result<Vec<Outcome>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        let update = self.update(stamp, observations)?;
        let camera = self.belief_at(stamp)?.pose() * self.settings.robot.mounting;
        let outcome = |observation: &LandmarkObservation| {
            let trust = update.trust.iter().find(|trust| trust.observation == *observation);
            let is_trusted = trust.is_some_and(|trust| trust.probability >= TRUSTED);
            let decision = if is_trusted { Decision::Accepted } else { Decision::Rejected };
            let outcome = Outcome::of(decision).with_landmark(observation.landmark);
            outcome.with_place(observed_position(camera, observation))
        };
        Ok(observations.iter().map(outcome).collect())
    }

    fn estimate(&self, stamp: f64) -> loc_filters::Result<Estimate> {
        Ok(self.belief_at(stamp)?.into())
    }

    fn particle_count(&self) -> usize {
        self.particles().len()
    }

    fn particle_set(&self, max: usize) -> Option<ParticleSet> {
        let weighted = self.weighed().map(|particles| particles.thinned(max));
        Some(ParticleSet { particles: self.particles().thinned(max), weighted })
    }
}

impl Sequential for LandmarkMcl {
    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Landmarks(_))
    }
}
