//! The methods `ukf` (compared with `ekf`) and `fusion`, simulated and on recordings.

use loc_filters::RobotSettings;
use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Consistency, Summary};
use loc_sim::output::figures;
use loc_sim::record::Run;
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, Scenario, recording};
use loc_sim::source::ranging::RangingStart;
use loc_sim::source::{Calibrated, Mrclam, RangeRecording, Source};

#[test]
fn landmark_drives_are_as_accurate_as_by_the_ekf_and_consistent() {
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
    let mut source = Calibrated::new(source, config.odometry, config.camera).unwrap();
    let methods = [Method::Ekf, Method::Ukf];
    let settings = config.settings(RobotSettings::default()).unwrap();
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

fn scenario(changes: &[&str]) -> Scenario {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    Scenario::named("sensor-fusion", &changes).unwrap()
}

fn fused(scenario: &Scenario, seed: u64) -> Run {
    scenario.run(Some(seed), Some(&[Method::Fusion]), &mut |_| {}).unwrap()
}

/// A drive of 40 s with 15 s without satellites, at a coarser step.
const SHORT: [&str; 6] = [
    "outdoor.time_step=0.05",
    "outdoor.course=[{ duration = 18.0, v = 1.2, omega = '4 deg/s' }, \
     { duration = 22.0, v = 1.0, omega = '-6 deg/s' }]",
    "outdoor.satellites.silent=[[15.0, 30.0]]",
    "outdoor.satellites.latency=0.3",
    "outdoor.radio.silent=[[15.0, 30.0]]",
    "outdoor.inertial.silent=[[33.0, 36.0]]",
];

fn sigma(run: &Run, stamp: f64) -> f64 {
    let index = run.stamps.iter().position(|at| *at >= stamp - 1e-9).unwrap();
    let covariance = run.methods[0].estimates[index].covariance.unwrap();
    covariance.fixed_view::<2, 2>(0, 0).trace().sqrt()
}

#[test]
fn an_outage_of_satellites_keeps_the_covariance_consistent() {
    let scenario = scenario(&SHORT);
    let mut tests = Consistency::new(0.95).unwrap();
    for seed in 1..=15 {
        let run = fused(&scenario, seed);
        assert!(sigma(&run, 29.9) > 1.3 * sigma(&run, 14.9), "seed {seed}");
        assert!(sigma(&run, 40.0) < sigma(&run, 29.9), "seed {seed}");
        tests.push(&run, &run.methods[0]).unwrap();
    }
    let figures = tests.figures();
    let [low, high] = figures.nees_interval.unwrap();
    println!("NEES {low:.2} to {high:.2}");
    assert!(low < 1.15 && high > 0.85 && high < 1.6, "{figures:?}");
}

#[test]
fn one_seed_gives_one_run_and_its_figures() {
    let scenario = scenario(&SHORT);
    let (first, second) = (fused(&scenario, 4), fused(&scenario, 4));
    assert_eq!(first.methods[0].estimates, second.methods[0].estimates);
    assert_eq!(first.sensor_truth.silences.len(), 4, "{:?}", first.sensor_truth.silences);
    let figures = figures::all(&first, "t");
    let names: Vec<_> = figures.iter().map(|figure| figure.file.as_ref()).collect();
    assert!(names.contains(&"fusion.svg") && names.contains(&"biases.svg"), "{names:?}");
    let known = first.methods[0].sensor_errors.last().unwrap();
    for error in known {
        let truth = first.sensor_truth.errors.iter().find(|truth| truth.name == error.name);
        let (_, value) = truth.unwrap().values.last().unwrap();
        let off = (error.mean - value).abs();
        assert!(off < 4.0 * error.sigma, "{}: {off} of {}", error.name, error.sigma);
    }
    assert_eq!(known.len(), 7);
}

#[test]
fn any_sensor_may_be_missing() {
    for sensor in ["wheels", "inertial", "compass", "satellites", "radio"] {
        let mut scenario = scenario(&SHORT);
        let outdoor = scenario.outdoor.as_mut().unwrap();
        match sensor {
            "wheels" => outdoor.wheels = None,
            "inertial" => outdoor.inertial = None,
            "compass" => outdoor.compass = None,
            "satellites" => outdoor.satellites = None,
            _ => outdoor.radio = None,
        }
        let run = fused(&scenario, 2);
        let end = run.methods[0].estimates.last().unwrap();
        let error = end.pose.distance(run.truth.last().unwrap().value.pose);
        println!("without {sensor}: {error:.2} m, sigma {:.2} m", sigma(&run, 40.0));
        assert!(error < 3.5 * sigma(&run, 40.0) && error < 3.0, "without {sensor}: {error}");
    }
}

#[test]
fn wrong_settings_name_their_key() {
    let wrong = [
        ("outdoor.satellites.every=0.03", "outdoor.satellites.every"),
        ("outdoor.radio.scale=0.0", "outdoor.radio.scale"),
        ("outdoor.compass.sigma='-1 deg'", "outdoor.compass.sigma"),
        ("outdoor.wheels.silent=[[3.0, 2.0]]", "silent"),
        ("outdoor.satellites.white_sigma=0.0", "outdoor.satellites.white_sigma"),
        ("outdoor.course=[]", "outdoor.course"),
    ];
    for (change, key) in wrong {
        let error = Scenario::named("sensor-fusion", &[change.to_owned()]).unwrap_err().to_string();
        assert!(error.contains(key), "{change}: {error}");
    }
}

/// Position RMSE over a whole recording, and its NEES of 2 numbers.
fn replayed(mut source: RangeRecording) -> (f64, f64) {
    let config = RecordingConfig::parse("settings", recording::RANGING, &[]).unwrap();
    let settings = config.settings(RobotSettings::default()).unwrap();
    let robot = settings.robot.camera(source.noise());
    let settings = settings.with_robot(robot);
    let methods = [Method::Fusion];
    assert!(source.has_truth());
    let run = runner::run(&mut source, &methods, &settings, &mut |_| {}).unwrap();
    let (_, summary) = &Summary::of(&run, None, Alignment::None).unwrap().methods[0];
    (summary.errors.unwrap().ate_rmse_m, summary.nees_mean.unwrap())
}

fn start() -> RangingStart {
    RangingStart { pose: None, sigmas: [0.2, 0.2, 5_f64.to_radians()] }
}

#[test]
fn ranges_and_odometry_of_the_labyrinth() {
    let Some(data) = std::env::var_os("LOC_DATA_DIR").map(std::path::PathBuf::from) else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let source = RangeRecording::labyrinth(data.join("uwb_labyrinth"), &start()).unwrap();
    let (rmse, nees) = replayed(source);
    println!("labyrinth: {rmse:.3} m, NEES {nees:.2} of 2");
    assert!(rmse <= 0.10 && (0.8..4.0).contains(&nees), "{rmse} {nees}");
}

#[test]
fn ranges_and_odometry_of_plaza() {
    let Some(data) = std::env::var_os("LOC_DATA_DIR").map(std::path::PathBuf::from) else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let (rmse, nees) = replayed(RangeRecording::plaza(data.join("plaza"), 1, &start()).unwrap());
    println!("plaza 1: {rmse:.3} m, NEES {nees:.2}");
    assert!(rmse <= 0.6 && nees < 6.0, "{rmse} {nees}");
}
