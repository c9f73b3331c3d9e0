//! Messages of a bag joined to a stream of events.

use loc_core::Pose2;
use loc_ros::messages::*;
use loc_ros::{McapWriter, RecordingOptions};
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sim::source::Source;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{RosOptions, RosRecording};
use std::path::PathBuf;

/// Tenths of a second to nanoseconds.
fn tenth(k: i64) -> Stamp {
    Stamp(1_000_000_000_000 + k * 100_000_000)
}

fn odometry(k: i64, x: f64) -> Odometry {
    let mut odometry = Odometry { header: Header::new(tenth(k), "odom"), ..Odometry::default() };
    odometry.child_frame_id = "base".into();
    odometry.pose.pose = Pose2::new(x, 0.0, 0.0).into();
    odometry
}

fn scan(stamp: Stamp, first: f32) -> LaserScan {
    LaserScan {
        header: Header::new(stamp, "laser"),
        angle_min: -0.5,
        angle_max: 0.5,
        angle_increment: 0.5,
        range_max: 10.0,
        ranges: vec![first, 2.0, f32::INFINITY],
        ..LaserScan::default()
    }
}

fn transform(parent: &str, child: &str, transform: Pose) -> TfMessage {
    let header = Header::new(tenth(0), parent);
    TfMessage {
        transforms: vec![TransformStamped { header, child_frame_id: child.into(), transform }],
    }
}

struct Bag {
    _folder: tempfile::TempDir,
    path: PathBuf,
    writer: McapWriter,
}

impl Bag {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        Bag { writer: McapWriter::create(&path).unwrap(), path, _folder: folder }
    }

    fn put<M: Message>(&mut self, topic: &str, message: &M) -> &mut Self {
        self.writer.write(topic, tenth(0).0, message).unwrap();
        self
    }

    /// The events of the bag, and the notes.
    fn events(self, ros: &RosOptions) -> Result<(Vec<Event>, Vec<String>), String> {
        let Bag { writer, path, _folder } = self;
        writer.finish().unwrap();
        let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
        let mut recording =
            RosRecording::open(&path, &options, ros).map_err(|error| error.to_string())?;
        let mut events = Vec::new();
        while let Some(event) = recording.next_event().unwrap() {
            events.push(event);
        }
        Ok((events, recording.notes()))
    }
}

fn laser_ahead() -> TfMessage {
    transform("base", "laser", Pose2::new(0.3, 0.0, 1.0).into())
}

/// A scan between two poses gets the pose between them, even if it comes before the first of
/// them, and its transform only at the end of the bag.
#[test]
fn scans_wait_for_the_odometry_around_them() {
    let mut bag = Bag::new();
    bag.put("/scan", &scan(Stamp(tenth(0).0 - 1), 1.0))
        .put("/scan", &scan(Stamp(tenth(1).0 + 25_000_000), 1.0))
        .put("/odom", &odometry(0, 0.0))
        .put("/odom", &odometry(1, 1.0))
        .put("/odom", &odometry(2, 3.0))
        .put("/scan", &scan(tenth(2), 1.0))
        .put("/odom", &odometry(3, 4.0))
        .put("/scan", &scan(tenth(4), 1.0))
        .put("/tf_static", &laser_ahead());
    let (events, notes) = bag.events(&RosOptions::default()).unwrap();
    let x = |event: &Event| match &event.payload {
        Payload::Control(Control::Odometry(pose)) => pose.x,
        Payload::Measurement(Measurement::Scan { mounting, .. }) => {
            assert!(mounting.distance(Pose2::new(0.3, 0.0, 0.0)) < 1e-12);
            assert!((mounting.theta - 1.0).abs() < 1e-12);
            -1.0
        }
        other => panic!("{other:?}"),
    };
    let reported: Vec<f64> = events.iter().map(x).collect();
    // From the first scan on: its odometry, the scan, and so on.
    assert_eq!(reported.len(), 6);
    for (reported, expected) in reported.iter().zip([1.5, -1.0, 3.0, -1.0, 3.0, 4.0]) {
        assert!((reported - expected).abs() < 1e-9, "{reported} {expected}");
    }
    assert!(events.windows(2).all(|pair| pair[0].stamp <= pair[1].stamp));
    assert!(notes.iter().any(|note| note == "2 scans without odometry before and after them"));
}

