//! A bag whose odometry comes late, and one with the parameters of nav2_amcl beside it.

use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::grid::io::{self, ImageFormat, Mode};
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{OccupancyGrid, RayCaster};
use loc_ros::messages::*;
use loc_ros::{McapWriter, RecordingOptions};
use loc_sensors::laser::{LaserScanner, LaserSpec};
use loc_sim::source::Source;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{OdometryDelay, RosOptions, RosRecording};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

fn office() -> OccupancyGrid {
    worlds::office(&WorldSettings { width: 300, height: 300, ..Default::default() }).unwrap().grid
}

/// Where the robot is: it swings to and fro about a clear place.
fn pose(t: f64) -> Pose2 {
    Pose2::new(7.5 + 0.3 * (0.9 * t).sin(), 7.5, 0.8 * (1.5 * t).sin())
}

fn stamp(t: f64) -> Stamp {
    Stamp::from_seconds(1000.0 + t)
}

/// A bag of 12 s with scans on `/front/scan` and an odometry that reports every pose `late` \[s\].
fn bag(folder: &Path, late: f64) -> PathBuf {
    let map = office();
    let laser =
        LaserScanner::new(LaserSpec { beams: 271, ..LaserSpec::hokuyo_ust_10lx() }).unwrap();
    let (walls, mut rng) = (RayCaster::new(&map), stream(1, "laser"));
    let path = folder.join("late.mcap");
    let mut writer = McapWriter::create(&path).unwrap();
    let place = Pose2::new(0.1, 0.0, 0.0);
    let transform = TfMessage {
        transforms: vec![TransformStamped {
            header: Header::new(stamp(0.0), "base_link"),
            child_frame_id: "laser".into(),
            transform: place.into(),
        }],
    };
    writer.write("/tf_static", stamp(0.0).0, &transform).unwrap();
    let foot = TfMessage {
        transforms: vec![TransformStamped {
            header: Header::new(stamp(0.0), "base_footprint"),
            child_frame_id: "base_link".into(),
            transform: Pose { position: [0.0, 0.0, 0.1], orientation: [0.0, 0.0, 0.0, 1.0] },
        }],
    };
    writer.write("/tf_static", stamp(0.0).0, &foot).unwrap();
    for step in 0..240 {
        let t = 0.05 * f64::from(step);
        let mut odometry =
            Odometry { header: Header::new(stamp(t + late), "odom"), ..Odometry::default() };
        odometry.child_frame_id = "base_link".into();
        odometry.pose.pose = (pose(0.0).inverse() * pose(t)).into();
        writer.write("/odom", stamp(t + late).0, &odometry).unwrap();
        if step % 2 == 0 {
            let seen = laser.scan(&walls, pose(t) * place, &mut rng);
            let scan = LaserScan {
                header: Header::new(stamp(t), "laser"),
                angle_min: seen.angle_min as f32,
                angle_max: seen.angle_max as f32,
                angle_increment: seen.angle_increment as f32,
                range_min: seen.range_min as f32,
                range_max: seen.range_max as f32,
                ranges: seen.ranges.iter().map(|range| *range as f32).collect(),
                ..LaserScan::default()
            };
            writer.write("/front/scan", stamp(t).0, &scan).unwrap();
        }
    }
    writer.finish().unwrap();
    path
}

