//! The landmark filter (H2), with its motion and measurement models and the outcome of an observation.

use crate::divergence::Widening;
use crate::extended::{LinearizedMotion, MeasurementModel, MotionModel};
use crate::localizer::{Decision, Outcome};
use crate::{
    ExtendedKalmanFilter, Gate, NonlinearFilter, Result, RobotSettings, UnscentedKalmanFilter,
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
    settings: RobotSettings,
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
    pub fn new(start: Gaussian<3>, settings: RobotSettings) -> Result<Self> {
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
    /// [`crate::Error::NotFinite`] for the velocity, [`loc_core::Error::OutOfRange`] for a negative time.
    pub fn predict(&mut self, twist: Twist2, dt: f64) -> Result<()> {
        crate::innovation::finite("velocity", &twist.to_vector())?;
        loc_core::error::non_negative("time step [s]", dt)?;
        let RobotSettings { integration, odometry: noise, .. } = self.settings;
        self.filter.predict(&VelocityMotion { twist, dt, integration, noise })
    }

    /// Widens the belief by a gap between observations and what was expected \[m\].
    pub(super) fn widen_by(&mut self, gap: f64) -> Result<()> {
        self.filter.predict(&Widening::by(gap))
    }

    /// The settings.
    pub fn settings(&self) -> &RobotSettings {
        &self.settings
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
        let observed = observation.observed.check()?;
        let id = observation.landmark;
        let Some(landmark) = map.get(id) else {
            return Ok(Outcome::of(Decision::UnknownLandmark).with_landmark(id));
        };
        let RobotSettings { mounting, camera: noise, .. } = self.settings;
        let landmark = landmark.position.xy();
        let model = RangeBearingModel { landmark, mounting, noise };
        let (filter, gate) = (&mut self.filter, &self.gate);
        let outcome = match observed {
            Observed::RangeBearing { range, bearing } => {
                let z = Vector2::new(range, bearing);
                Outcome::of_innovation(&filter.correct(&model, &z, gate)?)
            }
            Observed::Range { range } => {
                let z = Vector1::new(range);
                Outcome::of_innovation(&filter.correct(&RangeModel(model), &z, gate)?)
            }
            Observed::Bearing { bearing } => {
                let z = Vector1::new(bearing);
                Outcome::of_innovation(&filter.correct(&BearingModel(model), &z, gate)?)
            }
        };
        Ok(outcome.with_landmark(id))
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
