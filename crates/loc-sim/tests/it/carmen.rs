//! CARMEN logs: small ones everywhere, real ones where LOC_DATA_DIR is set.

use flate2::Compression;
use flate2::write::GzEncoder;
use loc_sim::source::carmen::{CarmenLog, Message};
use std::io::{Cursor, Write};
use std::path::Path;

const LOG: &str = "# a comment\n\
    PARAM robot_width 0.5 nohost 0\n\
    ODOM 1 2 0.5 0.1 0.2 0 7.5 host 7.6\n\
    NEFF 12\n\
    FLASER 4 1 2 3 81.9 1.2 2 0.5 1 2 0.5 7.7 host 7.8\n\
    ROBOTLASER1 0 -1.5 3.1416 1.5708 20 0.01 0 3 1 2 20 0 1 2 3 4 5 0.6 0 0 0 0 0 7.9 host 8\n\
    TRUEPOS 1 2 3 4 5 6 8.5 host 8.6\n";

fn parse(text: &str) -> Result<Vec<Message>, String> {
    let log = CarmenLog::parse("a.log", Cursor::new(text.to_owned()));
    log.collect::<Result<_, _>>().map_err(|error| error.to_string())
}

#[test]
fn every_message_by_hand() {
    let messages = parse(LOG).unwrap();
    let Message::Odometry(odometry) = &messages[0] else { panic!() };
    assert_eq!((odometry.stamp, odometry.value.y), (7.5, 2.0));
    let Message::Laser(front) = &messages[1] else { panic!() };
    assert_eq!(front.scan.ranges, [1.0, 2.0, 3.0, f64::INFINITY]);
    // An even number of beams: the last one is a step short of the left.
    assert_eq!(front.scan.angle_increment, std::f64::consts::PI / 4.0);
    assert_eq!((front.stamp, front.laser.x, front.robot.x), (7.7, 1.2, 1.0));
    let Message::Laser(robot) = &messages[2] else { panic!() };
    assert_eq!(robot.scan.ranges, [1.0, 2.0, f64::INFINITY]);
    assert_eq!((robot.scan.angle_min, robot.stamp), (-1.5, 7.9));
    assert_eq!((robot.laser.theta, robot.robot.theta), (3.0, 0.6));
    assert!(matches!(&messages[3], Message::Truth(truth) if truth.stamp == 8.5));
    let mut log = CarmenLog::parse("a.log", Cursor::new(LOG));
    assert!(log.by_ref().all(|message| message.is_ok()) && log.skipped() == 1);
}

#[test]
fn parameters_say_how_the_laser_sees() {
    let text = "PARAM laser_front_laser_fov 90 h 0\nPARAM robot_front_laser_max 5 h 0\n\
                FLASER 3 1 5 6 0 0 0 0 0 0 1 h 1\n";
    let Message::Laser(laser) = &parse(text).unwrap()[0] else { panic!() };
    assert_eq!(laser.scan.angle_min, -std::f64::consts::FRAC_PI_4);
    assert_eq!(laser.scan.angle_increment, std::f64::consts::FRAC_PI_4);
    assert_eq!(laser.scan.ranges, [1.0, f64::INFINITY, f64::INFINITY]);
}

#[test]
fn gzipped_logs_are_read_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, packed) = (folder.path().join("a.log"), folder.path().join("a.log.gz"));
    std::fs::write(&plain, LOG).unwrap();
    let mut gzip = GzEncoder::new(std::fs::File::create(&packed).unwrap(), Compression::fast());
    gzip.write_all(LOG.as_bytes()).unwrap();
    gzip.finish().unwrap();
    let read = |file: &Path| CarmenLog::open(file).unwrap().map(Result::unwrap).collect::<Vec<_>>();
    assert_eq!(read(&plain), read(&packed));
    assert!(CarmenLog::open(folder.path().join("none.log")).is_err());
}

#[test]
fn broken_lines_name_file_line_and_field() {
    for (text, message) in [
        ("ODOM 1 2\n", "a.log:1: pose: expected a value, got the end of the line"),
        ("\nODOM 1 x 0 0 0 0 1 h 1\n", "a.log:2: pose: expected a finite number, got `x`"),
        ("ODOM 1 NaN 0 0 0 0 1 h 1\n", "a.log:1: pose: expected a finite number, got `NaN`"),
        (
            "FLASER -3\n",
            "a.log:1: number of ranges: expected a whole number up to 1000000, got `-3`",
        ),
        (
            "FLASER 99999999999 1\n",
            "a.log:1: number of ranges: expected a whole number up to 1000000, got `99999999999`",
        ),
        ("FLASER 5 1 2\n", "a.log:1: range: expected a value, got the end of the line"),
        (
            "FLASER 0 0 0 0 0 0 0 1 h 1\n",
            "a.log:1: scan: expected a scan, got ranges of a scan: expected 1 to 1000000 beams, got 0 elements",
        ),
    ] {
        let error = parse(text).unwrap_err();
        assert_eq!(error, message);
    }
    assert_eq!(parse("").unwrap(), []);
}

#[test]
fn real_logs_are_read_whole() {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let carmen = Path::new(&folder).join("carmen");
    for (name, scans, beams) in [
        ("intel.log", 910, 180),
        ("belgioioso.log.gz", 395, 361),
        ("freiburg-079.log.gz", 4791, 360),
        ("intel-corrected.log.gz", 910, 180),
    ] {
        let lasers = CarmenLog::open(carmen.join(name)).unwrap().lasers().unwrap();
        assert_eq!((lasers.len(), lasers[0].scan.ranges.len()), (scans, beams), "{name}");
    }
}
