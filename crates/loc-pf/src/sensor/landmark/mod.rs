//! Landmarks at known positions, observed by distance, direction or both (M5).
//!
//! From a particle's pose follows the expected observation of each landmark; the nearer the
//! measured one is to it, the larger the particle's weight:
//!
//! `p = prod_j N(r_j - r_j*; s_r) N(phi_j - phi_j*; s_phi)`.
//!
//! Occasionally a number is misread. So that one such outlier does not exclude the true pose, each
//! factor is a mixture with a small uniform density over everything that a camera can report.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_pf::{ParticleFilter, Particles};
//! use loc_pf::sensor::landmark::{LandmarkLikelihood, ObservationModel};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let map = LandmarkMap::new([Landmark::planar(7, 3.0, 4.0)])?;
//! let observed = Observed::RangeBearing { range: 5.0, bearing: 4_f64.atan2(3.0) };
//! let seen = [LandmarkObservation { landmark: 7, observed }, LandmarkObservation { landmark: 99, observed }];
//! let likelihood = LandmarkLikelihood::new(&map, &seen, &ObservationModel::default())?;
//! assert_eq!(likelihood.unknown(), [seen[1]]);
//! let there = likelihood.log_likelihood(Pose2::IDENTITY);
//! assert!(there > likelihood.log_likelihood(Pose2::new(0.1, 0.0, 0.0)));
//!
//! let particles = Particles::from_poses([Pose2::IDENTITY, Pose2::new(0.2, 0.0, 0.0)]);
//! let mut filter = ParticleFilter::new(particles, stream(1, "filter"));
//! filter.weigh(&likelihood);
//! filter.normalize();
//! assert!(filter.particles().weight(0) > 0.8);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod kernel;
mod resetting;

pub use resetting::SensorResetting;
pub(crate) use resetting::anywhere;

use super::Likelihood;
use crate::{Poses, Result};
use kernel::Seen;
use loc_core::error::{finite, in_range, non_negative, positive};
use loc_core::{Pose2, angle};
use loc_maps::LandmarkMap;
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::Point2;
use std::f64::consts::TAU;

/// The observation model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ObservationModel {
    /// Noise of inliers; both sigmas above 0.
    pub noise: LandmarkNoise,
    /// The camera's pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Share of outliers, such as misread numbers, in \[0, 1).
    pub outlier_share: f64,
    /// Distance up to which landmarks are seen \[m\]: outliers are uniform within it.
    pub outlier_range: f64,
}

impl Default for ObservationModel {
    /// 5 cm and 1 degree at the robot's centre; one observation in a hundred is an outlier, up to
    /// 10 m away.
    fn default() -> Self {
        ObservationModel {
            noise: LandmarkNoise::default(),
            mounting: Pose2::IDENTITY,
            outlier_share: 0.01,
            outlier_range: 10.0,
        }
    }
}

impl ObservationModel {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for sigmas of 0, a share outside \[0, 1), a range that is
    /// not positive, and for what is not finite.
    pub fn check(&self) -> loc_core::Result<()> {
        positive("sigma of the range [m]", self.noise.range_sigma)?;
        non_negative("growth of the range's sigma [m/m]", self.noise.range_sigma_per_m)?;
        positive("sigma of the bearing [rad]", self.noise.bearing_sigma)?;
        for value in [self.mounting.x, self.mounting.y, self.mounting.theta] {
            finite("mounting of the camera [m, m, rad]", value)?;
        }
        let share = |share: f64| (0.0..1.0).contains(&share);
        in_range("share of outliers", "a number in [0, 1)", self.outlier_share, share)?;
        positive("farthest outlier [m]", self.outlier_range)?;
        Ok(())
    }
}

/// Observations of one time with the landmarks of a map, prepared to rate poses.
///
/// Many poses are rated in single precision, relative to the first landmark: a pose 100 m from it
/// is rounded by 4 um, an angle by 4 urad, the logarithm by 1e-5 and a relative 2e-5.
/// [`log_likelihood`](LandmarkLikelihood::log_likelihood) is the plain form in double precision.
#[derive(Debug, Clone)]
pub struct LandmarkLikelihood {
    model: ObservationModel,
    observations: Vec<Placed>,
    unknown: Vec<LandmarkObservation>,
    /// Where single precision counts from \[m\]: the first landmark.
    origin: Point2<f64>,
    seen: Vec<Seen>,
}

/// An observation with the position of its landmark in the map \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placed {
    pub(crate) landmark: Point2<f64>,
    pub(crate) observation: LandmarkObservation,
}

impl LandmarkLikelihood {
    /// Finds the landmarks of the observations in the map. Unknown numbers are left out, see
    /// [`unknown`](LandmarkLikelihood::unknown).
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for observations and models that are not valid.
    pub fn new(
        map: &LandmarkMap,
        observations: &[LandmarkObservation],
        model: &ObservationModel,
    ) -> Result<Self> {
        model.check()?;
        let (mut placed, mut unknown) = (Vec::with_capacity(observations.len()), Vec::new());
        for observation in observations {
            observation.observed.check()?;
            match map.get(observation.landmark) {
                Some(landmark) => {
                    placed.push(Placed {
                        landmark: landmark.position.xy(),
                        observation: *observation,
                    });
                }
                None => unknown.push(*observation),
            }
        }
        let origin = placed.first().map_or(Point2::origin(), |first: &Placed| first.landmark);
        let seen = placed.iter().map(|placed| Seen::new(placed, origin, model)).collect();
        Ok(LandmarkLikelihood { model: *model, observations: placed, unknown, origin, seen })
    }

