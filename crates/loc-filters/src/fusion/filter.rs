//! The fused filter at the stamp of its last input, and the algorithm of an input: predict to its stamp,
//! then correct with it. Measurements of the velocity hold until the next one is due.

use super::models::{
    CompassModel, DirectionModel, DistanceModel, FusedMotion, InertialModel, ObservationModel,
    PositionModel, RandomWalk, WheelModel,
};
use super::state::{FusedBelief, SPEED, STATES, Square, TURN};
use super::{FusionOutcome, FusionSensor, FusionSettings};
use crate::delayed::Step;
use crate::landmark::RangeBearingModel;
use crate::smoother::{Recorded, Smoother};
use crate::{Error, Gate, NonlinearFilter, Result};
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::compass::CompassReading;
use loc_sensors::imu::ImuReading;
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix2, Vector1, Vector2};
use std::sync::Arc;

/// A stretch without a measurement of the velocity is cut into pieces of this length, so that its
/// random walk reaches the pose \[s\].
const PIECE: f64 = 0.1;
/// More pieces than this are not worth their time.
const MAX_PIECES: f64 = 1000.0;
/// Rounding of what wheels report: 1 mm/s, 1 mrad/s.
const WHEEL_ROUNDING: f64 = 1e-6;

/// What the filter is given.
#[derive(Debug, Clone)]
pub(super) enum Input {
    Odometry(Twist2),
    Inertial(ImuReading),
    Compass(CompassReading),
    Position(Gaussian<2>),
    LandmarkObservations(Vec<LandmarkObservation>),
    /// A time whose belief is wanted later.
    Mark,
}

#[derive(Debug, Clone)]
pub(super) struct FilterState<F> {
    filter: F,
    settings: FusionSettings,
    gate: Gate,
    map: Arc<LandmarkMap>,
    pub(super) stamp: f64,
    wheels: SensorTiming,
    inertial: SensorTiming,
    acceleration: f64,
    sideways: f64,
    /// What the velocity has pending_walk since it was measured last.
    pending_walk: RandomWalk,
    steps: u64,
}

impl<F: NonlinearFilter<STATES>> FilterState<F> {
    pub(super) fn new(
        map: Arc<LandmarkMap>,
        settings: FusionSettings,
        stamp: f64,
        start: &Gaussian<3>,
    ) -> Result<Self> {
        let gate = settings.check()?;
        let belief = super::state::belief(&settings, start)?;
        Ok(FilterState {
            filter: F::start(belief, &[super::state::THETA])?,
            settings,
            gate,
            map,
            stamp,
            wheels: SensorTiming::SILENT,
            inertial: SensorTiming::SILENT,
            acceleration: 0.0,
            sideways: 0.0,
            pending_walk: RandomWalk { speed: 0.0, turn: 0.0 },
            steps: 0,
        })
    }

    /// The belief now.
    ///
    /// # Errors
    /// [`Error::LostPositivity`].
    pub(super) fn belief(&self) -> Result<FusedBelief> {
        let belief = *self.filter.belief();
        match loc_core::gaussian::check_covariance("fused covariance", &belief.covariance) {
            Ok(()) => Ok(FusedBelief(belief)),
            Err(_) => Err(self.lost(&belief.covariance)),
        }
    }

    fn lost(&self, covariance: &Square) -> Error {
        let found = format!("{:?}", covariance.diagonal().as_slice());
        Error::LostPositivity { what: "diagonal of the fused covariance", step: self.steps, found }
    }

