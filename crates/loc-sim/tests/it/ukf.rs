//! The method `ukf` beside `ekf`.

use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Consistency, Summary};
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, Scenario, recording};
use loc_sim::source::{Calibrated, Mrclam};

#[test]
fn landmark_drives_are_as_accurate_as_by_the_ekf_and_honest() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let mut tests = Consistency::new(0.95).unwrap();
    let mut rmse = [0.0; 2];
    for seed in 1..=60 {
        let methods = [Method::Ekf, Method::Ukf];
        let run = scenario.run(Some(seed), Some(&methods), &mut |_| {}).unwrap();
        let summary = Summary::of(&run, None, Alignment::None).unwrap();
        for (sum, (_, method)) in rmse.iter_mut().zip(&summary.methods) {
            *sum += method.errors.unwrap().ate_rmse_m / 60.0;
        }
        tests.push(&run, &run.methods[1]).unwrap();
    }
    println!("RMSE of ekf and ukf: {rmse:.4?}");
    assert!((rmse[1] / rmse[0] - 1.0).abs() < 0.05, "{rmse:?}");
    let [low, high] = tests.figures().nees_interval.unwrap();
    assert!(low < 1.0 && 1.0 < high + 0.05 && high < 1.3, "{low} {high}");
}

#[test]
fn a_real_robot_is_followed_as_by_the_ekf() {
    let Some(data) = std::env::var_os("LOC_DATA_DIR").map(std::path::PathBuf::from) else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let config = RecordingConfig::parse("settings", recording::MRCLAM, &[]).unwrap();
    let source = Mrclam::open(data.join("mrclam/MRCLAM_Dataset6"), 4).unwrap();
    let mut source =
        Calibrated::new(source, config.odometry_calibration(), config.camera_calibration())
            .unwrap();
    let methods = [Method::Ekf, Method::Ukf];
    let settings = config.settings().unwrap();
    let run = runner::run(&mut source, &methods, &settings, &mut |_| {}).unwrap();
    let summary = Summary::of(&run, None, Alignment::None).unwrap();
    let rmse: Vec<f64> =
        summary.methods.iter().map(|(_, method)| method.errors.unwrap().ate_rmse_m).collect();
    println!("robot 4: ekf {:.4} m, ukf {:.4} m", rmse[0], rmse[1]);
    assert!(rmse[1] < 1.1 * rmse[0], "{rmse:?}");
}

#[test]
fn without_landmarks_it_names_itself() {
    let scenario = Scenario::named("two-sensors", &[]).unwrap();
    let error = scenario.run(None, Some(&[Method::Ukf]), &mut |_| {}).unwrap_err().to_string();
    assert!(error.contains("ukf") && error.contains("landmarks"), "{error}");
}