#[test]
fn upside_down_lasers_turn_the_other_way() {
    let mut bag = Bag::new();
    // Half a turn about x.
    let place = Pose { position: [0.1, 0.0, 0.2], orientation: [1.0, 0.0, 0.0, 0.0] };
    bag.put("/tf_static", &transform("base", "laser", place))
        .put("/odom", &odometry(0, 0.0))
        .put("/odom", &odometry(2, 0.0))
        .put("/scan", &scan(tenth(1), 1.0));
    let (events, _) = bag.events(&RosOptions::default()).unwrap();
    let scan = events.iter().find_map(|event| match &event.payload {
        Payload::Measurement(Measurement::Scan { scan, .. }) => Some(scan),
        _ => None,
    });
    // What was at the right of the laser is at the left of the robot.
    let beam = scan.unwrap().beams().next().unwrap();
    assert!((beam.angle - 0.5).abs() < 1e-6 && (beam.range - 1.0).abs() < 1e-6);
}

#[test]
fn what_is_missing_is_said() {
    let error = |fill: &dyn Fn(&mut Bag), ros: &RosOptions| {
        let mut bag = Bag::new();
        fill(&mut bag);
        bag.events(ros).unwrap_err()
    };
    let none = RosOptions::default();
    let two_odometries = |bag: &mut Bag| {
        bag.put("/odom", &odometry(0, 0.0)).put("/odom", &odometry(2, 0.0));
    };
    let empty = error(&|_| {}, &none);
    assert!(empty.contains("LaserScan") && empty.contains("without messages"), "{empty}");
    let odometry_only = error(&two_odometries, &none);
    assert!(odometry_only.contains("/odom (nav_msgs/msg/Odometry)"), "{odometry_only}");
    let scan_only = error(&|bag| drop(bag.put("/scan", &scan(tenth(1), 1.0)).path.clone()), &none);
    assert!(scan_only.contains("type Odometry"), "{scan_only}");
    let full = |bag: &mut Bag| {
        two_odometries(bag);
        bag.put("/scan", &scan(tenth(1), 1.0)).put("/rear", &scan(tenth(1), 1.0));
    };
    let several = error(&full, &none);
    assert!(several.contains("--scan-topic") && several.contains("/scan, /rear"), "{several}");
    let chosen = scan_topic("rear");
    let no_frame = error(&full, &chosen);
    assert!(no_frame.contains("no transform base <- laser"), "{no_frame}");
    let wrong = scan_topic("/odom");
    assert!(error(&full, &wrong).contains("nav_msgs/msg/Odometry"));
    let tilted = Pose { position: [0.0; 3], orientation: [0.0, 0.7, 0.0, 0.7] };
    let frames = |bag: &mut Bag| {
        full(bag);
        bag.put("/tf_static", &transform("base", "laser", tilted));
    };
    assert!(error(&frames, &chosen).contains("tilted by 90.0 degrees"));
}

#[test]
fn stamps_of_zero_and_odometry_of_tf() {
    let mut bag = Bag::new();
    let moving = |k: i64, x: f64| {
        let mut message = transform("odom", "base", Pose2::new(x, 0.0, 0.0).into());
        message.transforms[0].header.stamp = tenth(k);
        message
    };
    bag.put("/tf", &moving(-1, 0.0)).put("/tf", &moving(1, 2.0)).put("/scan", &scan(Stamp(0), 1.0));
    let mounting = Some(Pose2::new(0.5, 0.0, 0.0));
    let (events, notes) =
        bag.events(&RecordingOptions { mounting, ..RecordingOptions::default() }.into()).unwrap();
    let Payload::Control(Control::Odometry(pose)) = events[0].payload else { panic!("odometry") };
    assert!((pose.x - 1.0).abs() < 1e-9);
    assert!(notes.iter().any(|note| note.starts_with("1 messages with stamp 0")), "{notes:?}");
}

fn scan_topic(topic: &str) -> RosOptions {
    RecordingOptions { scan_topic: Some(topic.into()), ..RecordingOptions::default() }.into()
}
