//! The interface of every localization method: [`Localizer`], and the [`Outcome`] of a measurement.
//!
//! A method predicts with the controls of [`loc_sensors::event`], corrects with its measurements and
//! answers with an [`Estimate`]. What only some methods have (particles, several hypotheses, a map
//! of their own) is optional. Filters of this crate implement the trait themselves, particle filters
//! in `loc-pf` too, and so can a method of your own: whatever runs a `Localizer` runs it.
//!
//! ```
//! use loc_core::{Twist2, gaussian::pose_belief, Pose2};
//! use loc_filters::{Localizer, RobotSettings, landmark::LandmarkLocalizer};
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_sensors::event::{Control, Measurement};
//! use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
//!
//! let map = LandmarkMap::new([Landmark::planar(7, 3.0, 0.0)])?;
//! let start = pose_belief(Pose2::IDENTITY, [0.3, 0.3, 0.1]);
//! let mut robot = LandmarkLocalizer::new(map, RobotSettings::default(), 0.0, start)?;
//! robot.predict(0.0, &Control::Velocity(Twist2::forward(1.0, 0.0)))?;
//! let seen = LandmarkObservation { landmark: 7, observed: Observed::RangeBearing { range: 2.0, bearing: 0.0 } };
//! let outcomes = robot.correct(1.0, &Measurement::Landmarks(vec![seen]))?;
//! assert!(outcomes[0].accepted());
//! assert!((robot.estimate(1.0)?.pose.x - 1.0).abs() < 0.1);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::line_matching::LineUpdate;
use crate::slam::MapLandmark;
use crate::{Innovation, Result};
use loc_core::{Gaussian, Pose2, Twist2};
use loc_maps::grid::GridFrame;
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix3, Point2, SVector};
use std::ops::Deref;

/// A method that estimates the pose of a robot from a stream of controls and measurements.
// ANCHOR: localizer
pub trait Localizer {
    /// Predicts with a control that holds from `stamp` \[s\] on.
    ///
    /// # Errors
    /// Values that are not finite, and what the filter refuses.
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()>;

    /// Corrects with a measurement of time `stamp` \[s\]; one [`Outcome`] for each part of it (each
    /// landmark, each line, a scan as a whole). A method that does not use this kind of measurement
    /// returns none.
    ///
    /// # Errors
    /// Values that are not finite, and what the filter refuses. A measurement that comes too late is
    /// an outcome ([`Decision::TooLate`]), not an error.
    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>>;

    /// The estimate for a time \[s\] not before the last input.
    ///
    /// # Errors
    /// A stamp that is not finite, [`crate::Error::LostPositivity`].
    fn estimate(&self, stamp: f64) -> Result<Estimate>;

    /// [`predict`](Localizer::predict) with a velocity from `stamp` \[s\] on.
    ///
    /// # Errors
    /// As [`predict`](Localizer::predict).
    fn velocity(&mut self, stamp: f64, twist: Twist2) -> Result<()> {
        self.predict(stamp, &Control::Velocity(twist))
    }

    /// [`correct`](Localizer::correct) with landmarks that were observed at `stamp` \[s\].
    ///
    /// # Errors
    /// As [`correct`](Localizer::correct).
    fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<Outcome>> {
        self.correct(stamp, &Measurement::Landmarks(observations.to_vec()))
    }

    /// The possible poses with their probabilities, the most probable first; empty for a method that
    /// tracks a single one.
    fn hypotheses(&self) -> Vec<Hypothesis> {
        Vec::new()
    }

    /// The number of particles; 0 for a method without any.
    fn particle_count(&self) -> usize {
        0
    }

    /// Some of the particles, evenly thinned to at most `max`; `None` for a method without any.
    fn particle_set(&self, _max: usize) -> Option<ParticleSet> {
        None
    }

    /// The position probabilities of a grid method, if the last input changed them.
    fn grid_belief(&self) -> Option<GridBelief> {
        None
    }

    /// The landmarks of a method that builds its own map; `None` for any other.
    ///
    /// # Errors
    /// [`crate::Error::LostPositivity`].
    fn map(&self) -> Result<Option<EstimatedMap>> {
        Ok(None)
    }

    /// The systematic errors of the sensors that a method estimates, at a time \[s\] not before the
    /// last input.
    ///
    /// # Errors
    /// As [`Localizer::estimate`].
    fn sensor_errors(&self, _stamp: f64) -> Result<Vec<SensorError>> {
        Ok(Vec::new())
    }

