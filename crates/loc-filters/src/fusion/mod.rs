//! Sensor fusion: wheels, gyroscope, accelerometers, compass, satellites and landmarks in one
//! extended Kalman filter (H1).
//!
//! Each sensor measures a part of the motion, and each may stop sending. The filter has twelve states:
//! the pose, the speed and the turn rate, and the slowly varying errors of the sensors: the biases of gyroscope and accelerometers, scale and offset of
//! ranges, the drift of the satellite receiver. Between measurements it predicts to the stamp of
//! the next one, whichever sensor it comes from; a measurement with too large an innovation is
//! rejected by its gate. The variance of a state that no sensor measures grows, at its own rate.
//!
//! Measurements may arrive late, up to the horizon of the settings, see
//! [`delayed`](crate::delayed). Of one stamp, the kinds have an order of their own, so that the
//! result does not depend on which came first.
//!
//! ```
//! use loc_core::{Gaussian, Pose2, Twist2, gaussian::pose_belief};
//! use loc_filters::fusion::{FusedLocalizer, FusionSettings};
//! use loc_maps::LandmarkMap;
//! use nalgebra::{Matrix2, Vector2};
//!
//! let start = pose_belief(Pose2::IDENTITY, [1.0, 1.0, 0.1]);
//! let mut robot =
//!     FusedLocalizer::new(LandmarkMap::default(), FusionSettings::default(), 0.0, start)?;
//! for k in 0..100 {
//!     robot.odometry(0.1 * f64::from(k), Twist2::forward(1.0, 0.0))?;
//! }
//! let satellites = Gaussian::new(Vector2::new(10.0, 0.5), Matrix2::identity() * 4.0)?;
//! robot.position(9.95, satellites)?;
//! let belief = robot.estimate(10.0)?;
//! assert!((belief.pose().x - 10.0).abs() < 0.1);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod filter;
mod models;
pub mod state;

pub use models::{
    CompassModel, DirectionModel, DistanceModel, FusedMotion, InertialModel, ObservationModel,
    PositionModel, WheelModel,
};
pub use state::FusedBelief;

use crate::delayed::DelayedFilter;
use crate::lateration::BiasPrior;
use crate::smoother::Recorded;
use crate::{ExtendedKalmanFilter, Gate, Innovation, NonlinearFilter, Result};
use filter::{FilterState, Input};
use loc_core::error::{finite, non_negative, positive};
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::{Gaussian, Pose2, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::compass::CompassReading;
use loc_sensors::gnss::GnssNoise;
use loc_sensors::imu::{ImuReading, ImuSpec};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation};
use nalgebra::{Point2, SVector, Vector2};
use state::STATES;
use std::sync::Arc;

/// Localization with whatever sensors there are, on stamped inputs; with the extended Kalman filter,
/// unless another one is named.
#[derive(Debug, Clone)]
pub struct FusedLocalizer<F: NonlinearFilter<STATES> = ExtendedKalmanFilter<STATES>> {
    filter: DelayedFilter<FilterState<F>>,
    /// Between two samples of the inertial unit \[s\].
    period: f64,
}

impl FusedLocalizer {
    /// A robot with a belief over (x, y, theta) at `stamp` \[s\], and a map of landmarks, which may
    /// be empty.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief, a stamp or settings that are not valid.
    pub fn new(
        map: impl Into<Arc<LandmarkMap>>,
        settings: FusionSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        FusedLocalizer::with_filter(map, settings, stamp, start)
    }
}

impl<F: NonlinearFilter<STATES>> FusedLocalizer<F> {
    /// A robot with any filter.
    ///
    /// # Errors
    /// As [`FusedLocalizer::new`].
    pub fn with_filter(
        map: impl Into<Arc<LandmarkMap>>,
        settings: FusionSettings,
        stamp: f64,
        start: Gaussian<3>,
    ) -> Result<Self> {
        let stamp = loc_core::error::finite("start time [s]", stamp)?;
        let state = FilterState::new(map.into(), settings, stamp, &start)?;
        let filter = DelayedFilter::new(state, settings.horizon)?;
        Ok(FusedLocalizer { filter, period: 1.0 / settings.imu.rate })
    }

    /// The velocity that the wheels measured, from `stamp` \[s\] on.
    ///
    /// # Errors
    /// [`crate::Error::TooLate`]; [`crate::Error::NotFinite`] for the velocity;
    /// [`crate::Error::LostPositivity`].
    pub fn odometry(&mut self, stamp: f64, twist: Twist2) -> Result<FusionOutcome> {
        crate::innovation::finite("velocity of the wheels", &twist.to_vector())?;
        self.one("odometry", stamp, Input::Odometry(twist), FusionSensor::Wheels)
    }

