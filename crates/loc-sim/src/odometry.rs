//! Where the odometry of a recording is, whether it tells poses or velocities.

use loc_core::{Pose2, Twist2};
use loc_sensors::event::Control;

/// Where the odometry is.
#[derive(Debug, Clone, Default)]
pub(crate) struct Driven {
    pose: Pose2,
    velocity: Option<(f64, Twist2)>,
}

impl Driven {
    /// Where it was last.
    pub(crate) fn last(&self) -> Pose2 {
        self.pose
    }

    /// The pose at the time of a control; `None` for one that is no motion in the plane.
    pub(crate) fn pose(&mut self, stamp: f64, control: &Control) -> Option<Pose2> {
        match control {
            Control::Odometry(pose) => {
                self.velocity = None;
                self.pose = *pose;
            }
            Control::Velocity(twist) => {
                self.drive_to(stamp);
                self.velocity = Some((stamp, *twist));
            }
            Control::Acceleration(_) => return None,
        }
        Some(self.pose)
    }

    /// Drives on with the last velocity up to a time \[s\].
    pub(crate) fn drive_to(&mut self, stamp: f64) -> Pose2 {
        if let Some((since, twist)) = &mut self.velocity {
            let step = twist.to_vector() * (stamp - *since).max(0.0);
            self.pose = self.pose * Pose2::exp(&step);
            *since = stamp;
        }
        self.pose
    }
}
