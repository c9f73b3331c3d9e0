//! A camera that recognises landmarks with known data association (B6, numbered landmarks): their
//! distance, their direction, or both.
//!
//! A [`LandmarkObservation`] is what such a camera reports of one landmark. [`LandmarkNoise`] says
//! how far it may be off, [`LandmarkCamera`] simulates it, with its field of view, missed
//! detections and wrong numbers, and [`CameraCalibration`] corrects what a real one reports.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::landmark_camera::{LandmarkCamera, LandmarkNoise, Observed};
//! use loc_sensors::world::Landmarks;
//! let camera = LandmarkCamera { noise: LandmarkNoise::NONE, ..LandmarkCamera::default() };
//! let world = Landmarks::from([(5, [3.0, 4.0])]);
//! let seen = camera.observe(&world, Pose2::IDENTITY, &mut stream(1, "camera"));
//! assert!(matches!(seen[0].observed, Observed::RangeBearing { range, .. } if range == 5.0));
//! ```

use crate::Result;
use crate::world::LandmarkWorld;
use loc_core::error::{finite, non_negative, positive, probability};
use loc_core::{Pose2, angle};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// One landmark as the camera reports it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LandmarkObservation {
    /// Number (identity) of the landmark; it may be wrong.
    pub landmark: u32,
    /// Where it was seen.
    pub observed: Observed,
}

/// Where a landmark was seen from the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Observed {
    /// Distance \[m\] and direction, counter-clockwise from the camera's axis \[rad\].
    RangeBearing {
        /// Distance \[m\].
        range: f64,
        /// Direction \[rad\].
        bearing: f64,
    },
    /// Distance only \[m\].
    Range {
        /// Distance \[m\].
        range: f64,
    },
    /// Direction only \[rad\].
    Bearing {
        /// Direction \[rad\].
        bearing: f64,
    },
}

/// Which of the two numbers a camera delivers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ObservedKind {
    /// Distance and direction.
    #[default]
    RangeBearing,
    /// Distance only.
    Range,
    /// Direction only.
    Bearing,
}

impl Observed {
    /// An observation of the given kind, from a distance \[m\] and a direction \[rad\].
    pub fn new(kind: ObservedKind, range: f64, bearing: f64) -> Self {
        match kind {
            ObservedKind::RangeBearing => Observed::RangeBearing { range, bearing },
            ObservedKind::Range => Observed::Range { range },
            ObservedKind::Bearing => Observed::Bearing { bearing },
        }
    }

    /// The distance \[m\], where it was measured.
    pub fn range(self) -> Option<f64> {
        match self {
            Observed::RangeBearing { range, .. } | Observed::Range { range } => Some(range),
            Observed::Bearing { .. } => None,
        }
    }

    /// The direction \[rad\], where it was measured.
    pub fn bearing(self) -> Option<f64> {
        match self {
            Observed::RangeBearing { bearing, .. } | Observed::Bearing { bearing } => Some(bearing),
            Observed::Range { .. } => None,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative distance, and for NaN and infinity.
    pub fn check(self) -> Result<Self> {
        self.range().map_or(Ok(0.0), |range| non_negative("range to a landmark [m]", range))?;
        self.bearing().map_or(Ok(0.0), |bearing| finite("bearing of a landmark [rad]", bearing))?;
        Ok(self)
    }
}

/// Independent normal errors of distance and direction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LandmarkNoise {
    /// Standard deviation of the distance at the camera \[m\]; also known as sigma_r.
    pub range_sigma: f64,
    /// Its growth with the distance \[m/m\].
    #[cfg_attr(feature = "serde", serde(default))]
    pub range_sigma_per_m: f64,
    /// Standard deviation of the direction \[rad\]; also known as sigma_phi.
    #[cfg_attr(feature = "serde", serde(with = "loc_core::settings::angle"))]
    pub bearing_sigma: f64,
}

impl LandmarkNoise {
    /// A perfect camera.
    pub const NONE: LandmarkNoise =
        LandmarkNoise { range_sigma: 0.0, range_sigma_per_m: 0.0, bearing_sigma: 0.0 };