    /// A sample of the inertial unit: the mean over one period of the settings' rate up to
    /// `stamp` \[s\], as units average. It is put where the period begins, so that the horizon
    /// must not be shorter.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::OutOfRange`].
    pub fn inertial(&mut self, stamp: f64, reading: ImuReading) -> Result<FusionOutcome> {
        reading.check()?;
        let from = stamp - self.period;
        self.one("inertial sample", from, Input::Inertial(reading), FusionSensor::Inertial)
    }

    /// A heading of the compass.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::OutOfRange`].
    pub fn compass(&mut self, stamp: f64, reading: CompassReading) -> Result<FusionOutcome> {
        reading.check()?;
        self.one("heading", stamp, Input::Compass(reading), FusionSensor::Compass)
    }

    /// A position of the satellite receiver's antenna in the map \[m\], with the covariance that
    /// the receiver claims.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::NotACovariance`].
    pub fn position(&mut self, stamp: f64, fix: Gaussian<2>) -> Result<FusionOutcome> {
        let fix = Gaussian::new(fix.mean, fix.covariance)?;
        self.one("position", stamp, Input::Position(fix), FusionSensor::Position)
    }

    /// Any number of landmarks seen at `stamp` \[s\]; the answer has one outcome for each.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry), and [`loc_core::Error::OutOfRange`] for observations
    /// that are not valid, none of which is then used.
    pub fn observations(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<FusionOutcome>> {
        for observation in observations {
            observation.sight.check()?;
        }
        self.filter.input("observations", stamp, Input::LandmarkObservations(observations.to_vec()))
    }

    /// The belief at a time \[s\]: predicted from the last input before it.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite,
    /// [`crate::Error::LostPositivity`].
    pub fn estimate(&self, stamp: f64) -> Result<FusedBelief> {
        loc_core::error::finite("stamp [s]", stamp)?;
        let mut state = self.filter.at(stamp).clone();
        state.predict_to(stamp)?;
        state.belief()
    }

    fn one(
        &mut self,
        what: &'static str,
        stamp: f64,
        input: Input,
        sensor: FusionSensor,
    ) -> Result<FusionOutcome> {
        let outcomes = self.filter.input(what, stamp, input)?;
        Ok(outcomes.first().copied().unwrap_or(FusionOutcome::rejected(sensor)))
    }
}

impl<F: NonlinearFilter<STATES>> FusedLocalizer<Recorded<F, STATES>> {
    /// Marks the belief at a time \[s\], to be smoothed later.
    ///
    /// # Errors
    /// As [`odometry`](FusedLocalizer::odometry).
    pub fn mark(&mut self, stamp: f64) -> Result<()> {
        self.filter.input("mark", stamp, Input::Mark).map(|_| ())
    }

    /// The smoothed belief at each mark, in the order of their times: from all inputs
    /// before and after, late ones included.
    ///
    /// # Errors
    /// Those of [`Smoother::smooth`](crate::smoother::Smoother::smooth).
    pub fn smooth(&self) -> Result<Vec<FusedBelief>> {
        let marked = self.filter.newest().past().smooth_marked()?;
        Ok(marked.into_iter().map(FusedBelief).collect())
    }
}

/// Settings of sensor fusion. Of a sensor that the robot does not have, the settings
/// do not matter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct FusionSettings {
    /// Rule that turns velocities into poses.
    pub integration: Integration,
    /// How far wheel odometry may be off (E7).
    pub motion_noise: VelocityNoise,
    /// How far observations of landmarks may be off.
    pub observation_noise: LandmarkNoise,
    /// The pose of the camera or the ranging antenna on the robot, `base_from_camera`.
    pub mounting: Pose2,
    /// What is known of the bias of ranges.
    pub range_bias: BiasPrior,
    /// Rate and errors of the inertial unit, which sits in the middle of the robot.
    pub imu: ImuSpec,
    /// Standard deviation of the compass \[rad\].
    pub compass_sigma: f64,
    /// Errors of the satellite receiver.
    pub gnss: GnssNoise,
    /// Place of the satellite receiver's antenna on the robot \[m\].
    pub antenna: Point2<f64>,
    /// How fast the speed changes while no accelerometer measures it, as a random walk
    /// \[m/s/sqrt(s)\].
    pub speed_walk: f64,
    /// How fast the speed changes beside what the accelerometer measures (floors are not level)
    /// \[m/s/sqrt(s)\].
    pub slope_walk: f64,
    /// How fast the turn rate changes, as a random walk \[rad/s/sqrt(s)\].
    pub turn_walk: f64,
    /// Standard deviation of the speed at the start, about 0 \[m/s\].
    pub start_speed: f64,
    /// Standard deviation of the turn rate at the start, about 0 \[rad/s\].
    pub start_turn: f64,
    /// Share of right measurements that the gate lets pass, 1 for no gate.
    pub gate_probability: f64,
    /// How late an input may come \[s\].
    pub horizon: f64,
}

