//! `info` of every format, and the MCAP files that `run` and `replay` write.

use super::formats::{bags, drive};
use loc_ros::McapReader;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

fn loc_sim(folder: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Format, and topics with type and number, as `info --json` tells them.
fn info(folder: &Path, log: &str) -> (String, Vec<(String, String, u64)>) {
    let json: Value = serde_json::from_str(&loc_sim(folder, &["info", log, "--json"])).unwrap();
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    let topic = |row: &Value| {
        let count = row["count"].as_u64().unwrap();
        let span = row["end_s"].as_f64().unwrap() - row["start_s"].as_f64().unwrap();
        // A rate is printed where there is time for one.
        assert_eq!(row["rate_hz"].is_f64(), span > 0.0, "{row}");
        (text(&row["topic"]), text(&row["type"]), count)
    };
    let topics: Vec<_> = json["topics"].as_array().unwrap().iter().map(topic).collect();
    let messages = topics.iter().map(|(.., count)| count).sum::<u64>();
    assert_eq!(json["messages"].as_u64().unwrap(), messages);
    assert!(json["duration_s"].as_f64().unwrap() > 0.0);
    (text(&json["format"]), topics)
}

fn check(folder: &Path, log: &str, format: &str, expected: &[(&str, &str, u64)]) {
    let (found, topics) = info(folder, log);
    let topics: Vec<_> =
        topics.iter().map(|(t, kind, count)| (t.as_str(), kind.as_str(), *count)).collect();
    assert_eq!((found.as_str(), topics.as_slice()), (format, expected), "{log}");
}

#[test]
fn info_of_bags() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in bags(&drive()) {
        fs::write(folder.path().join(name), &bytes).unwrap();
        let (between, odometry) = if name == "a.bag" { ("/", 4) } else { ("/msg/", 4) };
        let of = |package: &str, kind: &str| format!("{package}{between}{kind}");
        let types =
            [("nav_msgs", "Odometry"), ("sensor_msgs", "LaserScan"), ("tf2_msgs", "TFMessage")]
                .map(|(package, kind)| of(package, kind));
        let expected = [
            ("/odom", types[0].as_str(), odometry),
            ("/scan", &types[1], 4),
            ("/tf_static", &types[2], 1),
        ];
        check(folder.path(), name, "ros", &expected);
    }
    // A folder of ROS 2, and the table with its rate.
    let bag = folder.path().join("bag");
    fs::create_dir(&bag).unwrap();
    fs::rename(folder.path().join("a.db3"), bag.join("bag_0.db3")).unwrap();
    let table = loc_sim(folder.path(), &["info", "bag"]);
    assert!(table.starts_with("bag: ros, 9 messages, 3.0 s from 1.000 s\n"), "{table}");
    let row = table.lines().find(|line| line.starts_with("/odom")).unwrap();
    let words: Vec<&str> = row.split_whitespace().collect();
    assert_eq!(words, ["/odom", "nav_msgs/msg/Odometry", "4", "1.00", "3.0"], "{table}");
    assert!(table.contains("note: has no metadata.yaml"), "{table}");
}

#[test]
fn info_of_logs() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write(
        "a.log",
        "ODOM 0 0 0 0 0 0 9.5 host 9.5\nODOM 1 0 0 0 0 0 10.5 host 10.5\n\
         FLASER 3 1.0 2.0 90.0 1.2 2.0 0.5 1.0 2.0 0.5 9.6 host 9.6\n\
         TRUEPOS 5 6 0.5 0 0 0 10 host 10\n",
    );
    let scan = ("laser", "scan", 1);
    check(folder.path(), "a.log", "carmen", &[("odometry", "pose", 2), scan, ("truth", "pose", 1)]);
    let ranges = vec!["150"; 180].join(" ");
    write("b.log", &format!("O 100 0 0 0.1\nO 110 0 0 0.2\nL 100 0 0 125 0 0 {ranges} 0.3\n"));
    check(folder.path(), "b.log", "wean", &[("odometry", "pose", 2), ("laser", "scan", 1)]);
    let mrclam = folder.path().join("mrclam");
    fs::create_dir(&mrclam).unwrap();
    for (name, text) in [
        ("Barcodes.dat", "1 5\n6 63\n"),
        ("Landmark_Groundtruth.dat", "6 2.0 0.0 0.001 0.001\n"),
        ("Robot1_Groundtruth.dat", "0.0 0 0 0\n1.0 0.1 0 0\n"),
        ("Robot1_Odometry.dat", "0.0 0.1 0.0\n0.5 0.1 0.0\n1.0 0.0 0.0\n"),
        ("Robot1_Measurement.dat", "0.5 63 1.95 0.0\n"),
    ] {
        fs::write(mrclam.join(name), text).unwrap();
    }
    check(
        folder.path(),
        "mrclam",
        "mrclam",
        &[
            ("robot 1: odometry", "velocity", 3),
            ("robot 1: truth", "pose", 2),
            ("robot 1: landmarks", "range and bearing", 1),
        ],
    );
}

