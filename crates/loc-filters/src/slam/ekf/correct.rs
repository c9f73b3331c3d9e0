//! The correction: observations find their landmarks, and all of them correct the state together.

use super::common::{HEADING, NUMBERS};
use super::look::Place;
use super::pairs::Pairs;
use super::{EkfSlam, Identities, Jacobians, SlamOutcome, SlamVerdict};
use crate::Result;
use crate::association::AssociationSettings;
use crate::slam::state::Row;
use loc_core::angle;
use loc_sensors::landmark_camera::LandmarkObservation;

/// What an observation is until something better is known of it.
const UNPLACEABLE: SlamOutcome = SlamOutcome { landmark: None, verdict: SlamVerdict::Unplaceable };

impl EkfSlam {
    /// Corrects with all observations of one moment, any number of them, and says what became of each.
    ///
    /// LandmarkObservations are taken in groups of [`AssociationSettings::GROUP`]. Those of one group are
    /// linearised at the same state, gated one by one, and those believed correct the state in one
    /// pass over the covariance. Numbered observations of landmarks that are not in the state yet,
    /// and others that fit none, put new ones into it after that.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for an observation that is not finite or has a negative range:
    /// none is then used. [`crate::Error::LostPositivity`], with the step: the filter cannot go on.
    pub fn correct(&mut self, observations: &[LandmarkObservation]) -> Result<Vec<SlamOutcome>> {
        for observation in observations {
            observation.sight.check()?;
        }
        let mut outcomes = Vec::with_capacity(observations.len());
        let mut budget = self.settings.association.search_limit;
        for group in observations.chunks(AssociationSettings::GROUP) {
            self.refocus(group)?;
            match self.settings.identities {
                Identities::Known => self.correct_numbered(group, &mut outcomes)?,
                Identities::Unknown => {
                    self.correct_unnumbered(group, &mut budget, &mut outcomes)?;
                }
            }
        }
        if self.settings.identities == Identities::Unknown && !observations.is_empty() {
            let mut seen = vec![false; self.entries.len()];
            for id in outcomes.iter().filter_map(|outcome| outcome.landmark) {
                self.numbers.get(&id).into_iter().for_each(|&landmark| seen[landmark] = true);
            }
            self.tidy(&seen)?;
            self.merge(&mut outcomes)?;
        }
        Ok(outcomes)
    }

    fn correct_numbered(
        &mut self,
        group: &[LandmarkObservation],
        outcomes: &mut Vec<SlamOutcome>,
    ) -> Result<()> {
        let first = outcomes.len();
        let mut rows = Vec::with_capacity(2 * group.len());
        let mut new = Vec::new();
        for (k, observation) in group.iter().enumerate() {
            outcomes.push(match self.numbers.get(&observation.landmark) {
                Some(&landmark) => {
                    self.judge(landmark, observation.sight, &self.gate, &mut rows)?
                }
                None => {
                    new.push(k);
                    UNPLACEABLE
                }
            });
        }
        self.apply(&rows)?;
        for outcome in &outcomes[first..] {
            if let Some(id) = outcome.landmark {
                self.credit(id, outcome.accepted());
            }
        }
        for k in new {
            outcomes[first + k] = self.welcome(&group[k])?;
        }
        self.remove_false()
    }

    /// An observation of a number that the state did not have when its group began.
    fn welcome(&mut self, observation: &LandmarkObservation) -> Result<SlamOutcome> {
        let id = observation.landmark;
        let Some(&landmark) = self.numbers.get(&id) else {
            return match self.place(observation) {
                Some(place) => self.enter(id, &place),
                None => Ok(UNPLACEABLE),
            };
        };
        // It was born a moment ago, by another observation of the same group.
        let mut rows = Vec::with_capacity(2);
        let outcome = self.judge(landmark, observation.sight, &self.gate, &mut rows)?;
        self.apply(&rows)?;
        self.credit(id, outcome.accepted());
        Ok(outcome)
    }