    /// The lines of the last scan and their partners in the map, of a method that matches lines.
    fn line_matches(&self) -> Option<&LineUpdate> {
        None
    }

    /// What a user should know about the run, a line each.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }
}
// ANCHOR_END: localizer

/// The pose of the robot as a method estimates it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The pose in the map.
    pub pose: Pose2,
    /// Its covariance over (x, y, theta) \[m, m, rad\], where the method has one.
    pub covariance: Option<Matrix3<f64>>,
    /// The probability that the robot is farther from this pose than a tolerance, whatever the
    /// covariance says; `None` for a method that does not know it.
    pub lost: Option<f64>,
    /// Position \[m\] and speed \[m/s\] along the rail, for a vehicle on one.
    pub rail: Option<Gaussian<2>>,
}

impl Estimate {
    /// The estimate as a Gaussian over (x, y, theta); without a covariance, one of zeros.
    pub fn belief(&self) -> Gaussian<3> {
        let covariance = self.covariance.unwrap_or_else(Matrix3::zeros);
        Gaussian { mean: self.pose.to_vector(), covariance }
    }

    /// The same with the probability of being lost.
    #[must_use]
    pub fn with_lost(self, probability: f64) -> Self {
        Estimate { lost: Some(probability), ..self }
    }
}

impl From<Gaussian<3>> for Estimate {
    fn from(belief: Gaussian<3>) -> Self {
        Estimate {
            pose: belief.pose(),
            covariance: Some(belief.covariance),
            lost: None,
            rail: None,
        }
    }
}

/// A possible pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// Its probability.
    pub share: f64,
    /// The pose in the map over (x, y, theta) \[m, m, rad\].
    pub belief: Gaussian<3>,
}

/// What became of one part of a measurement, for every method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Whether it was used, and if not, why.
    pub decision: Decision,
    /// The landmark that it was assigned to, in the map's numbers.
    pub landmark: Option<u32>,
    /// Measurement minus expectation (prefit residual), angles wrapped; empty where nothing was
    /// expected.
    pub residual: Residual,
    /// The residual in units of its standard deviations, `L^-1 r` with `S = L L^T`: of a consistent
    /// filter independent numbers of mean 0 and variance 1.
    pub whitened: Residual,
    /// Normalised innovation squared, where the method computes one.
    pub nis: Option<f64>,
    /// How many numbers were compared with the expectation: the mean of the NIS of a consistent
    /// filter.
    pub degrees_of_freedom: usize,
    /// Where the measurement puts what was observed, from the estimated pose \[m\].
    pub observed_at: Option<Point2<f64>>,
}

/// Where an observation puts its landmark, from a camera's pose in the map \[m\]; `None` without a
/// range and a bearing.
pub fn observed_position(camera: Pose2, observation: &LandmarkObservation) -> Option<Point2<f64>> {
    let Observed::RangeBearing { range, bearing } = observation.observed else { return None };
    let (sin, cos) = bearing.sin_cos();
    Some(camera.transform(&Point2::new(range * cos, range * sin)))
}

/// Whether a measurement was used, and if not, why.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Decision {
    /// It changed the estimate.
    Accepted,
    /// It initialized a new landmark of the map.
    NewLandmark,
    /// It is kept, and will be used once there are enough others.
    Pending,
    /// It contradicts the estimate: beyond the gate, an outlier.
    Rejected,
    /// The map has no landmark of its number, or no feature that fits.
    UnknownLandmark,
    /// It fits several landmarks, or none well enough to be it and one too well to be new.
    Ambiguous,
    /// Something new without a distance or a direction, or too near to have one.
    Undetermined,
    /// Something new for which the map has no room left.
    MapFull,
    /// It is older than the filter can go back.
    TooLate,
}

impl Outcome {
    /// An outcome without a residual.
    pub const fn of(decision: Decision) -> Self {
        Outcome {
            decision,
            landmark: None,
            residual: Residual::NONE,
            whitened: Residual::NONE,
            nis: None,
            degrees_of_freedom: 0,
            observed_at: None,
        }
    }

    /// The outcome of a correction: accepted, or rejected by the gate.
    pub fn of_innovation<const M: usize>(innovation: &Innovation<M>) -> Self {
        let decision = if innovation.accepted { Decision::Accepted } else { Decision::Rejected };
        Outcome {
            residual: innovation.residual.into(),
            whitened: innovation.whitened.into(),
            nis: Some(innovation.nis),
            degrees_of_freedom: M,
            ..Outcome::of(decision)
        }
    }

