//! `dead-reckoning`: odometry alone, with its growing covariance (E2, E6, E7).

use super::{Estimate, Judgement, Localizer, MethodSettings};
use crate::Result;
use crate::event::{Control, Measurement};
use crate::source::Setup;
use loc_core::{Gaussian, Pose2};
use loc_filters::landmark::LandmarkLocalizer;
use loc_maps::LandmarkMap;
use loc_pf::motion::PathNoise;
use nalgebra::{Matrix3, Vector3};

/// Velocities by the prediction step of the landmark filter, without its corrections; poses of an
/// odometry by [`OdometryDrive`].
#[derive(Debug)]
pub(super) struct DeadReckoning {
    velocities: LandmarkLocalizer,
    start: Gaussian<3>,
    noise: PathNoise,
    drive: Option<OdometryDrive>,
}

impl DeadReckoning {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let (none, start) = (LandmarkMap::default(), setup.start_belief);
        Ok(DeadReckoning {
            velocities: LandmarkLocalizer::new(none, settings.landmark, setup.start, start)?,
            start,
            noise: settings.mcl.motion,
            drive: None,
        })
    }
}

impl Localizer for DeadReckoning {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        match control {
            Control::Velocity(twist) => self.velocities.velocity(stamp, *twist)?,
            Control::Odometry(pose) => {
                let begin = || OdometryDrive { belief: self.start, odometry: *pose };
                self.drive.get_or_insert_with(begin).move_to(*pose, &self.noise);
            }
            Control::Acceleration(_) => {}
        }
        Ok(())
    }

    fn correct(&mut self, _stamp: f64, _measurement: &Measurement) -> Result<Vec<Judgement>> {
        Ok(Vec::new())
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(match &self.drive {
            Some(drive) => drive.belief.into(),
            None => self.velocities.estimate(stamp)?.into(),
        })
    }
}

/// The start pose carried along by the poses of an odometry: `map_from_odom` never changes.
///
/// The covariance grows by the noise of the particle filter, which is in proportion to the way, so
/// that it does not matter how far apart the messages are. Its faults of the odometry are left
/// out: they are no Gaussian.
#[derive(Debug)]
struct OdometryDrive {
    belief: Gaussian<3>,
    odometry: Pose2,
}

impl OdometryDrive {
    fn move_to(&mut self, odometry: Pose2, noise: &PathNoise) {
        let step = self.odometry.between(odometry);
        let pose = self.belief.pose();
        let (next, by_pose, by_step) = pose.compose_jacobians(step);
        // On the average over the step the heading is off by half of what it is off at its end.
        let (half_x, half_y) = (0.5 * step.x, 0.5 * step.y);
        let by_noise = by_step * Matrix3::new(1.0, 0.0, -half_y, 0.0, 1.0, half_x, 0.0, 0.0, 1.0);
        let variances = Matrix3::from_diagonal(&variances(step, noise));
        let covariance = by_pose * self.belief.covariance * by_pose.transpose()
            + by_noise * variances * by_noise.transpose();
        self.belief = Gaussian { mean: next.to_vector(), covariance };
        self.odometry = odometry;
    }
}

/// Variances along the step, across it and of the heading \[m^2, m^2, rad^2\].
fn variances(step: Pose2, noise: &PathNoise) -> Vector3<f64> {
    let (length, turned) = (f64::hypot(step.x, step.y), step.theta.abs());
    let squared = [noise.along, noise.across, noise.drift, noise.turn, noise.pivot].map(|s| s * s);
    let [along, across, drift, turn, pivot] = squared;
    Vector3::new(
        along * length + pivot * turned,
        across * length + pivot * turned,
        drift * length + turn * turned,
    )
}
