//! The fused filter at the stamp of its last input, and the algorithm of an input: predict to its stamp,
//! then correct with it. Measurements of the velocity hold until the next one is due.

use super::FusionSettings;
use super::models::{
    CompassModel, DirectionModel, DistanceModel, FusedMotion, InertialModel, ObservationModel,
    PositionModel, RandomWalk, WheelModel,
};
use super::state::{
    DRIFT_X, DRIFT_Y, FORWARD_BIAS, FusedBelief, GYRO_BIAS, LEFT_BIAS, RANGE_OFFSET, RANGE_SCALE,
    SPEED, STATES, Square, TURN,
};
use crate::RobotSettings;
use crate::delayed::Sequential;
use crate::divergence::{DivergenceMonitor, Widening, gap};
use crate::landmark::RangeBearingModel;
use crate::localizer::{Decision, Estimate, Localizer, Outcome, SensorError, observed_position};
use crate::smoother::{Recorded, Smoothable};
use crate::{Error, ExtendedKalmanFilter, Gate, NonlinearFilter, Result};
use loc_core::error::{finite, positive};
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::compass::CompassReading;
use loc_sensors::event::{Control, Measurement, Payload};
use loc_sensors::imu::ImuReading;
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix2, Vector1, Vector2};
use std::sync::Arc;

/// How fast the speed changes beside what the accelerometer measures (floors are not level)
/// \[m/s/sqrt(s)\].
const SLOPE_WALK: f64 = 0.02;

/// A stretch without a measurement of the velocity is cut into pieces of this length, so that its
/// random walk reaches the pose \[s\].
const PIECE: f64 = 0.1;
/// More pieces than this are not worth their time.
const MAX_PIECES: f64 = 1000.0;
/// Rounding of what wheels report: 1 mm/s, 1 mrad/s.
const WHEEL_ROUNDING: f64 = 1e-6;

/// The errors of sensors that the filter reports, with the factor of their unit.
const ERRORS: [(usize, &str, f64); 7] = [
    (GYRO_BIAS, "gyroscope [deg/s]", 180.0 / std::f64::consts::PI),
    (FORWARD_BIAS, "accelerometer forward [m/s^2]", 1.0),
    (LEFT_BIAS, "accelerometer left [m/s^2]", 1.0),
    (RANGE_SCALE, "range scale", 1.0),
    (RANGE_OFFSET, "range offset [m]", 1.0),
    (DRIFT_X, "satellites east [m]", 1.0),
    (DRIFT_Y, "satellites north [m]", 1.0),
];

/// Localization with whatever sensors there are, over time-stamped inputs in order;
/// [`Delayed`](crate::delayed::Delayed) around it takes late ones. The filter is the extended Kalman
/// filter, unless another one is named.
///
/// It predicts with velocities of the wheels ([`Control::Velocity`]) and corrects with landmarks,
/// headings of a compass, positions of a satellite receiver's antenna in the map with the covariance
/// that the receiver claims, and samples of an inertial unit. Such a sample is the mean over one
/// period of the settings' rate up to its stamp; it acts from the beginning of the period on, so that
/// the horizon of `Delayed` must not be shorter than that.
#[derive(Debug, Clone)]
pub struct FusedLocalizer<F: NonlinearFilter<STATES> = ExtendedKalmanFilter<STATES>> {
    filter: F,
    settings: FusionSettings,
    gate: Gate,
    map: Arc<LandmarkMap>,
    stamp: f64,
    wheels: SensorTiming,
    inertial: SensorTiming,
    acceleration: f64,
    sideways: f64,
    /// What the velocity has pending_walk since it was measured last.
    pending_walk: RandomWalk,
    steps: u64,
    sensors: Sensors,
    divergence: DivergenceMonitor,
    /// When the filter had diverged last \[s\].
    diverged_at: f64,
}

