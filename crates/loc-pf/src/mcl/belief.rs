//! The belief: the particles, with prediction, correction, resampling and injection.

use super::recovery::Spread;
use super::scan::PreparedMap;
use super::{MclSettings, UpdateReport};
use crate::filter::Weighing;
use crate::motion::{DrivenPath, PathNoise};
use crate::recovery::{AugmentedMcl, Suspicion, UsualEvidence};
use crate::tempering::{Tempering, TemperingReport};
use crate::{
    Kld, Likelihood, Motion, ParticleFilter, Particles, PosesMut, ResamplePolicy, Resampling,
    Result, Transport, Workers,
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
    tempering: Option<Tempering>,
    /// For particles around the candidates of a search.
    pub(super) search_tempering: Tempering,
    pub(super) suspicion: Option<Suspicion>,
    pub(super) augmented: Option<AugmentedMcl>,
    /// Whether there was a scan since the start, and whether that was over the whole map.
    pub(super) has_seen: bool,
    pub(super) is_anywhere: bool,
    pub(super) updates_since_resampling: usize,
    /// Whether the particles were several clusters after the last update.
    pub(super) is_divided: bool,
}

impl Belief {
    pub(super) fn new(
        settings: &MclSettings,
        field: &LikelihoodFieldSettings,
        area: f64,
        rng: ChaCha8Rng,
    ) -> Result<Self> {
        let workers = Workers::new(settings.threads)?;
        let usual = usual_evidence(field);
        let suspicion = settings.recovery.suspicion;
        Ok(Belief {
            filter: ParticleFilter::new(Particles::new(), rng).with_workers(workers),
            max_particles: settings.particles.max_particles,
            kld: Kld::new(settings.particles.clone())?,
            resampling: settings.resampling,
            policy: settings.policy,
            tempering: settings.tempering.map(Tempering::new).transpose()?,
            search_tempering: Tempering::default(),
            suspicion: suspicion.map(|s| Suspicion::new(s, usual, area)).transpose()?,
            augmented: settings.recovery.augmented.map(AugmentedMcl::new).transpose()?,
            has_seen: false,
            is_anywhere: true,
            updates_since_resampling: 0,
            is_divided: false,
        })
    }

    /// Whether the particles are spread over the whole map and there was no scan yet.
    pub(super) fn awaits_first_scan(&self) -> bool {
        self.is_anywhere && !self.has_seen
    }

    /// Moves the particles by a step and weights them by scans.
    pub(super) fn update(
        &mut self,
        step: &Step<impl Motion + Transport>,
        scan: &impl Likelihood,
        endpoints: &Endpoints,
        exponent: f64,
        map: &PreparedMap,
    ) -> UpdateReport {
        let is_first = self.awaits_first_scan();
        // A scan without usable beams is not seen: the first one with some is still the first.
        self.has_seen |= !endpoints.is_empty();
        let is_lost = is_first && self.has_seen;
        let found = if is_lost { self.search_map(map, scan, endpoints) } else { None };
        let (report, searched) = match found {
            Some(found) => {
                *self.filter.particles_mut() = found.particles;
                (TemperingReport { stages: 1, log_evidence: found.log_evidence }, true)
            }
            None => (self.track(step, scan), false),
        };
        if !is_lost {
            self.update_suspicion(report.log_evidence, exponent * endpoints.len() as f64);
            self.inject(report.log_evidence, map);
        }
        let TemperingReport { stages, log_evidence } = report;
        let effective_sample_size = self.filter.effective_sample_size();
        UpdateReport { stages, log_evidence, effective_sample_size, searched }
    }

    /// Samples the motion, weights, resamples: tempered, or in one stage.
    // ANCHOR: track
    fn track(
        &mut self,
        step: &Step<impl Motion + Transport>,
        scan: &impl Likelihood,
    ) -> TemperingReport {
        if self.tempering.is_none() {
            self.filter.predict(step);
            let Weighing { log_evidence, effective_sample_size } = self.filter.correct(scan);
            self.updates_since_resampling += 1;
            let (updates, count) = (self.updates_since_resampling, self.filter.particles().len());
            if self.policy.is_due(updates, effective_sample_size, count) {
                self.filter.resample_adaptively(self.resampling, &mut self.kld);
                self.updates_since_resampling = 0;
            }
            return TemperingReport { stages: 1, log_evidence };
        }
        let count = self.count_needed();
        let tempering = self.tempering.get_or_insert_default();
        let report = tempering.update(&mut self.filter, step, scan, count);
        self.shrink(count);
        report
    }
    // ANCHOR_END: track

