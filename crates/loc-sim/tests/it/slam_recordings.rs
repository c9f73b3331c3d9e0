//! Recordings of landmarks: real ones where LOC_DATA_DIR is set, small written ones everywhere.

use loc_filters::slam::Identities;
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, LandmarkErrors, MethodSummary, Summary, landmark_errors};
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, recording};
use loc_sim::source::landmarks::Trees;
use loc_sim::source::{Calibrated, LandmarkRecording, Mrclam, Source};
use std::path::{Path, PathBuf};

fn settings(text: &str, changes: &[&str]) -> MethodSettings {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    RecordingConfig::parse("settings", text, &changes).unwrap().settings().unwrap()
}

/// The figures of one method on a recording, aligned by the path where there is a true one.
fn figures(
    mut source: LandmarkRecording,
    mut settings: MethodSettings,
    method: Method,
) -> MethodSummary {
    settings.landmark.mounting = source.mounting();
    settings.seed = 1;
    let align = if source.has_truth() { Alignment::Se2 } else { Alignment::None };
    let run = runner::run(&mut source, &[method], &settings, &mut |_| {}).unwrap();
    Summary::of(&run, None, align).unwrap().methods.remove(0).1
}

fn folder(name: &str) -> Option<PathBuf> {
    let Some(data) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return None;
    };
    Some(Path::new(&data).join(name))
}

#[test]
fn the_landmark_course_is_mapped() {
    let Some(folder) = folder("landmark_course") else { return };
    for method in [Method::EkfSlam, Method::FastSlam] {
        let source = LandmarkRecording::course(&folder, [0.0; 3]).unwrap();
        let map = figures(source, settings(recording::LANDMARK_COURSE, &[]), method).landmarks;
        let LandmarkErrors { found, extra, rmse_m, .. } = map.unwrap();
        assert_eq!((found, extra), (Some(9), Some(0)));
        assert!(rmse_m.unwrap() <= 0.10, "{method}: {rmse_m:?}");
    }
}

#[test]
fn the_demonstration_of_mrpt_is_mapped() {
    let Some(folder) = folder("mrpt") else { return };
    for method in [Method::EkfSlam, Method::FastSlam] {
        let source = LandmarkRecording::kf_slam_demo(&folder, [0.0; 3]).unwrap();
        let figures = figures(source, settings(recording::KF_SLAM_DEMO, &[]), method);
        let map = figures.landmarks.unwrap();
        assert_eq!((map.found, map.extra), (Some(70), Some(0)));
        assert!(map.rmse_m.unwrap() < 0.01 && figures.errors.unwrap().ate_rmse_m < 0.02);
    }
}

#[test]
fn victoria_park_with_numbers_has_all_trees() {
    let Some(folder) = folder("victoria_park") else { return };
    let source = LandmarkRecording::victoria_park(folder, Trees::Numbered, [0.0; 3]).unwrap();
    let figures = figures(source, settings(recording::VICTORIA_PARK, &[]), Method::EkfSlam);
    assert_eq!(figures.landmarks.unwrap().mapped, 151);
    let errors = figures.errors.unwrap();
    assert!(errors.ate_median_m <= 5.0, "{errors:?}");
}

#[test]
#[ignore = "26 minutes of a laser, about a minute without optimisation"]
fn victoria_park_without_numbers_does_not_diverge() {
    let Some(folder) = folder("victoria_park") else { return };
    let settings = settings(recording::VICTORIA_PARK_DETECTIONS, &[]);
    assert_eq!(settings.slam.identities, Identities::Unknown);
    let source = LandmarkRecording::victoria_park(folder, Trees::Detected, [0.0; 3]).unwrap();
    let errors = figures(source, settings, Method::EkfSlam).errors.unwrap();
    assert!(errors.ate_median_m <= 5.0 && errors.final_error_m < 15.0, "{errors:?}");
}

