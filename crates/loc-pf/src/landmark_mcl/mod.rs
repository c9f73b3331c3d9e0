//! Monte Carlo localization with landmarks at known positions (M5).
//!
//! Particles move with the odometry, each with its own noise; every observation of a landmark
//! weights them by its likelihood. Unlike the extended Kalman filter it needs no initial pose,
//! keeps several hypotheses until observations decide, and recovers from kidnapping. It accepts the
//! same stamped inputs, late ones included.
//!
//! ```
//! use loc_core::{Pose2, Twist2, gaussian::pose_belief, random::stream};
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_pf::{LandmarkMcl, LandmarkMclSettings};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0), Landmark::planar(2, 0.0, 3.0)])?;
//! let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
//! let settings = LandmarkMclSettings::default();
//! let mut mcl = LandmarkMcl::new(map, settings, 0.0, &start, stream(1, "mcl"))?;
//! mcl.velocity(0.0, Twist2::forward(1.0, 0.0))?;
//! let sight = Observed::RangeBearing { range: 2.0, bearing: 0.0 };
//! mcl.observations(2.0, &[LandmarkObservation { landmark: 1, sight }])?;
//! assert!((mcl.estimate(2.5)?.mean.x - 2.5).abs() < 0.2);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod past;
mod update;

pub use update::ObservationUpdate;

use crate::estimate::moments;
use crate::sensor::landmark::ObservationModel;
use crate::{ParticleFilter, Particles, Resampling, Result, Workers};
use loc_core::Gaussian;
use loc_core::error::{finite, in_range, non_negative, positive, probability};
use loc_core::motion::{Integration, Twist2, VelocityNoise, dead_reckon};
use loc_core::random::ChaCha8Rng;
use loc_maps::{Bounds, LandmarkMap};
use loc_sensors::landmark_camera::LandmarkObservation;
use past::{BufferedObservations, Velocities};
use std::collections::VecDeque;
use std::sync::Arc;
use update::Fit;

/// Settings of [`LandmarkMcl`], with defaults that serve a small indoor robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct LandmarkMclSettings {
    /// Number of particles.
    pub particles: usize,
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// How far odometry may be off.
    pub motion_noise: VelocityNoise,
    /// How observations come about.
    pub sights: ObservationModel,
    /// How far the robot may be outside of the box around the landmarks \[m\].
    pub margin: f64,
    /// The particle set is resampled where its effective sample size falls below this share.
    pub resample_below: f64,
    /// How particles are drawn.
    pub resampling: Resampling,
    /// How far resampled particles are moved apart, as a share of what suits a normal distribution,
    /// in \[0, 1\]: copies of one particle would stay copies on a robot that stands still. At most
    /// a quarter of an observation's sigma.
    pub roughening: f64,
    /// What to do when lost.
    pub recovery: RecoverySettings,
    /// How late an input may come \[s\].
    pub horizon: f64,
    /// Number of threads.
    pub threads: usize,
}

/// When observations no longer fit, particles are put where they would (augmented MCL).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct RecoverySettings {
    /// Decay of the slow average of how well observations fit; also known as alpha_slow.
    pub alpha_slow: f64,
    /// Decay of the fast one; 0 for no recovery. Also known as alpha_fast.
    pub alpha_fast: f64,
    /// The fast average must fall below the slow one divided by this before anything is done; the
    /// share of new particles is then `1 - fast / slow`. 1 is the textbook, which replaces a few
    /// whenever observations fit a little worse than usual.
    pub factor: f64,
    /// Share of the new particles that are put where the observations are, the others anywhere.
    pub sensor_resetting: f64,
}

impl Default for LandmarkMclSettings {
    fn default() -> Self {
        LandmarkMclSettings {
            particles: 2000,
            integration: Integration::default(),
            motion_noise: VelocityNoise::default(),
            sights: ObservationModel::default(),
            margin: 1.0,
            resample_below: 0.5,
            resampling: Resampling::default(),
            roughening: 1.0,
            recovery: RecoverySettings::default(),
            horizon: 2.0,
            threads: 1,
        }
    }
}

impl Default for RecoverySettings {
    fn default() -> Self {
        RecoverySettings { alpha_slow: 0.01, alpha_fast: 0.1, factor: 2.0, sensor_resetting: 0.9 }
    }
}

