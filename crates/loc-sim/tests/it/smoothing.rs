//! Kalman runs smoothed after the run.

use loc_filters::RobotSettings;
use loc_filters::localizer::Estimate;
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, Consistency, MethodSummary, Summary};
use loc_sim::record::Run;
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, Scenario, recording};
use loc_sim::source::{Calibrated, Mrclam};
use std::path::Path;

fn smoothed_run(scenario: &Scenario, method: Method, seed: u64) -> Run {
    let mut scenario = scenario.clone();
    scenario.set_filter("smooth=true").unwrap();
    scenario.run(Some(seed), Some(&[method]), &mut |_| {}).unwrap()
}

fn summaries(run: &Run) -> Vec<(String, MethodSummary)> {
    Summary::of(run, None, Alignment::None).unwrap().methods
}

/// Mean RMSE of filter and smoother over seeds, and in how many runs the smoother is better.
fn compare(scenario: &Scenario, method: Method, seeds: u64) -> (f64, f64, usize) {
    let (mut filter, mut smoother, mut better) = (0.0, 0.0, 0);
    for seed in 1..=seeds {
        let rmse: Vec<f64> = summaries(&smoothed_run(scenario, method, seed))
            .iter()
            .map(|(_, summary)| summary.errors.unwrap().ate_rmse_m)
            .collect();
        filter += rmse[0] / seeds as f64;
        smoother += rmse[1] / seeds as f64;
        better += usize::from(rmse[1] < rmse[0]);
    }
    println!(
        "{method}: RMSE {filter:.4} m, smoothed {smoother:.4} m, better in {better} of {seeds}"
    );
    (filter, smoother, better)
}

const RAIL: &str = r#"
name = "rail"
title = "A vehicle that measures its position at every step"
seed = 1
methods = ["kf"]
[rail]
time_step = 0.1
steps = 60
acceleration_sigma = 2.0
position_sigma = 1.0
speed_sigma = 0.5
sensors = [{ sigma = 0.5 }]
"#;

#[test]
fn smoothing_a_rail_is_more_accurate_and_consistent() {
    let scenario = Scenario::parse("rail", RAIL, &[]).unwrap();
    let (filter, smoother, better) = compare(&scenario, Method::Kf, 60);
    assert!(smoother < 0.85 * filter && better >= 50);
    let mut tests = Consistency::new(0.95).unwrap();
    for seed in 1..=200 {
        let run = smoothed_run(&scenario, Method::Kf, seed);
        assert_eq!((run.methods[1].name().as_ref(), run.methods.len()), ("kf-smoothed", 2));
        let ends = [0, 1].map(|k| run.methods[k].estimates.last().unwrap().rail.unwrap());
        assert!((ends[0].mean - ends[1].mean).norm() < 1e-12, "the end has nothing after it");
        tests.push(&run, &run.methods[1]).unwrap();
    }
    let figures = tests.figures();
    let [low, high] = figures.nees_interval.unwrap();
    assert!(low < 1.0 && 1.0 < high && figures.nees_share_in_band.unwrap() > 0.8, "{figures:?}");
    // Its innovations are the filter's, not its own.
    assert_eq!((figures.nis_mean, figures.white_share), (None, None));
}

#[test]
fn smoothing_among_landmarks_is_more_accurate_and_consistent() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let (filter, smoother, better) = compare(&scenario, Method::Ekf, 60);
    assert!(smoother < 0.8 * filter && better >= 57);
    let mut tests = Consistency::new(0.95).unwrap();
    for seed in 1..=150 {
        let run = smoothed_run(&scenario, Method::Ekf, seed);
        tests.push(&run, &run.methods[1]).unwrap();
    }
    let figures = tests.figures();
    println!("smoothed: {figures:?}");
    assert!(figures.nees_share_in_band.unwrap() > 0.8);
    assert!((figures.nees_per_degree.unwrap() - 1.0).abs() < 0.1);
}

/// Every sensor in one filter, extended or unscented, through a time without satellites.
#[test]
fn smoothing_a_fusion_is_more_accurate_and_consistent() {
    let scenario = Scenario::named("sensor-fusion", &[]).unwrap();
    for method in [Method::Fusion, Method::FusionUkf] {
        let (filter, smoother, better) = compare(&scenario, method, 4);
        assert!(smoother < 0.7 * filter && better == 4);
        let run = smoothed_run(&scenario, method, 5);
        let figures = summaries(&run);
        let nees = figures[1].1.nees_mean.unwrap();
        assert!((1.0..6.0).contains(&nees), "{method}: {nees}");
    }
}

/// Lines in a hall seen by a robot that starts 0.2 m off: the smoother knows that from what came
/// after, extended or unscented.
#[test]
fn smoothing_among_walls_errs_less() {
    let changes = ["seed=3".to_owned()];
    let scenario = Scenario::named("line-matching", &changes).unwrap();
    for method in [Method::LineEkf, Method::LineUkf] {
        let (filter, smoother, _) = compare(&scenario, method, 2);
        assert!(smoother <= filter, "{method}: {smoother} {filter}");
    }
}

/// After the run nothing is late: a camera with a latency leads to the same estimates.
#[test]
fn late_measurements_are_not_late_for_the_smoother() {
    let course = "drive.course=[{duration=12.0,v=0.5,omega='15 deg/s'}]".to_owned();
    let run = |more: &str| {
        let changes = [course.clone(), more.to_owned()];
        smoothed_run(&Scenario::named("landmark-drive", &changes).unwrap(), Method::Ekf, 3)
    };
    let (late, punctual) = (run("drive.camera.latency=0.35"), run("drive.camera.latency=0.0"));
    let pairs = late.methods[1].estimates.iter().zip(&punctual.methods[1].estimates);
    // Observations of the last 0.35 s are still pending at the end.
    let off = |(a, b): (&Estimate, &Estimate)| a.pose.distance(b.pose);
    let early: Vec<f64> = pairs.take(60).map(off).collect();
    assert!(early.iter().all(|off| *off < 1e-3), "{early:?}");
    let online = late.methods[0].estimates.iter().zip(&punctual.methods[0].estimates);
    assert!(online.map(off).fold(0.0, f64::max) > 0.005);
}

