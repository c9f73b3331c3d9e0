//! EKF-SLAM with heading, range and bearing (I2, I3), known or unknown data association (I4).
//!
//! This file holds the filter: prediction, correction, the model of an observation. `landmarks`
//! holds what is stored of each landmark beside its position, and which of them are in the active
//! submap; `observation` the types of single observations and their association; `settings` the
//! settings and outcomes.

mod landmarks;
mod observation;
mod settings;

pub use settings::{Identities, Jacobians, MapLandmark, MapSettings, SlamSettings};

use super::state::{LargeState, MapState, Row};
use crate::MeasurementModel;
use crate::association::{AssociationSettings, Associator};
use crate::landmark::RangeBearingModel;
use crate::localizer::{Decision, Outcome};
use crate::{Gate, Result};
use landmarks::{ActiveRegion, Entry, ViewExtent};
use loc_core::gaussian::check_covariance;
use loc_core::{Gaussian, Pose2, Twist2, angle};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{DMatrix, Matrix1, Matrix2, Matrix3, Point2, SMatrix, SVector, Vector1, Vector2};
use observation::{LocatedObservation, ObservationPairs, PredictedObservation};
use std::collections::BTreeMap;

/// Number of the robot's states: x, y, theta, and the common errors of range and bearing.
///
/// Errors that all observations of one moment share last over time: a wrong camera scale makes every
/// range too long, a late stamp shifts every bearing to one side during a turn. A filter that treats
/// them as independent becomes overconfident; one with wider independent noise cannot separate two
/// landmarks side by side. The filter therefore estimates the two common errors together with the
/// pose, in standard deviations of an observation. They are a Gauss-Markov process with the time
/// constant `tau`: `s' = e^(-dt/tau) s`, `var' = e^(-2 dt/tau) var + (1 - e^(-2 dt/tau)) share`.
const NUMBERS: usize = 5;

/// Index of the heading among the robot's states.
const HEADING: usize = 2;

/// Derivatives of a range and a bearing by the robot's states.
type Matrix2x5 = SMatrix<f64, 2, NUMBERS>;

type Square = SMatrix<f64, NUMBERS, NUMBERS>;

/// The outcome of an observation that neither fits a landmark nor gives the position of a new one.
const UNDETERMINED: Outcome = Outcome::of(Decision::Undetermined);

/// Extended Kalman filter over the robot's pose (x, y, theta) \[m, m, rad\] and the positions of
/// all landmarks seen so far \[m\], in the frame of the start.
///
/// A landmark is initialized at its first observation, from the pose of that moment. All
/// observations of one moment correct the state together, so that the covariance is read and
/// written once.
#[derive(Debug, Clone)]
pub struct EkfSlam {
    state: MapState<NUMBERS>,
    settings: SlamSettings,
    gate: Gate,
    new_landmark_gate: f64,
    distinct_gate: f64,
    associator: Associator,
    /// Finds landmarks that are in the map twice.
    merger: Associator,
    /// What is stored of each landmark beside its position, in the order of the state.
    entries: Vec<Entry>,
    /// From the number of a landmark to its index in the state.
    numbers: BTreeMap<u32, usize>,
    next_number: u32,
    /// The first estimate of the current pose: that before its corrections.
    first_pose: Pose2,
    view: ViewExtent,
    /// Whether a landmark has lost some of its score.
    score_lowered: bool,
    region: Option<ActiveRegion>,
}

