//! EKF-SLAM with heading, distance and direction (I2, I3), numbered landmarks or not (I4).

mod landmarks;
mod observation;
mod settings;

pub use settings::{
    Identities, Jacobians, MapLandmark, MapSettings, SlamOutcome, SlamSettings, SlamVerdict,
};

use super::state::{LargeState, MapState, Row};
use crate::association::{AssociationSettings, Associator};
use crate::{Gate, Result};
use landmarks::{Entry, Focus, Reach};
use loc_core::gaussian::check_covariance;
use loc_core::{Gaussian, Pose2, Twist2, angle};
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::{DMatrix, Matrix3, SMatrix, SVector};
use observation::{Pairs, Place};
use std::collections::BTreeMap;

/// Extended Kalman filter over the robot's pose (x, y, theta) \[m, m, rad\] and the positions of
/// all landmarks seen so far \[m\], in the frame of the start.
///
/// A landmark enters the state at its first observation, from the pose of that moment. All observations
/// of one moment correct the state together, so that the covariance is read and written once.
#[derive(Debug, Clone)]
pub struct EkfSlam {
    state: MapState<NUMBERS>,
    settings: SlamSettings,
    gate: Gate,
    new_landmark_gate: f64,
    distinct_gate: f64,
    associator: Associator,
    /// The one that finds landmarks which are in the map twice.
    merger: Associator,
    /// What is known of each landmark beside its position, in the order of the state.
    entries: Vec<Entry>,
    /// Index of each number.
    numbers: BTreeMap<u32, usize>,
    next_number: u32,
    /// The pose before the corrections of this moment: the first estimate of it.
    anchor: Pose2,
    reach: Reach,
    /// Whether a landmark has lost some of its score.
    doubted: bool,
    focus: Option<Focus>,
}

impl EkfSlam {
    /// A filter without landmarks, from a belief over (x, y, theta). The start may be certain:
    /// then it is the origin that the map is drawn from.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief or settings that are not valid.
    pub fn new(start: Gaussian<3>, settings: SlamSettings) -> Result<Self> {
        settings.check()?;
        let mut state = start(&start, &settings)?;
        state.robot_mut()[HEADING] = loc_core::angle::wrap(start.mean.z);
        Ok(EkfSlam {
            state: MapState::new(state),
            settings,
            gate: Gate::probability(settings.gate_probability)?,
            new_landmark_gate: settings.new_landmark_gate()?,
            distinct_gate: settings.distinct_gate()?,
            associator: Associator::new(settings.association)?,
            merger: Associator::new(settings.merging())?,
            entries: Vec::new(),
            numbers: BTreeMap::new(),
            next_number: 0,
            anchor: start.pose(),
            reach: Reach::default(),
            doubted: false,
            focus: None,
        })
    }

    /// The settings.
    pub fn settings(&self) -> &SlamSettings {
        &self.settings
    }

    /// Motions and corrections so far.
    pub fn step(&self) -> u64 {
        self.state.robot_state().step()
    }

    /// Drives on with velocity `twist` for `dt` \[s\]: `S' = F S F^T + F_u S_u F_u^T`, which
    /// touches the robot's rows only.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the velocity, [`loc_core::Error::OutOfRange`] for a negative time,
    /// [`crate::Error::LostPositivity`] where the covariance grows beyond all numbers.
    pub fn predict(&mut self, twist: Twist2, dt: f64) -> Result<()> {
        crate::innovation::finite("velocity", &twist.to_vector())?;
        loc_core::error::non_negative("time step [s]", dt)?;
        let SlamSettings { integration, motion_noise, .. } = self.settings;
        let pose = self.robot_pose();
        let (moved, jacobians) = integration.step_with_jacobians(pose, twist, dt);
        let (mut f, by_twist) = (jacobians.by_pose, jacobians.by_twist);
        if self.settings.jacobians == Jacobians::First {
            // From first estimate to first estimate, whatever was corrected between.
            f[(0, 2)] = -(moved.y - self.anchor.y);
            f[(1, 2)] = moved.x - self.anchor.x;
        }
        let noise = by_twist * motion_noise.covariance(twist, dt) * by_twist.transpose();
        let (moved_state, f, noise) = self.with_common_errors(moved, &f, &noise, dt);
        self.state.propagate(moved_state, &f, &noise)?;
        self.anchor = moved;
        Ok(())
    }

    /// What the filter believes about the robot's pose.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] for a covariance that is none, with the step.
    pub fn pose(&self) -> Result<Gaussian<3>> {
        let mean = self.state.robot().fixed_rows::<3>(0).into_owned();
        let covariance = self.state.robot_covariance().fixed_view::<3, 3>(0, 0).into_owned();
        check_covariance("covariance of the robot", &covariance)
            .map_err(|error| self.state.robot_state().blamed(error))?;
        Ok(Gaussian { mean, covariance })
    }

