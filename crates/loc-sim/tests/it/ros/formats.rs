//! The same messages in every format: what is wrong with them is said the same way.

use super::database::database;
use super::write::{self, bag1, chunk1, connection1, message1};
use loc_core::Pose2;
use loc_ros::Dialect;
use loc_ros::messages::*;
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sim::source::Source;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{RosOptions, RosRecording};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A message in the bytes of both generations of ROS.
#[derive(Clone)]
pub(super) struct Stored {
    topic: &'static str,
    type_name: &'static str,
    /// When it was recorded \[s\].
    time: u32,
    cdr: Vec<u8>,
    ros1: Vec<u8>,
}

pub(super) fn stored<M: Message>(topic: &'static str, time: u32, message: &M) -> Stored {
    let [cdr, ros1] = [Dialect::Cdr, Dialect::Ros1].map(|dialect| message.to_bytes(dialect));
    Stored { topic, type_name: M::NAME, time, cdr, ros1 }
}

/// The messages as a bag of each format, with its name.
pub(super) fn bags(messages: &[Stored]) -> Vec<(&'static str, Vec<u8>)> {
    let mut topics: Vec<(&str, &str)> = messages.iter().map(|m| (m.topic, m.type_name)).collect();
    topics.sort_unstable();
    topics.dedup();
    let number = |m: &Stored| topics.iter().position(|(topic, _)| *topic == m.topic).unwrap();
    let named = || (0_u16..).zip(&topics);
    let nanoseconds = |m: &Stored| u64::from(m.time) * 1_000_000_000;
    let channels: Vec<u8> = named().flat_map(|(k, (t, n))| write::channel(k + 1, t, n)).collect();
    let of_mcap = |m: &Stored| write::message(number(m) as u16 + 1, nanoseconds(m), &m.cdr);
    let of_mcap: Vec<u8> = messages.iter().flat_map(of_mcap).collect();
    let of_mcap = [channels, of_mcap].concat();
    let connections: Vec<u8> = named()
        .flat_map(|(k, (t, n))| connection1(k.into(), t, &n.replace("/msg/", "/")))
        .collect();
    let of_bag1 = |m: &Stored| message1(number(m) as u32, m.time, &m.ros1);
    let of_bag1: Vec<u8> = messages.iter().flat_map(of_bag1).collect();
    let of_bag1 = [connections, of_bag1].concat();
    let rows: Vec<(i64, &str, &str)> = named().map(|(k, (t, n))| (k.into(), *t, *n)).collect();
    let of_database = |m: &Stored| (number(m) as i64, nanoseconds(m) as i64, m.cdr.clone());
    let of_database: Vec<_> = messages.iter().map(of_database).collect();
    let of_database: Vec<(i64, i64, &[u8])> =
        of_database.iter().map(|(topic, time, data)| (*topic, *time, data.as_slice())).collect();
    let mut bags = vec![
        ("a.mcap", write::mcap(std::slice::from_ref(&of_mcap))),
        ("a.db3", database(&rows, &of_database)),
    ];
    let packed = |compression| write::mcap(&[write::chunk(compression, &of_mcap, true)]);
    bags.extend(["", "lz4", "zstd"].map(|compression| ("a.mcap", packed(compression))));
    let packed = |compression| bag1(&[chunk1(compression, &of_bag1)]);
    bags.extend(["none", "bz2", "lz4"].map(|compression| ("a.bag", packed(compression))));
    bags
}

struct Folder(TempDir);

impl Folder {
    fn with(name: &str, bytes: &[u8]) -> (Self, PathBuf) {
        let folder = Folder(TempDir::new().unwrap());
        let path = folder.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        (folder, path)
    }
}

/// Events and notes, or the error.
type Replayed = Result<(Vec<Event>, Vec<String>), String>;

fn replayed(bag: &Path) -> Replayed {
    let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
    let recording = RosRecording::open(bag, &options, &RosOptions::default());
    let mut recording = recording.map_err(|error| error.to_string())?;
    let mut events = Vec::new();
    while let Some(event) = recording.next_event().map_err(|error| error.to_string())? {
        events.push(event);
    }
    Ok((events, recording.notes()))
}

/// What every format makes of the messages.
fn in_every_format(messages: &[Stored]) -> Vec<Replayed> {
    let of = |(name, bytes): (&str, Vec<u8>)| {
        let (_folder, path) = Folder::with(name, &bytes);
        replayed(&path)
    };
    bags(messages).into_iter().map(of).collect()
}

pub(super) fn at(second: i64) -> Stamp {
    Stamp(second * 1_000_000_000)
}

pub(super) fn odometry(second: i64) -> Stored {
    let mut odometry = Odometry { header: Header::new(at(second), "odom"), ..Odometry::default() };
    odometry.child_frame_id = "base".into();
    odometry.pose.pose = Pose2::new(second as f64, 0.0, 0.0).into();
    stored("/odom", second as u32, &odometry)
}

