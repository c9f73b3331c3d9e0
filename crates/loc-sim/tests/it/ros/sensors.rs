//! Sensors beside the laser: clouds of points, inertial units, satellite receivers.

use loc_core::Pose2;
use loc_filters::RobotSettings;
use loc_ros::messages::*;
use loc_ros::{McapWriter, RecordingOptions};
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, recording};
use loc_sim::source::Source;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{RosOptions, RosRecording};
use std::path::PathBuf;
use tempfile::TempDir;

/// Where the first fix is.
const ORIGIN: [f64; 2] = [52.0, 8.0];
/// Metres of 1e-5 degrees to the north and to the east there, by the radii of the ellipsoid: with
/// s = 1 - e^2 sin^2, a (1 - e^2) / s^1.5 and a cos / s^0.5.
const NORTH: f64 = 1.112_673;
const EAST: f64 = 0.686_780;

fn header(second: f64, frame: &str) -> Header {
    Header::new(Stamp::from_seconds(100.0 + second), frame)
}

struct Bag {
    _folder: TempDir,
    path: PathBuf,
    writer: McapWriter,
}

impl Bag {
    /// A bag with a laser ahead, and an inertial unit that hangs upside down 1 m ahead.
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mcap");
        let mut bag = Bag { writer: McapWriter::create(&path).unwrap(), path, _folder: folder };
        let place = |child: &str, position, orientation| TransformStamped {
            header: header(0.0, "base"),
            child_frame_id: child.into(),
            transform: Pose { position, orientation },
        };
        let transforms = vec![
            place("laser", [0.2, 0.0, 0.3], [0.0, 0.0, 0.0, 1.0]),
            place("imu", [1.0, 0.0, 0.1], [1.0, 0.0, 0.0, 0.0]),
        ];
        bag.put("/tf_static", 0.0, &TfMessage { transforms });
        bag
    }

    fn put<M: Message>(&mut self, topic: &str, second: f64, message: &M) {
        self.writer.write(topic, header(second, "").stamp.0, message).unwrap();
    }

    fn odometry(&mut self, second: f64, pose: Pose2) {
        let child_frame_id = "base".into();
        let header = header(second, "odom");
        let mut message = Odometry { header, child_frame_id, ..Odometry::default() };
        message.pose.pose = pose.into();
        self.put("/odom", second, &message);
    }

    fn scan(&mut self, second: f64) {
        let scan = LaserScan {
            header: header(second, "laser"),
            angle_increment: 0.5,
            angle_max: 0.5,
            range_max: 9.0,
            ranges: vec![1.0, 2.0],
            ..LaserScan::default()
        };
        self.put("/scan", second, &scan);
    }

    /// What a level robot feels that turns left at this rate \[rad/s\], in the unit's own axes.
    fn inertial(&mut self, second: f64, turn: f64) {
        let imu = Imu {
            header: header(second, "imu"),
            angular_velocity: [0.0, 0.0, -turn],
            linear_acceleration: [-turn * turn, 0.0, -9.81],
            ..Imu::default()
        };
        self.put("/imu", second, &imu);
    }

    /// A fix so many 1e-5 degrees to the east and north of the origin.
    fn fix(&mut self, second: f64, east: f64, north: f64) {
        let mut covariance = [0.0; 9];
        (covariance[0], covariance[4], covariance[8]) = (0.04, 0.09, 1.0);
        let fix = NavSatFix {
            header: header(second, "gps"),
            latitude: ORIGIN[0] + 1e-5 * north,
            longitude: ORIGIN[1] + 1e-5 * east,
            altitude: 60.0,
            position_covariance: covariance,
            position_covariance_type: 2,
            ..NavSatFix::default()
        };
        self.put("/fix", second, &fix);
    }

    fn open(self, ros: &RosOptions) -> (RosRecording, TempDir) {
        self.writer.finish().unwrap();
        let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
        (RosRecording::open(&self.path, &options, ros).unwrap(), self._folder)
    }

    fn events(self, ros: &RosOptions) -> (Vec<Event>, Vec<String>) {
        let (mut recording, _folder) = self.open(ros);
        let events = std::iter::from_fn(|| recording.next_event().unwrap()).collect();
        (events, recording.notes())
    }
}