/// Poses of an odometry instead of velocities, and a method beside that has nothing to smooth.
#[test]
fn a_tour_is_smoothed_too() {
    let mut scenario = Scenario::named("overview", &["tour.duration=20.0".into()]).unwrap();
    scenario.set_filter("smooth=true").unwrap();
    let run = scenario.run(Some(2), Some(&[Method::DeadReckoning, Method::Ekf]), &mut |_| {});
    let run = run.unwrap();
    let names: Vec<_> = run.methods.iter().map(|record| record.name().into_owned()).collect();
    assert_eq!(names, ["dead-reckoning", "ekf", "ekf-smoothed"]);
    let rmse: Vec<f64> =
        summaries(&run).iter().map(|(_, s)| s.errors.unwrap().ate_rmse_m).collect();
    assert!(rmse[2] < rmse[1] && rmse[2] < rmse[0], "{rmse:?}");
}

/// Without the wish nothing is smoothed.
#[test]
fn no_method_is_smoothed_without_request() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let run = scenario.run(None, Some(&[Method::Ekf]), &mut |_| {}).unwrap();
    assert_eq!(run.methods.len(), 1);
}

/// The robots of MRCLAM, with the truth of a camera system.
#[test]
fn smoothing_a_real_robot_errs_less() {
    let Some(data) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let folder = Path::new(&data).join("mrclam/MRCLAM_Dataset6");
    let config = RecordingConfig::parse("mrclam", recording::MRCLAM, &[]).unwrap();
    let settings =
        MethodSettings { smooth: true, ..config.settings(RobotSettings::default()).unwrap() };
    for robot in [2, 4] {
        let source = Mrclam::open(&folder, robot).unwrap();
        let (odometry, camera) = (config.odometry, config.camera);
        let mut source = Calibrated::new(source, odometry, camera).unwrap();
        let run = runner::run(&mut source, &[Method::Ekf], &settings, &mut |_| {}).unwrap();
        let rmse: Vec<f64> =
            summaries(&run).iter().map(|(_, s)| s.errors.unwrap().ate_rmse_m).collect();
        println!("robot {robot}: ekf {:.3} m, smoothed {:.3} m", rmse[0], rmse[1]);
        assert!(rmse[1] < 0.95 * rmse[0]);
    }
}

#[cfg(feature = "cli")]
mod command {
    use std::fs;
    use std::path::Path;
    use std::process::{Command, Output};
    use tempfile::TempDir;

    fn loc_sim(folder: &Path, arguments: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
        command.current_dir(folder).args(arguments.split(' ')).output().unwrap()
    }

    #[test]
    fn a_second_record_is_in_table_figures_and_files() {
        let folder = TempDir::new().unwrap();
        let output = loc_sim(folder.path(), "run landmark-drive --method ekf --smooth --out o");
        let table = String::from_utf8(output.stdout).unwrap();
        assert!(table.contains("\nekf ") && table.contains("\nekf-smoothed "), "{table}");
        for file in ["estimate_ekf-smoothed.tum", "covariance_ekf-smoothed.csv"] {
            assert!(folder.path().join("o").join(file).is_file());
        }
        for figure in ["map.svg", "errors.svg", "report.html"] {
            let text = fs::read_to_string(folder.path().join("o").join(figure)).unwrap();
            assert!(text.contains("ekf-smoothed"), "{figure}");
        }
        // A run without leaves nothing of it.
        loc_sim(folder.path(), "run landmark-drive --method ekf --out o");
        assert!(!folder.path().join("o/estimate_ekf-smoothed.tum").exists());
        let rail = loc_sim(folder.path(), "run accelerated-vehicle --smooth --out r");
        assert!(String::from_utf8(rail.stdout).unwrap().contains("kf-smoothed ends at x = "));
    }

    #[test]
    fn a_study_has_rows_of_it() {
        let folder = TempDir::new().unwrap();
        let output =
            loc_sim(folder.path(), "study landmark-drive --method ekf --smooth --runs 3 --out s");
        assert!(output.status.success());
        let csv = fs::read_to_string(folder.path().join("s/runs.csv")).unwrap();
        assert_eq!(csv.matches(",ekf-smoothed,true,").count(), 3);
        let unlike = loc_sim(folder.path(), "study landmark-drive --method ekf --runs 3 --out s");
        let error = String::from_utf8(unlike.stderr).unwrap();
        assert!(error.contains("--method was `ekf-smoothed` there"), "{error}");
    }

    #[test]
    fn where_nothing_can_be_smoothed_it_is_refused() {
        let folder = TempDir::new().unwrap();
        for command in ["run", "study"] {
            let arguments = format!("{command} landmark-drive --method mcl --smooth --out o");
            let output = loc_sim(folder.path(), &arguments);
            let error = String::from_utf8(output.stderr).unwrap();
            let expected = "error: --smooth: expected a Kalman filter among the methods (kf, ekf, \
                            ukf, line-ekf, line-ukf, fusion, fusion-ukf), got mcl\n";
            assert_eq!((output.status.code(), error.as_str()), (Some(1), expected));
        }
    }
}
