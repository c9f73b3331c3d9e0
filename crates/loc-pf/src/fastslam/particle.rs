//! One particle: a way that the robot may have come, with the map that goes with it.

use super::FastSlamSettings;
use super::landmark_map::{Mark, MarkMap};
use super::observation::{Look, Place, View};
use loc_core::{Gaussian, Pose2, angle};
use loc_filters::association::{Associator, PairInnovation, Pairing};
use loc_filters::localizer::{Decision, Outcome};
use loc_filters::slam::Identities;
use loc_filters::{Gate, Result};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix2, Matrix3, Vector3};
use std::collections::BTreeMap;

/// What an observation is until something better is known of it.
const UNDETERMINED: Outcome = Outcome::of(Decision::Undetermined);

/// A pose with what odometry leaves open since it was drawn last, and a map.
#[derive(Debug, Clone)]
pub(super) struct Particle {
    pub(super) belief: Gaussian<3>,
    pub(super) map: MarkMap,
    /// The number that the next landmark gets, where they have none of their own.
    pub(super) next_number: u32,
}

/// What all particles share at one moment.
pub(super) struct Knowledge<'a> {
    pub(super) settings: &'a FastSlamSettings,
    pub(super) gate: Gate,
    pub(super) new_landmark_gate: f64,
    pub(super) associator: &'a Associator,
    pub(super) view: View,
    /// Slot of each number that is read off landmarks.
    pub(super) numbers: &'a BTreeMap<u32, usize>,
    /// Counts the calls with observations.
    pub(super) moment: u64,
    /// Counts motions and corrections, for errors.
    pub(super) step: u64,
}

/// What a particle made of the observations of a moment.
#[derive(Debug, Default)]
pub(super) struct Report {
    pub(super) log_likelihood: f64,
    pub(super) outcomes: Vec<Outcome>,
}

/// What an observation turned out to be, before the pose is drawn.
#[derive(Debug, Clone, Copy)]
enum Fate {
    /// Of the landmark in this slot.
    Of(usize),
    New,
    Nothing,
}

impl Particle {
    pub(super) fn new(start: Gaussian<3>) -> Self {
        Particle { belief: start, map: MarkMap::default(), next_number: 0 }
    }

    pub(super) fn pose(&self) -> Pose2 {
        Pose2::from_vector(&self.belief.mean)
    }

    /// Takes in a group of observations: finds their landmarks, draws a pose that suits both odometry
    /// and observations, and corrects each landmark from there.
    // ANCHOR: take-in
    pub(super) fn take_in(
        &mut self,
        knowledge: &Knowledge<'_>,
        group: &[LandmarkObservation],
        normals: &Vector3<f64>,
    ) -> Result<Report> {
        let mut report = Report { log_likelihood: 0.0, outcomes: vec![UNDETERMINED; group.len()] };
        let fates = self.recognize(knowledge, group, &mut report)?;
        for ((fate, seen), outcome) in fates.iter().zip(group).zip(&mut report.outcomes) {
            if let Fate::Of(slot) = fate {
                *outcome = self.propose(knowledge, *slot, seen, &mut report.log_likelihood)?;
            }
        }
        self.draw(normals);
        for ((fate, seen), outcome) in fates.iter().zip(group).zip(&mut report.outcomes) {
            match fate {
                Fate::Of(slot) => self.learn(knowledge, *slot, seen, outcome.accepted())?,
                Fate::New => *outcome = self.welcome(knowledge, seen)?,
                Fate::Nothing => {}
            }
        }
        Ok(report)
    }
    // ANCHOR_END: take-in

    fn recognize(
        &self,
        knowledge: &Knowledge<'_>,
        group: &[LandmarkObservation],
        report: &mut Report,
    ) -> Result<Vec<Fate>> {
        if knowledge.settings.identities == Identities::Known {
            let fate = |seen: &LandmarkObservation| {
                let slot = knowledge.numbers.get(&seen.landmark);
                slot.filter(|slot| self.map.get(**slot).is_some())
                    .map_or(Fate::New, |&s| Fate::Of(s))
            };
            return Ok(group.iter().map(fate).collect());
        }
        let place =
            |seen: &LandmarkObservation| Place::new(knowledge.settings, self.pose(), seen.sight);
        let places: Vec<Option<Place>> = group.iter().map(place).collect();
        let placed: Vec<Place> = places.iter().flatten().copied().collect();
        let pairs = Pairs::new(knowledge, self, &placed);
        let association = knowledge.associator.associate(&pairs)?;
        let mut fates = vec![Fate::Nothing; group.len()];
        let indices = (0..group.len()).filter(|&k| places[k].is_some());
        for (observation, k) in indices.enumerate() {
            let nis = association.nearest[observation];
            fates[k] = match association.partners[observation] {
                Some(landmark) => Fate::Of(pairs.slot(landmark)),
                None if nis > knowledge.new_landmark_gate => Fate::New,
                None => {
                    report.outcomes[k] = Outcome::of(Decision::Ambiguous).with_nis(nis);
                    Fate::Nothing
                }
            };
            if !matches!(fates[k], Fate::Of(_)) {
                // It was seen, and this particle knows of nothing there.
                let density = knowledge.view.density(placed[observation].range);
                report.log_likelihood += (knowledge.settings.new_share * density).ln();
            }
        }
        Ok(fates)
    }

