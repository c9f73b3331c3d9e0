//! What a user may say about a bag.

use loc_core::Pose2;
use loc_core::motion::VelocityNoise;

/// How much later than its stamp the robot was where its odometry says; negative for an odometry
/// that comes late.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OdometryDelay {
    /// This much \[s\]; 0 for stamps as they are.
    Known(f64),
    /// As much as the turns of the scans say, where that is significant: the bag is read once more
    /// up to where they say enough. See [`loc_pf::delay`].
    Estimated,
}

impl Default for OdometryDelay {
    fn default() -> Self {
        OdometryDelay::Known(0.0)
    }
}

/// Names that a parameter file of nav2_amcl gives. A bag that has none of a name is read without
/// it, and a note says so.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosNames {
    /// The topic with the scans (`scan_topic`).
    pub scan_topic: Option<String>,
    /// The frame of the robot (`base_frame_id`).
    pub base_frame: Option<String>,
    /// The frame of the odometry (`odom_frame_id`).
    pub odom_frame: Option<String>,
    /// The frame of the map (`global_frame_id`).
    pub map_frame: Option<String>,
}

/// What is not found in a bag by itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RosOptions {
    /// The topic with the scans; the only one of a type of scans where left out.
    pub scan_topic: Option<String>,
    /// The topic with the odometry; the only one of its type where left out.
    pub odom_topic: Option<String>,
    /// The topic with the true poses, `/tf` for the transform from the map that was recorded, or
    /// `none`; found by its name where left out.
    pub reference_topic: Option<String>,
    /// Names to use where the bag has them and nothing else is said.
    pub names: RosNames,
    /// The topic of the inertial unit, or `none`; the only one of its type where left out.
    pub imu_topic: Option<String>,
    /// The topic of the satellite receiver, or `none`; the only one of its type where left out.
    pub fix_topic: Option<String>,
    /// Where the laser sits on the robot, in place of what the transforms say.
    pub mounting: Option<Pose2>,
    /// What is added to the stamps of the odometry.
    pub odometry_delay: OdometryDelay,
    /// Noise that is added to the odometry, with the seed of its stream.
    pub odometry_noise: Option<(VelocityNoise, u64)>,
}
