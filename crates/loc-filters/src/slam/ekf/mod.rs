//! EKF-SLAM with heading, distance and direction (I2, I3), numbered landmarks or not (I4).

mod common;
mod correct;
mod entries;
mod focus;
mod look;
mod merge;
mod outcome;
mod pairs;
mod settings;

pub use outcome::{MapLandmark, SlamOutcome, SlamVerdict};
pub use settings::{Identities, Jacobians, MapSettings, SlamSettings};

use super::state::MapState;
use crate::association::Associator;
use crate::{Gate, Result};
use common::{HEADING, NUMBERS};
use entries::{Entry, Reach};
use focus::Focus;
use loc_core::gaussian::check_covariance;
use loc_core::{Gaussian, Pose2, Twist2};
use nalgebra::DMatrix;
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
        let mut state = common::start(&start, &settings)?;
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
}
