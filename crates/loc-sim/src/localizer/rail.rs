//! `kf`, and `dead-reckoning` for a vehicle on a rail: the linear Kalman filter (G3, G4).

use super::{Estimate, Judgement, Localizer, RailSettings};
use crate::source::Setup;
use crate::{Error, Result};
use loc_core::{Gaussian, Pose2};
use loc_filters::kalman::{KalmanFilter, LinearMeasurement, LinearMotion};
use loc_filters::{Gate, Innovation};
use loc_sensors::event::{Control, Measurement};
use nalgebra::{Matrix1, Matrix1x2, Matrix2, Matrix2x1, Matrix3, Point2, Vector1};

/// State (x, v) \[m, m/s\] under a commanded acceleration.
#[derive(Debug)]
pub(super) struct RailFilter {
    filter: KalmanFilter<2>,
    stamp: f64,
    acceleration: f64,
    settings: RailSettings,
    corrects: bool,
}

impl RailFilter {
    /// With `corrects` the Kalman filter, without it its prediction alone.
    pub(super) fn new(
        method: &str,
        setup: &Setup,
        settings: &RailSettings,
        corrects: bool,
    ) -> Result<Self> {
        let Some(start) = setup.rail else {
            return Err(Error::Unsuitable {
                method: method.into(),
                expected: "a vehicle on a rail",
                source_name: setup.name.clone(),
            });
        };
        Ok(RailFilter {
            filter: KalmanFilter::new(start)?,
            stamp: setup.start,
            acceleration: 0.0,
            settings: settings.clone(),
            corrects,
        })
    }

    /// Drives on to a time \[s\].
    fn drive_to(&mut self, stamp: f64) -> Result<()> {
        let dt = stamp - self.stamp;
        if dt <= 0.0 {
            return Ok(());
        }
        let motion = motion(&self.settings, dt)?;
        self.filter.predict(&motion, &Vector1::new(self.acceleration))?;
        self.stamp = stamp;
        Ok(())
    }

    fn measure(&mut self, index: usize, position: f64) -> Result<Innovation<1>> {
        let sensor = sensor(&self.settings, index)?;
        Ok(self.filter.correct(&sensor, &Vector1::new(position), &Gate::OPEN)?)
    }
}

/// A step of `dt` \[s\]: A = [[1, T], [0, 1]], B = (0, T).
pub(super) fn motion(settings: &RailSettings, dt: f64) -> Result<LinearMotion<2, 1>> {
    Ok(LinearMotion::new(
        Matrix2::new(1.0, dt, 0.0, 1.0),
        Matrix2x1::new(0.0, dt),
        Matrix1::new(settings.acceleration_sigma.powi(2)),
        Matrix2::zeros(),
    )?)
}

/// The sensor with this index, counted from 0.
pub(super) fn sensor(settings: &RailSettings, index: usize) -> Result<LinearMeasurement<2, 1>> {
    // A sensor without a sigma of its own does not come out of a checked scenario.
    let sigma = settings.sensor_sigmas.get(index).copied().unwrap_or(f64::MAX.sqrt());
    Ok(LinearMeasurement::new(Matrix1x2::new(1.0, 0.0), Matrix1::new(sigma * sigma))?)
}

/// A belief about position and speed as a pose on the x axis.
pub(super) fn estimate(belief: Gaussian<2>) -> Estimate {
    let mut covariance = Matrix3::zeros();
    covariance[(0, 0)] = belief.covariance[(0, 0)];
    Estimate {
        pose: Pose2::new(belief.mean.x, 0.0, 0.0),
        covariance: Some(covariance),
        rail: Some(belief),
    }
}

impl Localizer for RailFilter {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        self.drive_to(stamp)?;
        if let Control::Acceleration(acceleration) = control {
            self.acceleration = *acceleration;
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::RailPosition { sensor, position } = *measurement else {
            return Ok(Vec::new());
        };
        if !self.corrects {
            return Ok(Vec::new());
        }
        self.drive_to(stamp)?;
        let innovation = self.measure(sensor, position)?;
        Ok(vec![Judgement {
            accepted: innovation.accepted,
            nis: Some(innovation.nis),
            degrees_of_freedom: 1,
            whitened: innovation.whitened.into(),
            seen_at: Some(Point2::new(position, 0.0)),
        }])
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        let mut ahead = RailFilter { settings: self.settings.clone(), ..*self };
        ahead.drive_to(stamp)?;
        Ok(estimate(*ahead.filter.belief()))
    }
}
