//! Recordings converted to other formats, and read back.

use loc_core::Pose2;
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sim::convert::{Track, to_carmen, to_mcap, to_tum};
use loc_sim::source::carmen::CarmenLog;
use loc_sim::source::laser_log::{LaserRecording, ReplayOptions, Start};
use loc_sim::source::ros::{RosOptions, RosRecording};
use loc_sim::source::{Mrclam, Source};
use std::path::Path;

/// A robot that turns, with a laser 0.2 m ahead of its centre and true poses of their own.
const LOG: &str = "\
ODOM 0 0 0 0 0 0 9.5 host 9.5
ROBOTLASER1 0 -1 2 1 20 0 0 3 1.5 20 3.25 0 0.2 0 0 0 0 0 0 0 0 0 0 10 host 10
TRUEPOS 5 6 0.5 0 0 0 10 host 10
ODOM 1 0 0.5 0 0 0 10.5 host 10.5
ROBOTLASER1 0 -1 2 1 20 0 0 3 1.25 2 3 0 1 0.2 1.5707963267948966 1 0 1.5707963267948966 0 0 0 0 0 11 host 11
TRUEPOS 5.5 6.5 1 1 0 1.5707963267948966 11 host 11
";

fn anywhere() -> ReplayOptions {
    ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() }
}

fn recording(text: &str) -> LaserRecording {
    let log = CarmenLog::parse("demo.log", std::io::Cursor::new(text.to_owned()));
    LaserRecording::new(log.laser_log().unwrap(), &anywhere()).unwrap()
}

fn events(source: &mut dyn Source) -> Vec<Event> {
    std::iter::from_fn(|| source.next_event().unwrap()).collect()
}

#[test]
fn a_carmen_log_is_read_back_as_it_was() {
    let mut text = Vec::new();
    let file = Path::new("out.log");
    let converted = to_carmen(&mut recording(LOG), &mut text, file, &mut |_| {}).unwrap();
    // Odometry, scan and truth of both scans, and the odometry between them.
    assert_eq!((converted.written, converted.left_out), (7, vec![]));
    let text = String::from_utf8(text).unwrap();
    let again = events(&mut recording(&text));
    let first = events(&mut recording(LOG));
    let without_repeats = |events: &[Event]| {
        let mut events = events.to_vec();
        events.dedup();
        events
    };
    assert_eq!(without_repeats(&again), without_repeats(&first), "{text}");
    let Payload::Measurement(Measurement::Scan { scan, mounting }) = &first[1].payload else {
        panic!("{first:?}")
    };
    assert_eq!(scan.ranges, [1.5, f64::INFINITY, 3.25]);
    assert!(mounting.distance(Pose2::new(0.2, 0.0, 0.0)) < 1e-12);
}

/// The frames, scans and poses of the MCAP file make the same recording as the log.
#[test]
fn a_log_becomes_an_mcap_file_that_can_be_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("demo.mcap");
    let converted = to_mcap(&mut recording(LOG), &file, &mut |_| {}).unwrap();
    assert!(converted.left_out.is_empty());
    let mut bag = RosRecording::open(&file, &anywhere(), &RosOptions::default()).unwrap();
    let scans = |events: Vec<Event>| -> Vec<(f64, Vec<f64>, Pose2)> {
        let scan = |event: Event| match event.payload {
            Payload::Measurement(Measurement::Scan { scan, mounting }) => {
                Some((event.stamp, scan.ranges.clone(), mounting))
            }
            _ => None,
        };
        events.into_iter().filter_map(scan).collect()
    };
    let (read, written) = (scans(events(&mut bag)), scans(events(&mut recording(LOG))));
    assert_eq!(read.len(), 2);
    for ((t, ranges, mounting), (t0, ranges0, mounting0)) in read.iter().zip(&written) {
        assert_eq!((t, ranges), (t0, ranges0)); // these ranges are exact in 32 bits
        assert!(mounting.distance(*mounting0) < 1e-12);
    }
}

#[test]
fn a_track_is_the_reference_unless_the_odometry_is_asked_for() {
    let (truth, _) = to_tum(&mut recording(LOG), None, &mut |_| {}).unwrap();
    let truth: Vec<_> = truth.iter().map(|at| (at.stamp, at.value.x, at.value.y)).collect();
    assert_eq!(truth, [(10.0, 5.0, 6.0), (11.0, 5.5, 6.5)]);
    let track = Some(Track::Odometry);
    let (odometry, converted) = to_tum(&mut recording(LOG), track, &mut |_| {}).unwrap();
    let odometry: Vec<_> = odometry.iter().map(|at| (at.stamp, at.value.x)).collect();
    assert_eq!(odometry, [(10.0, 0.0), (10.5, 1.0), (11.0, 1.0)]);
    assert!(converted.left_out.is_empty());
}

#[test]
fn a_missing_track_is_an_error() {
    let text = "FLASER 2 1 2 0 0 0 0 0 0 10 host 10\n";
    let error = to_tum(&mut recording(text), Some(Track::Reference), &mut |_| {}).unwrap_err();
    assert_eq!(error.to_string(), "demo: expected true poses, got none");
}

/// LandmarkObservations of landmarks have no line in a CARMEN log; velocities are driven along.
#[test]
fn what_has_no_place_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("Barcodes.dat", "1 5\n6 63\n"),
        ("Landmark_Groundtruth.dat", "6 1 2 0 0\n"),
        ("Robot1_Groundtruth.dat", "0.0 0 0 0\n3.0 2 0 0\n"),
        ("Robot1_Odometry.dat", "0.0 1 0\n1.0 0.5 0\n2.0 0 0\n"),
        ("Robot1_Measurement.dat", "1.5 63 2 0.5\n"),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mut source = Mrclam::open(folder.path(), 1).unwrap();
    let mut text = Vec::new();
    let converted = to_carmen(&mut source, &mut text, Path::new("x"), &mut |_| {}).unwrap();
    assert_eq!(converted.left_out, ["1 measurements that are no scans"]);
    let text = String::from_utf8(text).unwrap();
    let odometry: Vec<&str> = text.lines().filter(|line| line.starts_with("ODOM")).collect();
    assert_eq!(odometry.last().unwrap().split(' ').nth(1), Some("1.5"), "{text}");
    let mut source = Mrclam::open(folder.path(), 1).unwrap();
    let is_velocity =
        |event: &Event| matches!(event.payload, Payload::Control(Control::Velocity(_)));
    assert_eq!(events(&mut source).iter().filter(|event| is_velocity(event)).count(), 3);
}
