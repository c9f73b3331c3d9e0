//! CARMEN logs and logs of Wean Hall: small ones written here, real ones if LOC_DATA_DIR is set.

use flate2::Compression;
use flate2::write::GzEncoder;
use loc_core::Pose2;
use loc_sim::source::carmen::{CarmenLog, Message};
use loc_sim::source::laser_log::{LaserLog, Reference};
use loc_sim::source::wean::WeanLog;
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

fn parse_wean(text: &str) -> Result<LaserLog, String> {
    let log = WeanLog::parse("a.log", Cursor::new(text.to_owned()));
    log.laser_log().map_err(|error| error.to_string())
}

fn scan_line() -> String {
    let ranges: Vec<String> = (0..180).map(|k| (100 + k).to_string()).collect();
    format!("L 100 200 1.5707963267948966 100 225 1.5707963267948966 {} 0.3\n", ranges.join(" "))
}

#[test]
fn centimetres_become_metres_and_the_laser_sits_ahead() {
    let log = parse_wean(&format!("O 100 -50 0.5 0.1\n{}", scan_line())).unwrap();
    let odometry = &log.entries[0];
    assert_eq!(odometry.payloads.len(), 1);
    assert_eq!((odometry.odometry(), odometry.stamp), (Some(Pose2::new(1.0, -0.5, 0.5)), 0.1));
    let entry = &log.entries[1];
    let (scan, mounting) = entry.scan().unwrap();
    assert!(mounting.distance(Pose2::new(0.25, 0.0, 0.0)) < 1e-12);
    let odometry = entry.odometry().unwrap();
    assert_eq!((odometry.x, odometry.y), (1.0, 2.0));
    assert_eq!((scan.ranges[0], scan.ranges.len()), (1.0, 180));
    // From the right to the left: beam 90 points ahead.
    let ahead = scan.angle_min + 90.0 * scan.angle_increment;
    assert!(ahead.abs() < 1e-12);
    assert_eq!((entry.truth(), entry.stamp), (None, 0.3));
}

#[test]
fn broken_lines_of_wean_hall_name_file_line_and_field() {
    let truncated = scan_line().replace(" 279 0.3", "");
    let long = scan_line().replace(" 0.3", " 0.3 0.4");
    for (text, message) in [
        ("O 1 2\n", "pose: expected a value, got the end of the line"),
        ("O 1 2 x 3\n", "pose: expected a finite number, got `x`"),
        ("Q 1\n", "message: expected O or L, got `Q`"),
        ("O 1 2 3 4 5\n", "line: expected the end of the line, got `5`"),
        (&truncated, "range: expected a value, got the end of the line"),
        (&long, "line: expected the end of the line, got `0.4`"),
    ] {
        assert_eq!(parse_wean(text).unwrap_err(), format!("a.log:1: {message}"));
    }
    assert_eq!(parse_wean("# nothing\n\n").unwrap().entries, []);
}

#[test]
fn references_are_read_by_the_names_of_their_columns() {
    let read =
        |text: &str| Reference::parse(Path::new("r.csv"), text).map_err(|error| error.to_string());
    let text = "# time_s,x_cm,y_cm,theta_rad,spread_cm (a remark)\n\
                0,1,2,3,1\n1,100,200,0.5,40\n2,300,400,1,5\n3,310,400,1,30\n";
    let reference = read(text).unwrap();
    assert_eq!((reference.vague, reference.poses.len()), (2, 2));
    let first = reference.poses.first().unwrap();
    assert_eq!((first.stamp, first.value), (2.0, Pose2::new(3.0, 4.0, 1.0)));
    let degrees = read("theta_deg,y_m,x_m,time_s\n90,1,2,3\n").unwrap();
    let pose = degrees.poses.first().unwrap().value;
    assert_eq!(pose, Pose2::new(2.0, 1.0, std::f64::consts::FRAC_PI_2));
    for (text, message) in [
        ("time_s,x,y_m,theta_rad\n", "r.csv:1: x: expected a column x_m or x_cm in the first line"),
        ("time_s,x_m,y_m,theta_rad\n1,2,3\n", "r.csv:2: theta_rad: expected a value"),
        ("time_s,x_m,y_m,theta_rad\n1,2,3,0\n0,2,3,0\n", "r.csv:3: time_s: expected a time not"),
        ("time_s,x_m,y_m,theta_rad\n", "r.csv: "),
        ("", "r.csv:1: time: expected"),
    ] {
        let error = read(text).unwrap_err();
        assert!(error.starts_with(message), "{error}");
    }
}

#[test]
fn real_logs_of_wean_hall_are_read_whole() {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let folder = Path::new(&folder).join("wean_hall");
    for (name, odometry, scans) in
        [("robotdata1", 1505, 713), ("robotdata2", 3126, 2251), ("robotdata3", 1735, 1241)]
    {
        let log = WeanLog::open(&folder.join(format!("{name}.log.gz"))).unwrap();
        let log = log.laser_log().unwrap();
        let mountings =
            log.entries.iter().filter_map(|entry| entry.scan().map(|(_, mounting)| mounting));
        let ahead = Pose2::new(0.25, 0.0, 0.0);
        let at_its_place = mountings.clone().filter(|at| at.distance(ahead) < 1e-3).count();
        assert_eq!((log.entries.len(), mountings.count()), (odometry + scans, scans), "{name}");
        assert_eq!(at_its_place, scans, "{name}");
        let reference = Reference::read(&folder.join(format!("{name}_pf_reference.csv"))).unwrap();
        assert!(reference.poses.len() > 500 && reference.vague > 0);
    }
}
