//! Folders of recordings with landmarks or ranges; the first byte says of which kind, the files have
//! zero bytes between them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_sim::source::landmarks::Trees;
use loc_sim::source::ranging::RangingStart;
use loc_sim::source::{LandmarkRecording, RangeRecording};

const SIGMAS: [f64; 3] = [0.1; 3];

fuzz_target!(|data: &[u8]| {
    let Some((kind, rest)) = data.split_first() else { return };
    let folder = loc_fuzz::folder();
    match kind % 6 {
        0 => {
            loc_fuzz::files(&["a_Input.txt", "a_GT.txt"], rest);
            loc_fuzz::replay(RangeRecording::labyrinth(folder, &RangingStart::default()));
        }
        1 => {
            let parts = [
                "plaza1_ranges.csv",
                "plaza1_odometry.csv",
                "plaza1_beacons.csv",
                "plaza1_groundtruth.csv",
            ];
            loc_fuzz::files(&parts, rest);
            loc_fuzz::replay(RangeRecording::plaza(folder, 1, &RangingStart::default()));
        }
        2 => {
            loc_fuzz::files(&["sensor_data.dat", "world.dat"], rest);
            loc_fuzz::replay(LandmarkRecording::course(folder, SIGMAS));
        }
        3 => {
            let parts = [
                "kf_bearing_range.csv",
                "kf_odometry.csv",
                "kf_ground_truth.txt",
                "kf_ground_truth_robot_path.txt",
            ];
            loc_fuzz::files(&parts, rest);
            loc_fuzz::replay(LandmarkRecording::kf_slam_demo(folder, SIGMAS));
        }
        4 => {
            loc_fuzz::files(&["gps.csv", "gtsam_odometry.csv", "gtsam_landmark_obs.csv"], rest);
            loc_fuzz::replay(LandmarkRecording::victoria_park(folder, Trees::Numbered, SIGMAS));
        }
        _ => {
            loc_fuzz::files(&["gps.csv", "dead_reckoning.csv", "tree_detections.csv"], rest);
            loc_fuzz::replay(LandmarkRecording::victoria_park(folder, Trees::Detected, SIGMAS));
        }
    }
});