fn scan_at(stamp: Stamp, recorded: u32) -> Stored {
    let scan = LaserScan {
        header: Header::new(stamp, "laser"),
        angle_max: 0.5,
        angle_increment: 0.5,
        range_max: 10.0,
        ranges: vec![2.0, f32::INFINITY],
        ..LaserScan::default()
    };
    stored("/scan", recorded, &scan)
}

fn scan(second: i64) -> Stored {
    scan_at(at(second), second as u32)
}

pub(super) fn place() -> Stored {
    let transform = TransformStamped {
        header: Header::new(at(1), "base"),
        child_frame_id: "laser".into(),
        transform: Pose2::new(0.2, 0.0, 0.0).into(),
    };
    stored("/tf_static", 1, &TfMessage { transforms: vec![transform] })
}

/// Odometry and scans of seconds 1 to 4.
pub(super) fn drive() -> Vec<Stored> {
    std::iter::once(place()).chain((1..5).flat_map(|k| [odometry(k), scan(k)])).collect()
}

fn scans(events: &[Event]) -> Vec<f64> {
    let is_scan =
        |event: &&Event| matches!(event.payload, Payload::Measurement(Measurement::Scan { .. }));
    events.iter().filter(is_scan).map(|event| event.stamp).collect()
}

#[test]
fn all_formats_tell_the_same() {
    let replayed = in_every_format(&drive());
    let first = replayed[0].clone().unwrap();
    assert_eq!(scans(&first.0), [1.0, 2.0, 3.0, 4.0]);
    for (index, other) in replayed.into_iter().enumerate() {
        assert_eq!(other.unwrap(), first, "format {index}");
    }
}

#[test]
fn stamps_of_zero_are_the_times_of_recording() {
    let messages: Vec<Stored> = std::iter::once(place())
        .chain((1..5).flat_map(|k| [odometry(k), scan_at(Stamp(0), k as u32)]))
        .collect();
    for replayed in in_every_format(&messages) {
        let (events, notes) = replayed.unwrap();
        assert_eq!(scans(&events), [1.0, 2.0, 3.0, 4.0]);
        let note = "4 messages with stamp 0, taken at the time of recording";
        assert!(notes.iter().any(|line| line == note), "{notes:?}");
    }
}

#[test]
fn scans_before_the_first_odometry_are_counted() {
    let mut messages = vec![place(), scan_at(Stamp(500_000_000), 1)];
    messages.extend(drive().split_off(1));
    for replayed in in_every_format(&messages) {
        let (events, notes) = replayed.unwrap();
        assert_eq!(scans(&events), [1.0, 2.0, 3.0, 4.0]);
        let note = "1 scans without odometry before and after them";
        assert!(notes.iter().any(|line| line == note), "{notes:?}");
    }
}

#[test]
fn a_laser_without_a_place_is_an_error() {
    for replayed in in_every_format(&drive().split_off(1)) {
        let error = replayed.unwrap_err();
        let text = "no transform base <- laser at 1 s";
        assert!(error.contains(text) && error.contains("known frames: none"), "{error}");
    }
}

/// A text that claims more bytes than its message has: the message is passed over, and the reason
/// is reported.
#[test]
fn texts_beyond_their_message_are_counted() {
    let mut messages = drive();
    let broken = &mut messages[4];
    assert_eq!(broken.topic, "/scan");
    // The length of the frame's name: behind the stamp, and in ROS 1 the number of the message.
    broken.cdr[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    broken.ros1[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    for replayed in in_every_format(&messages) {
        let (events, notes) = replayed.unwrap();
        assert_eq!(scans(&events), [1.0, 3.0, 4.0]);
        let reported =
            notes.iter().find(|line| line.contains("messages that cannot be used")).unwrap();
        assert!(
            reported.contains("/scan: frame_id") && reported.contains("4294967295"),
            "{reported}"
        );
    }
}

/// A recorder that was killed: whatever the byte, what is there is used, or an error says what is
/// missing; it is always reported that the bag breaks off.
#[test]
fn bags_cut_off_anywhere_are_used_up_to_there() {
    for (name, whole) in bags(&drive()) {
        let mut most = 0;
        let step = whole.len() / 60 + 1;
        for length in (0..whole.len()).step_by(step).chain([whole.len() - 1]) {
            let (_folder, path) = Folder::with(name, &whole[..length]);
            match replayed(&path) {
                Ok((events, notes)) => {
                    let scans = scans(&events).len();
                    assert!(scans >= most && scans <= 4, "{name} {length}");
                    most = scans;
                    let says = ["breaks off", "was not closed", "ends within", "unpacks to"];
                    let reported =
                        notes.iter().any(|note| says.iter().any(|say| note.contains(say)));
                    assert!(reported || scans == 4, "{name} {length}: {notes:?}");
                }
                Err(error) => assert!(most == 0 && !error.is_empty(), "{name} {length}: {error}"),
            }
        }
        assert!(most >= 1 || name != "a.mcap", "{name}: {most}");
    }
}