    /// Number of observations that rate.
    pub fn len(&self) -> usize {
        self.observations.len()
    }

    /// Whether there is no observation that rates; every pose is then as likely as any other.
    pub fn is_empty(&self) -> bool {
        self.observations.is_empty()
    }

    /// The observations whose number is not in the map, in the order in which they came.
    pub fn unknown(&self) -> &[LandmarkObservation] {
        &self.unknown
    }

    /// The observations that rate, with the positions of their landmarks.
    pub(crate) fn placed(&self) -> &[Placed] {
        &self.observations
    }

    /// The observation model.
    pub fn model(&self) -> &ObservationModel {
        &self.model
    }

    /// `ln p(observations | pose)`, in double precision. Densities are per metre and radian, so
    /// that the logarithm may be positive.
    pub fn log_likelihood(&self, pose: Pose2) -> f64 {
        self.placed().iter().map(|placed| density(placed, self.model(), pose).ln()).sum()
    }

    /// The largest value that the log-likelihood could have: that of observations without any
    /// error.
    pub fn log_peak(&self) -> f64 {
        let without_error = |placed: &Placed| {
            let range = placed.observation.observed.range();
            let right = peak(range, placed, self.model());
            Density { right, wrong: wrong(placed, self.model()) }.ln()
        };
        self.placed().iter().map(without_error).sum()
    }

    /// Probability of each observation being right if the robot is at `pose`: the share of inliers
    /// in the mixture there.
    pub fn trust(&self, pose: Pose2) -> impl Iterator<Item = Trust> + '_ {
        let known = self.placed().iter().map(move |placed| {
            let density = density(placed, self.model(), pose);
            let probability = (density.right - density.ln()).exp().min(1.0);
            Trust { observation: placed.observation, probability }
        });
        let unknown = self.unknown().iter();
        known.chain(unknown.map(|&observation| Trust { observation, probability: 0.0 }))
    }
}

impl Likelihood for LandmarkLikelihood {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        kernel::rate(self, poses, log_weights);
    }
}

/// Probability of an observation being right, given a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trust {
    /// The observation.
    pub observation: LandmarkObservation,
    /// Probability that the observation is right; 0 where the map has no such landmark.
    pub probability: f64,
}

/// The parts of one observation's density.
struct Density {
    /// Logarithm of the density of a right observation, times the share of right ones.
    right: f64,
    /// The same of a wrong one.
    wrong: f64,
}

impl Density {
    fn ln(&self) -> f64 {
        let (less, more) = (self.right.min(self.wrong), self.right.max(self.wrong));
        if more > f64::NEG_INFINITY { more + (less - more).exp().ln_1p() } else { more }
    }
}

// ANCHOR: density
fn density(placed: &Placed, model: &ObservationModel, pose: Pose2) -> Density {
    let camera = pose * model.mounting;
    let way = placed.landmark - camera.position();
    let (expected, observed) = (way.norm(), placed.observation.observed);
    let mut right = peak(Some(expected), placed, model);
    if let Some(range) = observed.range() {
        right -= 0.5 * ((range - expected) / model.noise.range_sigma_at(expected)).powi(2);
    }
    // At a landmark its direction is undefined.
    if let Some(bearing) = observed.bearing().filter(|_| expected > 0.0) {
        let turn = angle::difference(bearing, way.y.atan2(way.x) - camera.theta);
        right -= 0.5 * (turn / model.noise.bearing_sigma).powi(2);
    }
    Density { right, wrong: wrong(placed, model) }
}
// ANCHOR_END: density

/// Logarithm of the normal densities' product without error, times the share of right observations.
fn peak(expected_range: Option<f64>, placed: &Placed, model: &ObservationModel) -> f64 {
    let normal = |sigma: f64| -sigma.ln() - 0.5 * TAU.ln();
    let range = || normal(model.noise.range_sigma_at(expected_range.unwrap_or(0.0)));
    let bearing = || normal(model.noise.bearing_sigma);
    (1.0 - model.outlier_share).ln()
        + match placed.observation.observed {
            Observed::RangeBearing { .. } => range() + bearing(),
            Observed::Range { .. } => range(),
            Observed::Bearing { .. } => bearing(),
        }
}

/// Logarithm of the uniform density of outliers, times their share.
fn wrong(placed: &Placed, model: &ObservationModel) -> f64 {
    let reach = match placed.observation.observed {
        Observed::RangeBearing { .. } => model.outlier_range * TAU,
        Observed::Range { .. } => model.outlier_range,
        Observed::Bearing { .. } => TAU,
    };
    (model.outlier_share / reach).ln()
}