impl EkfSlam {
    /// A filter without landmarks, from a belief over (x, y, theta). The start may be certain:
    /// it is then the origin of the map.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief or settings that are not valid.
    pub fn new(start: Gaussian<3>, settings: SlamSettings) -> Result<Self> {
        let gate = settings.gate()?;
        let mut state = initial_state(&start, &settings)?;
        state.robot_mut()[HEADING] = loc_core::angle::wrap(start.mean.z);
        Ok(EkfSlam {
            state: MapState::new(state),
            settings,
            gate,
            new_landmark_gate: settings.new_landmark_gate()?,
            distinct_gate: settings.distinct_gate()?,
            associator: Associator::new(settings.association)?,
            merger: Associator::new(settings.merging())?,
            entries: Vec::new(),
            numbers: BTreeMap::new(),
            next_number: 0,
            first_pose: start.pose(),
            view: ViewExtent::default(),
            score_lowered: false,
            region: None,
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

    /// The estimate of the robot's pose with its covariance.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] for a covariance that is none, with the step.
    pub fn pose(&self) -> Result<Gaussian<3>> {
        let mean = self.state.robot().fixed_rows::<3>(0).into_owned();
        let covariance = self.state.robot_covariance().fixed_view::<3, 3>(0, 0).into_owned();
        check_covariance("covariance of the robot", &covariance)
            .map_err(|error| self.state.robot_state().state_error(error))?;
        Ok(Gaussian { mean, covariance })
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

    /// Prediction with velocity `twist` for `dt` \[s\]: `S' = F S F^T + F_u S_u F_u^T`, which
    /// touches the robot's rows only.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the velocity, [`loc_core::Error::OutOfRange`] for a negative time,
    /// [`crate::Error::LostPositivity`] where the covariance grows beyond all numbers.
    pub fn predict(&mut self, twist: Twist2, dt: f64) -> Result<()> {
        crate::innovation::finite("velocity", &twist.to_vector())?;
        loc_core::error::non_negative("time step [s]", dt)?;
        let crate::RobotSettings { integration, odometry, .. } = self.settings.robot;
        let pose = self.robot_pose();
        let (moved, jacobians) = integration.step_with_jacobians(pose, twist, dt);
        let (mut f, by_twist) = (jacobians.by_pose, jacobians.by_twist);
        if self.settings.jacobians == Jacobians::First {
            // From first estimate to first estimate, without the corrections in between.
            f[(0, 2)] = -(moved.y - self.first_pose.y);
            f[(1, 2)] = moved.x - self.first_pose.x;
        }
        let noise = by_twist * odometry.covariance(twist, dt) * by_twist.transpose();
        let (moved_state, f, noise) = self.with_common_errors(moved, &f, &noise, dt);
        self.state.propagate(moved_state, &f, &noise)?;
        self.first_pose = moved;
        Ok(())
    }

    /// The motion of all of the robot's states, from that of its pose: state, Jacobian, noise.
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

    /// Correction with all observations of one moment, any number of them; returns an outcome for each.
    ///
    /// Observations are processed in groups of [`AssociationSettings::GROUP`]. Those of one group are
    /// linearised at the same state and gated one by one; the accepted ones correct the state in one
    /// pass over the covariance. Then new landmarks are initialized: from observations with a number
    /// that the state does not have, or, with unknown association, that fit no landmark.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for an observation that is not finite or has a negative range:
    /// none is then used. [`crate::Error::LostPositivity`], with the step: the filter cannot go on.
    pub fn correct(&mut self, observations: &[LandmarkObservation]) -> Result<Vec<Outcome>> {
        for observation in observations {
            observation.observed.check()?;
        }
        let mut outcomes = Vec::with_capacity(observations.len());
        let mut budget = self.settings.association.search_limit;
        for group in observations.chunks(AssociationSettings::GROUP) {
            self.update_submap(group)?;
            match self.settings.identities {
                Identities::Known => self.correct_known(group, &mut outcomes)?,
                Identities::Unknown => {
                    self.correct_unknown(group, &mut budget, &mut outcomes)?;
                }
            }
        }
        if self.settings.identities == Identities::Unknown && !observations.is_empty() {
            let mut seen = vec![false; self.entries.len()];
            for id in outcomes.iter().filter_map(|outcome| outcome.landmark) {
                self.numbers.get(&id).into_iter().for_each(|&landmark| seen[landmark] = true);
            }
            self.score_missed(&seen)?;
            self.merge(&mut outcomes)?;
        }
        Ok(outcomes)
    }

    fn correct_known(
        &mut self,
        group: &[LandmarkObservation],
        outcomes: &mut Vec<Outcome>,
    ) -> Result<()> {
        let first = outcomes.len();
        let mut rows = Vec::with_capacity(2 * group.len());
        let mut new = Vec::new();
        for (k, observation) in group.iter().enumerate() {
            outcomes.push(match self.numbers.get(&observation.landmark) {
                Some(&landmark) => {
                    self.evaluate(landmark, observation.observed, &self.gate, &mut rows)?
                }
                None => {
                    new.push(k);
                    UNDETERMINED
                }
            });
        }
        self.apply(&rows)?;
        for outcome in &outcomes[first..] {
            if let Some(id) = outcome.landmark {
                self.update_score(id, outcome.accepted());
            }
        }
        for k in new {
            outcomes[first + k] = self.add_new(&group[k])?;
        }
        self.remove_unsupported()
    }

    /// Processes an observation of a number that the state did not have when its group began.
    fn add_new(&mut self, observation: &LandmarkObservation) -> Result<Outcome> {
        let id = observation.landmark;
        let Some(&landmark) = self.numbers.get(&id) else {
            return match self.locate(observation) {
                Some(located) => self.add_landmark(id, &located),
                None => Ok(UNDETERMINED),
            };
        };
        // It was initialized by an earlier observation of the same group.
        let mut rows = Vec::with_capacity(2);
        let outcome = self.evaluate(landmark, observation.observed, &self.gate, &mut rows)?;
        self.apply(&rows)?;
        self.update_score(id, outcome.accepted());
        Ok(outcome)
    }

    fn correct_unknown(
        &mut self,
        group: &[LandmarkObservation],
        budget: &mut usize,
        outcomes: &mut Vec<Outcome>,
    ) -> Result<()> {
        let located: Vec<Option<LocatedObservation>> =
            group.iter().map(|seen| self.locate(seen)).collect();
        let usable: Vec<LocatedObservation> = located.iter().flatten().copied().collect();
        usable.iter().for_each(|located| self.view.include(located));
        let pairs = ObservationPairs::new(self, &usable);
        let association = self.associator.associate_within(&pairs, budget);
        let association =
            association.map_err(|error| self.state.robot_state().state_error(error))?;
        let distinctive: Vec<bool> = (0..usable.len()).map(|k| pairs.is_distinctive(k)).collect();
        let mut rows = Vec::with_capacity(2 * usable.len());
        let mut found = vec![UNDETERMINED; group.len()];
        let mut new = Vec::new();
        let mut taken: Vec<usize> = association.partners.iter().flatten().copied().collect();
        taken.sort_unstable();
        let usable = (0..group.len()).filter(|&k| located[k].is_some());
        for (observation, k) in usable.enumerate() {
            // A landmark is observed once per moment: a second observation beside it is of a new one.
            let nis = pairs.nearest_free(observation, &taken);
            match association.partners[observation] {
                Some(landmark) => {
                    found[k] = self.evaluate(landmark, group[k].observed, &self.gate, &mut rows)?;
                }
                None if nis > self.new_landmark_gate || !distinctive[observation] => new.push(k),
                None => found[k] = Outcome::of(Decision::Ambiguous).with_nis(nis),
            }
        }
        self.apply(&rows)?;
        for outcome in &found {
            if let Some(id) = outcome.landmark {
                self.update_score(id, outcome.accepted());
            }
        }
        let known = self.entries.len();
        for k in new {
            found[k] = self.add_new_unidentified(
                &group[k],
                taken.iter().copied().chain(known..self.entries.len()),
            )?;
        }
        outcomes.extend(found);
        Ok(())
    }

    /// Processes an observation that fits no landmark except, perhaps, those that other observations
    /// of its group were associated with or initialized: a new landmark must be apart from these too.
    fn add_new_unidentified(
        &mut self,
        observation: &LandmarkObservation,
        beside: impl Iterator<Item = usize>,
    ) -> Result<Outcome> {
        // From the corrected pose.
        let Some(located) = self.locate(observation) else { return Ok(UNDETERMINED) };
        let mut nearest = f64::INFINITY;
        for landmark in beside {
            let outcome =
                self.evaluate(landmark, observation.observed, &self.gate, &mut Vec::new())?;
            nearest = nearest.min(outcome.nis.unwrap_or(f64::INFINITY));
        }
        if nearest <= self.distinct_gate {
            return Ok(Outcome::of(Decision::Ambiguous).with_nis(nearest));
        }
        self.add_landmark(self.next_number, &located)
    }

    /// Adds a new landmark to the state, unless the map is full.
    fn add_landmark(&mut self, id: u32, located: &LocatedObservation) -> Result<Outcome> {
        if self.entries.len() >= self.settings.map.max_landmarks {
            return Ok(Outcome::of(Decision::MapFull));
        }
        self.initialize_landmark(id, located)?;
        Ok(Outcome::of(Decision::NewLandmark).with_landmark(id))
    }

    fn update_score(&mut self, id: u32, accepted: bool) {
        if let Some(&landmark) = self.numbers.get(&id) {
            if accepted {
                self.raise_score(landmark);
            } else {
                self.lower_score(landmark, self.settings.map.contradiction_cost);
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

    /// Gates an observation of a landmark; if it is accepted, its rows are appended to `rows`.
    fn evaluate(
        &self,
        landmark: usize,
        observed: Observed,
        gate: &Gate,
        rows: &mut Vec<Row<NUMBERS>>,
    ) -> Result<Outcome> {
        let (range, bearing) = (observed.range().unwrap_or(0.0), observed.bearing().unwrap_or(0.0));
        let prediction = self.prediction(landmark, range, bearing);
        let covariance = self.innovation_covariance(&prediction);
        let state = self.state.robot_state();
        let one = |k: usize| {
            let residual = Vector1::new(prediction.residual[k]);
            state.innovation(residual, Matrix1::new(covariance[(k, k)]), gate)
        };
        let outcome = match observed {
            Observed::RangeBearing { .. } => {
                Outcome::of_innovation(&state.innovation(prediction.residual, covariance, gate)?)
            }
            Observed::Range { .. } => Outcome::of_innovation(&one(0)?),
            Observed::Bearing { .. } => Outcome::of_innovation(&one(1)?),
        };
        let outcome = outcome.with_landmark(self.entries[landmark].id);
        if outcome.accepted() {
            let measured = [observed.range().is_some(), observed.bearing().is_some()];
            rows.extend([0, 1].into_iter().filter(|&k| measured[k]).map(|k| prediction.row(k)));
        }
        Ok(outcome)
    }

    /// Linearises the observation of a landmark, with the residual of a range and a bearing. Of the two,
    /// one that is not measured may be any number.
    fn prediction(&self, landmark: usize, range: f64, bearing: f64) -> PredictedObservation {
        let seen = Vector2::new(range, bearing);
        let share = self.settings.common_share;
        let model = self.model(self.state.position(landmark));
        let robot = self.state.robot();
        match self.settings.jacobians {
            Jacobians::Current | Jacobians::Invariant => {
                PredictedObservation::new(landmark, &model, robot, seen, share)
            }
            Jacobians::First => {
                let mut prediction =
                    PredictedObservation::new(landmark, &model, robot, seen, share);
                let first = self.model(self.entries[landmark].first);
                prediction.linearize(&first.jacobian(&self.first_pose.to_vector()));
                prediction
            }
        }
    }

    fn model(&self, landmark: Point2<f64>) -> RangeBearingModel {
        let (mounting, noise) = (self.settings.robot.mounting, self.settings.robot.camera);
        RangeBearingModel { landmark, mounting, noise }
    }

    /// `H_a P H_b^T` of two predictions.
    // ANCHOR: covariance-between
    fn covariance_between(
        &self,
        a: &PredictedObservation,
        b: &PredictedObservation,
    ) -> Matrix2<f64> {
        let robot = self.state.robot_covariance();
        let (with_a, with_b) = (self.state.cross(a.landmark), self.state.cross(b.landmark));
        let map = self.state.block(a.landmark, b.landmark);
        a.by_robot * (robot * b.by_robot.transpose() + with_b * b.by_landmark.transpose())
            + a.by_landmark
                * (with_a.transpose() * b.by_robot.transpose() + map * b.by_landmark.transpose())
    }
    // ANCHOR_END: covariance-between

    /// The covariance of a prediction's innovation.
    fn innovation_covariance(&self, prediction: &PredictedObservation) -> Matrix2<f64> {
        self.covariance_between(prediction, prediction) + prediction.noise
    }

    /// The position of a landmark that an observation gives at the estimated pose \[m\]; `None` without
    /// a range or a bearing.
    fn locate(&self, observation: &LandmarkObservation) -> Option<LocatedObservation> {
        let Observed::RangeBearing { range, bearing } = observation.observed else { return None };
        if range < LocatedObservation::NEAREST {
            return None;
        }
        let camera = self.robot_pose() * self.settings.robot.mounting;
        let (true_range, true_bearing) = self.without_common_errors(range, bearing);
        let (sin, cos) = true_bearing.sin_cos();
        let position = camera.transform(&Point2::new(true_range * cos, true_range * sin));
        Some(LocatedObservation {
            range,
            bearing,
            direction: camera.theta + true_bearing,
            position,
        })
    }

    /// A range and a bearing minus the estimated common errors.
    fn without_common_errors(&self, range: f64, bearing: f64) -> (f64, f64) {
        let (robot, noise) = (self.state.robot(), self.settings.robot.camera);
        let range = (range - robot[3] * noise.range_sigma_at(range)).max(0.0);
        (range, bearing - robot[4] * noise.bearing_sigma)
    }

    /// The estimate of the robot's pose.
    fn robot_pose(&self) -> Pose2 {
        Pose2::from_vector(&self.state.robot().fixed_rows::<3>(0).into_owned())
    }
}

/// The state without a map, from a belief over the pose.
fn initial_state(pose: &Gaussian<3>, settings: &SlamSettings) -> Result<LargeState<NUMBERS>> {
    let mut covariance = Square::identity() * settings.common_share;
    covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.covariance);
    let mut mean = SVector::<f64, NUMBERS>::zeros();
    mean.fixed_rows_mut::<3>(0).copy_from(&pose.mean);
    LargeState::new(mean, covariance)
}
