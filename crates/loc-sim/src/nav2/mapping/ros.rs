//! What only a running robot needs.

use crate::nav2::given::Given;

pub(super) fn ros(given: &mut Given) {
    given.pass_over(
        &["base_frame_id", "odom_frame_id", "global_frame_id"],
        "a recording names no frames",
    );
    given.pass_over(&["scan_topic"], "a recording has one laser");
    given.pass_over(&["map_topic"], "the map comes from --map");
    given.pass_over(&["transform_tolerance", "tf_broadcast"], "nothing is broadcast");
    given.pass_over(&["always_reset_initial_pose"], "a run is never reset");
    given.pass_over(&["first_map_only"], "a run has one map");
    given.pass_over(&["use_sim_time"], "time is that of the recording");
    given.pass_over(&["save_pose_rate"], "every pose is saved");
}