/// The sensors that have measured so far.
#[derive(Debug, Clone, Copy, Default)]
struct Sensors {
    landmarks: bool,
    inertial: bool,
    satellites: bool,
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
        settings.check()?;
        let gate = settings.robot.gate()?;
        positive("white sigma of a position [m]", settings.gnss.white_sigma)?;
        finite("prior sigma of the range scale", settings.range_bias.scale_sigma)?;
        finite("prior sigma of the range offset [m]", settings.range_bias.offset_sigma)?;
        let belief = super::state::belief(&settings, &start)?;
        Ok(FusedLocalizer {
            filter: F::start(belief, &[super::state::THETA])?,
            settings,
            gate,
            map: map.into(),
            stamp,
            wheels: SensorTiming::SILENT,
            inertial: SensorTiming::SILENT,
            acceleration: 0.0,
            sideways: 0.0,
            pending_walk: RandomWalk { speed: 0.0, turn: 0.0 },
            steps: 0,
            sensors: Sensors::default(),
            divergence: DivergenceMonitor::default(),
            diverged_at: stamp,
        })
    }

    /// The belief about all states at a time \[s\] not before the last input.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite, [`Error::LostPositivity`].
    pub fn belief_at(&self, stamp: f64) -> Result<FusedBelief> {
        let mut ahead = self.clone();
        ahead.predict_to(loc_core::error::finite("stamp [s]", stamp)?)?;
        ahead.belief()
    }

    /// The belief now.
    ///
    /// # Errors
    /// [`Error::LostPositivity`].
    fn belief(&self) -> Result<FusedBelief> {
        let belief = *self.filter.belief();
        match loc_core::gaussian::check_covariance("fused covariance", &belief.covariance) {
            Ok(()) => Ok(FusedBelief(belief)),
            Err(_) => Err(self.lost_positivity(&belief.covariance)),
        }
    }

    fn lost_positivity(&self, covariance: &Square) -> Error {
        let found = format!("{:?}", covariance.diagonal().as_slice());
        Error::LostPositivity { what: "diagonal of the fused covariance", step: self.steps, found }
    }

    /// Drives on to a time \[s\], through every moment at which a measurement ceases to hold.
    // ANCHOR: predict-to
    fn predict_to(&mut self, stamp: f64) -> Result<()> {
        let longest = PIECE.max((stamp - self.stamp) / MAX_PIECES);
        while self.stamp < stamp {
            let known = self.wheels.holds(self.stamp);
            let turn_known = known || self.inertial.holds(self.stamp);
            let mut end = stamp;
            for timing in [&self.wheels, &self.inertial] {
                if timing.holds(self.stamp) {
                    end = end.min(timing.until);
                }
            }
            if !(known && turn_known) {
                end = end.min(self.stamp + longest);
                self.walk(!known, !turn_known)?;
            }
            self.predict_step(end)?;
        }
        Ok(())
    }
    // ANCHOR_END: predict-to

    fn predict_step(&mut self, end: f64) -> Result<()> {
        let dt = end - self.stamp;
        let acceleration = self.inertial.holds(self.stamp).then_some(self.acceleration);
        let sideways = if self.wheels.holds(self.stamp) { self.sideways } else { 0.0 };
        let motion = FusedMotion::new(&self.settings, dt, sideways, acceleration);
        self.filter.predict(&motion)?;
        let FusionSettings { speed_walk, turn_walk, imu, .. } = &self.settings;
        self.pending_walk.turn += turn_walk * turn_walk * dt;
        self.pending_walk.speed += dt
            * match acceleration {
                Some(_) => SLOPE_WALK * SLOPE_WALK + imu.accelerometer.density.powi(2),
                None => speed_walk * speed_walk,
            };
        self.stamp = end;
        Ok(())
    }

    /// Lets the walk of the speed or the turn rate enter the belief. Where a sensor measures them
    /// again and again, it does so only then: what was measured holds in between, with the
    /// sensor's own noise.
    fn walk(&mut self, speed: bool, turn: bool) -> Result<()> {
        let take = |wanted: bool, pending_walk: &mut f64| {
            if wanted { std::mem::take(pending_walk) } else { 0.0 }
        };
        let pending_walk = RandomWalk {
            speed: take(speed, &mut self.pending_walk.speed),
            turn: take(turn, &mut self.pending_walk.turn),
        };
        if pending_walk.speed > 0.0 || pending_walk.turn > 0.0 {
            self.filter.predict(&pending_walk)
        } else {
            Ok(())
        }
    }

    fn odometry(&mut self, stamp: f64, twist: &Twist2) -> Result<Outcome> {
        let period = self.wheels.beat(stamp);
        self.walk(true, true)?;
        // Only an inertial unit measures the motion better than the wheels.
        let better_known = self.inertial.holds(self.stamp);
        let gate = if better_known { self.gate } else { Gate::OPEN };
        let moves = if better_known { self.expected_twist() } else { *twist };
        let variances = self.settings.robot.odometry.variances(moves, period);
        let variances = Vector2::new(variances.x, variances.z).add_scalar(WHEEL_ROUNDING);
        let z = Vector2::new(twist.vx, twist.omega);
        let innovation = self.filter.correct(&WheelModel { variances }, &z, &gate)?;
        self.sideways = twist.vy;
        Ok(Outcome::of_innovation(&innovation))
    }

    /// The velocity that is expected, as the root of its mean square. The noise of the wheels grows
    /// with the speed: taken from a reading, it would make those that are too fast count less than
    /// those that are too slow, and the robot slower than it is.
    fn expected_twist(&self) -> Twist2 {
        let Gaussian { mean, covariance } = self.filter.belief();
        let size = |index: usize| (mean[index].powi(2) + covariance[(index, index)]).sqrt();
        Twist2::forward(size(SPEED), size(TURN))
    }

    fn inertial(&mut self, stamp: f64, reading: &ImuReading) -> Result<Outcome> {
        self.inertial.beat(stamp);
        self.walk(false, true)?;
        let imu = &self.settings.imu;
        let period = 1.0 / imu.rate;
        // The turn rate of a wheel's wobble is far below this.
        let floor = 1e-8;
        let variances = Vector2::new(
            imu.gyroscope.sample_sigma(period).powi(2) + floor,
            imu.accelerometer.sample_sigma(period).powi(2) + SLOPE_WALK.powi(2),
        );
        let z = Vector2::new(reading.angular_velocity.z, reading.acceleration.y);
        let innovation = self.filter.correct(&InertialModel { variances }, &z, &self.gate)?;
        self.acceleration = reading.acceleration.x;
        Ok(Outcome::of_innovation(&innovation))
    }

    fn compass(&mut self, reading: &CompassReading) -> Result<Outcome> {
        let variance = self.settings.compass_sigma.powi(2);
        let z = Vector1::new(reading.heading);
        let innovation = self.filter.correct(&CompassModel { variance }, &z, &self.gate)?;
        Ok(Outcome::of_innovation(&innovation))
    }

    /// The drift is a state; what the receiver claims beyond it is noise.
    fn position(&mut self, fix: &Gaussian<2>) -> Result<Outcome> {
        let gnss = &self.settings.gnss;
        let usual = 2.0 * gnss.sigma().powi(2);
        let worse = (fix.covariance.trace() / usual).max(1.0);
        let noise = Matrix2::identity() * (gnss.white_sigma.powi(2) * worse);
        let model = PositionModel { antenna: self.settings.antenna, noise };
        let innovation = self.filter.correct(&model, &fix.mean, &self.gate)?;
        Ok(Outcome::of_innovation(&innovation))
    }

    fn observation(&mut self, observation: &LandmarkObservation) -> Result<Outcome> {
        let id = observation.landmark;
        let Some(landmark) = self.map.get(id) else {
            return Ok(Outcome::of(Decision::UnknownLandmark).with_landmark(id));
        };
        let RobotSettings { mounting, camera: noise, .. } = self.settings.robot;
        let landmark = landmark.position.xy();
        let model = RangeBearingModel { landmark, mounting, noise };
        let model = if F::SECOND_ORDER {
            ObservationModel::straight(model)
        } else {
            ObservationModel::new(model, self.filter.belief())
        };
        let (filter, gate) = (&mut self.filter, &self.gate);
        let outcome = match observation.observed {
            Observed::RangeBearing { range, bearing } => {
                let z = Vector2::new(range, bearing);
                Outcome::of_innovation(&filter.correct(&model, &z, gate)?)
            }
            Observed::Range { range } => {
                let z = Vector1::new(range);
                Outcome::of_innovation(&filter.correct(&DistanceModel(model), &z, gate)?)
            }
            Observed::Bearing { bearing } => {
                let z = Vector1::new(bearing);
                Outcome::of_innovation(&filter.correct(&DirectionModel(model), &z, gate)?)
            }
        };
        Ok(outcome.with_landmark(id))
    }

    /// Counts the decisions of the gate, and widens a diverged belief by the gap between the
    /// measurements and what was expected \[m\].
    fn count(&mut self, outcomes: &[Outcome], gap: f64) -> Result<()> {
        if self.divergence.observe_all(outcomes) {
            self.diverged_at = self.stamp;
            self.filter.predict(&Widening::by(gap))?;
        }
        Ok(())
    }

    /// Begins an input: predicts to its time. Inputs from before the start belong to the start.
    fn begin(&mut self, stamp: f64) -> Result<f64> {
        let stamp = loc_core::error::finite("stamp [s]", stamp)?.max(self.stamp);
        self.predict_to(stamp)?;
        self.steps += 1;
        Ok(stamp)
    }

    /// Ends an input: the covariance must still be one.
    fn check(&self) -> Result<()> {
        let covariance = &self.filter.belief().covariance;
        if covariance.diagonal().iter().all(|variance| *variance >= 0.0 && variance.is_finite()) {
            return Ok(());
        }
        Err(self.lost_positivity(covariance))
    }
}

