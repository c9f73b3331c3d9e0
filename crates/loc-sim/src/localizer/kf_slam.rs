//! `kf-slam`: SLAM of a robot that slides without turning (I1).

use super::{Estimate, EstimatedMap, Judgement, Localizer, MethodSettings, Whitened};
use crate::source::Setup;
use crate::{Error, Result};
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::Innovation;
use loc_filters::slam::{LinearSlam, LinearSlamSettings, MapLandmark, RelativeObservation};
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::{Matrix2, Matrix3, Point2, Rotation2, Vector2};

/// The filter works along the robot's own axes, which are those of the map turned by a heading
/// that never changes.
#[derive(Debug)]
pub(super) struct KfSlamMethod {
    slam: LinearSlam,
    heading: f64,
    mounting: Pose2,
    noise: LandmarkNoise,
    stamp: f64,
    twist: Twist2,
    setup_name: String,
}

impl KfSlamMethod {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let start = setup.start_belief;
        let heading = start.mean.z;
        let turn = Rotation2::new(-heading);
        let position = start.position();
        let covariance = turn.matrix() * position.covariance * turn.matrix().transpose();
        let linear = LinearSlamSettings {
            k_d: settings.landmark.motion_noise.k_d,
            gate_probability: settings.landmark.gate_probability,
            ..LinearSlamSettings::default()
        };
        Ok(KfSlamMethod {
            slam: LinearSlam::new(Gaussian { mean: turn * position.mean, covariance }, linear)?,
            heading,
            mounting: settings.landmark.mounting,
            noise: settings.landmark.observation_noise,
            stamp: setup.start,
            twist: Twist2::ZERO,
            setup_name: setup.name.clone(),
        })
    }

    fn drive_to(&mut self, stamp: f64) -> Result<()> {
        let dt = stamp - self.stamp;
        if dt > 0.0 {
            self.slam.predict(Vector2::new(self.twist.vx, self.twist.vy), dt)?;
            self.stamp = stamp;
        }
        Ok(())
    }

    /// Where the landmark is from the robot's centre; `None` without a distance and a direction.
    fn relative(&self, observation: &LandmarkObservation) -> Option<RelativeObservation> {
        let Observed::RangeBearing { range, bearing } = observation.sight else { return None };
        let direction = bearing + self.mounting.theta;
        let along = Vector2::new(direction.cos(), direction.sin());
        let offset = Vector2::new(self.mounting.x, self.mounting.y) + range * along;
        let sigma = self.noise.range_sigma_at(range);
        // A landmark at the camera has no direction; its place is still good to the range.
        let across = (self.noise.bearing_sigma * range).max(1e-3 * sigma);
        let axes = Matrix2::new(along.x, -along.y, along.y, along.x);
        let variances = Matrix2::from_diagonal(&Vector2::new(sigma * sigma, across * across));
        let covariance = axes * variances * axes.transpose();
        Some(RelativeObservation { landmark: observation.landmark, offset, covariance })
    }

    /// From the robot's axes to those of the map.
    fn turned(&self, belief: &Gaussian<2>) -> Gaussian<2> {
        let turn = Rotation2::new(self.heading);
        let covariance = turn.matrix() * belief.covariance * turn.matrix().transpose();
        Gaussian { mean: turn * belief.mean, covariance }
    }

    fn judge(&self, seen: &RelativeObservation, innovation: Option<&Innovation<2>>) -> Judgement {
        let robot = self.slam.robot();
        let at = self.turned(&Gaussian { mean: robot.mean + seen.offset, ..robot }).mean;
        Judgement {
            accepted: innovation.is_none_or(|innovation| innovation.accepted),
            nis: innovation.map(|innovation| innovation.nis),
            degrees_of_freedom: if innovation.is_some() { 2 } else { 0 },
            whitened: innovation.map_or(Whitened::NONE, |i| i.whitened.into()),
            seen_at: Some(Point2::from(at)),
        }
    }
}

impl Localizer for KfSlamMethod {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        if twist.omega.abs() > 1e-9 {
            return Err(Error::Unsuitable {
                method: "kf-slam".into(),
                expected: "a robot that never turns",
                source_name: self.setup_name.clone(),
            });
        }
        self.drive_to(stamp)?;
        self.twist = *twist;
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        if stamp < self.stamp - 1e-9 {
            return Ok(vec![Judgement::REFUSED; observations.len()]);
        }
        self.drive_to(stamp)?;
        let relative: Vec<_> = observations.iter().map(|seen| self.relative(seen)).collect();
        let used: Vec<RelativeObservation> = relative.iter().flatten().copied().collect();
        let innovations = self.slam.correct(&used)?;
        let mut judged = used.iter().zip(&innovations);
        let judge = |seen: &Option<RelativeObservation>| {
            let pair = seen.as_ref().and_then(|_| judged.next());
            pair.map_or(Judgement::REFUSED, |(seen, found)| self.judge(seen, found.as_ref()))
        };
        Ok(relative.iter().map(judge).collect())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        let robot = self.turned(&self.slam.robot());
        let mut ahead = Vector2::new(self.twist.vx, self.twist.vy) * (stamp - self.stamp).max(0.0);
        ahead = Rotation2::new(self.heading) * ahead;
        let mut covariance = Matrix3::zeros();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&robot.covariance);
        Ok(Estimate {
            pose: Pose2::new(robot.mean.x + ahead.x, robot.mean.y + ahead.y, self.heading),
            covariance: Some(covariance),
            rail: None,
        })
    }

    fn map(&self) -> Result<Option<EstimatedMap>> {
        let describe = |(id, belief): (u32, Gaussian<2>)| MapLandmark {
            id,
            position: self.turned(&belief),
            observations: 1,
            confirmed: true,
        };
        let landmarks = self.slam.landmarks().map(describe).collect();
        Ok(Some(EstimatedMap { numbered: true, landmarks }))
    }
}
