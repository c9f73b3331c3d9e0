//! One particle: a hypothesis of the path of the robot, with the map that belongs to it, and its
//! update by the observations of one time.

use super::FastSlamSettings;
use super::landmark_map::{LandmarkEstimate, ParticleMap};
use super::observation::{Linearized, Located, View};
use loc_core::{Gaussian, Pose2, angle};
use loc_filters::association::{Associator, PairInnovation, Pairing};
use loc_filters::localizer::{Decision, Outcome};
use loc_filters::slam::Identities;
use loc_filters::{Gate, Result};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix2, Matrix3, Vector3};
use std::collections::BTreeMap;

/// The outcome of an observation without a position.
const UNDETERMINED: Outcome = Outcome::of(Decision::Undetermined);

/// A pose, with its covariance by odometry since it was drawn last, and a map.
#[derive(Debug, Clone)]
pub(super) struct Particle {
    pub(super) belief: Gaussian<3>,
    pub(super) map: ParticleMap,
    /// The number that the next landmark gets, where they have none of their own.
    pub(super) next_number: u32,
}

/// Data shared by all particles during an update.
pub(super) struct Context<'a> {
    pub(super) settings: &'a FastSlamSettings,
    pub(super) gate: Gate,
    pub(super) new_landmark_gate: f64,
    pub(super) associator: &'a Associator,
    pub(super) view: View,
    /// Slot of each landmark number.
    pub(super) numbers: &'a BTreeMap<u32, usize>,
    /// Number of updates with observations.
    pub(super) moment: u64,
    /// Number of motions and corrections, for errors.
    pub(super) step: u64,
}

/// Result of an update.
#[derive(Debug, Default)]
pub(super) struct Report {
    pub(super) log_likelihood: f64,
    pub(super) outcomes: Vec<Outcome>,
}

/// Data association of an observation, before the pose is drawn.
#[derive(Debug, Clone, Copy)]
enum Association {
    /// The landmark in this slot.
    Existing(usize),
    /// A landmark that is not in the map.
    New,
    /// Ambiguous, or without a position.
    None,
}

impl Particle {
    pub(super) fn new(start: Gaussian<3>) -> Self {
        Particle { belief: start, map: ParticleMap::default(), next_number: 0 }
    }

    pub(super) fn pose(&self) -> Pose2 {
        Pose2::from_vector(&self.belief.mean)
    }

    /// Updates with a group of observations: associates them with landmarks, draws a pose from
    /// odometry and observations together, and corrects each landmark from that pose.
    // ANCHOR: update
    pub(super) fn update(
        &mut self,
        context: &Context<'_>,
        group: &[LandmarkObservation],
        normals: &Vector3<f64>,
    ) -> Result<Report> {
        let mut report = Report { log_likelihood: 0.0, outcomes: vec![UNDETERMINED; group.len()] };
        let associations = self.associate(context, group, &mut report)?;
        for ((association, seen), outcome) in
            associations.iter().zip(group).zip(&mut report.outcomes)
        {
            if let Association::Existing(slot) = association {
                *outcome = self.propose(context, *slot, seen, &mut report.log_likelihood)?;
            }
        }
        self.draw(normals);
        for ((association, seen), outcome) in
            associations.iter().zip(group).zip(&mut report.outcomes)
        {
            match association {
                Association::Existing(slot) => {
                    self.correct_landmark(context, *slot, seen, outcome.accepted())?;
                }
                Association::New => *outcome = self.initialize_landmark(context, seen)?,
                Association::None => {}
            }
        }
        Ok(report)
    }
    // ANCHOR_END: update

    fn associate(
        &self,
        context: &Context<'_>,
        group: &[LandmarkObservation],
        report: &mut Report,
    ) -> Result<Vec<Association>> {
        if context.settings.identities == Identities::Known {
            let association = |seen: &LandmarkObservation| {
                let slot = context.numbers.get(&seen.landmark);
                slot.filter(|slot| self.map.get(**slot).is_some())
                    .map_or(Association::New, |&s| Association::Existing(s))
            };
            return Ok(group.iter().map(association).collect());
        }
        let located =
            |seen: &LandmarkObservation| Located::new(context.settings, self.pose(), seen.observed);
        let located: Vec<Option<Located>> = group.iter().map(located).collect();
        let placed: Vec<Located> = located.iter().flatten().copied().collect();
        let pairs = Pairs::new(context, self, &placed);
        let association = context.associator.associate(&pairs)?;
        let mut associations = vec![Association::None; group.len()];
        let indices = (0..group.len()).filter(|&k| located[k].is_some());
        for (observation, k) in indices.enumerate() {
            let nis = association.nearest[observation];
            associations[k] = match association.partners[observation] {
                Some(landmark) => Association::Existing(pairs.slot(landmark)),
                None if nis > context.new_landmark_gate => Association::New,
                None => {
                    report.outcomes[k] = Outcome::of(Decision::Ambiguous).with_nis(nis);
                    Association::None
                }
            };
            if !matches!(associations[k], Association::Existing(_)) {
                // The likelihood of an observation of something that is not in the map.
                let density = context.view.density(placed[observation].range);
                report.log_likelihood += (context.settings.new_share * density).ln();
            }
        }
        Ok(associations)
    }

