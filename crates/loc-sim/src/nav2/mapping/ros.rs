//! Names of topics and frames, and what only a running robot needs.

use crate::Result;
use crate::nav2::AmclParameters;
use crate::nav2::given::Given;

pub(super) fn ros(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let names = &mut parameters.names;
    for (key, name, reason) in [
        ("scan_topic", &mut names.scan_topic, "a recording has one laser"),
        ("base_frame_id", &mut names.base_frame, "a recording names no frames"),
        ("odom_frame_id", &mut names.odom_frame, "a recording names no frames"),
        ("global_frame_id", &mut names.map_frame, "a recording names no frames"),
    ] {
        if let Some(found) = given.name(key)? {
            parameters.without_bag.push(given.warning(found.line, key, reason));
            *name = Some(found.value);
        }
    }
    given.pass_over(&["map_topic"], "the map comes from --map");
    given.pass_over(&["transform_tolerance", "tf_broadcast"], "nothing is broadcast");
    given.pass_over(&["always_reset_initial_pose"], "a run is never reset");
    given.pass_over(&["first_map_only"], "a run has one map");
    given.pass_over(&["use_sim_time"], "time is that of the recording");
    given.pass_over(&["save_pose_rate"], "every pose is saved");
    Ok(())
}