    /// Takes an observation into the distribution that the pose will be drawn from, which is what sets
    /// FastSLAM 2.0 apart: `K = P G_s^T L^-1`, `L = G_s P G_s^T + G_m S G_m^T + R`.
    // ANCHOR: propose
    fn propose(
        &mut self,
        knowledge: &Knowledge<'_>,
        slot: usize,
        seen: &LandmarkObservation,
        log_likelihood: &mut f64,
    ) -> Result<Outcome> {
        let Some(mark) = self.map.get(slot) else { return Ok(UNDETERMINED) };
        let look =
            Look::new(knowledge.settings, &self.belief.mean, &mark.position.mean, seen.sight);
        let (id, p) = (mark.id, self.belief.covariance);
        let without_robot = look.apart_from_robot(&mark.position.covariance);
        let covariance = look.by_robot * p * look.by_robot.transpose() + without_robot;
        let judged = look.judge(covariance, &knowledge.gate, knowledge.step)?;
        *log_likelihood += judged.log_likelihood;
        if let Some(gain) =
            look.gain(&self.belief, &covariance).filter(|_| judged.outcome.accepted())
        {
            self.belief.mean += gain * look.residual;
            let rest = Matrix3::identity() - gain * look.by_robot;
            let corrected = rest * p * rest.transpose() + gain * without_robot * gain.transpose();
            self.belief.covariance = 0.5 * (corrected + corrected.transpose());
        }
        Ok(judged.outcome.with_landmark(id))
    }
    // ANCHOR_END: propose

    /// Draws the pose; from now on the particle takes it for certain.
    pub(super) fn draw(&mut self, normals: &Vector3<f64>) {
        let mut mean = self.belief.mean + self.belief.factor() * normals;
        mean.z = angle::wrap(mean.z);
        self.belief = Gaussian::certain(mean);
    }

    /// Corrects a landmark from the pose that was drawn.
    fn learn(
        &mut self,
        knowledge: &Knowledge<'_>,
        slot: usize,
        seen: &LandmarkObservation,
        accepted: bool,
    ) -> Result<()> {
        let pose = self.belief.mean;
        let Some(mark) = self.map.get_mut(slot) else { return Ok(()) };
        if accepted {
            let look = Look::new(knowledge.settings, &pose, &mark.position.mean, seen.sight);
            let covariance = look.apart_from_robot(&mark.position.covariance);
            look.judge(covariance, &Gate::OPEN, knowledge.step)?;
            mark.correct(&look, &covariance);
            mark.praise(knowledge.moment, &knowledge.settings.map);
        } else {
            mark.blame(knowledge.settings.map.contradiction_cost);
            if mark.is_false() {
                self.map.remove(slot);
            }
        }
        Ok(())
    }

    /// An observation of something that was not in the map when its group began.
    fn welcome(
        &mut self,
        knowledge: &Knowledge<'_>,
        seen: &LandmarkObservation,
    ) -> Result<Outcome> {
        let settings = knowledge.settings;
        let Some(place) = Place::new(settings, self.pose(), seen.sight) else {
            return Ok(UNDETERMINED);
        };
        let full = Outcome::of(Decision::MapFull);
        if settings.identities == Identities::Unknown {
            if self.map.len() >= settings.map.max_landmarks {
                return Ok(full);
            }
            let id = self.next_number;
            self.next_number = id.wrapping_add(1);
            self.map.push(Mark::born(id, &place, knowledge.moment, &settings.map));
            return Ok(Outcome::of(Decision::NewLandmark).with_landmark(id));
        }
        let id = seen.landmark;
        let Some(&slot) = knowledge.numbers.get(&id) else { return Ok(full) };
        if self.map.get(slot).is_some() {
            // It was born a moment ago, by another observation of the same group.
            let mut unused = 0.0;
            let outcome = self.propose(knowledge, slot, seen, &mut unused)?;
            self.learn(knowledge, slot, seen, outcome.accepted())?;
            return Ok(outcome);
        }
        self.map.put(slot, Mark::born(id, &place, knowledge.moment, &settings.map));
        Ok(Outcome::of(Decision::NewLandmark).with_landmark(id))
    }