/// The topics of an MCAP file with their types.
fn topics(file: &Path) -> BTreeMap<String, String> {
    let (messages, notes) = super::all(&mut McapReader::open(file).unwrap());
    assert!(notes.is_empty(), "{notes:?}");
    messages.into_iter().map(|(channel, ..)| (channel.topic, channel.type_name)).collect()
}

const OF_A_LASER: [(&str, &str); 11] = [
    ("/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped"),
    ("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray"),
    ("/ground_truth", "nav_msgs/msg/Path"),
    ("/map", "nav_msgs/msg/OccupancyGrid"),
    ("/odom", "nav_msgs/msg/Odometry"),
    ("/particle_cloud", "nav2_msgs/msg/ParticleCloud"),
    ("/particle_poses", "geometry_msgs/msg/PoseArray"),
    ("/scan", "sensor_msgs/msg/LaserScan"),
    ("/scan_points", "sensor_msgs/msg/PointCloud2"),
    ("/tf", "tf2_msgs/msg/TFMessage"),
    ("/tf_static", "tf2_msgs/msg/TFMessage"),
];

/// The run of a robot with a laser, its MCAP file replayed in the map that it carries, and a run
/// among landmarks: all topics that viewers look for, with their types.
#[test]
fn runs_and_replays_write_what_viewers_know() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let laser = OF_A_LASER.map(|(topic, kind)| (topic.to_owned(), kind.to_owned()));
    let short = ["--set", "tour.duration=2", "--method", "mcl", "--mcap", "run.mcap"];
    loc_sim(path, &[&["run", "position-tracking"][..], &short].concat());
    assert_eq!(topics(&path.join("run.mcap")), BTreeMap::from(laser.clone()));
    let yaml = "image: map.pgm\nresolution: 0.5\norigin: [-10, -10, 0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    fs::write(path.join("map.yaml"), yaml).unwrap();
    let image = [b"P5 40 40 255\n".as_slice(), &[254; 1600]].concat();
    fs::write(path.join("map.pgm"), image).unwrap();
    let (_, bag) = bags(&drive()).remove(0);
    fs::write(path.join("a.mcap"), bag).unwrap();
    let replay = ["replay", "a.mcap", "--map", "map.yaml", "--initial-pose", "0,0,0"];
    let printed = loc_sim(path, &[&replay[..], &["--mcap", "replay.mcap"]].concat());
    assert!(printed.contains("times as fast as it was"), "{printed}");
    let replayed = topics(&path.join("replay.mcap"));
    // The truth is unknown here; the second method has a topic of its own.
    let mut expected = BTreeMap::from(laser);
    expected.remove("/ground_truth");
    let pose = expected["/amcl_pose"].clone();
    expected.insert("/dead_reckoning/pose".into(), pose);
    assert_eq!(replayed, expected);
    let short = ["--method", "ekf", "--mcap", "landmarks.mcap"];
    loc_sim(path, &[&["run", "landmark-drive"][..], &short].concat());
    let among = topics(&path.join("landmarks.mcap"));
    assert_eq!(among["/landmarks"], "geometry_msgs/msg/PoseArray");
    let names: BTreeSet<&str> = among.keys().map(String::as_str).collect();
    for name in ["/amcl_pose", "/ground_truth", "/odom", "/tf", "/diagnostics"] {
        assert!(names.contains(name), "{names:?}");
    }
}
