//! The part of the filter that changes: the particle set, and what decides over it.

use super::scan::{Observation, Surroundings};
use super::{MclSettings, MotionSettings, UpdateReport};
use crate::filter::Weighing;
use crate::motion::{DifferentialStep, DrivenPath, NoisyStep, OmnidirectionalStep, PathNoise};
use crate::recovery::{AugmentedMcl, Suspicion, UsualEvidence};
use crate::tempering::{Tempering, TemperingReport};
use crate::{
    Kld, Motion, ParticleFilter, Particles, PosesMut, ResamplePolicy, Resampling, Result,
    Transport, Workers,
};
use loc_core::random::ChaCha8Rng;
use loc_core::{Gaussian, Pose2};
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use nalgebra::{Matrix3, Vector3};
use rand_distr::{Distribution, StandardNormal};

/// The belief about the pose.
#[derive(Debug)]
pub(super) struct Belief {
    pub(super) filter: ParticleFilter,
    pub(super) max_particles: usize,
    kld: Kld,
    resampling: Resampling,
    policy: ResamplePolicy,
    independent_beams: f64,
    tempering: Option<Tempering>,
    /// For the places that a search finds.
    pub(super) everywhere: Tempering,
    pub(super) suspicion: Option<Suspicion>,
    pub(super) augmented: Option<AugmentedMcl>,
    /// Whether the particle set has seen a scan since it was spread, and whether over the whole map.
    pub(super) has_seen: bool,
    pub(super) is_anywhere: bool,
    pub(super) updates_since_resampling: usize,
}

impl Belief {
    pub(super) fn new(settings: &MclSettings, area: f64, rng: ChaCha8Rng) -> Result<Self> {
        let workers = Workers::new(settings.threads)?;
        let usual = usual_evidence(&settings.sensor.field());
        let suspicion = settings.recovery.suspicion;
        Ok(Belief {
            filter: ParticleFilter::new(Particles::new(), rng).with_workers(workers),
            max_particles: settings.particles.max_particles,
            kld: Kld::new(settings.particles.clone())?,
            resampling: settings.resampling,
            policy: settings.policy,
            independent_beams: settings.independent_beams,
            tempering: settings.tempering.map(Tempering::new).transpose()?,
            everywhere: Tempering::default(),
            suspicion: suspicion.map(|s| Suspicion::new(s, usual, area)).transpose()?,
            augmented: settings.recovery.augmented.map(AugmentedMcl::new).transpose()?,
            has_seen: false,
            is_anywhere: true,
            updates_since_resampling: 0,
        })
    }

    /// Whether the particle set is spread over the whole map and has seen nothing yet.
    pub(super) fn is_looking(&self) -> bool {
        self.is_anywhere && !self.has_seen
    }

    /// Moves the particle set by a step and weighs it by scans.
    pub(super) fn update(
        &mut self,
        step: &Step,
        scan: &Observation<'_>,
        endpoints: &Endpoints,
        map: &Surroundings,
    ) -> UpdateReport {
        let is_lost = self.is_looking();
        self.has_seen = true;
        let found = if is_lost { self.look_everywhere(map, scan, endpoints) } else { None };
        let (report, searched) = match found {
            Some(found) => {
                *self.filter.particles_mut() = found.particles;
                (TemperingReport { stages: 1, log_evidence: found.log_evidence }, true)
            }
            None => (self.track(step, scan), false),
        };
        if !is_lost {
            self.suspect(report.log_evidence, endpoints.len());
            self.inject(report.log_evidence, map);
        }
        let TemperingReport { stages, log_evidence } = report;
        let effective_sample_size = self.filter.effective_sample_size();
        UpdateReport { stages, log_evidence, effective_sample_size, searched }
    }

    /// Sample the motion, weigh, resample: by degrees, or at once.
    // ANCHOR: track
    fn track(&mut self, step: &Step, scan: &Observation<'_>) -> TemperingReport {
        match &mut self.tempering {
            Some(tempering) => {
                let count = self.filter.count_needed(&mut self.kld);
                let report = tempering.update(&mut self.filter, step, scan, count);
                self.shrink(count);
                report
            }
            None => {
                self.filter.predict(step);
                let Weighing { log_evidence, effective_sample_size } = self.filter.correct(scan);
                self.updates_since_resampling += 1;
                let (updates, count) =
                    (self.updates_since_resampling, self.filter.particles().len());
                if self.policy.is_due(updates, effective_sample_size, count) {
                    self.filter.resample_adaptively(self.resampling, &mut self.kld);
                    self.updates_since_resampling = 0;
                }
                TemperingReport { stages: 1, log_evidence }
            }
        }
    }
    // ANCHOR_END: track