impl<F: NonlinearFilter<STATES>> Localizer for FusedLocalizer<F> {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        crate::innovation::finite("velocity of the wheels", &twist.to_vector())?;
        let stamp = self.begin(stamp)?;
        self.odometry(stamp, twist)?;
        self.check()
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let from = self.acts_from(stamp, measurement);
        let outcomes = match measurement {
            Measurement::Landmarks(observations) => {
                for observation in observations {
                    observation.observed.check()?;
                }
                self.begin(from)?;
                self.sensors.landmarks = true;
                let correct = |one: &LandmarkObservation| self.observation(one);
                let mut outcomes = observations.iter().map(correct).collect::<Result<Vec<_>>>()?;
                let camera =
                    FusedBelief(*self.filter.belief()).pose() * self.settings.robot.mounting;
                for (outcome, observation) in outcomes.iter_mut().zip(observations) {
                    outcome.observed_at = observed_position(camera, observation);
                }
                let gap = gap(&self.map, camera, observations);
                self.count(&outcomes, gap)?;
                outcomes
            }
            Measurement::Inertial(reading) => {
                reading.check()?;
                let from = self.begin(from)?;
                self.sensors.inertial = true;
                vec![self.inertial(from, reading)?]
            }
            Measurement::Compass(reading) => {
                reading.check()?;
                self.begin(from)?;
                vec![self.compass(reading)?]
            }
            Measurement::Position(fix) => {
                let fix = Gaussian::new(fix.mean, fix.covariance)?;
                self.begin(from)?;
                self.sensors.satellites = true;
                let off = fix.mean - self.filter.belief().mean.xy();
                let outcome = self.position(&fix)?.with_place(Some(fix.mean.into()));
                self.count(&[outcome], off.norm())?;
                vec![outcome]
            }
            Measurement::Scan { .. } | Measurement::RailPosition { .. } => return Ok(Vec::new()),
        };
        self.check()?;
        Ok(outcomes)
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.belief_at(stamp)?.about_pose().into())
    }

    fn notes(&self) -> Vec<String> {
        self.divergence.notes(self.diverged_at)
    }

    fn sensor_errors(&self, stamp: f64) -> Result<Vec<SensorError>> {
        let belief = self.belief_at(stamp)?;
        let has_measured = |index: usize| match index {
            RANGE_SCALE | RANGE_OFFSET => self.sensors.landmarks,
            DRIFT_X | DRIFT_Y => self.sensors.satellites,
            _ => self.sensors.inertial,
        };
        let known = ERRORS.iter().filter(|(index, ..)| has_measured(*index));
        let errors = known.filter_map(|&(index, name, unit)| {
            let (mean, sigma) = belief.state(index)?;
            Some(SensorError { name, mean: unit * mean, sigma: unit * sigma })
        });
        Ok(errors.collect())
    }
}

