//! Linear Kalman SLAM: a robot that moves in the plane without turning (I1).

use super::state::{LargeState, Row};
use crate::RobotSettings;
use crate::delayed::{Clock, Sequential};
use crate::localizer::{Decision, Estimate, EstimatedMap, Localizer, Outcome};
use crate::slam::{MapLandmark, SlamSettings};
use crate::{Gate, Innovation, Result};
use loc_core::error::non_negative;
use loc_core::gaussian::cholesky;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{DMatrix, Matrix2, Matrix3, Point2, Rotation2, Vector2};
use std::collections::BTreeMap;

/// A numbered landmark as the robot sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeObservation {
    /// Its number.
    pub landmark: u32,
    /// Where it is from the robot, along the axes of the map \[m\].
    pub offset: Vector2<f64>,
    /// Covariance of that \[m^2\], positive definite.
    pub covariance: Matrix2<f64>,
}

/// Kalman filter over the robot's position (x, y) and the positions of all landmarks seen so far
/// \[m\]. Everything in it is linear, so its covariance is right, not only nearly.
///
/// ```
/// use loc_core::Gaussian;
/// use loc_filters::slam::{LinearSlam, RelativeObservation, SlamSettings};
/// use nalgebra::{Matrix2, Vector2};
/// let start = Gaussian::certain(Vector2::zeros());
/// let mut slam = LinearSlam::new(start, SlamSettings::default())?;
/// let covariance = Matrix2::identity() * 0.0025;
/// let see = |x| RelativeObservation { landmark: 1, offset: Vector2::new(x, 2.0), covariance };
/// slam.correct(&[see(3.0)])?;
/// slam.predict(Vector2::new(1.0, 0.0), 1.0)?;
/// slam.correct(&[see(2.1)])?;
/// assert!(slam.robot().mean.x < 1.0 && slam.landmark(1).unwrap().mean.x > 3.0);
/// # Ok::<(), loc_filters::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct LinearSlam {
    state: LargeState<2>,
    settings: SlamSettings,
    gate: Gate,
    numbers: BTreeMap<u32, usize>,
}

impl LinearSlam {
    /// A filter without landmarks, from a belief about the robot's position \[m\].
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief or settings that are not valid.
    pub fn new(start: Gaussian<2>, settings: SlamSettings) -> Result<Self> {
        settings.check()?;
        let gate = Gate::probability(settings.robot.gate_probability)?;
        let state = LargeState::new(start.mean, start.covariance)?;
        Ok(LinearSlam { state, settings, gate, numbers: BTreeMap::new() })
    }

    /// Prediction with a velocity (vx, vy) \[m/s\] for `dt` \[s\]: `A = I`, `B = T I`, and a variance
    /// of `k_d |v_i| T` (E7) along each axis.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the velocity, [`loc_core::Error::OutOfRange`] for a negative
    /// time.
    pub fn predict(&mut self, velocity: Vector2<f64>, dt: f64) -> Result<()> {
        crate::innovation::finite("velocity", &velocity)?;
        let way = velocity * non_negative("time step [s]", dt)?;
        let noise = Matrix2::from_diagonal(&(self.settings.robot.odometry.k_d() * way.abs()));
        self.state.propagate(self.state.robot() + way, &Matrix2::identity(), &noise)
    }

    /// Corrects with observations of one moment, any number of them. For each the innovation; `None`
    /// for one that put a new landmark into the map, or that a full map has no room for.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for an observation, [`loc_core::Error::NotACovariance`] for its
    /// covariance: none is then used.
    /// [`crate::Error::LostPositivity`], with the step: the filter cannot go on.
    pub fn correct(
        &mut self,
        observations: &[RelativeObservation],
    ) -> Result<Vec<Option<Innovation<2>>>> {
        for observation in observations {
            crate::innovation::finite("position of a landmark", &observation.offset)?;
            cholesky("covariance of an observation", &observation.covariance)?;
        }
        let mut innovations = Vec::with_capacity(observations.len());
        for group in observations.chunks(crate::association::AssociationSettings::GROUP) {
            let mut rows = Vec::with_capacity(2 * group.len());
            let mut new = Vec::new();
            for observation in group {
                let known = self.numbers.get(&observation.landmark).copied();
                innovations
                    .push(known.map(|k| self.evaluate(k, observation, &mut rows)).transpose()?);
                if known.is_none() {
                    new.push((innovations.len() - 1, *observation));
                }
            }
            if !rows.is_empty() {
                self.state.correct(&rows, None)?;
            }
            for (place, observation) in new {
                innovations[place] = self.welcome(&observation)?;
            }
        }
        Ok(innovations)
    }

