//! The landmark filter (H2), with its motion and measurement models and the outcome of an observation.

use super::LandmarkSettings;
use crate::extended::{LinearizedMotion, MeasurementModel, MotionModel};
use crate::{
    Error, ExtendedKalmanFilter, Gate, Innovation, NonlinearFilter, Result, UnscentedKalmanFilter,
};
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::{Gaussian, Pose2, Twist2, angle};
use loc_maps::LandmarkMap;
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::{Matrix1, Matrix1x3, Matrix2, Matrix2x3, Point2, Vector1, Vector2, Vector3};

/// A Kalman filter over (x, y, theta) \[m, m, rad\] with known landmarks: [`LandmarkEkf`] or
/// [`LandmarkUkf`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandmarkFilter<F> {
    filter: F,
    settings: LandmarkSettings,
    gate: Gate,
}

/// The extended Kalman filter (H2).
pub type LandmarkEkf = LandmarkFilter<ExtendedKalmanFilter<3>>;

/// The unscented Kalman filter on the same models.
pub type LandmarkUkf = LandmarkFilter<UnscentedKalmanFilter<3>>;

impl<F: NonlinearFilter<3>> LandmarkFilter<F> {
    /// A filter that starts from a belief over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief or settings that are not valid.
    pub fn new(start: Gaussian<3>, settings: LandmarkSettings) -> Result<Self> {
        let gate = settings.gate()?;
        let filter = F::start(start, &[2])?;
        Ok(LandmarkFilter { filter, settings, gate })
    }

    /// The current belief.
    pub fn belief(&self) -> &Gaussian<3> {
        self.filter.belief()
    }

    /// Prediction with velocity `twist` for `dt` \[s\].
    ///
    /// # Errors
    /// [`Error::NotFinite`] for the velocity, [`loc_core::Error::OutOfRange`] for a negative time.
    pub fn predict(&mut self, twist: Twist2, dt: f64) -> Result<()> {
        crate::innovation::finite("velocity", &twist.to_vector())?;
        loc_core::error::non_negative("time step [s]", dt)?;
        let LandmarkSettings { integration, motion_noise: noise, .. } = self.settings;
        self.filter.predict(&VelocityMotion { twist, dt, integration, noise })
    }

    /// The filter on the models of this module.
    pub(super) fn filter(&self) -> &F {
        &self.filter
    }

    /// See [`NonlinearFilter::mark`].
    pub(super) fn mark(&mut self) {
        self.filter.mark();
    }

    /// Corrects with one observation. Several of one moment are given one after the other; each is
    /// then linearised where the one before has led, and gated for itself.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for an observation that is not finite or has a negative range.
    pub fn correct(
        &mut self,
        map: &LandmarkMap,
        observation: &LandmarkObservation,
    ) -> Result<Outcome> {
        let sight = observation.sight.check()?;
        let verdict = match map.get(observation.landmark) {
            None => Verdict::UnknownLandmark,
            Some(landmark) => {
                let LandmarkSettings { mounting, observation_noise: noise, .. } = self.settings;
                let landmark = landmark.position.xy();
                self.judge(sight, RangeBearingModel { landmark, mounting, noise })?
            }
        };
        Ok(Outcome { landmark: observation.landmark, verdict })
    }

    fn judge(&mut self, sight: Observed, model: RangeBearingModel) -> Result<Verdict, Error> {
        let (filter, gate) = (&mut self.filter, &self.gate);
        Ok(match sight {
            Observed::RangeBearing { range, bearing } => {
                let z = Vector2::new(range, bearing);
                Verdict::RangeBearing(filter.correct(&model, &z, gate)?)
            }
            Observed::Range { range } => {
                Verdict::Range(filter.correct(&RangeModel(model), &Vector1::new(range), gate)?)
            }
            Observed::Bearing { bearing } => Verdict::Bearing(filter.correct(
                &BearingModel(model),
                &Vector1::new(bearing),
                gate,
            )?),
        })
    }
}

/// A step at constant velocity (E2), with the lectures' error model (E7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VelocityMotion {
    /// The velocity.
    pub twist: Twist2,
    /// How long it lasts \[s\].
    pub dt: f64,
    /// The rule that makes a pose of it.
    pub integration: Integration,
    /// How far it may be off.
    pub noise: VelocityNoise,
}

impl MotionModel<3> for VelocityMotion {
    fn predict(&self, state: &Vector3<f64>) -> Vector3<f64> {
        self.integration.step(Pose2::from_vector(state), self.twist, self.dt).to_vector()
    }

    fn linearize(&self, state: &Vector3<f64>) -> LinearizedMotion<3> {
        let pose = Pose2::from_vector(state);
        let (moved, f) = self.integration.step_with_jacobians(pose, self.twist, self.dt);
        let control = self.noise.covariance(self.twist, self.dt);
        LinearizedMotion {
            state: moved.to_vector(),
            jacobian: f.by_pose,
            noise: f.by_twist * control * f.by_twist.transpose(),
        }
    }
}

/// Distance and direction of one landmark from a camera on the robot.
///
/// `h = (r, atan2(y_i - y, x_i - x) - theta)`, seen from the camera's place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeBearingModel {
    /// The landmark in the map \[m\].
    pub landmark: Point2<f64>,
    /// The camera on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// How far sights may be off.
    pub noise: LandmarkNoise,
}

/// Nearer than this \[m\] a landmark has no direction that a linear filter could use.
const NEAREST: f64 = 1e-3;

/// The camera and the landmark, as the robot at some pose sees them.
struct View {
    /// From the robot to its camera, in the map \[m\].
    lever: (f64, f64),
    /// From the camera to the landmark, in the map \[m\].
    offset: (f64, f64),
    /// Heading of the camera \[rad\].
    heading: f64,
}