    /// Standard deviation of a distance of `range` \[m\].
    pub fn range_sigma_at(&self, range: f64) -> f64 {
        self.range_sigma + self.range_sigma_per_m * range
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for negative values, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        non_negative("sigma of the range [m]", self.range_sigma)?;
        non_negative("growth of the range's sigma [m/m]", self.range_sigma_per_m)?;
        non_negative("sigma of the bearing [rad]", self.bearing_sigma)?;
        Ok(())
    }
}

impl Default for LandmarkNoise {
    /// 5 cm and 1 degree, as a small camera on a desk-sized robot reaches.
    fn default() -> Self {
        LandmarkNoise {
            range_sigma: 0.05,
            range_sigma_per_m: 0.0,
            bearing_sigma: 1_f64.to_radians(),
        }
    }
}

/// Converts a recorded observation to distance and direction from the camera.
///
/// A camera that infers the distance from a landmark's size in the image measures the *depth*
/// along its optical axis, not the distance: `reported = scale * distance * cos(bearing)`. The
/// error is nothing straight ahead and a seventh at 30 degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct CameraCalibration {
    /// Factor by which reported distances are too long (focal length).
    pub range_scale: f64,
    /// Whether the reported distance is the depth along the optical axis. Needs a bearing.
    pub range_is_depth: bool,
    /// Angle added to every direction by a camera turned on its mount \[rad\].
    #[cfg_attr(feature = "serde", serde(with = "loc_core::settings::angle"))]
    pub bearing_bias: f64,
    /// Time from the observation to its stamp \[s\].
    pub delay: f64,
}

impl CameraCalibration {
    /// No correction.
    pub const NONE: CameraCalibration = CameraCalibration {
        range_scale: 1.0,
        range_is_depth: false,
        bearing_bias: 0.0,
        delay: 0.0,
    };

    /// Beyond this direction \[rad\] a depth determines the distance poorly.
    pub const WIDEST_DEPTH_BEARING: f64 = 1.4;

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a scale that is not positive, and for values that are not
    /// finite.
    pub fn check(&self) -> Result<()> {
        positive("range scale", self.range_scale)?;
        finite("bearing bias [rad]", self.bearing_bias)?;
        finite("camera delay [s]", self.delay)?;
        Ok(())
    }

    /// Distance and direction of a recorded observation.
    ///
    /// A depth at a wider direction than [`Self::WIDEST_DEPTH_BEARING`] keeps its direction only.
    pub fn correct(&self, recorded: Observed) -> Observed {
        match recorded {
            Observed::RangeBearing { range, bearing } => self.correct_both(range, bearing),
            Observed::Range { range } => Observed::Range { range: range / self.range_scale },
            Observed::Bearing { bearing } => {
                Observed::Bearing { bearing: bearing - self.bearing_bias }
            }
        }
    }

    fn correct_both(&self, range: f64, bearing: f64) -> Observed {
        let direction = bearing - self.bearing_bias;
        let range = range / self.range_scale;
        if !self.range_is_depth {
            return Observed::RangeBearing { range, bearing: direction };
        }
        // The optical axis turns with the camera, so the depth follows the reported direction.
        if bearing.abs() > Self::WIDEST_DEPTH_BEARING {
            return Observed::Bearing { bearing: direction };
        }
        Observed::RangeBearing { range: range / bearing.cos(), bearing: direction }
    }
}

impl Default for CameraCalibration {
    fn default() -> Self {
        CameraCalibration::NONE
    }
}