    /// Updates the probability that the robot is elsewhere.
    fn update_suspicion(&mut self, log_evidence: f64, beams: f64) {
        if let Some(suspicion) = &mut self.suspicion {
            suspicion.update(log_evidence, beams);
        }
    }

    /// Moves and weights the present particles, which a search has found.
    pub(super) fn track_alternative(
        &mut self,
        step: &Step<impl Motion + Transport>,
        scan: &impl Likelihood,
    ) {
        let count = self.count_needed();
        self.search_tempering.update(&mut self.filter, step, scan, count);
        self.shrink(count);
    }

    /// How many particles the belief needs; as many as allowed for one with several clusters, whose
    /// shares change by chance the more the fewer there are.
    fn count_needed(&mut self) -> usize {
        if self.is_divided { self.max_particles } else { self.filter.count_needed(&mut self.kld) }
    }

    /// Draws fewer particles where there are far more than needed, for instance after a search.
    pub(super) fn shrink(&mut self, count: usize) {
        if self.filter.particles().len() > 2 * count {
            self.filter.resample(self.resampling, count);
        }
    }

    /// Replaces the share of particles that augmented MCL requires by random ones.
    fn inject(&mut self, log_evidence: f64, map: &PreparedMap) {
        let Some(augmented) = &mut self.augmented else { return };
        let share = augmented.update(log_evidence);
        let count = (share * self.filter.particles().len() as f64).round() as usize;
        let random: Vec<_> =
            (0..count).map(|_| map.free_space.draw(self.filter.rng_mut())).collect();
        self.filter.particles_mut().replace_evenly(&random);
    }
}

/// Log-likelihood of a beam at the true pose: three of four beams end on obstacles of the map, and
/// at least half of them.
fn usual_evidence(field: &LikelihoodFieldSettings) -> UsualEvidence {
    // The mean of -d^2 / (2 sigma^2) over the hits is -1/2.
    let hit = field.likelihood(0.0).ln() - 0.5;
    let miss = field.likelihood(f64::INFINITY).ln();
    let mixed = |share: f64| share * hit + (1.0 - share) * miss;
    UsualEvidence { expected: mixed(0.75), min: mixed(0.5) }
}

/// The motion since the last update.
#[derive(Debug)]
pub(super) enum Step<T> {
    /// By the motion model.
    Model(T),
    /// From the initial pose distribution, independent of the pose of a particle: mean, and a
    /// factor of the covariance.
    Start(Vector3<f64>, Matrix3<f64>),
    /// By chance, in any direction.
    Spread(Spread),
}

impl<T> Step<T> {
    /// The motion from the initial pose distribution to the first scan; its covariance was checked
    /// at the start.
    pub(super) fn from_start(path: &DrivenPath, belief: &Gaussian<3>, noise: &PathNoise) -> Self {
        let belief = noise.belief_after(path, belief);
        Step::Start(belief.mean, belief.factor())
    }
}

impl<T: Motion + Transport> Motion for Step<T> {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        let one_by_one = |pose, rng: &mut ChaCha8Rng| {
            self.moved(pose, std::array::from_fn(|_| StandardNormal.sample(rng)))
        };
        match self {
            Step::Model(step) => step.sample(poses, rng),
            Step::Start(..) | Step::Spread(_) => one_by_one.sample(poses, rng),
        }
    }
}

impl<T: Transport> Transport for Step<T> {
    #[inline]
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        match self {
            Step::Model(step) => step.moved(pose, noise),
            Step::Spread(spread) => spread.moved(pose, noise),
            Step::Start(mean, factor) => {
                let [a, b, c, _] = noise;
                Pose2::from_vector(&(mean + factor * Vector3::new(a, b, c)))
            }
        }
    }
}