#[test]
fn the_delay_of_a_bag_is_found_told_and_can_be_set() {
    let folder = tempfile::tempdir().unwrap();
    let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
    let mut seen = Vec::new();
    for late in [0.0, 0.12] {
        let path = bag(folder.path(), late);
        let estimated = OdometryDelay::Estimated;
        let known = RecordingOptions { odometry_delay: -0.2, ..RecordingOptions::default() };
        for ros in [
            RosOptions { odometry_delay: estimated, ..RosOptions::default() },
            RosOptions::from(known),
        ] {
            let mut recording = RosRecording::open(&path, &options, &ros).unwrap();
            let first = recording.next_event().unwrap().unwrap();
            assert!(first.stamp >= 1000.0);
            seen.push((recording.odometry_timing().unwrap(), recording.notes().join("\n")));
        }
    }
    let [none, set, late, _] = &seen[..] else { panic!("four") };
    assert_eq!((none.0.delay_s, set.0.delay_s, set.0.estimated_s), (0.0, -0.2, None));
    assert!(none.0.estimated_s.unwrap().abs() < 0.01, "{none:?}");
    assert!(none.1.contains("odometry left in time: not significant"), "{}", none.1);
    assert!(set.1.contains("odometry moved in time by -0.200 s"), "{}", set.1);
    assert!((late.0.delay_s + 0.12).abs() < 0.01 && late.0.sigma_s.unwrap() < 0.01, "{late:?}");
    assert!(late.1.contains("odometry moved in time by -0.1"), "{}", late.1);
}

/// The summary of a replay with the parameters of nav2_amcl, and what it says on standard error.
fn with_parameters(folder: &Path, lines: &[&str]) -> (Value, String) {
    let lines: String = lines.iter().map(|line| format!("    {line}\n")).collect();
    std::fs::write(folder.join("amcl.yaml"), format!("amcl:\n  ros__parameters:\n{lines}"))
        .unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_loc-sim"))
        .current_dir(folder)
        .args(["replay", "late.mcap", "--map", "office.yaml", "--config", "amcl.yaml", "--json"])
        .output()
        .unwrap();
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{reported}");
    (serde_json::from_slice(&output.stdout).unwrap(), reported)
}

#[test]
fn the_parameters_of_nav2_serve_a_bag() {
    let folder = tempfile::tempdir().unwrap();
    bag(folder.path(), 0.12);
    io::save(&office(), folder.path().join("office.yaml"), ImageFormat::Pgm, Mode::Trinary)
        .unwrap();
    let start = ["set_initial_pose: true", "initial_pose.x: 7.5", "initial_pose.y: 7.5"];
    let fits = [
        "scan_topic: front/scan",
        "base_frame_id: base_footprint",
        "odom_frame_id: odom",
        "global_frame_id: map",
        "laser_importance: 3",
    ];
    let notes = |summary: &Value| -> String {
        let notes = summary["notes"].as_array().unwrap();
        notes.iter().map(|note| note.as_str().unwrap()).collect::<Vec<_>>().join("\n")
    };
    let (summary, reported) = with_parameters(folder.path(), &[&start[..], &fits].concat());
    assert!(reported.contains("amcl.yaml:10: laser_importance: not a parameter"), "{reported}");
    assert!(
        !reported.contains("scan_topic") && !notes(&summary).contains("not in the bag"),
        "{reported}"
    );
    assert!((summary["odometry"]["delay_s"].as_f64().unwrap() + 0.12).abs() < 0.01);
    assert!(summary["methods"]["mcl"]["beam_fit_at_end"].as_f64().unwrap() > 0.95, "{summary}");
    let used = summary["methods"]["mcl"]["measurements_used"].as_u64().unwrap();
    assert!(used > 20, "{used}");
    // Parameters are taken over, and names that the bag has not are said.
    let other = [
        "update_min_d: 100.0",
        "update_min_a: 6.0",
        "scan_topic: scan",
        "base_frame_id: chassis",
        "odom_frame_id: wheels",
    ];
    let (summary, _) = with_parameters(folder.path(), &[&start[..], &other].concat());
    assert_eq!(summary["methods"]["mcl"]["measurements_used"], 1);
    let notes = notes(&summary);
    for note in [
        "scan_topic scan: not in the bag, /front/scan taken",
        "base_frame_id chassis: not in the bag, base_link taken",
        "odom_frame_id wheels: not in the bag, odom taken",
    ] {
        assert!(notes.contains(note), "{notes}");
    }
}