impl<F: NonlinearFilter<STATES>> Sequential for FusedLocalizer<F> {
    fn uses(&self, measurement: &Measurement) -> bool {
        !matches!(measurement, Measurement::Scan { .. } | Measurement::RailPosition { .. })
    }

    fn acts_from(&self, stamp: f64, measurement: &Measurement) -> f64 {
        match measurement {
            Measurement::Inertial(_) => stamp - 1.0 / self.settings.imu.rate,
            _ => stamp,
        }
    }

    /// Of one stamp, first what measures the motion, then what measures the pose.
    fn rank(input: &Payload) -> u64 {
        match input {
            Payload::Control(_) => 0,
            Payload::Measurement(Measurement::Inertial(_)) => 1,
            Payload::Measurement(Measurement::Compass(_)) => 2,
            Payload::Measurement(Measurement::Position(_)) => 3,
            Payload::Measurement(Measurement::Landmarks(observations)) => {
                4 + observations.first().map_or(0, |first| u64::from(first.landmark))
            }
            _ => u64::MAX,
        }
    }

    fn mark(&mut self, stamp: f64) -> Result<()> {
        self.begin(stamp)?;
        self.filter.mark();
        Ok(())
    }
}

impl<F: NonlinearFilter<STATES>> FusedLocalizer<Recorded<F, STATES>> {
    /// The smoothed belief about all states at each mark, in the order of the marks.
    ///
    /// # Errors
    /// Those of [`Smoother::smooth`](crate::smoother::Smoother::smooth).
    pub fn smoothed_beliefs(&self) -> Result<Vec<FusedBelief>> {
        Ok(self.filter.past().smooth_marked()?.into_iter().map(FusedBelief).collect())
    }
}

