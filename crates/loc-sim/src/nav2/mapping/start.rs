//! Where the robot starts.

use crate::Result;
use crate::nav2::AmclParameters;
use crate::nav2::given::{Found, Given};
use loc_core::Pose2;

/// The start pose, and how well it is known.
pub(super) fn start(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let mut covariance = |key: &str| {
        given.number(&format!("initial_pose.covariance_{key}"), "a number >= 0", |v| v >= 0.0)
    };
    let variances = [covariance("x")?, covariance("y")?, covariance("yaw")?];
    parameters.start_sigmas = variances.map(|found| found.map(|found| found.value.sqrt()));
    for key in ["covariance_xy", "covariance_xyaw", "covariance_yyaw"] {
        let key = format!("initial_pose.{key}");
        let found = given.number(&key, "a number", |_| true)?;
        if let Some(found) = found.filter(|found| found.value.abs() > 0.0) {
            given.warn(found.line, &key, "the start pose has independent deviations");
        }
    }
    if !given.flag("set_initial_pose")?.is_some_and(|set| set.value) {
        let keys = ["x", "y", "z", "yaw"].map(|key| format!("initial_pose.{key}"));
        given.pass_over(&keys, "set_initial_pose is not true");
        return Ok(());
    }
    let mut number = |key: &str| given.number(&format!("initial_pose.{key}"), "a number", |_| true);
    let [x, y, yaw, z] = [number("x")?, number("y")?, number("yaw")?, number("z")?];
    if let Some(z) = z.filter(|z| z.value.abs() > 0.0) {
        given.warn(z.line, "initial_pose.z", "the robot drives in the plane");
    }
    let or_zero = |found: Option<Found<f64>>| found.map_or(0.0, |found| found.value);
    parameters.start = Some(Pose2::new(or_zero(x), or_zero(y), or_zero(yaw)));
    Ok(())
}
