//! The recorded bags, where they are there.

use super::all;
use loc_ros::{Recording, RecordingOptions};
use loc_sensors::event::Measurement;
use std::path::PathBuf;

fn bags() -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return None;
    };
    Some(PathBuf::from(folder).join("ros_bags"))
}

/// The numbers of `metadata.yaml`.
#[test]
fn turtlebot4_has_all_its_messages_and_its_laser_at_the_left() {
    let Some(folder) = bags().map(|bags| bags.join("turtlebot4")) else { return };
    let mut bag = loc_ros::open(&folder).unwrap();
    let (messages, notes) = all(bag.as_mut());
    assert!(notes.is_empty(), "{notes:?}");
    let count = |topic: &str| messages.iter().filter(|m| m.0.topic == topic).count();
    assert_eq!(messages.len(), 2425);
    assert_eq!(
        [count("/odom"), count("/tf"), count("/scan"), count("/tf_static")],
        [920, 953, 357, 2]
    );
    let recording = Recording::open(&folder, &RecordingOptions::default()).unwrap();
    let mut scans = 0;
    for moment in recording {
        if let Some(Measurement::Scan { mounting, scan }) = moment.unwrap().measurement {
            scans += 1;
            assert_eq!(scan.ranges.len(), 720);
            assert!((mounting.theta - std::f64::consts::FRAC_PI_2).abs() < 0.01, "{mounting}");
        }
    }
    assert_eq!(scans, 354);
}

#[test]
fn ros1_bags_have_all_their_messages() {
    let Some(folder) = bags() else { return };
    for (file, scans, all_messages) in
        [("pioneer/trace0.bag", 958, 4792), ("stage_sim/simpath2.bag", 634, 3804)]
    {
        let mut bag = loc_ros::open(&folder.join(file)).unwrap();
        let (messages, notes) = all(bag.as_mut());
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(messages.len(), all_messages);
        assert_eq!(messages.iter().filter(|m| m.0.topic == "/base_scan").count(), scans);
    }
}