fn measurements(events: &[Event]) -> Vec<&Measurement> {
    let measured = events.iter().filter_map(|event| match &event.payload {
        Payload::Measurement(measurement) => Some(measurement),
        _ => None,
    });
    measured.collect()
}

#[test]
fn a_cloud_of_points_is_cut_to_a_scan() {
    let mut bag = Bag::new();
    bag.odometry(0.0, Pose2::IDENTITY);
    // Ahead at the height of the sensor, behind that, to the left but on the floor.
    let points = [[2.0, 0.0, 0.05], [3.0, 0.0, 0.0], [0.0, 1.0, -0.3], [0.0, -4.0, 0.0]];
    bag.put("/points", 0.5, &PointCloud2::of(header(0.5, "laser"), &points));
    bag.odometry(1.0, Pose2::new(1.0, 0.0, 0.0));
    let (events, _) = bag.events(&RosOptions::default());
    let [Measurement::Scan { scan, mounting }] = measurements(&events)[..] else {
        panic!("{events:?}")
    };
    assert!(mounting.distance(Pose2::new(0.2, 0.0, 0.0)) < 1e-12);
    let seen: Vec<_> = scan.beams().filter(|beam| beam.range.is_finite()).collect();
    assert_eq!((scan.ranges.len(), seen.len()), (720, 2));
    let half = std::f64::consts::FRAC_PI_2;
    for (beam, (angle, range)) in seen.iter().zip([(-half, 4.0), (0.0, 2.0)]) {
        assert!((beam.angle - angle).abs() < 1e-5 && (beam.range - range).abs() < 1e-6);
    }
}

/// By hand: turned over, and without the centripetal part of 0.5^2 times 1 m; metres by the radii
/// of the ellipsoid.
#[test]
fn samples_and_fixes_become_measurements() {
    let mut bag = Bag::new();
    bag.odometry(0.0, Pose2::IDENTITY);
    bag.scan(0.1);
    bag.inertial(0.2, 0.5);
    bag.fix(0.3, 0.0, 0.0);
    bag.fix(0.4, 100.0, 200.0);
    bag.put(
        "/fix",
        0.5,
        &NavSatFix { header: header(0.5, "gps"), status: -1, ..NavSatFix::default() },
    );
    let half = Imu {
        header: header(0.6, "imu"),
        linear_acceleration_covariance: [-1.0; 9],
        ..Imu::default()
    };
    bag.put("/imu", 0.6, &half);
    let broken = NavSatFix { header: header(0.7, "gps"), latitude: 91.0, ..NavSatFix::default() };
    bag.put("/fix", 0.7, &broken);
    let vague = NavSatFix {
        header: header(0.8, "gps"),
        latitude: 52.0,
        longitude: 8.0,
        altitude: 60.0,
        ..NavSatFix::default()
    };
    bag.put("/fix", 0.8, &vague);
    bag.odometry(1.0, Pose2::new(1.0, 0.0, 0.0));
    let (events, notes) = bag.events(&RosOptions::default());
    assert!(events.windows(2).all(|pair| pair[0].stamp <= pair[1].stamp));
    let measured = measurements(&events);
    let [
        Measurement::Scan { .. },
        Measurement::Inertial(sample),
        Measurement::Position(first),
        Measurement::Position(second),
        Measurement::Position(third),
    ] = measured[..]
    else {
        panic!("{measured:?}")
    };
    assert!((sample.angular_velocity.z - 0.5).abs() < 1e-12);
    let acceleration = sample.acceleration;
    assert!(
        acceleration.xy().norm() < 1e-12 && (acceleration.z - 9.81).abs() < 1e-12,
        "{sample:?}"
    );
    assert!(first.mean.norm() < 1e-9);
    // On the plane that touches the ellipsoid, 260 m away are 0.02 mm less.
    assert!((second.mean.x - 100.0 * EAST).abs() < 1e-2, "{second:?}");
    assert!((second.mean.y - 200.0 * NORTH).abs() < 1e-2, "{second:?}");
    assert_eq!((second.covariance.m11, second.covariance.m22), (0.04, 0.09));
    // A covariance that are unknown is that of a usual receiver.
    assert!(third.mean.norm() < 1e-9 && (third.covariance.m11.sqrt() - 2.088).abs() < 1e-3);
    let says = |text: &str| assert!(notes.iter().any(|note| note.contains(text)), "{notes:?}");
    says("2 messages without a fix, or of half an inertial unit");
    says("1 messages that cannot be used, the first: /fix: ");
    says("east and north of the first, 52.0000000, 8.0000000");
}

