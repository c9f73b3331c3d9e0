//! The MRCLAM recordings: real ones where LOC_DATA_DIR is set, small written ones everywhere.

use loc_filters::RobotSettings;
use loc_sensors::event::Payload;
use loc_sim::Error;
use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, recording};
use loc_sim::source::{Calibrated, Mrclam, Source};
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn real() -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return None;
    };
    Some(Path::new(&folder).join("mrclam/MRCLAM_Dataset6"))
}

fn rmse(folder: &Path, robot: u32) -> f64 {
    let config = RecordingConfig::parse("mrclam", recording::MRCLAM, &[]).unwrap();
    let source = Mrclam::open(folder, robot).unwrap();
    let mut source = Calibrated::new(source, config.odometry, config.camera).unwrap();
    let settings = config.settings(RobotSettings::default()).unwrap();
    let run = runner::run(&mut source, &[Method::Ekf], &settings, &mut |_| {}).unwrap();
    Summary::of(&run, None, Alignment::None).unwrap().methods[0].1.errors.unwrap().ate_rmse_m
}

/// One set of parameters beats the plain filter on every robot, and by far on most.
#[test]
fn ekf_beats_the_plain_baseline_on_all_robots() {
    let Some(folder) = real() else { return };
    let baselines = [0.173, 0.225, 0.185, 0.280, 0.221];
    let mut by_far = 0;
    for (robot, baseline) in (1..).zip(baselines) {
        let rmse = rmse(&folder, robot);
        println!("robot {robot}: {rmse:.3} m, plain {baseline} m");
        assert!(rmse < baseline, "robot {robot}: {rmse}");
        by_far += usize::from(rmse <= 0.9 * baseline);
    }
    assert!(by_far >= 3);
}

const FILES: [(&str, &str); 5] = [
    ("Barcodes.dat", "# subject barcode\n1 5\n6 63\n7 81\n"),
    ("Landmark_Groundtruth.dat", "6 2.0 0.0 0.001 0.001\n7 0.0 2.0 0.001 0.001\n"),
    ("Robot1_Odometry.dat", "0.0 0.1 0.0\n0.5 0.1 0.0\n1.0 0.0 0.0\n"),
    ("Robot1_Measurement.dat", "0.5 63 1.95 0.0\n0.5 81 2.0 1.6\n0.7 5 1.0 0.0\n0.8 99 1.0 0.0\n"),
    ("Robot1_Groundtruth.dat", "0.0 0.0 0.0 0.0\n0.5 0.05 0.0 0.0\n1.0 0.1 0.0 0.0\n"),
];