impl<F: NonlinearFilter<STATES>> Smoothable for FusedLocalizer<Recorded<F, STATES>> {
    fn smoothed(&self) -> Result<Vec<Estimate>> {
        let beliefs = self.smoothed_beliefs()?;
        Ok(beliefs.into_iter().map(|belief| belief.about_pose().into()).collect())
    }
}

/// What a sensor measured holds for so many of its periods.
const HOLDS: f64 = 1.5;
/// A sensor's period as long as only one reading is known, and the longest \[s\].
const FIRST_PERIOD: f64 = 0.1;
const LONGEST_PERIOD: f64 = 1.0;

/// A sensor that measures again and again.
#[derive(Debug, Clone, Copy)]
struct SensorTiming {
    last: Option<f64>,
    /// When its last measurement ceases to hold \[s\].
    until: f64,
}

impl SensorTiming {
    const SILENT: SensorTiming = SensorTiming { last: None, until: f64::NEG_INFINITY };

    /// A measurement at `stamp` \[s\]; the answer is the time since the last one.
    fn beat(&mut self, stamp: f64) -> f64 {
        let since = self.last.map(|last| stamp - last).filter(|since| *since > 0.0);
        let period = since.unwrap_or(FIRST_PERIOD).min(LONGEST_PERIOD);
        *self = SensorTiming { last: Some(stamp), until: stamp + HOLDS * period };
        period
    }

    fn holds(&self, stamp: f64) -> bool {
        stamp < self.until
    }
}
