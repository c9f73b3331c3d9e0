//! Landmarks of known places, seen by distance, direction or both (M5).
//!
//! From a particle's pose follows where each landmark should have been seen; the nearer the
//! observation is to that, the larger the particle's weight:
//! `p = prod_j N(r_j - r_j*; s_r) N(phi_j - phi_j*; s_phi)`. Now and then a number is misread. So
//! that one such observation does not rule out the right pose, each factor is a mixture with a small
//! even density over everything that a camera can report.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_maps::{Landmark, LandmarkMap};
//! use loc_pf::{ParticleFilter, Particles};
//! use loc_pf::sensor::landmark::{LandmarkLikelihood, ObservationModel};
//! use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
//!
//! let map = LandmarkMap::new([Landmark::planar(7, 3.0, 4.0)])?;
//! let sight = Observed::RangeBearing { range: 5.0, bearing: 4_f64.atan2(3.0) };
//! let seen = [LandmarkObservation { landmark: 7, sight }, LandmarkObservation { landmark: 99, sight }];
//! let likelihood = LandmarkLikelihood::new(&map, &seen, &ObservationModel::default())?;
//! assert_eq!(likelihood.unknown(), [seen[1]]);
//! let there = likelihood.log_likelihood(Pose2::IDENTITY);
//! assert!(there > likelihood.log_likelihood(Pose2::new(0.1, 0.0, 0.0)));
//!
//! let cloud = Particles::from_poses([Pose2::IDENTITY, Pose2::new(0.2, 0.0, 0.0)]);
//! let mut filter = ParticleFilter::new(cloud, stream(1, "filter"));
//! filter.weigh(&likelihood);
//! filter.normalize();
//! assert!(filter.particles().weight(0) > 0.8);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod kernel;
mod plain;
mod resetting;
mod single;

pub use plain::Trust;
pub use resetting::SensorResetting;
pub(crate) use resetting::anywhere;

use super::Likelihood;
use crate::{Poses, Result};
use kernel::Seen;
use loc_core::Pose2;
use loc_core::error::{finite, in_range, non_negative, positive};
use loc_maps::LandmarkMap;
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation};
use nalgebra::Point2;

/// How observations come about.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ObservationModel {
    /// How far a right observation may be off; both sigmas above 0.
    pub noise: LandmarkNoise,
    /// The camera's pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Share of observations that say nothing, such as misread numbers, in \[0, 1).
    pub outlier_share: f64,
    /// Distance up to which landmarks are seen \[m\]: the wrong ones lie anywhere within it.
    pub outlier_range: f64,
}

impl Default for ObservationModel {
    /// 5 cm and 1 degree at the robot's centre; one observation in a hundred is wrong, up to 10 m away.
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
    pub fn validate(&self) -> Result<()> {
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

/// LandmarkObservations of one moment before a map, ready to rate poses.
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

/// An observation with the place of its landmark in the map \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placed {
    pub(crate) landmark: Point2<f64>,
    pub(crate) observation: LandmarkObservation,
}

impl LandmarkLikelihood {
    /// Looks the observations up in the map. Numbers that the map has not are left out, see
    /// [`unknown`](LandmarkLikelihood::unknown).
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for observations and models that are not valid.
    pub fn new(
        map: &LandmarkMap,
        observations: &[LandmarkObservation],
        model: &ObservationModel,
    ) -> Result<Self> {
        model.validate()?;
        let (mut placed, mut unknown) = (Vec::with_capacity(observations.len()), Vec::new());
        for observation in observations {
            observation.sight.check()?;
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

    /// The observations that rate, with the places of their landmarks.
    pub(crate) fn placed(&self) -> &[Placed] {
        &self.observations
    }

    /// How the observations come about.
    pub fn model(&self) -> &ObservationModel {
        &self.model
    }
}

impl Likelihood for LandmarkLikelihood {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        kernel::rate(self, poses, log_weights);
    }
}
