//! Recordings of ranges to beacons: real ones where LOC_DATA_DIR is set, small written ones
//! everywhere.

use approx::assert_relative_eq;
use loc_filters::RobotSettings;
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, MethodSummary, Summary};
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, recording};
use loc_sim::source::Source;
use loc_sim::source::ranging::{RangeRecording, RangingStart};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const START: RangingStart = RangingStart { pose: None, sigmas: [0.2, 0.2, 0.1] };

fn real(folder: &str) -> Option<PathBuf> {
    let Some(data) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return None;
    };
    Some(Path::new(&data).join(folder))
}

/// The figures of a method with the settings that recordings of ranges are replayed with.
fn figures(mut source: RangeRecording, method: Method, changes: &[&str]) -> MethodSummary {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let config = RecordingConfig::parse("ranging", recording::RANGING, &changes).unwrap();
    let settings: MethodSettings = config.settings(RobotSettings::default()).unwrap();
    let robot = settings.robot.camera(source.noise());
    let settings = settings.with_robot(robot);
    let run = runner::run(&mut source, &[method], &settings, &mut |_| {}).unwrap();
    Summary::of(&run, None, Alignment::None).unwrap().methods.remove(0).1
}

fn ate(figures: &MethodSummary) -> f64 {
    figures.errors.unwrap().ate_rmse_m
}

/// The published baseline of plain sliding lateration is 0.20 m; the goal is 0.15 m.
#[test]
fn labyrinth_by_lateration() {
    let Some(folder) = real("uwb_labyrinth") else { return };
    let open = || RangeRecording::labyrinth(&folder, &START).unwrap();
    let with = figures(open(), Method::Lateration, &[]);
    let alone = figures(open(), Method::Lateration, &["filter.lateration.odometry=false"]);
    let nees = with.nees_mean.unwrap();
    println!("with odometry {:.3} m, NEES {nees:.2}; alone {:.3} m", ate(&with), ate(&alone));
    assert!(ate(&with) <= 0.10 && ate(&alone) <= 0.20);
    // No true heading was recorded, so nothing is said about headings.
    let errors = with.errors.unwrap();
    assert_eq!((errors.heading_rmse_deg, errors.rpe_rot_rmse_deg), (None, None));
    assert!((0.5..4.0).contains(&nees), "of two degrees of freedom: {nees}");
    // Without a start pose.
    let found = figures(open(), Method::Lateration, &["filter.global=true"]);
    assert!(found.converged_at_s.is_some_and(|after| after < 2.0), "{found:?}");
}

#[test]
fn plaza_by_lateration() {
    let Some(folder) = real("plaza") else { return };
    let source = RangeRecording::plaza(&folder, 1, &START).unwrap();
    let beacons: Vec<u32> = source.setup().landmarks.iter().map(|beacon| beacon.id).collect();
    assert_eq!(beacons, [0, 1, 5, 6]);
    assert!(source.notes()[0].starts_with("217 ranges stand behind later ones"));
    let found = figures(source, Method::Lateration, &[]);
    println!(
        "RMSE {:.3} m, heading {:.2} deg",
        ate(&found),
        found.errors.unwrap().heading_rmse_deg.unwrap()
    );
    assert!(ate(&found) <= 0.5);
}

const LABYRINTH: [(&str, &str); 2] = [
    (
        "a_Input.txt",
        "range2 0.1 5.0 0.01 0.0 0.0 7 0\nodom2diff 0.1 4.0 6.0 0.0 0.5 1 1 1\n\
         range2 0.2 4.0 0.04 0.0 9.0 8 0\nodom2diff 0.2 5.0 5.0 0.0 0.05 1 1 1\n",
    ),
    ("a_GT.txt", "point2 0.1 3.0 4.0 0 0 0 0\npoint2 0.2 3.0 4.5 0 0 0 0\n"),
];

const PLAZA: [(&str, &str); 4] = [
    ("plaza1_beacons.csv", "beacon_id,x_m,y_m\n0.000000,0.0,0.0\n6.000000,9.0,0.0\n"),
    (
        "plaza1_ranges.csv",
        "time_s,antenna_id,beacon_id,range_m\n10.3,2.0,0.0,5.0\n10.1,2.0,6.0,6.0\n",
    ),
    (
        "plaza1_odometry.csv",
        "time_s,delta_distance_m,delta_heading_rad\n10.2,0.1,0.02\n10.4,0.3,0.0\n",
    ),
    (
        "plaza1_groundtruth.csv",
        "time_s,x_m,y_m,theta_rad\n10.0,3.0,4.0,0.5\n10.2,3.1,4.0,0.5\n10.4,3.3,4.1,0.5\n",
    ),
];