    /// Corrects the distribution that the pose is drawn from, the proposal of FastSLAM 2.0, by an
    /// observation: `K = P G_s^T L^-1`, `L = G_s P G_s^T + G_m S G_m^T + R`.
    // ANCHOR: propose
    fn propose(
        &mut self,
        context: &Context<'_>,
        slot: usize,
        seen: &LandmarkObservation,
        log_likelihood: &mut f64,
    ) -> Result<Outcome> {
        let Some(estimate) = self.map.get(slot) else { return Ok(UNDETERMINED) };
        let linearized = Linearized::new(
            context.settings,
            &self.belief.mean,
            &estimate.position.mean,
            seen.observed,
        );
        let (id, p) = (estimate.id, self.belief.covariance);
        let without_robot = linearized.covariance_without_robot(&estimate.position.covariance);
        let covariance = linearized.by_robot * p * linearized.by_robot.transpose() + without_robot;
        let scored = linearized.score_residual(covariance, &context.gate, context.step)?;
        *log_likelihood += scored.log_likelihood;
        if let Some(gain) =
            linearized.gain(&self.belief, &covariance).filter(|_| scored.outcome.accepted())
        {
            self.belief.mean += gain * linearized.residual;
            let rest = Matrix3::identity() - gain * linearized.by_robot;
            let corrected = rest * p * rest.transpose() + gain * without_robot * gain.transpose();
            self.belief.covariance = 0.5 * (corrected + corrected.transpose());
        }
        Ok(scored.outcome.with_landmark(id))
    }
    // ANCHOR_END: propose

    /// Draws the pose, which is then certain for this particle.
    pub(super) fn draw(&mut self, normals: &Vector3<f64>) {
        let mut mean = self.belief.mean + self.belief.factor() * normals;
        mean.z = angle::wrap(mean.z);
        self.belief = Gaussian::certain(mean);
    }

    /// Corrects a landmark from the pose that was drawn.
    fn correct_landmark(
        &mut self,
        context: &Context<'_>,
        slot: usize,
        seen: &LandmarkObservation,
        accepted: bool,
    ) -> Result<()> {
        let pose = self.belief.mean;
        let Some(estimate) = self.map.get_mut(slot) else { return Ok(()) };
        if accepted {
            let linearized =
                Linearized::new(context.settings, &pose, &estimate.position.mean, seen.observed);
            let covariance = linearized.covariance_without_robot(&estimate.position.covariance);
            linearized.score_residual(covariance, &Gate::OPEN, context.step)?;
            estimate.correct(&linearized, &covariance);
            estimate.support(context.moment, &context.settings.map);
        } else {
            estimate.penalize(context.settings.map.contradiction_cost);
            if estimate.is_false() {
                self.map.remove(slot);
            }
        }
        Ok(())
    }

    /// Initializes a landmark that was not in the map before this group of observations.
    fn initialize_landmark(
        &mut self,
        context: &Context<'_>,
        seen: &LandmarkObservation,
    ) -> Result<Outcome> {
        let settings = context.settings;
        let Some(located) = Located::new(settings, self.pose(), seen.observed) else {
            return Ok(UNDETERMINED);
        };
        let full = Outcome::of(Decision::MapFull);
        if settings.identities == Identities::Unknown {
            if self.map.len() >= settings.map.max_landmarks {
                return Ok(full);
            }
            let id = self.next_number;
            self.next_number = id.wrapping_add(1);
            self.map.push(LandmarkEstimate::new(id, &located, context.moment, &settings.map));
            return Ok(Outcome::of(Decision::NewLandmark).with_landmark(id));
        }
        let id = seen.landmark;
        let Some(&slot) = context.numbers.get(&id) else { return Ok(full) };
        if self.map.get(slot).is_some() {
            // It was initialized by another observation of the same group.
            let mut unused = 0.0;
            let outcome = self.propose(context, slot, seen, &mut unused)?;
            self.correct_landmark(context, slot, seen, outcome.accepted())?;
            return Ok(outcome);
        }
        self.map.put(slot, LandmarkEstimate::new(id, &located, context.moment, &settings.map));
        Ok(Outcome::of(Decision::NewLandmark).with_landmark(id))
    }

