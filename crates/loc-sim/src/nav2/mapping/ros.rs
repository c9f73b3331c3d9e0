//! Names of topics and frames, and what only a running robot needs.

use crate::Result;
use crate::nav2::AmclParameters;
use crate::nav2::given::Given;

pub(super) fn ros(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let names = &mut parameters.names;
    names.scan_topic = given.name("scan_topic")?;
    names.base_frame = given.name("base_frame_id")?;
    names.odom_frame = given.name("odom_frame_id")?;
    names.map_frame = given.name("global_frame_id")?;
    given.pass_over(&["map_topic"], "the map comes from --map");
    given.pass_over(&["transform_tolerance", "tf_broadcast"], "nothing is broadcast");
    given.pass_over(&["always_reset_initial_pose"], "a run is never reset");
    given.pass_over(&["first_map_only"], "a run has one map");
    given.pass_over(&["use_sim_time"], "time is that of the recording");
    given.pass_over(&["save_pose_rate"], "every pose is saved");
    Ok(())
}
