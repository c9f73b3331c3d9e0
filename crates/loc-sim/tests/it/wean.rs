//! Logs of Wean Hall: small ones everywhere, real ones where LOC_DATA_DIR is set.

use loc_core::Pose2;
use loc_sim::source::laser_log::{LaserLog, Reference, What};
use loc_sim::source::wean::WeanLog;
use std::io::Cursor;
use std::path::Path;

fn parse(text: &str) -> Result<LaserLog, String> {
    let log = WeanLog::parse("a.log", Cursor::new(text.to_owned()));
    log.laser_log().map_err(|error| error.to_string())
}

fn scan_line() -> String {
    let ranges: Vec<String> = (0..180).map(|k| (100 + k).to_string()).collect();
    format!("L 100 200 1.5707963267948966 100 225 1.5707963267948966 {} 0.3\n", ranges.join(" "))
}

#[test]
fn centimetres_become_metres_and_the_laser_sits_ahead() {
    let log = parse(&format!("O 100 -50 0.5 0.1\n{}", scan_line())).unwrap();
    let What::Odometry(pose) = log.entries[0].what else { panic!() };
    assert_eq!((pose, log.entries[0].stamp), (Pose2::new(1.0, -0.5, 0.5), 0.1));
    let What::Scan(scan) = &log.entries[1].what else { panic!() };
    assert!(scan.mounting.distance(Pose2::new(0.25, 0.0, 0.0)) < 1e-12);
    assert_eq!((scan.odometry.x, scan.odometry.y), (1.0, 2.0));
    assert_eq!((scan.scan.ranges[0], scan.scan.ranges.len()), (1.0, 180));
    // From the right to the left: beam 90 looks ahead.
    let ahead = scan.scan.angle_min + 90.0 * scan.scan.angle_increment;
    assert!(ahead.abs() < 1e-12);
    assert_eq!((scan.truth, log.entries[1].stamp), (None, 0.3));
}

#[test]
fn broken_lines_name_file_line_and_field() {
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
        assert_eq!(parse(text).unwrap_err(), format!("a.log:1: {message}"));
    }
    assert_eq!(parse("# nothing\n\n").unwrap().entries, []);
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
fn real_logs_are_read_whole() {
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
        let mountings = log.entries.iter().filter_map(|entry| match &entry.what {
            What::Scan(scan) => Some(scan.mounting),
            _ => None,
        });
        let ahead = Pose2::new(0.25, 0.0, 0.0);
        let at_its_place = mountings.clone().filter(|at| at.distance(ahead) < 1e-3).count();
        assert_eq!((log.entries.len(), mountings.count()), (odometry + scans, scans), "{name}");
        assert_eq!(at_its_place, scans, "{name}");
        let reference = Reference::read(&folder.join(format!("{name}_pf_reference.csv"))).unwrap();
        assert!(reference.poses.len() > 500 && reference.vague > 0);
    }
}
