//! Bags carried over into MCAP.

use super::all;
use super::write::{bag1, chunk1, connection1, message1};
use loc_ros::messages::{LaserScan, Message, definition};
use loc_ros::transcribe;
use loc_ros::{Dialect, Encoding, McapReader, McapWriter, open};
use std::path::Path;

fn transcribed(bag: &Path) -> (Vec<super::Read>, u64, Vec<String>) {
    let out = bag.with_extension("out.mcap");
    let writer = McapWriter::create(&out).unwrap();
    let converted = transcribe(open(bag).unwrap().as_mut(), writer, &mut |_| {}).unwrap();
    let (messages, notes) = all(&mut McapReader::open(&out).unwrap());
    assert!(notes.is_empty(), "{notes:?}");
    (messages, converted.written, converted.left_out)
}

/// A message of ROS 1 keeps every field; a type that is not known, and a message that is cut off,
/// are counted.
#[test]
fn messages_of_ros_1_become_messages_of_ros_2() {
    let scan = LaserScan {
        range_max: 8.0,
        ranges: vec![1.5, f32::NAN, f32::INFINITY],
        intensities: vec![7.0; 3],
        ..LaserScan::default()
    };
    let bytes = scan.to_bytes(Dialect::Ros1);
    let records = [
        connection1(0, "/scan", "sensor_msgs/LaserScan"),
        connection1(1, "/battery", "robot_msgs/Battery"),
        message1(0, 100, &bytes),
        message1(1, 101, &[1, 2, 3]),
        message1(0, 102, &bytes[..bytes.len() - 2]),
    ];
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("a.bag");
    std::fs::write(&bag, bag1(&[chunk1("none", &records.concat())])).unwrap();
    let (messages, written, left_out) = transcribed(&bag);
    assert_eq!((messages.len(), written), (1, 1));
    let (channel, time, data) = &messages[0];
    assert_eq!(channel.topic, "/scan");
    assert_eq!((channel.type_name.as_str(), *time), (LaserScan::NAME, 100_000_000_000));
    let again = LaserScan::from_bytes(data, &channel.encoding).unwrap();
    assert_eq!(format!("{again:?}"), format!("{scan:?}"));
    assert!(
        left_out.iter().any(|line| line == "1 messages on /battery of type robot_msgs/Battery")
    );
    assert!(left_out.iter().any(|line| line.starts_with("1 messages on /scan (")), "{left_out:?}");
}

/// Whatever its type, a message of ROS 2 keeps its bytes.
#[test]
fn messages_of_ros_2_keep_their_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let bag = folder.path().join("b.mcap");
    let mut writer = McapWriter::create(&bag).unwrap();
    writer.write_bytes("/odd", "robot_msgs/msg/Odd", 5, &[0, 1, 0, 0, 42]).unwrap();
    writer.write("/scan", 6, &LaserScan::default()).unwrap();
    assert!(writer.write_bytes("/odd", "robot_msgs/msg/Other", 7, &[]).is_err());
    writer.finish().unwrap();
    let (messages, written, left_out) = transcribed(&bag);
    assert_eq!((messages.clone(), written), (all(&mut McapReader::open(&bag).unwrap()).0, 2));
    assert_eq!(messages[0].2, [0, 1, 0, 0, 42]);
    assert_eq!(messages[0].0.encoding, Encoding::Cdr);
    assert!(left_out.is_empty());
}

/// Every field of a type is itself defined.
#[test]
fn every_type_that_is_written_is_defined() {
    for name in ["sensor_msgs/msg/MultiEchoLaserScan", "sensor_msgs/msg/NavSatFix"] {
        let text = definition(name);
        assert!(text.contains("MSG: sensor_msgs/"), "{name}: {text}");
    }
}