#[test]
fn sensors_can_be_left_out_and_chosen() {
    let fill = || {
        let mut bag = Bag::new();
        bag.odometry(0.0, Pose2::IDENTITY);
        bag.scan(0.1);
        bag.inertial(0.2, 0.5);
        bag.fix(0.3, 0.0, 0.0);
        let imu = Imu { header: header(0.4, "nowhere"), ..Imu::default() };
        bag.put("/other_imu", 0.4, &imu);
        bag.odometry(1.0, Pose2::new(1.0, 0.0, 0.0));
        bag
    };
    let number = |ros: &RosOptions| {
        let (events, notes) = fill().events(ros);
        (measurements(&events).len(), notes)
    };
    let with = |imu: Option<&str>, fix: Option<&str>| -> RosOptions {
        RecordingOptions {
            imu_topic: imu.map(str::to_owned),
            fix_topic: fix.map(str::to_owned),
            ..RecordingOptions::default()
        }
        .into()
    };
    assert_eq!(number(&with(Some("none"), Some("none"))).0, 1);
    assert_eq!(number(&with(Some("/imu"), None)).0, 3);
    // Of several nothing is used, and a note says how to choose.
    let (count, notes) = number(&with(None, None));
    assert_eq!(count, 2);
    assert!(notes.iter().any(|note| note.contains("--imu-topic")), "{notes:?}");
    // A unit without a known mounting is no reason not to replay.
    let (count, notes) = number(&with(Some("/other_imu"), None));
    assert_eq!(count, 2);
    assert!(notes.iter().any(|note| note.contains("no transform base <- nowhere")), "{notes:?}");
}

/// An odometry that turns where the robot goes straight: gyroscope and satellites know better.
#[test]
fn fusion_takes_what_the_bag_has() {
    let mut bag = Bag::new();
    for k in 0..=1200 {
        let second = 0.05 * f64::from(k);
        let turned = 0.01 * second;
        let curve = Pose2::new(turned.sin() / 0.01, (1.0 - turned.cos()) / 0.01, turned);
        bag.odometry(second, curve);
        bag.inertial(second + 0.01, 0.0);
        if k % 20 == 0 {
            bag.scan(second);
            bag.fix(second + 0.02, (second + 0.02) / EAST, 0.0);
            let pose = Pose2::new(second, 0.0, 0.0).into();
            let truth = PoseStamped { header: header(second, "map"), pose };
            bag.put("/ground_truth", second, &truth);
        }
    }
    let (mut recording, _folder) = bag.open(&RosOptions::default());
    let config = RecordingConfig::parse("lasers", recording::LASER, &[]).unwrap();
    let methods = [Method::DeadReckoning, Method::Fusion];
    let settings = config.settings(RobotSettings::default()).unwrap();
    let run = runner::run(&mut recording, &methods, &settings, &mut |_| {}).unwrap();
    let summary = Summary::of(&run, None, Alignment::None).unwrap();
    let rmse = |index: usize| summary.methods[index].1.errors.unwrap().ate_rmse_m;
    assert!(rmse(0) > 5.0 && rmse(1) < 0.3, "{} {}", rmse(0), rmse(1));
}