    /// Blames landmarks that should have been seen at this moment and were not, and removes those
    /// that no longer have anything to speak for them.
    /// Returns the logarithm of how likely it is that they were not.
    pub(super) fn tidy(&mut self, knowledge: &Knowledge<'_>) -> f64 {
        let mut log_likelihood = 0.0;
        let map = &knowledge.settings.map;
        let back = (self.pose() * knowledge.settings.mounting).inverse();
        let mut blamed = Vec::new();
        self.map.visit(&mut |slot, mark| {
            let from_camera = back.transform(&mark.position.mean.into());
            let missed =
                mark.seen_at != knowledge.moment && knowledge.view.should_see(&from_camera);
            let forgotten = !mark.confirmed && knowledge.view.has_left(&from_camera);
            if forgotten {
                blamed.push((slot, f64::INFINITY));
            } else if missed {
                blamed.push((slot, map.miss_cost));
                log_likelihood +=
                    if mark.confirmed { knowledge.settings.miss_share.ln() } else { 0.0 };
            }
        });
        for (slot, cost) in blamed {
            let Some(mark) = self.map.get_mut(slot) else { continue };
            mark.blame(cost);
            if mark.is_false() {
                self.map.remove(slot);
            }
        }
        self.map.tighten();
        log_likelihood
    }
}

// LandmarkObservations without numbers, held against the landmarks of one particle.

/// Distance and direction are curved coordinates; a bound on a distance must hold in them too.
const SLACK: f64 = 2.0;

/// The looks of all pairs that are not out of the question.
pub(super) struct Pairs {
    /// The landmarks that are near any of the observations.
    slots: Vec<usize>,
    robot: Matrix3<f64>,
    /// For each observation its density, were it of something new.
    elsewhere: Vec<f64>,
    /// For each observation and each of the landmarks the look and the residual's covariance.
    looks: Vec<Option<(Look, Matrix2<f64>)>>,
}

impl Pairs {
    pub(super) fn new(knowledge: &Knowledge<'_>, particle: &Particle, places: &[Place]) -> Self {
        let near = |place: &Place, mark: &Matrix2<f64>| {
            // The variance of a difference is at most twice the sum of both.
            let p = &particle.belief.covariance;
            let robot = p.m11 + p.m22 + place.range.powi(2) * p.m33;
            let variance = robot + place.position.covariance.trace() + mark.trace();
            SLACK * knowledge.new_landmark_gate * 2.0 * variance
        };
        let (mut slots, mut marks) = (Vec::new(), Vec::new());
        particle.map.visit(&mut |slot, mark| {
            let fits = |place: &Place| {
                let squared = (place.position.mean - mark.position.mean).norm_squared();
                squared <= near(place, &mark.position.covariance)
            };
            if places.iter().any(fits) {
                slots.push(slot);
                marks.push(mark.position);
            }
        });
        let looks = places.iter().flat_map(|place| {
            let sight = Observed::RangeBearing { range: place.range, bearing: place.bearing };
            let marks = marks.iter();
            marks.map(move |mark| {
                let squared = (place.position.mean - mark.mean).norm_squared();
                if squared > near(place, &mark.covariance) {
                    return None;
                }
                let pose = &particle.belief.mean;
                let look = Look::new(knowledge.settings, pose, &mark.mean, sight);
                let of_robot =
                    look.by_robot * particle.belief.covariance * look.by_robot.transpose();
                Some((look, look.apart_from_robot(&mark.covariance) + of_robot))
            })
        });
        let density =
            |place: &Place| knowledge.settings.new_share * knowledge.view.density(place.range);
        Pairs {
            looks: looks.collect(),
            slots,
            robot: particle.belief.covariance,
            elsewhere: places.iter().map(density).collect(),
        }
    }

    /// The slot of the k-th landmark.
    pub(super) fn slot(&self, landmark: usize) -> usize {
        self.slots[landmark]
    }

    fn look(&self, (observation, landmark): (usize, usize)) -> Option<&(Look, Matrix2<f64>)> {
        self.looks.get(observation * self.slots.len() + landmark)?.as_ref()
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
        let (look, covariance) = self.look((observation, landmark))?;
        Some(PairInnovation { residual: look.residual, covariance: *covariance })
    }

    fn elsewhere(&self, observation: usize) -> f64 {
        self.elsewhere[observation]
    }

    /// What is left open of the robot's pose since the last time it was drawn.
    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        match (self.look(a), self.look(b)) {
            (Some((a, _)), Some((b, _))) => a.by_robot * self.robot * b.by_robot.transpose(),
            _ => Matrix2::zeros(),
        }
    }
}