/// The map that a robot of MRCLAM draws, as if alone.
fn mrclam_map(folder: &Path, robot: u32, changes: &[&str]) -> LandmarkErrors {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    let config = RecordingConfig::parse("mrclam", recording::MRCLAM, &changes).unwrap();
    let calibration = (config.odometry_calibration(), config.camera_calibration());
    let source = Mrclam::open(folder, robot).unwrap();
    let mut source = Calibrated::new(source, calibration.0, calibration.1).unwrap();
    let settings = config.settings().unwrap();
    let run = runner::run(&mut source, &[Method::EkfSlam], &settings, &mut |_| {}).unwrap();
    landmark_errors(&run, &run.methods[0]).unwrap().unwrap()
}

#[test]
fn mrclam_is_mapped_by_every_robot() {
    let Some(folder) = folder("mrclam/MRCLAM_Dataset6") else { return };
    for robot in 1..=5 {
        let map = mrclam_map(&folder, robot, &[]);
        assert_eq!((map.found, map.extra), (Some(15), Some(0)), "robot {robot}");
        assert!(map.rmse_m.unwrap() <= 0.15, "robot {robot}: {map:?}");
    }
}

/// The barcodes hang in twos and threes, 18 cm from each other.
#[test]
fn mrclam_is_mapped_without_numbers() {
    let Some(folder) = folder("mrclam/MRCLAM_Dataset6") else { return };
    let maps = (1..=5).map(|robot| mrclam_map(&folder, robot, &["filter.slam.identities=unknown"]));
    let maps: Vec<LandmarkErrors> = maps.collect();
    let right = |map: &&LandmarkErrors| {
        (map.found, map.extra) == (Some(15), Some(0)) && map.rmse_m.unwrap() <= 0.15
    };
    assert!(maps.iter().filter(right).count() >= 3, "{maps:?}");
}

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn broken_recordings_name_file_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let message = |result: loc_sim::Result<LandmarkRecording>| result.unwrap_err().to_string();
    let course = |text: &str| {
        write(path, "sensor_data.dat", text);
        message(LandmarkRecording::course(path, [0.0; 3]))
    };
    let text = course("ODOMETRY 0.1 0.1 0\nSENSOR 1 far 0.3\n");
    assert!(text.contains("sensor_data.dat:2: trans or range"), "{text}");
    let text = course("ODOMETRY 0.1 0.1 0\nSONAR 1 2 0.3\n");
    assert!(text.contains(":2: kind: expected ODOMETRY or SENSOR, got `SONAR`"), "{text}");
    let text = course("ODOMETRY 0.1 0.1 0\nSENSOR -1 2 0.3\n");
    assert!(text.contains(":2: rot1 or id: expected a whole number"), "{text}");
    assert!(course("").contains("motions (ODOMETRY)"));

    let text = message(LandmarkRecording::kf_slam_demo(path, [0.0; 3]));
    assert!(text.contains("expected a file *_bearing_range.csv"), "{text}");
    write(path, "a_bearing_range.csv", "1,0.0,7,-3.0,1.1,0.0,0.01,0.002\n");
    write(path, "a_odometry.csv", "1,0.0,inc,0.1,0.0,0.0\n1,0.0,inc,0.1,0.0,0.0\n");
    let text = message(LandmarkRecording::kf_slam_demo(path, [0.0; 3]));
    assert!(text.contains("a_odometry.csv:2: step"), "{text}");
    write(path, "a_odometry.csv", "1,0.0,inc,0.1,0.0,0.0\n");
    let text = message(LandmarkRecording::kf_slam_demo(path, [0.0; 3]));
    assert!(text.contains("a_bearing_range.csv:1: range: expected a distance"), "{text}");

    write(path, "gtsam_odometry.csv", "0,1,1.0,0.1,0.0,0.0\n");
    write(path, "gtsam_landmark_obs.csv", "5,2,1.0,0.0,1.0,0.0\n");
    let text = message(LandmarkRecording::victoria_park(path, Trees::Numbered, [0.0; 3]));
    assert!(text.contains("gtsam_landmark_obs.csv:1: pose: expected a pose that"), "{text}");
    write(path, "gtsam_landmark_obs.csv", "1,2,1.0,0.0,1.0,0.0\n");
    write(path, "gps.csv", "9.0,1.0,2.0\n");
    let text = message(LandmarkRecording::victoria_park(path, Trees::Numbered, [0.0; 3]));
    assert!(text.contains("positions of the GPS along the first way"), "{text}");
}