fn folder(files: &[(&str, &str)], replaced: &str, text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, original) in files {
        let text = if *name == replaced { text } else { original };
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn events(source: &mut RangeRecording) -> Vec<Event> {
    std::iter::from_fn(|| source.next_event().unwrap()).collect()
}

#[test]
fn labyrinth_has_the_left_wheel_first_and_half_the_track() {
    let folder = folder(&LABYRINTH, "", "");
    let mut source = RangeRecording::labyrinth(folder.path(), &START).unwrap();
    assert!(!source.truth_has_heading());
    // The mean of the variances in the file.
    assert_relative_eq!(source.noise().range_sigma, 0.025_f64.sqrt(), epsilon = 1e-12);
    // The first half metre leads north, the odometry ahead and a little to the left.
    let heading = source.setup().start_belief.mean.z;
    assert_relative_eq!(heading, 90_f64.to_radians() - 0.1, epsilon = 1e-3);
    let events = events(&mut source);
    let Payload::Control(Control::Velocity(twist)) = events[0].payload else { panic!() };
    assert_relative_eq!(twist.vx, 5.0, epsilon = 1e-12);
    assert_relative_eq!(twist.omega, 2.0, epsilon = 1e-12);
    let kinds: Vec<&str> = events.iter().map(kind).collect();
    assert_eq!(kinds, ["control", "range", "truth", "control", "range", "truth"]);
}

fn kind(event: &Event) -> &'static str {
    match &event.payload {
        Payload::Control(_) => "control",
        Payload::Measurement(Measurement::Landmarks(_)) => "range",
        Payload::Truth(_) => "truth",
        _ => "other",
    }
}

/// The motion from one line to the next is a velocity from the first on, known at the second.
#[test]
fn plaza_distances_become_velocities_and_ranges_are_sorted() {
    let folder = folder(&PLAZA, "", "");
    let mut source = RangeRecording::plaza(folder.path(), 1, &START).unwrap();
    assert_eq!(source.notes(), ["1 ranges stand behind later ones in the file; sorted by stamp"]);
    let events = events(&mut source);
    let reported: Vec<(f64, f64, &str)> =
        events.iter().map(|event| (event.stamp, event.arrival, kind(event))).collect();
    let expected = [
        (10.0, 10.0, "truth"),
        (10.1, 10.1, "range"),
        (10.0, 10.2, "control"),
        (10.2, 10.2, "truth"),
        (10.3, 10.3, "range"),
        (10.2, 10.4, "control"),
        (10.4, 10.4, "control"),
        (10.4, 10.4, "truth"),
    ];
    assert_eq!(reported, expected);
    let Payload::Control(Control::Velocity(twist)) = events[5].payload else { panic!() };
    assert_relative_eq!(twist.vx, 1.5, epsilon = 1e-9);
}

#[test]
fn broken_files_name_file_line_and_field() {
    let input = LABYRINTH[0].1;
    for (file, text, message) in [
        (
            "a_Input.txt",
            input.replace("4.0 0.04", "-4.0 0.04"),
            "a_Input.txt:3: range: expected a distance >= 0, got `-4.0`",
        ),
        (
            "a_Input.txt",
            input.replace("0.2 4.0", "0.05 4.0"),
            "a_Input.txt:3: time: expected a time not before 0.1, that of the line above, got `0.05`",
        ),
        (
            "a_Input.txt",
            input.replace("0.0 9.0 8", "0.0 9.0 7"),
            "a_Input.txt:3: x: expected the place (0, 0) that anchor 7 has above, got `0.0`",
        ),
        ("a_Input.txt", input.replace("0.05 1 1 1", "0 1 1 1"), "track"),
        (
            "a_Input.txt",
            input.replace("range2", "# "),
            "a_Input.txt: ranges (range2): the file holds none",
        ),
        ("a_GT.txt", String::new(), "a_GT.txt: true positions (point2): the file holds none"),
        (
            "a_GT.txt",
            "point2 0.1 nan 4.0 0 0 0 0".into(),
            "a_GT.txt:1: x: expected a finite number, got `nan`",
        ),
    ] {
        let folder = folder(&LABYRINTH, file, &text);
        let error = RangeRecording::labyrinth(folder.path(), &START).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    for (file, text, message) in [
        (
            "plaza1_ranges.csv",
            "1,2,3.5,4",
            "plaza1_ranges.csv:1: beacon_id: expected a whole number >= 0, got `3.5`",
        ),
        (
            "plaza1_ranges.csv",
            "1,2,3,-4",
            "plaza1_ranges.csv:1: range_m: expected a distance >= 0, got `-4`",
        ),
        (
            "plaza1_beacons.csv",
            "0,0,0\n0,1,1\n",
            "landmark 0: expected one position, got a second one",
        ),
        ("plaza1_odometry.csv", "", "plaza1_odometry.csv: odometry: the file holds none"),
        (
            "plaza1_groundtruth.csv",
            "1,2,3",
            "plaza1_groundtruth.csv:1: theta_rad: expected a value",
        ),
    ] {
        let folder = folder(&PLAZA, file, text);
        let error = RangeRecording::plaza(folder.path(), 1, &START).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let folder = folder(&PLAZA, "", "");
    let error = RangeRecording::plaza(folder.path(), 2, &START).unwrap_err().to_string();
    assert!(error.ends_with("expected one of the drives 1, got drive 2"), "{error}");
    let error = RangeRecording::labyrinth(folder.path(), &START).unwrap_err().to_string();
    assert!(error.ends_with("expected a file *_Input.txt, got none"), "{error}");
}