    /// Number of landmarks in the state, provisional ones included.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The landmarks in the order of the state.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] where the covariance of one is none.
    pub fn landmarks(&self) -> Result<Vec<MapLandmark>> {
        (0..self.entries.len()).map(|index| self.describe(index)).collect()
    }

    /// The landmark with a number.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] where its covariance is none.
    pub fn landmark(&self, id: u32) -> Result<Option<MapLandmark>> {
        self.numbers.get(&id).map(|&index| self.describe(index)).transpose()
    }

    fn describe(&self, index: usize) -> Result<MapLandmark> {
        let Entry { id, observations, confirmed, .. } = self.entries[index];
        let (position, covariance) = self.state.landmark(index);
        check_covariance("covariance of a landmark", &covariance)
            .map_err(|error| self.state.robot_state().blamed(error))?;
        let position = Gaussian { mean: position.coords, covariance };
        Ok(MapLandmark { id, position, observations, confirmed })
    }

    /// The whole covariance, (3 + 2 n) x (3 + 2 n): x, y, theta of the robot, then x, y of one
    /// landmark after the other. It is checked by a factorisation, which takes a third of the cube
    /// of its size in operations.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] for one that is not positive semi-definite, with the step.
    pub fn covariance(&self) -> Result<DMatrix<f64>> {
        let whole = self.state.checked_covariance()?;
        Ok(whole.remove_rows(3, NUMBERS - 3).remove_columns(3, NUMBERS - 3))
    }

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

    fn apply(&mut self, rows: &[Row<NUMBERS>]) -> Result<()> {
        if !rows.is_empty() {
            let invariant = self.settings.jacobians == Jacobians::Invariant;
            self.state.correct(rows, invariant.then_some(HEADING))?;
            let robot = self.state.robot_mut();
            robot[HEADING] = angle::wrap(robot[HEADING]);
        }
        Ok(())
    }

    /// The estimate of the robot's pose.
    fn robot_pose(&self) -> Pose2 {
        Pose2::from_vector(&self.state.robot().fixed_rows::<3>(0).into_owned())
    }

    /// The motion of all numbers of the robot, from that of its pose: where to, by what derivatives,
    /// with what noise.
    fn with_common_errors(
        &self,
        moved: Pose2,
        by_pose: &Matrix3<f64>,
        pose_noise: &Matrix3<f64>,
        dt: f64,
    ) -> (SVector<f64, NUMBERS>, Square, Square) {
        let kept = (-dt / self.settings.common_time).exp();
        let mut state = self.state.robot() * kept;
        state.fixed_rows_mut::<3>(0).copy_from(&moved.to_vector());
        let mut by_state = Square::identity() * kept;
        by_state.fixed_view_mut::<3, 3>(0, 0).copy_from(by_pose);
        let mut noise = Square::identity() * ((1.0 - kept * kept) * self.settings.common_share);
        noise.fixed_view_mut::<3, 3>(0, 0).copy_from(pose_noise);
        (state, by_state, noise)
    }

    /// A distance and a direction without the common errors, as far as these are known.
    fn without_common_errors(&self, range: f64, bearing: f64) -> (f64, f64) {
        let (robot, noise) = (self.state.robot(), self.settings.observation_noise);
        let range = (range - robot[3] * noise.range_sigma_at(range)).max(0.0);
        (range, bearing - robot[4] * noise.bearing_sigma)
    }
}

// The correction: observations find their landmarks, and all of them correct the state together.

/// What an observation is until something better is known of it.
const UNPLACEABLE: SlamOutcome = SlamOutcome { landmark: None, verdict: SlamVerdict::Unplaceable };

// Errors that observations of one moment have in common.
//
// A camera whose scale is off sees everything too far away, and one whose images come late sees
// everything to the same side in a turn. Such errors last; a filter that takes each observation for
// a new witness believes them after a while, and one that is told of wide noise instead cannot tell
// two landmarks apart that stand side by side. So the filter keeps the two common errors, of
// distance and of direction, beside the pose, counted in standard deviations of an observation. They
// fade with a time constant `tau` while new ones come (a Gauss-Markov process):
// `s' = e^(-dt/tau) s`, `var' = e^(-2 dt/tau) var + (1 - e^(-2 dt/tau)) share`.

/// The robot's numbers: x, y, theta, and the common errors of distance and direction.
const NUMBERS: usize = 5;

/// Index of the robot's heading among its numbers.
const HEADING: usize = 2;

/// Derivatives of two numbers over those of the robot.
type Matrix2x5 = SMatrix<f64, 2, NUMBERS>;

type Square = SMatrix<f64, NUMBERS, NUMBERS>;

/// The state without a map, from a belief over the pose.
fn start(pose: &Gaussian<3>, settings: &SlamSettings) -> Result<LargeState<NUMBERS>> {
    let mut covariance = Square::identity() * settings.common_share;
    covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.covariance);
    let mut mean = SVector::<f64, NUMBERS>::zeros();
    mean.fixed_rows_mut::<3>(0).copy_from(&pose.mean);
    LargeState::new(mean, covariance)
}
