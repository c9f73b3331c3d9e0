//! `fusion` and `fusion-ukf`: whatever sensors there are, in one extended or unscented Kalman filter.

use super::driven::DrivenVelocity;
use super::{Estimate, Judgement, Localizer, MethodSettings, SensorError, Whitened, seen_at};
use crate::source::Setup;
use crate::{Error, Result};
use loc_core::Pose2;
use loc_filters::NonlinearFilter;
use loc_filters::fusion::state::STATES;
use loc_filters::fusion::{FusedLocalizer, FusionOutcome, FusionSettings, state};
use loc_sensors::event::{Control, Measurement};
use nalgebra::{Point2, Vector2};

/// The errors that figures show, with the factor of their unit.
const ERRORS: [(usize, &str, f64); 7] = [
    (state::GYRO_BIAS, "gyroscope [deg/s]", 180.0 / std::f64::consts::PI),
    (state::FORWARD_BIAS, "accelerometer forward [m/s^2]", 1.0),
    (state::LEFT_BIAS, "accelerometer left [m/s^2]", 1.0),
    (state::RANGE_SCALE, "range scale", 1.0),
    (state::RANGE_OFFSET, "range offset [m]", 1.0),
    (state::DRIFT_X, "satellites east [m]", 1.0),
    (state::DRIFT_Y, "satellites north [m]", 1.0),
];

#[derive(Debug)]
pub(super) struct Fusion<F: NonlinearFilter<STATES>> {
    localizer: FusedLocalizer<F>,
    driven: DrivenVelocity,
    mounting: Pose2,
    /// The sensors that have been heard.
    heard: Heard,
}

#[derive(Debug, Default)]
struct Heard {
    inertial: bool,
    landmarks: bool,
    satellites: bool,
}

/// The filter of a method, at the start of a source.
pub(super) fn localizer<F: NonlinearFilter<STATES>>(
    method: &str,
    setup: &Setup,
    settings: FusionSettings,
) -> Result<FusedLocalizer<F>> {
    if setup.rail.is_some() {
        return Err(Error::Unsuitable {
            method: method.into(),
            expected: "a robot in the plane",
            source_name: setup.name.clone(),
        });
    }
    let (map, start) = (setup.landmarks.clone(), setup.start);
    Ok(FusedLocalizer::with_filter(map, settings, start, setup.start_belief)?)
}

/// Gives a measurement to the filter; one outcome for each of its parts.
pub(super) fn take<F: NonlinearFilter<STATES>>(
    localizer: &mut FusedLocalizer<F>,
    stamp: f64,
    measurement: &Measurement,
) -> Result<Vec<FusionOutcome>> {
    let outcome = match measurement {
        Measurement::Landmarks(observations) => {
            return Ok(localizer.observations(stamp, observations)?);
        }
        Measurement::Inertial(reading) => localizer.inertial(stamp, *reading)?,
        Measurement::Compass(reading) => localizer.compass(stamp, *reading)?,
        Measurement::Position(fix) => localizer.position(stamp, *fix)?,
        Measurement::Scan { .. } | Measurement::RailPosition { .. } => return Ok(Vec::new()),
    };
    Ok(vec![outcome])
}

impl Heard {
    fn hear(&mut self, measurement: &Measurement) {
        match measurement {
            Measurement::Landmarks(_) => self.landmarks = true,
            Measurement::Inertial(_) => self.inertial = true,
            Measurement::Position(_) => self.satellites = true,
            _ => {}
        }
    }
}

impl<F: NonlinearFilter<STATES>> Fusion<F> {
    pub(super) fn new(method: &str, setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let settings = settings.fusion();
        let localizer = localizer(method, setup, settings)?;
        let (driven, heard) = (DrivenVelocity::default(), Heard::default());
        Ok(Fusion { localizer, driven, mounting: settings.mounting, heard })
    }

    /// Where each part of a measurement puts what was seen.
    fn places(&self, stamp: f64, measurement: &Measurement) -> Result<Vec<Option<Point2<f64>>>> {
        Ok(match measurement {
            Measurement::Landmarks(observations) => {
                let camera = self.localizer.estimate(stamp)?.pose() * self.mounting;
                observations.iter().map(|observation| seen_at(camera, observation)).collect()
            }
            Measurement::Position(fix) => vec![Some(fix.mean.into())],
            _ => Vec::new(),
        })
    }
}

fn whitened(outcome: &FusionOutcome) -> Whitened {
    match *outcome.whitened() {
        [] => Whitened::NONE,
        [only] => nalgebra::Vector1::new(only).into(),
        [first, second, ..] => Vector2::new(first, second).into(),
    }
}

impl<F: NonlinearFilter<STATES>> Localizer for Fusion<F> {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        if let Some((from, twist)) = self.driven.of(stamp, control) {
            match self.localizer.odometry(from, twist) {
                // Odometry from beyond the horizon is lost.
                Ok(_) | Err(loc_filters::Error::TooLate { .. }) => {}
                Err(error) => return Err(error.into()),
            }
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        self.heard.hear(measurement);
        let outcomes = match take(&mut self.localizer, stamp, measurement) {
            Ok(outcomes) => outcomes,
            // A measurement beyond the horizon is lost to this method, not to the run.
            Err(Error::Filter(loc_filters::Error::TooLate { .. })) => {
                let parts = if let Measurement::Landmarks(s) = measurement { s.len() } else { 1 };
                return Ok(vec![Judgement::REFUSED; parts]);
            }
            Err(error) => return Err(error),
        };
        let places = self.places(stamp, measurement)?.into_iter().chain(std::iter::repeat(None));
        let judge = |(outcome, seen_at): (&FusionOutcome, _)| Judgement {
            accepted: outcome.accepted,
            nis: outcome.nis,
            degrees_of_freedom: outcome.degrees_of_freedom,
            whitened: whitened(outcome),
            seen_at,
        };
        Ok(outcomes.iter().zip(places).map(judge).collect())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.localizer.estimate(stamp)?.about_pose().into())
    }

    fn sensor_errors(&self, stamp: f64) -> Result<Vec<SensorError>> {
        let belief = self.localizer.estimate(stamp)?;
        let is_heard = |index: usize| match index {
            state::RANGE_SCALE | state::RANGE_OFFSET => self.heard.landmarks,
            state::DRIFT_X | state::DRIFT_Y => self.heard.satellites,
            _ => self.heard.inertial,
        };
        let known = ERRORS.iter().filter(|(index, ..)| is_heard(*index));
        let told = known.filter_map(|&(index, name, unit)| {
            let (mean, sigma) = belief.state(index)?;
            Some(SensorError { name, mean: unit * mean, sigma: unit * sigma })
        });
        Ok(told.collect())
    }
}