/// A landmark camera on a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LandmarkCamera {
    /// The camera's pose on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// Opening angle, half of it to each side \[rad\]; a full turn sees everything.
    #[cfg_attr(feature = "serde", serde(with = "loc_core::settings::angle"))]
    pub fov: f64,
    /// Nearest distance \[m\].
    pub min_range: f64,
    /// Farthest distance \[m\].
    pub max_range: f64,
    /// Which numbers it delivers.
    pub kind: ObservedKind,
    /// Probability that a landmark in view is detected.
    pub detection_probability: f64,
    /// Probability that a detected landmark gets the number of another one in reach.
    pub wrong_identity_probability: f64,
    /// Errors of distance and direction.
    pub noise: LandmarkNoise,
}

impl LandmarkCamera {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for an opening angle or range that is not positive,
    /// probabilities outside \[0, 1\], or bad noise.
    pub fn check(&self) -> Result<()> {
        positive("field of view [rad]", self.fov)?;
        non_negative("nearest range [m]", self.min_range)?;
        positive("farthest range [m] minus nearest", self.max_range - self.min_range)?;
        probability("detection probability", self.detection_probability)?;
        probability("wrong identity probability", self.wrong_identity_probability)?;
        self.noise.check()
    }

    /// Where the camera sees a point of the map: distance \[m\] and direction \[rad\], without
    /// noise; `None` out of view.
    fn view(&self, camera: Pose2, landmark: &nalgebra::Point2<f64>) -> Option<(f64, f64)> {
        let (dx, dy) = (landmark.x - camera.x, landmark.y - camera.y);
        let range = f64::hypot(dx, dy);
        let bearing = angle::wrap(dy.atan2(dx) - camera.theta);
        let in_reach = (self.min_range..=self.max_range).contains(&range);
        (in_reach && bearing.abs() <= 0.5 * self.fov).then_some((range, bearing))
    }

    /// What the camera reports from a robot at `pose`, in the world's order.
    pub fn observe<R: Rng + ?Sized>(
        &self,
        world: &(impl LandmarkWorld + ?Sized),
        pose: Pose2,
        rng: &mut R,
    ) -> Vec<LandmarkObservation> {
        let camera = pose * self.mounting;
        let mut in_reach = Vec::new();
        world.visit_landmarks(&camera.position(), self.max_range, &mut |id, position| {
            in_reach.push((id, position));
        });
        let mut observations = Vec::new();
        for (id, position) in &in_reach {
            let Some((range, bearing)) = self.view(camera, position) else {
                continue;
            };
            if rng.random::<f64>() < self.detection_probability {
                let landmark = self.identity(*id, &in_reach, rng);
                observations.push(LandmarkObservation {
                    landmark,
                    observed: self.blur(range, bearing, rng),
                });
            }
        }
        observations
    }

    fn blur<R: Rng + ?Sized>(&self, range: f64, bearing: f64, rng: &mut R) -> Observed {
        let mut draw = || -> f64 { StandardNormal.sample(rng) };
        let range = range + self.noise.range_sigma_at(range) * draw();
        let bearing = angle::wrap(bearing + self.noise.bearing_sigma * draw());
        Observed::new(self.kind, range.max(0.0), bearing)
    }

    /// The identity reported for a landmark, with a small probability that of another one in reach.
    fn identity<R: Rng + ?Sized, P>(&self, id: u32, in_reach: &[(u32, P)], rng: &mut R) -> u32 {
        let wrong = rng.random::<f64>() < self.wrong_identity_probability;
        let others: Vec<u32> = in_reach.iter().map(|(n, _)| *n).filter(|n| *n != id).collect();
        if wrong && !others.is_empty() { others[rng.random_range(0..others.len())] } else { id }
    }
}

impl Default for LandmarkCamera {
    /// Sees all around up to 10 m, without misses.
    fn default() -> Self {
        LandmarkCamera {
            mounting: Pose2::IDENTITY,
            fov: TAU,
            min_range: 0.0,
            max_range: 10.0,
            kind: ObservedKind::RangeBearing,
            detection_probability: 1.0,
            wrong_identity_probability: 0.0,
            noise: LandmarkNoise::default(),
        }
    }
}