    /// Predicts to a time \[s\], in steps that end where a measurement ceases to hold.
    // ANCHOR: drive-to
    pub(super) fn predict_to(&mut self, stamp: f64) -> Result<()> {
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
    // ANCHOR_END: drive-to

    fn predict_step(&mut self, end: f64) -> Result<()> {
        let dt = end - self.stamp;
        let acceleration = self.inertial.holds(self.stamp).then_some(self.acceleration);
        let sideways = if self.wheels.holds(self.stamp) { self.sideways } else { 0.0 };
        let motion = FusedMotion::new(&self.settings, dt, sideways, acceleration);
        self.filter.predict(&motion)?;
        let FusionSettings { speed_walk, slope_walk, turn_walk, imu, .. } = &self.settings;
        self.pending_walk.turn += turn_walk * turn_walk * dt;
        self.pending_walk.speed += dt
            * match acceleration {
                Some(_) => slope_walk * slope_walk + imu.accelerometer.density.powi(2),
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

    fn odometry(&mut self, stamp: f64, twist: &Twist2) -> Result<FusionOutcome> {
        let period = self.wheels.record(stamp);
        self.walk(true, true)?;
        // Only an inertial unit measures the motion better than the wheels.
        let better_known = self.inertial.holds(self.stamp);
        let gate = if better_known { self.gate } else { Gate::OPEN };
        let moves = if better_known { self.expected_twist() } else { *twist };
        let variances = self.settings.motion_noise.variances(moves, period);
        let variances = Vector2::new(variances.x, variances.z).add_scalar(WHEEL_ROUNDING);
        let z = Vector2::new(twist.vx, twist.omega);
        let innovation = self.filter.correct(&WheelModel { variances }, &z, &gate)?;
        self.sideways = twist.vy;
        Ok(FusionOutcome::of(FusionSensor::Wheels, &innovation))
    }

    /// The velocity that is expected, as the root of its mean square. The noise of the wheels grows
    /// with the speed: taken from a reading, it would make those that are too fast count less than
    /// those that are too slow, and the robot slower than it is.
    fn expected_twist(&self) -> Twist2 {
        let Gaussian { mean, covariance } = self.filter.belief();
        let size = |index: usize| (mean[index].powi(2) + covariance[(index, index)]).sqrt();
        Twist2::forward(size(SPEED), size(TURN))
    }

    fn inertial(&mut self, stamp: f64, reading: &ImuReading) -> Result<FusionOutcome> {
        self.inertial.record(stamp);
        self.walk(false, true)?;
        let imu = &self.settings.imu;
        let period = 1.0 / imu.rate;
        // The turn rate of a wheel's wobble is far below this.
        let floor = 1e-8;
        let variances = Vector2::new(
            imu.gyroscope.sample_sigma(period).powi(2) + floor,
            imu.accelerometer.sample_sigma(period).powi(2) + self.settings.slope_walk.powi(2),
        );
        let z = Vector2::new(reading.angular_velocity.z, reading.acceleration.y);
        let innovation = self.filter.correct(&InertialModel { variances }, &z, &self.gate)?;
        self.acceleration = reading.acceleration.x;
        Ok(FusionOutcome::of(FusionSensor::Inertial, &innovation))
    }

    fn compass(&mut self, reading: &CompassReading) -> Result<FusionOutcome> {
        let variance = self.settings.compass_sigma.powi(2);
        let z = Vector1::new(reading.heading);
        let innovation = self.filter.correct(&CompassModel { variance }, &z, &self.gate)?;
        Ok(FusionOutcome::of(FusionSensor::Compass, &innovation))
    }

    /// The drift is a state; what the receiver claims beyond it is noise.
    fn position(&mut self, fix: &Gaussian<2>) -> Result<FusionOutcome> {
        let gnss = &self.settings.gnss;
        let usual = 2.0 * gnss.sigma().powi(2);
        let worse = (fix.covariance.trace() / usual).max(1.0);
        let noise = Matrix2::identity() * (gnss.white_sigma.powi(2) * worse);
        let model = PositionModel { antenna: self.settings.antenna, noise };
        let innovation = self.filter.correct(&model, &fix.mean, &self.gate)?;
        Ok(FusionOutcome::of(FusionSensor::Position, &innovation))
    }

    fn observation(&mut self, observation: &LandmarkObservation) -> Result<FusionOutcome> {
        let sensor = FusionSensor::Landmark(observation.landmark);
        let Some(landmark) = self.map.get(observation.landmark) else {
            return Ok(FusionOutcome::rejected(sensor));
        };
        let FusionSettings { mounting, observation_noise: noise, .. } = self.settings;
        let landmark = landmark.position.xy();
        let sight = RangeBearingModel { landmark, mounting, noise };
        let model = if F::SECOND_ORDER {
            ObservationModel::straight(sight)
        } else {
            ObservationModel::new(sight, self.filter.belief())
        };
        let (filter, gate) = (&mut self.filter, &self.gate);
        Ok(match observation.sight {
            Observed::RangeBearing { range, bearing } => {
                let z = Vector2::new(range, bearing);
                FusionOutcome::of(sensor, &filter.correct(&model, &z, gate)?)
            }
            Observed::Range { range } => {
                let z = Vector1::new(range);
                FusionOutcome::of(sensor, &filter.correct(&DistanceModel(model), &z, gate)?)
            }
            Observed::Bearing { bearing } => {
                let z = Vector1::new(bearing);
                FusionOutcome::of(sensor, &filter.correct(&DirectionModel(model), &z, gate)?)
            }
        })
    }

    fn apply(&mut self, stamp: f64, input: &Input) -> Result<Vec<FusionOutcome>> {
        // Inputs from before the start belong to the start.
        let stamp = stamp.max(self.stamp);
        self.predict_to(stamp)?;
        self.steps += 1;
        let outcomes = match input {
            Input::Odometry(twist) => vec![self.odometry(stamp, twist)?],
            Input::Inertial(reading) => vec![self.inertial(stamp, reading)?],
            Input::Compass(reading) => vec![self.compass(reading)?],
            Input::Position(fix) => vec![self.position(fix)?],
            Input::LandmarkObservations(observations) => {
                observations.iter().map(|one| self.observation(one)).collect::<Result<_>>()?
            }
            Input::Mark => {
                self.filter.mark();
                Vec::new()
            }
        };
        let covariance = &self.filter.belief().covariance;
        if covariance.diagonal().iter().all(|variance| *variance >= 0.0 && variance.is_finite()) {
            return Ok(outcomes);
        }
        Err(self.lost(covariance))
    }
}

impl<F: NonlinearFilter<STATES>> FilterState<Recorded<F, STATES>> {
    pub(super) fn past(&self) -> &Smoother<STATES> {
        self.filter.past()
    }
}

impl<F: NonlinearFilter<STATES>> Step for FilterState<F> {
    type Input = Input;
    type Report = Vec<FusionOutcome>;

    fn step(&mut self, stamp: f64, input: &Input) -> Result<Vec<FusionOutcome>> {
        let mut next = self.clone();
        let outcomes = next.apply(stamp, input)?;
        *self = next;
        Ok(outcomes)
    }

    /// Of one stamp, velocities come before positions.
    fn rank(input: &Input) -> u64 {
        match input {
            Input::Odometry(_) => 0,
            Input::Inertial(_) => 1,
            Input::Compass(_) => 2,
            Input::Position(_) => 3,
            Input::LandmarkObservations(observations) => {
                4 + observations.first().map_or(0, |first| u64::from(first.landmark))
            }
            Input::Mark => u64::MAX,
        }
    }
}

/// What a sensor measured holds for so many of its periods.
const HOLDS: f64 = 1.5;
/// A sensor's period as long as only one reading is known, and the longest \[s\].
const FIRST_PERIOD: f64 = 0.1;
const LONGEST_PERIOD: f64 = 1.0;

/// A sensor that measures again and again.
#[derive(Debug, Clone, Copy)]
pub(super) struct SensorTiming {
    last: Option<f64>,
    /// When its last measurement ceases to hold \[s\].
    pub(super) until: f64,
}

impl SensorTiming {
    pub(super) const SILENT: SensorTiming = SensorTiming { last: None, until: f64::NEG_INFINITY };

    /// A measurement at `stamp` \[s\]; the answer is the time since the last one.
    pub(super) fn record(&mut self, stamp: f64) -> f64 {
        let since = self.last.map(|last| stamp - last).filter(|since| *since > 0.0);
        let period = since.unwrap_or(FIRST_PERIOD).min(LONGEST_PERIOD);
        *self = SensorTiming { last: Some(stamp), until: stamp + HOLDS * period };
        period
    }

    pub(super) fn holds(&self, stamp: f64) -> bool {
        stamp < self.until
    }
}
