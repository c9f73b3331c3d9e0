//! `dead-reckoning`: odometry alone, with its growing covariance (E2, E6, E7).

use super::{Estimate, Judgement, Localizer, MethodSettings};
use crate::Result;
use crate::source::Setup;
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2};
use loc_filters::landmark::LandmarkLocalizer;
use loc_maps::LandmarkMap;
use loc_sensors::event::{Control, Measurement};

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
            noise: settings.mcl.motion.path_noise(),
            drive: None,
        })
    }
}

// ANCHOR: adapter
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
// ANCHOR_END: adapter

/// The start pose carried along by the poses of an odometry: `map_from_odom` never changes, while
/// the covariance grows with the way driven and the turning done (E6, E7).
#[derive(Debug)]
struct OdometryDrive {
    belief: Gaussian<3>,
    odometry: Pose2,
}

impl OdometryDrive {
    fn move_to(&mut self, odometry: Pose2, noise: &PathNoise) {
        let mut path = DrivenPath::starting_at(self.odometry);
        path.extend(odometry);
        self.belief = noise.belief_after(&path, &self.belief);
        self.odometry = odometry;
    }
}