    // ANCHOR: judge
    fn evaluate(
        &self,
        landmark: usize,
        observation: &RelativeObservation,
        rows: &mut Vec<Row<2>>,
    ) -> Result<Innovation<2>> {
        let expected = self.state.position(landmark).coords - self.state.robot();
        let residual = observation.offset - expected;
        let cross = self.state.cross(landmark);
        let covariance = self.state.robot_covariance() + self.state.block(landmark, landmark)
            - cross
            - cross.transpose()
            + observation.covariance;
        let innovation = self.state.innovation(residual, covariance, &self.gate)?;
        if innovation.accepted {
            rows.extend(whitened_rows(landmark, observation, &residual)?);
        }
        Ok(innovation)
    }
    // ANCHOR_END: judge

    /// An observation of a number that the state did not have when its group began.
    fn welcome(&mut self, observation: &RelativeObservation) -> Result<Option<Innovation<2>>> {
        if let Some(&landmark) = self.numbers.get(&observation.landmark) {
            let mut rows = Vec::with_capacity(2);
            let innovation = self.evaluate(landmark, observation, &mut rows)?;
            if !rows.is_empty() {
                self.state.correct(&rows, None)?;
            }
            return Ok(Some(innovation));
        }
        if self.state.len() < self.settings.map.max_landmarks {
            let position = Point2::from(self.state.robot() + observation.offset);
            self.state.push(position, &Matrix2::identity(), &observation.covariance)?;
            self.numbers.insert(observation.landmark, self.state.len() - 1);
        }
        Ok(None)
    }

    /// The belief about the robot's position \[m\].
    pub fn robot(&self) -> Gaussian<2> {
        Gaussian { mean: *self.state.robot(), covariance: *self.state.robot_covariance() }
    }

    /// The belief about the landmark with a number \[m\].
    pub fn landmark(&self, id: u32) -> Option<Gaussian<2>> {
        self.numbers.get(&id).map(|&index| self.describe(index))
    }

    /// The landmarks in order of their numbers.
    pub fn landmarks(&self) -> impl Iterator<Item = (u32, Gaussian<2>)> + '_ {
        self.numbers.iter().map(|(&id, &index)| (id, self.describe(index)))
    }

    fn describe(&self, index: usize) -> Gaussian<2> {
        let mean = self.state.position(index).coords;
        Gaussian { mean, covariance: self.state.block(index, index) }
    }

    /// The whole covariance, (2 + 2 n) x (2 + 2 n), the robot first, then the landmarks in the
    /// order in which they were first seen.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`] for one that is not positive semi-definite, with the step.
    pub fn covariance(&self) -> Result<DMatrix<f64>> {
        self.state.checked_covariance()
    }
}

/// The two rows of an observation, turned and scaled so that their noise is independent, of variance 1.
fn whitened_rows(
    landmark: usize,
    observation: &RelativeObservation,
    residual: &Vector2<f64>,
) -> Result<[Row<2>; 2]> {
    let lower = cholesky("covariance of an observation", &observation.covariance)?.l();
    let (l11, l21, l22) = (lower.m11, lower.m21, lower.m22);
    let first = Vector2::new(1.0 / l11, 0.0);
    let second = Vector2::new(-l21 / (l11 * l22), 1.0 / l22);
    Ok([first, second].map(|along| Row {
        landmark,
        by_robot: -along,
        by_landmark: [along.x, along.y],
        other: None,
        residual: along.dot(residual),
        variance: 1.0,
    }))
}

/// Linear SLAM over time-stamped inputs: velocities without rotation, and observations of a camera.
///
/// The filter works along the robot's own axes, which are those of the map turned by a constant
/// heading.
#[derive(Debug, Clone)]
pub struct LinearSlamLocalizer {
    slam: LinearSlam,
    heading: f64,
    robot: RobotSettings,
    clock: Clock,
    twist: Twist2,
}