    /// Takes in what the scan says about the robot's being elsewhere.
    fn suspect(&mut self, log_evidence: f64, beams: usize) {
        let beams = self.independent_beams.min(beams as f64);
        if let Some(suspicion) = &mut self.suspicion {
            suspicion.update(log_evidence, beams);
        }
    }

    /// Moves and weighs the present particle set, which a search has found.
    pub(super) fn track_elsewhere(&mut self, step: &Step, scan: &Observation<'_>) {
        let count = self.filter.count_needed(&mut self.kld);
        self.everywhere.update(&mut self.filter, step, scan, count);
        self.shrink(count);
    }

    /// Draws fewer particles where a particle set has outgrown its need, after a search, say.
    fn shrink(&mut self, count: usize) {
        if self.filter.particles().len() > 2 * count {
            self.filter.resample(self.resampling, count);
        }
    }

    /// Replaces as many particles by random ones as the running averages call for.
    fn inject(&mut self, log_evidence: f64, map: &Surroundings) {
        let Some(augmented) = &mut self.augmented else { return };
        let share = augmented.update(log_evidence);
        let count = (share * self.filter.particles().len() as f64).round() as usize;
        let strangers: Vec<_> =
            (0..count).map(|_| map.free_space.draw(self.filter.rng_mut())).collect();
        self.filter.particles_mut().replace_evenly(&strangers);
    }
}

/// What a beam is worth: three of four end on the map's obstacles where the robot is right, half of
/// them at the least.
fn usual_evidence(field: &LikelihoodFieldSettings) -> UsualEvidence {
    // The mean of -d^2 / (2 sigma^2) over the hits is -1/2.
    let hit = field.likelihood(0.0).ln() - 0.5;
    let miss = field.likelihood(f64::INFINITY).ln();
    let mixed = |share: f64| share * hit + (1.0 - share) * miss;
    UsualEvidence { expected: mixed(0.75), least: mixed(0.5) }
}

// The motion since the last update, by the model that the settings name.

/// A step of one of the models.
#[derive(Debug)]
pub(super) enum Step {
    Path(NoisyStep),
    Differential(DifferentialStep),
    Omnidirectional(OmnidirectionalStep),
    /// From the belief about the start, whatever pose a particle had: mean, and a factor of the
    /// covariance.
    Start(Vector3<f64>, Matrix3<f64>),
}

impl Step {
    pub(super) fn new(path: &DrivenPath, settings: &MotionSettings) -> Result<Self> {
        let (from, to) = (path.start(), path.end());
        Ok(match settings {
            MotionSettings::Path(noise) => Step::Path(NoisyStep::new(path, noise)),
            MotionSettings::Differential(noise) => {
                Step::Differential(DifferentialStep::between(from, to, noise)?)
            }
            MotionSettings::Omnidirectional(noise) => {
                Step::Omnidirectional(OmnidirectionalStep::between(from, to, noise)?)
            }
        })
    }

    /// The way from the start belief to the first scan; its covariance was checked at the start.
    pub(super) fn from_start(path: &DrivenPath, belief: &Gaussian<3>, noise: &PathNoise) -> Self {
        let belief = noise.belief_after(path, belief);
        Step::Start(belief.mean, belief.factor())
    }
}

impl Motion for Step {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        let one_by_one = |pose, rng: &mut ChaCha8Rng| {
            self.moved(pose, std::array::from_fn(|_| StandardNormal.sample(rng)))
        };
        match self {
            Step::Path(step) => step.sample(poses, rng),
            Step::Differential(step) => step.sample(poses, rng),
            Step::Omnidirectional(step) => step.sample(poses, rng),
            Step::Start(..) => one_by_one.sample(poses, rng),
        }
    }
}

impl Transport for Step {
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        match self {
            Step::Path(step) => step.moved(pose, noise),
            Step::Differential(step) => step.moved(pose, noise),
            Step::Omnidirectional(step) => step.moved(pose, noise),
            Step::Start(mean, factor) => {
                let [a, b, c, _] = noise;
                Pose2::from_vector(&(mean + factor * Vector3::new(a, b, c)))
            }
        }
    }
}