impl LandmarkMclSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`] naming the first that is not
    /// allowed.
    pub fn validate(&self) -> Result<()> {
        if self.particles == 0 {
            let (what, expected) = ("particles", "at least 1");
            return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
        }
        self.motion_noise.check()?;
        self.sights.validate()?;
        positive("margin around the landmarks [m]", self.margin)?;
        probability("resample_below", self.resample_below)?;
        probability("roughening", self.roughening)?;
        self.recovery.validate()?;
        non_negative("horizon for late inputs [s]", self.horizon)?;
        Ok(())
    }
}

impl RecoverySettings {
    fn validate(&self) -> Result<()> {
        probability("alpha_slow", self.alpha_slow)?;
        probability("alpha_fast", self.alpha_fast)?;
        let at_least_1 = |factor: f64| factor.is_finite() && factor >= 1.0;
        in_range("recovery factor", "a finite number >= 1", self.factor, at_least_1)?;
        probability("share of sensor resetting", self.sensor_resetting)?;
        Ok(())
    }
}

/// Monte Carlo localization over stamped velocities and observations, in order or late.
///
/// A velocity intervals from its stamp until the next one. Observations may come between
/// velocities, several at one stamp, up to the settings' `horizon` late, or not at all: the result
/// is the same, to the bit, as if all had come in order. For that the particles before each
/// observation of the last `horizon` is kept, 32 bytes a particle.
#[derive(Debug)]
pub struct LandmarkMcl {
    map: Arc<LandmarkMap>,
    settings: LandmarkMclSettings,
    /// Where the robot can be.
    region: Bounds,
    filter: ParticleFilter,
    state: State,
    velocities: Velocities,
    /// The observations of the recent past.
    past: VecDeque<BufferedObservations>,
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
        let particles = Particles::from_gaussian(&start, settings.particles, mcl.filter.rng_mut());
        *mcl.filter.particles_mut() = particles;
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
        settings.validate()?;
        let (map, stamp) = (map.into(), finite("start time [s]", stamp)?);
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
        let (velocities, past) = (Velocities::default(), VecDeque::new());
        Ok(LandmarkMcl { map, settings, region, filter, state, velocities, past })
    }

    /// Restarts from a belief; earlier observations are dropped, the velocity is kept.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief that is not valid.
    pub fn start_at(&mut self, start: &Gaussian<3>) -> Result<()> {
        let start = Gaussian::new(start.mean, start.covariance)?;
        let count = self.settings.particles;
        *self.filter.particles_mut() =
            Particles::from_gaussian(&start, count, self.filter.rng_mut());
        let (fit, anywhere, resampled) = (Fit::default(), false, false);
        self.state = State { belief: start, fit, anywhere, resampled, ..self.state };
        self.past.clear();
        Ok(())
    }

    /// The velocity from `stamp` \[s\] on.
    ///
    /// # Errors
    /// [`crate::Error::TooLate`], and [`loc_core::Error::OutOfRange`] for what is not finite.
    pub fn velocity(&mut self, stamp: f64, twist: Twist2) -> Result<()> {
        for value in [twist.vx, twist.vy, twist.omega] {
            finite("velocity [m/s, rad/s]", value)?;
        }
        self.check_stamp("velocity", stamp)?;
        self.velocities.insert(stamp, twist);
        // It changes the motion before later observations.
        let index = self.index_after(stamp);
        self.rewind_to(index);
        self.replay_from(index)?;
        self.drop_old();
        Ok(())
    }

    /// Any number of landmarks seen at `stamp` \[s\].
    ///
    /// # Errors
    /// [`crate::Error::TooLate`], and [`loc_core::Error::OutOfRange`] for observations that are not valid,
    /// none of which is then used.
    pub fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<ObservationUpdate> {
        self.check_stamp("observations", stamp)?;
        observations.iter().try_for_each(|observation| observation.sight.check().map(|_| ()))?;
        let index = self.index_after(stamp);
        self.rewind_to(index);
        let before = self.snapshot();
        let update = self.update(stamp, observations)?;
        self.past.insert(
            index,
            BufferedObservations { stamp, observations: observations.to_vec(), before },
        );
        self.replay_from(index + 1)?;
        self.drop_old();
        Ok(update)
    }

    /// The belief at a time \[s\]: predicted from the last observation before it.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite.
    pub fn estimate(&self, stamp: f64) -> Result<Gaussian<3>> {
        finite("stamp [s]", stamp)?;
        let later = self.past.get(self.index_after(stamp));
        let State { stamp: from, belief, .. } =
            later.map_or(self.state, |moment| moment.before.state);
        let LandmarkMclSettings { integration, motion_noise, .. } = &self.settings;
        let drive = self.velocities.between(from, stamp);
        Ok(drive.fold(belief, |belief, interval| {
            dead_reckon(&belief, interval.twist, interval.duration, *integration, motion_noise)
        }))
    }

    /// The particles, at the time of the last observation.
    pub fn particles(&self) -> &Particles {
        self.filter.particles()
    }

    /// The particles with their weights by the last observations, if they were resampled then.
    pub fn weighed(&self) -> Option<&Particles> {
        self.state.resampled.then(|| self.filter.resampled_from())
    }

    /// How well observations fit, as shares of their likelihood without errors: long-term and
    /// short-term average. `None` before the first.
    pub fn fit(&self) -> Option<[f64; 2]> {
        self.state.fit.averages()
    }
}