impl LinearSlamLocalizer {
    /// A localizer without a map that stands still at `stamp` \[s\] with a belief over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(settings: SlamSettings, stamp: f64, start: &Gaussian<3>) -> Result<Self> {
        let heading = start.mean.z;
        let turn = Rotation2::new(-heading);
        let position = start.position();
        let covariance = turn.matrix() * position.covariance * turn.matrix().transpose();
        let start = Gaussian { mean: turn * position.mean, covariance };
        let slam = LinearSlam::new(start, settings)?;
        let clock = Clock::starting_at(stamp)?;
        Ok(LinearSlamLocalizer { slam, heading, robot: settings.robot, clock, twist: Twist2::ZERO })
    }

    fn predict_to(&mut self, what: &'static str, stamp: f64) -> Result<()> {
        let dt = self.clock.advance(what, stamp)?;
        if dt > 0.0 {
            self.slam.predict(Vector2::new(self.twist.vx, self.twist.vy), dt)?;
        }
        Ok(())
    }

    /// The landmark from the robot's centre; `None` without a range and a bearing.
    fn relative(&self, observation: &LandmarkObservation) -> Option<RelativeObservation> {
        let Observed::RangeBearing { range, bearing } = observation.observed else { return None };
        let direction = bearing + self.robot.mounting.theta;
        let along = Vector2::new(direction.cos(), direction.sin());
        let offset = Vector2::new(self.robot.mounting.x, self.robot.mounting.y) + range * along;
        let sigma = self.robot.camera.range_sigma_at(range);
        // A landmark at the camera has no bearing; its position is still as good as the range.
        let across = (self.robot.camera.bearing_sigma * range).max(1e-3 * sigma);
        let axes = Matrix2::new(along.x, -along.y, along.y, along.x);
        let variances = Matrix2::from_diagonal(&Vector2::new(sigma * sigma, across * across));
        let covariance = axes * variances * axes.transpose();
        Some(RelativeObservation { landmark: observation.landmark, offset, covariance })
    }

    /// From the robot's axes to those of the map.
    fn in_map(&self, belief: &Gaussian<2>) -> Gaussian<2> {
        let turn = Rotation2::new(self.heading);
        let covariance = turn.matrix() * belief.covariance * turn.matrix().transpose();
        Gaussian { mean: turn * belief.mean, covariance }
    }

    fn outcome(&self, of: &RelativeObservation, innovation: Option<&Innovation<2>>) -> Outcome {
        let robot = self.slam.robot();
        let at = self.in_map(&Gaussian { mean: robot.mean + of.offset, ..robot }).mean;
        let new = Outcome::of(Decision::NewLandmark);
        let outcome = innovation.map_or(new, Outcome::of_innovation);
        outcome.with_landmark(of.landmark).with_place(Some(Point2::from(at)))
    }
}

impl Localizer for LinearSlamLocalizer {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        loc_core::error::in_range(
            "turn rate in kf-slam [rad/s]",
            "0, of a robot that never turns",
            twist.omega,
            |omega| omega.abs() <= 1e-9,
        )?;
        self.predict_to("velocity", stamp)?;
        self.twist = *twist;
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        self.predict_to("observations", stamp)?;
        let relative: Vec<_> = observations.iter().map(|seen| self.relative(seen)).collect();
        let used: Vec<RelativeObservation> = relative.iter().flatten().copied().collect();
        let innovations = self.slam.correct(&used)?;
        let mut corrected = used.iter().zip(&innovations);
        let outcome = |seen: &Option<RelativeObservation>| {
            let pair = seen.as_ref().and_then(|_| corrected.next());
            pair.map_or(Outcome::of(Decision::Undetermined), |(seen, innovation)| {
                self.outcome(seen, innovation.as_ref())
            })
        };
        Ok(relative.iter().map(outcome).collect())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        let robot = self.in_map(&self.slam.robot());
        let dt = self.clock.until(loc_core::error::finite("stamp [s]", stamp)?);
        let ahead = Vector2::new(self.twist.vx, self.twist.vy) * dt;
        let ahead = Rotation2::new(self.heading) * ahead;
        let mut covariance = Matrix3::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&robot.covariance);
        Ok(Estimate {
            pose: Pose2::new(robot.mean.x + ahead.x, robot.mean.y + ahead.y, self.heading),
            covariance: Some(covariance),
            lost: None,
            rail: None,
        })
    }

    fn map(&self) -> Result<Option<EstimatedMap>> {
        let describe = |(id, belief): (u32, Gaussian<2>)| MapLandmark {
            id,
            position: self.in_map(&belief),
            observations: 1,
            confirmed: true,
        };
        let landmarks = self.slam.landmarks().map(describe).collect();
        Ok(Some(EstimatedMap { known_association: true, landmarks }))
    }
}

impl Sequential for LinearSlamLocalizer {
    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Landmarks(_))
    }
}