    fn correct_unnumbered(
        &mut self,
        group: &[LandmarkObservation],
        budget: &mut usize,
        outcomes: &mut Vec<SlamOutcome>,
    ) -> Result<()> {
        let places: Vec<Option<Place>> = group.iter().map(|seen| self.place(seen)).collect();
        let placed: Vec<Place> = places.iter().flatten().copied().collect();
        placed.iter().for_each(|place| self.reach.include(place));
        let pairs = Pairs::new(self, &placed);
        let association = self.associator.associate_within(&pairs, budget);
        let association = association.map_err(|error| self.state.robot_state().blamed(error))?;
        let telling: Vec<bool> = (0..placed.len()).map(|k| pairs.is_telling(k)).collect();
        let mut rows = Vec::with_capacity(2 * placed.len());
        let mut found = vec![UNPLACEABLE; group.len()];
        let mut new = Vec::new();
        let mut taken: Vec<usize> = association.partners.iter().flatten().copied().collect();
        taken.sort_unstable();
        let placed = (0..group.len()).filter(|&k| places[k].is_some());
        for (observation, k) in placed.enumerate() {
            // Of one moment a landmark has one observation: what stands beside one that was seen is new.
            let nis = pairs.nearest_free(observation, &taken);
            match association.partners[observation] {
                Some(landmark) => {
                    found[k] = self.judge(landmark, group[k].sight, &self.gate, &mut rows)?;
                }
                None if nis > self.new_landmark_gate || !telling[observation] => new.push(k),
                None => found[k].verdict = SlamVerdict::Ambiguous(nis),
            }
        }
        self.apply(&rows)?;
        for outcome in &found {
            if let Some(id) = outcome.landmark {
                self.credit(id, outcome.accepted());
            }
        }
        let known = self.entries.len();
        for k in new {
            found[k] = self.welcome_unnumbered(
                &group[k],
                taken.iter().copied().chain(known..self.entries.len()),
            )?;
        }
        outcomes.extend(found);
        Ok(())
    }

    /// An observation that fits none of the landmarks but, perhaps, those that others of its group were
    /// of or gave birth to: something new stands apart from these too.
    fn welcome_unnumbered(
        &mut self,
        observation: &LandmarkObservation,
        beside: impl Iterator<Item = usize>,
    ) -> Result<SlamOutcome> {
        // From the corrected pose.
        let Some(place) = self.place(observation) else { return Ok(UNPLACEABLE) };
        let mut nearest = f64::INFINITY;
        for landmark in beside {
            let outcome = self.judge(landmark, observation.sight, &self.gate, &mut Vec::new())?;
            nearest = nearest.min(outcome.nis().unwrap_or(f64::INFINITY));
        }
        if nearest <= self.distinct_gate {
            return Ok(SlamOutcome { landmark: None, verdict: SlamVerdict::Ambiguous(nearest) });
        }
        self.enter(self.next_number, &place)
    }

    /// Puts a new landmark into the state, if there is room.
    fn enter(&mut self, id: u32, place: &Place) -> Result<SlamOutcome> {
        if self.entries.len() >= self.settings.map.max_landmarks {
            return Ok(SlamOutcome { landmark: None, verdict: SlamVerdict::MapFull });
        }
        self.give_birth(id, place)?;
        Ok(SlamOutcome { landmark: Some(id), verdict: SlamVerdict::Born })
    }

    fn credit(&mut self, id: u32, accepted: bool) {
        if let Some(&landmark) = self.numbers.get(&id) {
            if accepted {
                self.praise(landmark);
            } else {
                self.blame(landmark, self.settings.map.contradiction_cost);
            }
        }
    }

    pub(super) fn apply(&mut self, rows: &[Row<NUMBERS>]) -> Result<()> {
        if !rows.is_empty() {
            let invariant = self.settings.jacobians == Jacobians::Invariant;
            self.state.correct(rows, invariant.then_some(HEADING))?;
            let robot = self.state.robot_mut();
            robot[HEADING] = angle::wrap(robot[HEADING]);
        }
        Ok(())
    }
}
