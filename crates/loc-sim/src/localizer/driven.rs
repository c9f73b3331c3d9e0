//! Poses of an odometry as the velocities between them, for methods that want those.

use loc_core::{Pose2, Twist2};
use loc_sensors::event::Control;

/// Turns either kind of control into velocities with the time from which on they hold.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct DrivenVelocity {
    /// Time \[s\] and pose of the odometry's last report.
    last: Option<(f64, Pose2)>,
}

impl DrivenVelocity {
    /// The velocity that a control at `stamp` \[s\] tells: from its stamp on, or between the poses
    /// of the odometry now and before, along the arc that joins them. `None` where it tells none.
    pub(super) fn of(&mut self, stamp: f64, control: &Control) -> Option<(f64, Twist2)> {
        match control {
            Control::Velocity(twist) => Some((stamp, *twist)),
            Control::Odometry(pose) => {
                let (before, start) = self.last.replace((stamp, *pose))?;
                let dt = stamp - before;
                let way = start.between(*pose).log() / dt;
                (dt > 0.0).then(|| (before, Twist2::new(way.x, way.y, way.z)))
            }
            Control::Acceleration(_) => None,
        }
    }
}
