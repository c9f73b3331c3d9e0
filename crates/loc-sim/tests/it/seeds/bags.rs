//! Bags, whole and with the parts of which they are made.

use super::Corpus;
use crate::ros::database::{DB3, WAL_DB3, WAL_LOG, bytes};
use crate::ros::write;
use loc_core::Pose2;
use loc_ros::messages::*;
use loc_ros::{Bag1, Bag2, McapReader, McapWriter};
use loc_sim::source::Source;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{RosOptions, RosRecording};

#[test]
fn bags_of_ros_1() {
    let corpus = Corpus::of("bag1");
    let records = [
        write::connection1(4, "/a", "std_msgs/String"),
        write::message1(4, 1, b"one"),
        write::message1(4, 2, b"two"),
    ]
    .concat();
    for compression in ["none", "bz2", "lz4"] {
        let bag = write::bag1(&[write::chunk1(compression, &records)]);
        let path = corpus.put(compression, &bag);
        assert_eq!(crate::ros::all(&mut Bag1::open(&path).unwrap()).0.len(), 2);
    }
    let loose = write::connection1(4, "/a", "std_msgs/String");
    corpus.put(
        "two-chunks",
        &write::bag1(&[loose, write::chunk1("none", &records)].map(|r| r.repeat(2))),
    );
}

#[test]
fn mcap_files() {
    let corpus = Corpus::of("mcap");
    let records = [
        write::channel(1, "/a", "std_msgs/msg/String"),
        write::message(1, 1, b"one"),
        write::message(1, 2, b"two"),
    ]
    .concat();
    for compression in ["", "lz4", "zstd"] {
        let file = write::mcap(&[write::chunk(compression, &records, true)]);
        let path = corpus.put(&format!("chunk-{compression}"), &file);
        assert_eq!(crate::ros::all(&mut McapReader::open(&path).unwrap()).0.len(), 2);
    }
    corpus.put("loose", &write::mcap(&[records]));
    let indexed = corpus.put("indexed", &[]);
    let mut writer = McapWriter::create(&indexed).unwrap();
    writer.write("/scan", 6, &LaserScan::default()).unwrap();
    writer.finish().unwrap();
}

#[test]
fn databases() {
    let corpus = Corpus::of("sqlite");
    let with = |kind: &[u8], parts: &[&[u8]]| [kind, &parts.concat()].concat();
    corpus.put("database", &with(b"D", &[&bytes(DB3)]));
    let (database, log) = (bytes(WAL_DB3), bytes(WAL_LOG));
    let length = u16::try_from(log.len()).unwrap().to_le_bytes();
    corpus.put("logged", &with(b"L", &[&length, &log, &database]));
    corpus.put("empty", &with(b"D", &[&database]));
    for (name, mode) in [("plain", ""), ("packed", "MESSAGE"), ("packed-file", "FILE")] {
        let text = format!(
            "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  \
             compression_format: zstd\n  compression_mode: '{mode}'\n  relative_file_paths:\n    - \
             bag_0.db3\n"
        );
        corpus.put(name, &with(b"M", &[text.as_bytes()]));
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("metadata.yaml"), text).unwrap();
        assert_eq!(Bag2::open(folder.path()).is_err(), mode == "FILE");
    }
}

/// A bag with everything that a recording is joined from.
#[test]
fn recordings() {
    let corpus = Corpus::of("recording");
    let path = corpus.put("joined", &[]);
    let mut writer = McapWriter::create(&path).unwrap();
    let at = |k: i64| Stamp(1_000_000_000 * (k + 1));
    let transform = |k: i64, parent: &str, child: &str| TransformStamped {
        header: Header::new(at(k), parent),
        child_frame_id: child.into(),
        transform: Pose2::new(0.1 * k as f64, 0.0, 0.0).into(),
    };
    let transforms = vec![transform(0, "base", "laser")];
    writer.write("/tf_static", at(0).0, &TfMessage { transforms }).unwrap();
    for k in 0..3 {
        let mut odometry = Odometry { header: Header::new(at(k), "odom"), ..Odometry::default() };
        odometry.child_frame_id = "base".into();
        writer.write("/odom", at(k).0, &odometry).unwrap();
        let transforms = vec![transform(k, "map", "odom")];
        writer.write("/tf", at(k).0, &TfMessage { transforms }).unwrap();
        let scan = LaserScan {
            header: Header::new(at(k), "laser"),
            angle_min: -0.5,
            angle_max: 0.5,
            angle_increment: 0.5,
            range_max: 10.0,
            ranges: vec![1.0, 2.0, f32::INFINITY],
            ..LaserScan::default()
        };
        writer.write("/scan", at(k).0, &scan).unwrap();
        let header = Header::new(at(k), "base");
        writer.write("/imu", at(k).0, &Imu { header: header.clone(), ..Imu::default() }).unwrap();
        let fix = NavSatFix { header: header.clone(), latitude: 52.0, ..NavSatFix::default() };
        writer.write("/fix", at(k).0, &fix).unwrap();
        let pose = PoseStamped { header, ..PoseStamped::default() };
        writer.write("/ground_truth", at(k).0, &pose).unwrap();
    }
    writer.finish().unwrap();
    let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
    let mut recording = RosRecording::open(&path, &options, &RosOptions::default()).unwrap();
    assert!(std::iter::from_fn(|| recording.next_event().unwrap()).count() > 3);
}