impl RangeBearingModel {
    fn view(&self, state: &Vector3<f64>) -> View {
        let (sin, cos) = state.z.sin_cos();
        let (x, y) = (self.mounting.x, self.mounting.y);
        let lever = (cos * x - sin * y, sin * x + cos * y);
        let offset = (self.landmark.x - state.x - lever.0, self.landmark.y - state.y - lever.1);
        View { lever, offset, heading: state.z + self.mounting.theta }
    }
}

impl View {
    // ANCHOR: range-bearing
    fn predict(&self) -> Vector2<f64> {
        let (dx, dy) = self.offset;
        let range = (dx * dx + dy * dy).sqrt();
        Vector2::new(range, angle::wrap(dy.atan2(dx) - self.heading))
    }

    fn jacobian(&self, range: f64) -> Matrix2x3<f64> {
        let per_r = 1.0 / range.max(NEAREST);
        let (ux, uy) = (self.offset.0 * per_r, self.offset.1 * per_r);
        // As the robot turns, its camera moves at a right angle to the lever arm.
        let (lever_x, lever_y) = self.lever;
        let range_by_theta = ux * lever_y - uy * lever_x;
        let bearing_by_theta = -1.0 - (ux * lever_x + uy * lever_y) * per_r;
        Matrix2x3::new(-ux, -uy, range_by_theta, uy * per_r, -ux * per_r, bearing_by_theta)
    }
    // ANCHOR_END: range-bearing
}

impl MeasurementModel<3, 2> for RangeBearingModel {
    fn predict(&self, state: &Vector3<f64>) -> Vector2<f64> {
        self.view(state).predict()
    }

    /// Rows `[(x-x_i)/r, (y-y_i)/r, .]` and `[-(y-y_i)/r^2, (x-x_i)/r^2, .]`; the last column
    /// moves the camera round the robot's centre, and is (0, -1) for a camera there.
    fn jacobian(&self, state: &Vector3<f64>) -> Matrix2x3<f64> {
        self.linearize(state).1
    }

    fn linearize(&self, state: &Vector3<f64>) -> (Vector2<f64>, Matrix2x3<f64>) {
        let view = self.view(state);
        let expected = view.predict();
        (expected, view.jacobian(expected.x))
    }

    fn noise(&self, expected: &Vector2<f64>) -> Matrix2<f64> {
        let range_sigma = self.noise.range_sigma_at(expected.x);
        let bearing_sigma = self.noise.bearing_sigma;
        Matrix2::from_diagonal(&Vector2::new(range_sigma.powi(2), bearing_sigma.powi(2)))
    }

    fn residual(&self, z: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(z.x - expected.x, angle::difference(z.y, expected.y))
    }
}

/// The distance alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeModel(pub RangeBearingModel);

impl MeasurementModel<3, 1> for RangeModel {
    fn predict(&self, state: &Vector3<f64>) -> Vector1<f64> {
        Vector1::new(self.0.predict(state).x)
    }

    fn jacobian(&self, state: &Vector3<f64>) -> Matrix1x3<f64> {
        self.0.jacobian(state).row(0).into()
    }

    fn noise(&self, expected: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(self.0.noise.range_sigma_at(expected.x).powi(2))
    }
}

/// The direction alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BearingModel(pub RangeBearingModel);

impl MeasurementModel<3, 1> for BearingModel {
    fn predict(&self, state: &Vector3<f64>) -> Vector1<f64> {
        Vector1::new(self.0.predict(state).y)
    }

    fn jacobian(&self, state: &Vector3<f64>) -> Matrix1x3<f64> {
        self.0.jacobian(state).row(1).into()
    }

    fn noise(&self, _expected: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(self.0.noise.bearing_sigma.powi(2))
    }

    fn residual(&self, z: &Vector1<f64>, expected: &Vector1<f64>) -> Vector1<f64> {
        Vector1::new(angle::difference(z.x, expected.x))
    }
}

/// An observation's landmark and what the filter made of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// The number that was read off the landmark.
    pub landmark: u32,
    /// What was done with it, and why.
    pub verdict: Verdict,
}

/// What the filter made of an observation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// The map has no landmark of this number; nothing was changed.
    UnknownLandmark,
    /// Range and bearing were compared with the expectation.
    RangeBearing(Innovation<2>),
    /// The distance was.
    Range(Innovation<1>),
    /// The direction was.
    Bearing(Innovation<1>),
}

impl Outcome {
    /// Whether the observation changed the belief.
    pub fn accepted(&self) -> bool {
        match &self.verdict {
            Verdict::UnknownLandmark => false,
            Verdict::RangeBearing(innovation) => innovation.accepted,
            Verdict::Range(innovation) | Verdict::Bearing(innovation) => innovation.accepted,
        }
    }

    /// The normalised innovation squared; `None` for an unknown landmark.
    pub fn nis(&self) -> Option<f64> {
        match &self.verdict {
            Verdict::UnknownLandmark => None,
            Verdict::RangeBearing(innovation) => Some(innovation.nis),
            Verdict::Range(innovation) | Verdict::Bearing(innovation) => Some(innovation.nis),
        }
    }

    /// How many numbers were measured: the mean of the NIS of a consistent filter.
    pub fn degrees_of_freedom(&self) -> usize {
        match &self.verdict {
            Verdict::UnknownLandmark => 0,
            Verdict::RangeBearing(_) => 2,
            Verdict::Range(_) | Verdict::Bearing(_) => 1,
        }
    }
}
