//! The correction: every particle takes the observations in, and good particles have children.

use super::FastSlam;
use super::look::Place;
use super::particle::{Knowledge, Report};
use crate::Result;
use crate::log_weights::{Mass, divide};
use loc_core::Pose2;
use loc_filters::association::AssociationSettings;
use loc_filters::slam::{Identities, SlamOutcome};
use loc_sensors::landmark_camera::LandmarkObservation;

/// Particles that one thread takes at a time.
const TOGETHER: usize = 8;

impl FastSlam {
    /// Corrects with all observations of one moment, any number of them, and says what became of each
    /// in the eyes of the particle that they suit best.
    ///
    /// LandmarkObservations are taken in groups of [`AssociationSettings::GROUP`]; the poses are drawn with
    /// the first group, and the others weigh them.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for an observation that is not finite or has a negative range:
    /// none is then used. [`loc_filters::Error::LostPositivity`], with the step: the filter cannot
    /// go on.
    pub fn correct(&mut self, observations: &[LandmarkObservation]) -> Result<Vec<SlamOutcome>> {
        Ok(self.take_in(observations)?)
    }

    pub(super) fn take_in(
        &mut self,
        observations: &[LandmarkObservation],
    ) -> loc_filters::Result<Vec<SlamOutcome>> {
        for observation in observations {
            observation.sight.check()?;
        }
        if observations.is_empty() {
            return Ok(Vec::new());
        }
        self.moment += 1;
        self.step += 1;
        let mut outcomes = Vec::with_capacity(observations.len());
        for group in observations.chunks(AssociationSettings::GROUP) {
            self.register(group);
            outcomes.extend(self.take_in_group(group)?);
        }
        self.tidy();
        self.resample();
        Ok(outcomes)
    }

    /// Widens the view by what is seen, and gives slots to new numbers.
    fn register(&mut self, group: &[LandmarkObservation]) {
        for seen in group {
            // Distance and direction do not depend on where the robot is.
            let Some(place) = Place::new(&self.settings, Pose2::IDENTITY, seen.sight) else {
                continue;
            };
            self.view.include(&place);
            let slot = self.numbers.len();
            let numbered = self.settings.identities == Identities::Known;
            if numbered && slot < self.settings.map.max_landmarks {
                self.numbers.entry(seen.landmark).or_insert(slot);
            }
        }
    }

    fn take_in_group(
        &mut self,
        group: &[LandmarkObservation],
    ) -> loc_filters::Result<Vec<SlamOutcome>> {
        let normals = self.normals();
        let mut particles = std::mem::take(&mut self.particles);
        let parts = particles.chunks_mut(TOGETHER).zip(normals.chunks(TOGETHER));
        let knowledge = self.knowledge();
        let reports = self.workers.map(parts, |(particles, normals)| {
            let both = particles.iter_mut().zip(normals);
            both.map(|(particle, normals)| particle.take_in(&knowledge, group, normals)).collect()
        });
        self.particles = particles;
        let reports: Vec<Report> =
            reports.into_iter().flat_map(|part: Vec<_>| part).collect::<Result<_, _>>()?;
        for (weight, report) in self.log_weights.iter_mut().zip(&reports) {
            *weight += report.log_likelihood;
        }
        self.weigh();
        Ok(reports.into_iter().nth(self.best).map(|report| report.outcomes).unwrap_or_default())
    }

    fn knowledge(&self) -> Knowledge<'_> {
        Knowledge {
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

    /// Makes the weights add up to 1; weights that say nothing become equal. The best particle is
    /// the first of those with the largest.
    fn weigh(&mut self) {
        match Mass::of(&self.log_weights).log_sum() {
            Some(sum) => divide(&mut self.log_weights, sum),
            None => self.log_weights.fill(-(self.particles.len() as f64).ln()),
        }
        let weights = self.log_weights.iter().enumerate();
        let largest = weights.rev().max_by(|a, b| a.1.total_cmp(b.1));
        self.best = largest.map_or(0, |(index, _)| index);
    }

    /// Without numbers, a landmark may be one that was never there.
    fn tidy(&mut self) {
        if self.settings.identities == Identities::Unknown {
            let mut particles = std::mem::take(&mut self.particles);
            let knowledge = self.knowledge();
            let missed: Vec<Vec<f64>> =
                self.workers.map(particles.chunks_mut(TOGETHER), |particles| {
                    particles.iter_mut().map(|particle| particle.tidy(&knowledge)).collect()
                });
            self.particles = particles;
            for (weight, missed) in self.log_weights.iter_mut().zip(missed.iter().flatten()) {
                *weight += missed;
            }
            self.weigh();
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
        // The best one has the largest share, but a roulette may pass it over.
        let best = parents.clone().position(|parent| parent == self.best);
        let children = parents.filter_map(|parent| self.particles.get(parent).cloned());
        self.particles = children.collect();
        self.log_weights.fill(-(count as f64).ln());
        self.best = best.unwrap_or(0);
    }
}
