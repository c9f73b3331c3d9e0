//! One adapter per method between the event stream and a filter.
//!
//! A new method is one file here that implements [`Localizer`], and one line in [`Method`].

pub mod cloud;
mod dead_reckoning;
mod driven;
mod ekf;
mod ekf_slam;
mod estimated_map;
mod fastslam;
mod fusion;
mod histogram;
mod kf_slam;
mod landmark_mcl;
mod lateration;
mod line_ekf;
mod mcl;
mod method;
mod place_belief;
mod rail;
mod sensor_error;
pub(crate) mod smoothed;
mod whitened;

pub use cloud::Cloud;
pub use estimated_map::EstimatedMap;
pub use method::{Method, MethodSettings, Needs, RailSettings};
pub use place_belief::PlaceBelief;
pub use sensor_error::SensorError;
pub use whitened::Whitened;

use crate::Result;
use loc_core::{Gaussian, Pose2};
use loc_filters::line_matching::LineUpdate;
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix3, Point2};

/// A method that follows a robot through a stream of events.
// ANCHOR: localizer
pub trait Localizer {
    /// Takes in a control that holds from `stamp` \[s\] on.
    ///
    /// # Errors
    /// What the filter refuses.
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()>;

    /// Takes in a measurement of time `stamp` \[s\]; the answer judges each part of it. A method
    /// that has no use for it answers with nothing.
    ///
    /// # Errors
    /// What the filter refuses.
    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>>;

    /// The estimate for a time \[s\] not before the last input.
    ///
    /// # Errors
    /// What the filter refuses.
    fn estimate(&self, stamp: f64) -> Result<Estimate>;

    /// How many particles it has; 0 for a method without any.
    fn particle_count(&self) -> usize {
        0
    }

    /// The poses that it holds possible, the likeliest first; none for a method that knows but one.
    fn hypotheses(&self) -> Vec<Hypothesis> {
        Vec::new()
    }

    /// The landmarks of a method that draws its own map; `None` for any other.
    ///
    /// # Errors
    /// What the filter refuses.
    fn map(&self) -> Result<Option<EstimatedMap>> {
        Ok(None)
    }

    /// What a method that calibrates its sensors on the way believes about their errors at a time
    /// \[s\] not before the last input; nothing for any other.
    ///
    /// # Errors
    /// What the filter refuses.
    fn sensor_errors(&self, _stamp: f64) -> Result<Vec<SensorError>> {
        Ok(Vec::new())
    }

    /// What it has found out on the way that a user should know, as lines.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// The particles of a method that has any, for figures: thinned to at most
    /// [`Cloud::MAX`](cloud::Cloud::MAX).
    fn cloud(&self) -> Option<Cloud> {
        None
    }

    /// The probabilities of all places after an update that has changed them, of a method that keeps
    /// a grid of them, for figures.
    fn place_belief(&self) -> Option<PlaceBelief> {
        None
    }

    /// What the last scan told a method that matches lines, for figures.
    fn lines(&self) -> Option<&LineUpdate> {
        None
    }
}
// ANCHOR_END: localizer

/// A pose that a method holds possible.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// Its probability.
    pub share: f64,
    /// The pose in the map, over (x, y, theta) \[m, m, rad\].
    pub belief: Gaussian<3>,
}

/// Where a method believes the robot to be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The pose in the map.
    pub pose: Pose2,
    /// Its covariance over (x, y, theta), where the method has one.
    pub covariance: Option<Matrix3<f64>>,
    /// Position \[m\] and speed \[m/s\] along the rail, for a vehicle on one.
    pub rail: Option<Gaussian<2>>,
}

impl From<Gaussian<3>> for Estimate {
    fn from(belief: Gaussian<3>) -> Self {
        Estimate { pose: belief.pose(), covariance: Some(belief.covariance), rail: None }
    }
}

/// What a method made of one measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    /// Whether it changed the belief.
    pub accepted: bool,
    /// Normalised innovation squared, where the method computes one.
    pub nis: Option<f64>,
    /// How many numbers were measured.
    pub degrees_of_freedom: usize,
    /// The whitened innovation, where the method computes one.
    pub whitened: Whitened,
    /// Where the measurement puts the thing it saw, from the method's pose \[m\].
    pub seen_at: Option<Point2<f64>>,
}

impl Judgement {
    /// A measurement that was turned away before it was looked at.
    pub const REFUSED: Judgement = Judgement {
        accepted: false,
        nis: None,
        degrees_of_freedom: 0,
        whitened: Whitened::NONE,
        seen_at: None,
    };
}

/// Where an observation puts its landmark from a camera's pose \[m\]; `None` without a distance and a
/// direction.
fn seen_at(camera: Pose2, observation: &LandmarkObservation) -> Option<Point2<f64>> {
    let Observed::RangeBearing { range, bearing } = observation.sight else { return None };
    let (sin, cos) = bearing.sin_cos();
    Some(camera.transform(&Point2::new(range * cos, range * sin)))
}