    /// The outcome of one with its NIS alone.
    #[must_use]
    pub fn with_nis(self, nis: f64) -> Self {
        Outcome { nis: Some(nis), ..self }
    }

    /// The same, of a landmark.
    #[must_use]
    pub fn with_landmark(self, landmark: u32) -> Self {
        Outcome { landmark: Some(landmark), ..self }
    }

    /// The same, with the place of what was observed \[m\].
    #[must_use]
    pub fn with_place(self, observed_at: Option<Point2<f64>>) -> Self {
        Outcome { observed_at, ..self }
    }

    /// Whether the measurement is used, for the estimate or the map.
    pub fn accepted(&self) -> bool {
        matches!(self.decision, Decision::Accepted | Decision::NewLandmark | Decision::Pending)
    }
}

/// The numbers of a residual: a slice of at most [`Residual::MAX`], empty where there is none.
///
/// ```
/// use loc_filters::localizer::Residual;
/// use nalgebra::Vector2;
/// assert_eq!(*Residual::from(Vector2::new(0.3, -1.2)), [0.3, -1.2]);
/// assert!(Residual::NONE.is_empty());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    values: [f64; Residual::MAX],
    count: usize,
}

impl Residual {
    /// The number of values that are kept of one measurement.
    pub const MAX: usize = 3;
    /// No residual.
    pub const NONE: Residual = Residual { values: [0.0; Residual::MAX], count: 0 };
}

impl<const M: usize> From<SVector<f64, M>> for Residual {
    /// Of a longer vector, the first values.
    fn from(vector: SVector<f64, M>) -> Self {
        let mut residual = Residual { count: M.min(Residual::MAX), ..Residual::NONE };
        for (value, given) in residual.values.iter_mut().zip(vector.iter()) {
            *value = *given;
        }
        residual
    }
}

impl Deref for Residual {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.values[..self.count]
    }
}

/// Particles of a method, evenly thinned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ParticleSet {
    /// Poses in the map with their weights; those of all particles add up to 1.
    pub particles: Vec<(Pose2, f64)>,
    /// The weighted particles before the last resampling, from a method that keeps them.
    pub weighted: Option<Vec<(Pose2, f64)>>,
}

/// The position probabilities of a grid method.
#[derive(Debug, Clone, PartialEq)]
pub struct GridBelief {
    /// The cells.
    pub cells: GridFrame,
    /// The probability of each cell over all headings, row by row from the bottom; sum 1.
    pub probabilities: Vec<f32>,
}

impl GridBelief {
    /// Mean position \[m\] and its standard deviation over both axes \[m\]; within a cell the
    /// position is uniform.
    pub fn mean_and_spread(&self) -> ([f64; 2], f64) {
        let weighted = || {
            let centers = self.cells.cells().map(|cell| self.cells.center(cell));
            centers.zip(self.probabilities.iter().map(|&p| f64::from(p)))
        };
        let total: f64 = weighted().map(|(_, p)| p).sum();
        let mean = |of: &dyn Fn([f64; 2]) -> f64| {
            weighted().map(|(at, p)| p * of([at.x, at.y])).sum::<f64>() / total
        };
        let [x, y] = [mean(&|at| at[0]), mean(&|at| at[1])];
        let squared = mean(&|at| (at[0] - x).powi(2) + (at[1] - y).powi(2));
        ([x, y], (squared + self.cells.resolution().powi(2) / 6.0).sqrt())
    }
}

/// The map that a SLAM method has built.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EstimatedMap {
    /// Whether the numbers were read off the landmarks (known data association); otherwise the
    /// method has assigned them.
    pub known_association: bool,
    /// The landmarks, provisional ones included.
    pub landmarks: Vec<MapLandmark>,
}

impl EstimatedMap {
    /// Number of landmarks that are not provisional.
    pub fn confirmed(&self) -> usize {
        self.landmarks.iter().filter(|landmark| landmark.confirmed).count()
    }
}

/// A systematic error of a sensor, as a method estimates it.
///
/// ```
/// use loc_filters::localizer::SensorError;
/// let bias = SensorError { name: "gyroscope [deg/s]", mean: 0.02, sigma: 0.005 };
/// assert!(bias.mean > 3.0 * bias.sigma, "significant");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorError {
    /// The sensor with the unit of the error.
    pub name: &'static str,
    /// The error, in that unit.
    pub mean: f64,
    /// Its standard deviation.
    pub sigma: f64,
}