/// A small recording with one file replaced.
fn folder(replaced: &str, text: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    for (name, original) in FILES {
        let text = if name == replaced { text } else { original };
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn refusal(replaced: &str, text: &str) -> String {
    let folder = folder(replaced, text);
    let error = Mrclam::open(folder.path(), 1).unwrap_err().to_string();
    error.replace(&format!("{}/", folder.path().display()), "")
}

fn events(folder: &TempDir) -> (Vec<String>, Vec<String>) {
    let mut source = Mrclam::open(folder.path(), 1).unwrap();
    let mut events = Vec::new();
    while let Some(event) = source.next_event().unwrap() {
        let kind = match event.payload {
            Payload::Control(_) => "control",
            Payload::Truth(_) => "truth",
            _ => "measurement",
        };
        events.push(format!("{} {kind}", event.stamp));
    }
    (events, source.notes())
}

#[test]
fn events_come_in_order_and_strangers_are_counted() {
    let (events, notes) = events(&folder("", ""));
    let expected = [
        "0 control",
        "0 truth",
        "0.5 control",
        "0.5 measurement",
        "0.5 truth",
        "1 control",
        "1 truth",
    ];
    assert_eq!(events, expected);
    assert_eq!(
        notes,
        [
            "1 observations of unknown barcodes passed over",
            "1 observations of other robots passed over"
        ]
    );
}

#[test]
fn line_ends_of_other_systems_change_nothing() {
    let odometry = FILES[2].1.replace('\n', "\r\n");
    assert_eq!(events(&folder("Robot1_Odometry.dat", &odometry)), events(&folder("", "")));
}

#[test]
fn broken_files_name_file_line_and_field() {
    for (file, text, message) in [
        (
            "Robot1_Odometry.dat",
            "0.0 fast 0.0\n",
            "Robot1_Odometry.dat:1: v: expected a finite number, got `fast`",
        ),
        (
            "Robot1_Odometry.dat",
            "0.0 0.1 0.0\n0.1 NaN 0.0\n",
            "Robot1_Odometry.dat:2: v: expected a finite number, got `NaN`",
        ),
        (
            "Robot1_Odometry.dat",
            "0.0 0.1 0.0\n0.5 0.1",
            "Robot1_Odometry.dat:2: omega: expected a value, got the end of the line after 2 columns",
        ),
        (
            "Robot1_Odometry.dat",
            "0.5 0.1 0.0\n0.4 0.1 0.0\n",
            "Robot1_Odometry.dat:2: time: expected a time not before 0.5, that of the line above, got `0.4`",
        ),
        ("Robot1_Odometry.dat", "", "Robot1_Odometry.dat: odometry: the file holds none"),
        (
            "Robot1_Odometry.dat",
            "0.0 0.1 0.0 7\n",
            "Robot1_Odometry.dat:1: line: expected 3 columns (time v omega), got 4 columns",
        ),
        (
            "Robot1_Measurement.dat",
            "0.5 63 -1.0 0.0\n",
            "Robot1_Measurement.dat:1: range: expected a distance >= 0, got `-1.0`",
        ),
        (
            "Robot1_Measurement.dat",
            "0.5 6.3 1.0 0.0\n",
            "Robot1_Measurement.dat:1: barcode: expected a whole number >= 0, got `6.3`",
        ),
        (
            "Robot1_Groundtruth.dat",
            "# nothing\n",
            "Robot1_Groundtruth.dat: poses: the file holds none",
        ),
        (
            "Robot1_Groundtruth.dat",
            "1.0 0 0 inf\n",
            "Robot1_Groundtruth.dat:1: theta: expected a finite number, got `inf`",
        ),
        (
            "Barcodes.dat",
            "1 5\n6 5\n",
            "Barcodes.dat:2: barcode: expected a barcode that no other subject wears, got `5`",
        ),
        (
            "Landmark_Groundtruth.dat",
            "6 2.0 0.0 0 0\n6 1.0 0.0 0 0\n",
            "landmark 6: expected one position, got a second one",
        ),
    ] {
        assert_eq!(refusal(file, text), message);
    }
    let apart = refusal("Robot1_Groundtruth.dat", "5.0 0 0 0\n6.0 0 0 0\n");
    assert!(apart.contains("expected odometry and truth that overlap in time"), "{apart}");
}

#[test]
fn missing_files_folders_and_robots_are_named() {
    let missing = folder("", "");
    fs::remove_file(missing.path().join("Robot1_Measurement.dat")).unwrap();
    let error = Mrclam::open(missing.path(), 1).unwrap_err().to_string();
    assert!(error.contains("Robot1_Measurement.dat: No such file"), "{error}");
    assert!(matches!(Mrclam::open(missing.path(), 3), Err(Error::Recording { .. })));
    let error = Mrclam::open(missing.path(), 3).unwrap_err().to_string();
    assert!(error.ends_with("expected one of the robots 1, got robot 3"), "{error}");
    let nowhere = Mrclam::open("/nowhere/at/all", 1).unwrap_err().to_string();
    assert!(nowhere.starts_with("/nowhere/at/all/Barcodes.dat: No such file"), "{nowhere}");
}

/// A delayed control arrives later, behind what had been measured before it took effect.
#[test]
fn calibration_puts_events_where_they_took_effect() {
    let folder = folder("", "");
    let changes = ["odometry={delay=0.2}".to_owned(), "camera.delay=0.1".to_owned()];
    let config = RecordingConfig::parse("mrclam", recording::MRCLAM, &changes).unwrap();
    let source = Mrclam::open(folder.path(), 1).unwrap();
    let mut source = Calibrated::new(source, config.odometry, config.camera).unwrap();
    let mut seen = Vec::new();
    while let Some(event) = source.next_event().unwrap() {
        seen.push((event.arrival, event.stamp, matches!(event.payload, Payload::Control(_))));
    }
    let expected = [
        (0.0, 0.0, false),
        (0.2, 0.2, true),
        (0.5, 0.4, false),
        (0.5, 0.5, false),
        (0.7, 0.7, true),
        (1.0, 1.0, false),
        (1.2, 1.2, true),
    ];
    assert_eq!(seen, expected);
}