impl FusionSettings {
    /// Checks every value and computes the gate.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the name of the first that is not allowed.
    pub fn check(&self) -> Result<Gate> {
        self.motion_noise.check()?;
        self.observation_noise.check()?;
        positive("sigma of the range [m]", self.observation_noise.range_sigma)?;
        positive("sigma of the bearing [rad]", self.observation_noise.bearing_sigma)?;
        for value in [self.mounting.x, self.mounting.y, self.mounting.theta] {
            finite("mounting of the camera [m, m, rad]", value)?;
        }
        self.range_bias.check()?;
        finite("prior sigma of the range scale", self.range_bias.scale_sigma)?;
        finite("prior sigma of the range offset [m]", self.range_bias.offset_sigma)?;
        self.imu.check()?;
        positive("sigma of the compass [rad]", self.compass_sigma)?;
        self.gnss.check()?;
        positive("white sigma of a position [m]", self.gnss.white_sigma)?;
        finite("place of the satellite antenna [m]", self.antenna.x)?;
        finite("place of the satellite antenna [m]", self.antenna.y)?;
        positive("walk of the speed [m/s/sqrt(s)]", self.speed_walk)?;
        non_negative("walk of the speed on slopes [m/s/sqrt(s)]", self.slope_walk)?;
        positive("walk of the turn rate [rad/s/sqrt(s)]", self.turn_walk)?;
        non_negative("speed at the start [m/s]", self.start_speed)?;
        non_negative("turn rate at the start [rad/s]", self.start_turn)?;
        non_negative("horizon for late inputs [s]", self.horizon)?;
        Gate::probability(self.gate_probability)
    }
}

impl Default for FusionSettings {
    /// A small robot on wheels. Ranges have the bias of radio ranging out of the box: a scale known
    /// to 10 %, an offset known to 20 cm.
    fn default() -> Self {
        FusionSettings {
            integration: Integration::ExactArc,
            motion_noise: VelocityNoise::default(),
            observation_noise: LandmarkNoise::default(),
            mounting: Pose2::IDENTITY,
            range_bias: BiasPrior { scale_sigma: 0.1, offset_sigma: 0.2 },
            imu: ImuSpec::default(),
            compass_sigma: 2_f64.to_radians(),
            gnss: GnssNoise::neo_m8(),
            antenna: Point2::origin(),
            speed_walk: 1.0,
            slope_walk: 0.02,
            turn_walk: 1.0,
            start_speed: 0.5,
            start_turn: 0.5,
            gate_probability: 0.999,
            horizon: 2.0,
        }
    }
}

/// The sensor that measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FusionSensor {
    /// Wheel odometry.
    Wheels,
    /// The inertial unit.
    Inertial,
    /// The compass.
    Compass,
    /// The satellite receiver.
    Position,
    /// The camera or the ranging radio, with the landmark's number.
    Landmark(u32),
}

/// What the filter made of one measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FusionOutcome {
    /// The sensor.
    pub sensor: FusionSensor,
    /// Whether it changed the belief.
    pub accepted: bool,
    /// Normalised innovation squared; `None` for a landmark that the map does not have.
    pub nis: Option<f64>,
    /// Dimension of the measurement: 0, 1 or 2.
    pub degrees_of_freedom: usize,
    whitened: Vector2<f64>,
}

impl FusionOutcome {
    /// A measurement that nothing is expected of.
    fn rejected(sensor: FusionSensor) -> Self {
        let whitened = Vector2::zeros();
        FusionOutcome { sensor, accepted: false, nis: None, degrees_of_freedom: 0, whitened }
    }

    fn of<const M: usize>(sensor: FusionSensor, innovation: &Innovation<M>) -> Self {
        let part = |vector: &SVector<f64, M>, k: usize| vector.get(k).copied().unwrap_or(0.0);
        FusionOutcome {
            sensor,
            accepted: innovation.accepted,
            nis: Some(innovation.nis),
            degrees_of_freedom: M.min(2),
            whitened: Vector2::from_fn(|k, _| part(&innovation.whitened, k)),
        }
    }

    /// The innovation in units of its standard deviations: as many independent numbers of variance
    /// 1 as there are degrees of freedom.
    pub fn whitened(&self) -> &[f64] {
        &self.whitened.as_slice()[..self.degrees_of_freedom.min(2)]
    }
}
