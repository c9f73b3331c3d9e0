//! `dead-reckoning`: odometry alone, with its growing covariance (E2, E6).

use super::{Estimate, Judgement, Localizer, MethodSettings};
use crate::Result;
use crate::event::{Control, Measurement};
use crate::source::Setup;
use loc_core::motion::{OdometryMotion, OdometryNoise};
use loc_core::{Gaussian, Pose2};
use loc_filters::landmark::LandmarkLocalizer;
use loc_maps::LandmarkMap;
use loc_pf::MclSettings;
use nalgebra::Matrix3;

/// Velocities by the prediction step of the landmark filter, without its corrections; poses of an
/// odometry by [`OdometryDrive`].
#[derive(Debug)]
pub(super) struct DeadReckoning {
    velocities: LandmarkLocalizer,
    start: Gaussian<3>,
    mcl: MclSettings,
    drive: Option<OdometryDrive>,
}

impl DeadReckoning {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let (none, start) = (LandmarkMap::default(), setup.start_belief);
        Ok(DeadReckoning {
            velocities: LandmarkLocalizer::new(none, settings.landmark, setup.start, start)?,
            start,
            mcl: settings.mcl.clone(),
            drive: None,
        })
    }
}

impl Localizer for DeadReckoning {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        match control {
            Control::Velocity(twist) => self.velocities.velocity(stamp, *twist)?,
            Control::Odometry(pose) => {
                let begin = || OdometryDrive { belief: self.start, anchor: *pose, odometry: *pose };
                self.drive.get_or_insert_with(begin).move_to(*pose, &self.mcl);
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
            Some(drive) => drive.ahead(&self.mcl.motion).into(),
            None => self.velocities.estimate(stamp)?.into(),
        })
    }
}

/// The start pose carried along by the poses of an odometry: `map_from_odom` never changes.
///
/// The covariance grows by the odometry model (turn, drive, turn) with the noise of the particle
/// filter, in steps as long as those of its updates: the model's variances depend on the length of
/// a step, and the messages of an odometry may be any length apart.
#[derive(Debug)]
struct OdometryDrive {
    /// The belief at the end of the last whole step.
    belief: Gaussian<3>,
    /// The odometry there.
    anchor: Pose2,
    /// The odometry now.
    odometry: Pose2,
}

impl OdometryDrive {
    fn move_to(&mut self, odometry: Pose2, settings: &MclSettings) {
        self.odometry = odometry;
        let step = self.anchor.between(odometry);
        let far = f64::hypot(step.x, step.y) >= settings.update_distance;
        if far || step.theta.abs() >= settings.update_turn {
            self.belief = self.ahead(&settings.motion);
            self.anchor = odometry;
        }
    }

    /// The belief at the odometry of now.
    fn ahead(&self, noise: &OdometryNoise) -> Gaussian<3> {
        let motion = OdometryMotion::between(self.anchor, self.odometry);
        let pose = self.belief.pose();
        let (_, by_pose, by_step) = motion.apply_with_jacobians(pose);
        let variances = Matrix3::from_diagonal(&motion.variances(noise));
        let covariance = by_pose * self.belief.covariance * by_pose.transpose()
            + by_step * variances * by_step.transpose();
        // The pose itself is chained exactly, whatever the model leaves out of a tiny step.
        let pose = pose * self.anchor.between(self.odometry);
        Gaussian { mean: pose.to_vector(), covariance }
    }
}
