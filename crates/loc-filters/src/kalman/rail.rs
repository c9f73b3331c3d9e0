//! A vehicle on a rail: the linear Kalman filter over position and speed (G3, G4).
//!
//! The state is (x, v) \[m, m/s\] under a commanded acceleration a that is disturbed by white noise:
//! `x' = x + v T`, `v' = v + a T` (G4). Position sensors measure x.
//!
//! ```
//! use loc_core::Gaussian;
//! use loc_filters::kalman::rail::{RailLocalizer, RailSettings};
//! use loc_filters::Localizer;
//! use loc_sensors::event::{Control, Measurement};
//! use nalgebra::{Matrix2, Vector2};
//!
//! let settings = RailSettings { acceleration_sigma: 0.1, sensor_sigmas: vec![0.5] };
//! let start = Gaussian::new(Vector2::zeros(), Matrix2::identity() * 0.01)?;
//! let mut vehicle = RailLocalizer::new(settings, 0.0, start)?;
//! vehicle.predict(0.0, &Control::Acceleration(1.0))?;
//! let outcomes = vehicle.correct(2.0, &Measurement::RailPosition { sensor: 0, position: 0.3 })?;
//! assert!(outcomes[0].accepted());
//! # Ok::<(), loc_filters::Error>(())
//! ```

use super::{KalmanFilter, LinearMeasurement, LinearMotion};
use crate::delayed::Sequential;
use crate::localizer::{Estimate, Localizer, Outcome};
use crate::smoother::{Link, Smoothable, Smoother};
use crate::{Gate, Result};
use loc_core::{Gaussian, Pose2};
use loc_sensors::event::{Control, Measurement};
use nalgebra::{Matrix1, Matrix1x2, Matrix2, Matrix2x1, Matrix3, Point2, Vector1};

/// What the filter knows about the vehicle and its sensors.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RailSettings {
    /// Standard deviation of the commanded acceleration \[m/s^2\].
    pub acceleration_sigma: f64,
    /// Standard deviation of each position sensor \[m\].
    pub sensor_sigmas: Vec<f64>,
}

/// A vehicle on a rail with position sensors.
#[derive(Debug, Clone)]
pub struct RailLocalizer {
    filter: KalmanFilter<2>,
    /// What smoothing needs, where it is wanted.
    past: Option<Smoother<2>>,
    stamp: f64,
    acceleration: f64,
    settings: RailSettings,
    corrects: bool,
}

impl RailLocalizer {
    /// A vehicle with a belief over (x, v) at `stamp` \[s\].
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief that is none.
    pub fn new(settings: RailSettings, stamp: f64, start: Gaussian<2>) -> Result<Self> {
        let filter = KalmanFilter::new(start)?;
        let acceleration = 0.0;
        Ok(RailLocalizer { filter, past: None, stamp, acceleration, settings, corrects: true })
    }

    /// The same, keeping what [`smooth`](crate::smoother::smooth) needs.
    ///
    /// # Errors
    /// [`loc_core::Error`] for a belief that is none.
    pub fn recorded(self) -> Result<Self> {
        Ok(RailLocalizer { past: Some(Smoother::new(*self.filter.belief())?), ..self })
    }

    /// The same without corrections: dead reckoning.
    #[must_use]
    pub fn without_corrections(self) -> Self {
        RailLocalizer { corrects: false, ..self }
    }

    /// Predicts to a time \[s\]: A = [[1, T], [0, 1]], B = (0, T).
    fn predict_to(&mut self, stamp: f64) -> Result<()> {
        let dt = stamp - self.stamp;
        if dt > 0.0 {
            let motion = self.motion(dt)?;
            self.filter.predict(&motion, &Vector1::new(self.acceleration))?;
            self.stamp = stamp;
            if let Some(past) = &mut self.past {
                let link = Link::Tangent { jacobian: *motion.transition(), noise: *motion.noise() };
                past.linked(link, self.filter.belief());
            }
        }
        Ok(())
    }

    fn motion(&self, dt: f64) -> Result<LinearMotion<2, 1>> {
        LinearMotion::new(
            Matrix2::new(1.0, dt, 0.0, 1.0),
            Matrix2x1::new(0.0, dt),
            Matrix1::new(self.settings.acceleration_sigma.powi(2)),
            Matrix2::zeros(),
        )
    }

    /// The model of the sensor with this index, counted from 0.
    fn sensor(&self, index: usize) -> Result<LinearMeasurement<2, 1>> {
        // A sensor without a standard deviation of its own measures nothing.
        let sigma = self.settings.sensor_sigmas.get(index).copied().unwrap_or(f64::MAX.sqrt());
        LinearMeasurement::new(Matrix1x2::new(1.0, 0.0), Matrix1::new(sigma * sigma))
    }
}

/// A belief about position and speed as a pose on the x axis.
fn on_rail(belief: Gaussian<2>) -> Estimate {
    let mut covariance = Matrix3::zeros();
    covariance[(0, 0)] = belief.covariance[(0, 0)];
    let pose = Pose2::new(belief.mean.x, 0.0, 0.0);
    Estimate { pose, covariance: Some(covariance), lost: None, rail: Some(belief) }
}

impl Localizer for RailLocalizer {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        self.predict_to(stamp)?;
        if let Control::Acceleration(acceleration) = control {
            self.acceleration = *acceleration;
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let &Measurement::RailPosition { sensor, position } = measurement else {
            return Ok(Vec::new());
        };
        if !self.corrects {
            return Ok(Vec::new());
        }
        self.predict_to(stamp)?;
        let sensor = self.sensor(sensor)?;
        let innovation = self.filter.correct(&sensor, &Vector1::new(position), &Gate::OPEN)?;
        if let Some(past) = &mut self.past {
            past.corrected(self.filter.belief());
        }
        let place = Some(Point2::new(position, 0.0));
        Ok(vec![Outcome::of_innovation(&innovation).with_place(place)])
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        let dt = stamp - self.stamp;
        if dt <= 0.0 {
            return Ok(on_rail(*self.filter.belief()));
        }
        let mut ahead = self.filter;
        ahead.predict(&self.motion(dt)?, &Vector1::new(self.acceleration))?;
        Ok(on_rail(*ahead.belief()))
    }
}

impl Sequential for RailLocalizer {
    fn uses(&self, measurement: &Measurement) -> bool {
        self.corrects && matches!(measurement, Measurement::RailPosition { .. })
    }

    fn mark(&mut self, stamp: f64) -> Result<()> {
        self.predict_to(stamp)?;
        self.past.iter_mut().for_each(Smoother::mark);
        Ok(())
    }
}

impl Smoothable for RailLocalizer {
    fn smoothed(&self) -> Result<Vec<Estimate>> {
        let beliefs = self.past.as_ref().map_or(Ok(Vec::new()), Smoother::smooth_marked)?;
        Ok(beliefs.into_iter().map(on_rail).collect())
    }
}