    /// Lowers the score of landmarks that should have been seen and were not, and removes those
    /// without score. Returns the log-likelihood of not seeing them.
    pub(super) fn prune(&mut self, context: &Context<'_>) -> f64 {
        let mut log_likelihood = 0.0;
        let map = &context.settings.map;
        let back = (self.pose() * context.settings.robot.mounting).inverse();
        let mut penalized = Vec::new();
        self.map.visit(&mut |slot, estimate| {
            let from_camera = back.transform(&estimate.position.mean.into());
            let missed =
                estimate.seen_at != context.moment && context.view.should_see(&from_camera);
            let expired = !estimate.confirmed && context.view.is_out_of_range(&from_camera);
            if expired {
                penalized.push((slot, f64::INFINITY));
            } else if missed {
                penalized.push((slot, map.miss_cost));
                log_likelihood +=
                    if estimate.confirmed { context.settings.miss_share.ln() } else { 0.0 };
            }
        });
        for (slot, cost) in penalized {
            let Some(estimate) = self.map.get_mut(slot) else { continue };
            estimate.penalize(cost);
            if estimate.is_false() {
                self.map.remove(slot);
            }
        }
        self.map.compact();
        log_likelihood
    }
}

/// Distance and direction are curved coordinates; a bound on a distance must hold in them too.
const SLACK: f64 = 2.0;

/// All plausible pairs of an observation without number and a landmark of the particle, linearized.
pub(super) struct Pairs {
    /// The landmarks that are near any of the observations.
    slots: Vec<usize>,
    robot: Matrix3<f64>,
    /// For each observation its density as one of a new landmark.
    elsewhere: Vec<f64>,
    /// For each observation and each of the landmarks the linearized observation and the covariance
    /// of its residual.
    linearized: Vec<Option<(Linearized, Matrix2<f64>)>>,
}

impl Pairs {
    pub(super) fn new(context: &Context<'_>, particle: &Particle, located: &[Located]) -> Self {
        let near = |located: &Located, estimate: &Matrix2<f64>| {
            // The variance of a difference is at most twice the sum of both.
            let p = &particle.belief.covariance;
            let robot = p.m11 + p.m22 + located.range.powi(2) * p.m33;
            let variance = robot + located.position.covariance.trace() + estimate.trace();
            SLACK * context.new_landmark_gate * 2.0 * variance
        };
        let (mut slots, mut near_landmarks) = (Vec::new(), Vec::new());
        particle.map.visit(&mut |slot, estimate| {
            let fits = |located: &Located| {
                let squared = (located.position.mean - estimate.position.mean).norm_squared();
                squared <= near(located, &estimate.position.covariance)
            };
            if located.iter().any(fits) {
                slots.push(slot);
                near_landmarks.push(estimate.position);
            }
        });
        let linearized = located.iter().flat_map(|located| {
            let observed =
                Observed::RangeBearing { range: located.range, bearing: located.bearing };
            let near_landmarks = near_landmarks.iter();
            near_landmarks.map(move |estimate| {
                let squared = (located.position.mean - estimate.mean).norm_squared();
                if squared > near(located, &estimate.covariance) {
                    return None;
                }
                let pose = &particle.belief.mean;
                let linearized = Linearized::new(context.settings, pose, &estimate.mean, observed);
                let of_robot = linearized.by_robot
                    * particle.belief.covariance
                    * linearized.by_robot.transpose();
                Some((
                    linearized,
                    linearized.covariance_without_robot(&estimate.covariance) + of_robot,
                ))
            })
        });
        let density =
            |located: &Located| context.settings.new_share * context.view.density(located.range);
        Pairs {
            linearized: linearized.collect(),
            slots,
            robot: particle.belief.covariance,
            elsewhere: located.iter().map(density).collect(),
        }
    }

    /// The slot of the k-th landmark.
    pub(super) fn slot(&self, landmark: usize) -> usize {
        self.slots[landmark]
    }

    fn linearized(
        &self,
        (observation, landmark): (usize, usize),
    ) -> Option<&(Linearized, Matrix2<f64>)> {
        self.linearized.get(observation * self.slots.len() + landmark)?.as_ref()
    }
}

impl Pairing<2> for Pairs {
    fn observations(&self) -> usize {
        self.elsewhere.len()
    }

    fn landmarks(&self) -> usize {
        self.slots.len()
    }

    fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<2>> {
        let (linearized, covariance) = self.linearized((observation, landmark))?;
        Some(PairInnovation { residual: linearized.residual, covariance: *covariance })
    }

    fn elsewhere(&self, observation: usize) -> f64 {
        self.elsewhere[observation]
    }

    /// By the covariance of the pose since it was drawn last.
    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        match (self.linearized(a), self.linearized(b)) {
            (Some((a, _)), Some((b, _))) => a.by_robot * self.robot * b.by_robot.transpose(),
            _ => Matrix2::zeros(),
        }
    }
}
