//! What a user may say about a bag.

use loc_core::Pose2;
use loc_core::motion::VelocityNoise;

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
    /// The topic of the inertial unit, or `none`; the only one of its type where left out.
    pub imu_topic: Option<String>,
    /// The topic of the satellite receiver, or `none`; the only one of its type where left out.
    pub fix_topic: Option<String>,
    /// Where the laser sits on the robot, in place of what the transforms say.
    pub mounting: Option<Pose2>,
    /// How much later than its stamp the robot was where its odometry says \[s\]; negative for an
    /// odometry that comes late.
    pub odometry_delay: f64,
    /// Noise that is added to the odometry, with the seed of its stream.
    pub odometry_noise: Option<(VelocityNoise, u64)>,
}
