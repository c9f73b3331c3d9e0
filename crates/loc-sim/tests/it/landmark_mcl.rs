//! `mcl` among landmarks: beside the extended Kalman filter, from anywhere, on legs.

use loc_filters::RobotSettings;
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::output;
use loc_sim::record::Run;
use loc_sim::scenario::{RecordingConfig, Scenario, recording};
use loc_sim::source::{Calibrated, Mrclam};
use loc_sim::{Error, runner};
use roxmltree::Document;
use std::path::Path;

fn rmse(run: &Run, method: &str) -> f64 {
    let summary = Summary::of(run, None, Alignment::None).unwrap();
    let found = summary.methods.iter().find(|(name, _)| name == method).unwrap();
    found.1.errors.as_ref().unwrap().ate_rmse_m
}

/// A robot of MRCLAM_Dataset6 under a seed; `None` without recordings.
fn replay(robot: u32, methods: &[Method], seed: u64, global: bool) -> Option<Run> {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return None;
    };
    let folder = Path::new(&folder).join("mrclam/MRCLAM_Dataset6");
    let config = RecordingConfig::parse("mrclam", recording::MRCLAM, &[]).unwrap();
    let source = Mrclam::open(folder, robot).unwrap();
    let mut source = Calibrated::new(source, config.odometry, config.camera).unwrap();
    let settings =
        MethodSettings { seed, global, ..config.settings(RobotSettings::default()).unwrap() };
    Some(runner::run(&mut source, methods, &settings, &mut |_| {}).unwrap())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    0.5 * (values[(values.len() - 1) / 2] + values[values.len() / 2])
}

/// With the same calibration and noise, median over seeds.
fn beside_the_ekf(robots: impl IntoIterator<Item = u32>, seeds: u64) {
    for robot in robots {
        let Some(run) = replay(robot, &[Method::Ekf], 1, false) else { return };
        let ekf = rmse(&run, "ekf");
        let of_seed =
            |seed| replay(robot, &[Method::Mcl], seed, false).map(|run| rmse(&run, "mcl"));
        let mcl = median((1..=seeds).filter_map(of_seed).collect());
        println!("robot {robot}: ekf {ekf:.4} m, mcl {mcl:.4} m, {:.3} times", mcl / ekf);
        assert!(mcl <= 1.1 * ekf, "robot {robot}: {mcl} against {ekf}");
    }
}

#[test]
fn one_mrclam_robot_is_localized_as_well_as_by_the_ekf() {
    beside_the_ekf([4], 1);
}

#[test]
#[ignore = "five robots, ten seeds"]
fn all_mrclam_robots_are_localized_as_well_as_by_the_ekf() {
    beside_the_ekf(1..=5, 10);
}

/// Error at the end of a global start [m], and when it was last above 1 m [s].
fn found(run: &Run) -> (f64, f64) {
    let record = &run.methods[0];
    let pairs = record.estimates.iter().zip(&run.truth);
    let errors: Vec<f64> = pairs.map(|(e, t)| e.pose.distance(t.value.pose)).collect();
    let wrong = |error: &f64| *error > 1.0;
    let last_wrong = errors.iter().rposition(wrong).map_or(0.0, |k| run.stamps[k]);
    (errors[errors.len() - 1], last_wrong - run.setup.start)
}

#[test]
#[ignore = "five robots, ten seeds"]
fn mrclam_robots_are_found_from_anywhere() {
    let mut hits = 0;
    for robot in 1..=5 {
        for seed in 1..=10 {
            let Some(run) = replay(robot, &[Method::Mcl], seed, true) else { return };
            let (end, since) = found(&run);
            println!("robot {robot}, seed {seed}: ends {end:.3} m off, right since {since:.1} s");
            hits += usize::from(end < 0.6);
        }
    }
    assert!(hits >= 48, "{hits} of 50");
}

#[test]
fn landmark_drive_is_as_good_as_with_the_ekf() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let mut ratios = Vec::new();
    for seed in 1..=5 {
        let run = scenario.run(Some(seed), None, &mut |_| {}).unwrap();
        ratios.push(rmse(&run, "mcl") / rmse(&run, "ekf"));
    }
    println!("{ratios:.3?}");
    assert!(median(ratios) < 1.1);
}

/// M10, and from anywhere on the field.
#[test]
fn aibo_finds_itself_on_the_field() {
    let tracking = Scenario::named("aibo-soccer", &[]).unwrap();
    let run = tracking.run(None, None, &mut |_| {}).unwrap();
    let (mcl, odometry) = (rmse(&run, "mcl"), rmse(&run, "dead-reckoning"));
    assert!(mcl < 0.3 && odometry > 0.8, "{mcl} {odometry}");
    let summary = Summary::of(&run, Some(1), Alignment::None).unwrap();
    let folder = output::files(&run, &summary, "Soccer", "loc-sim").unwrap();
    for name in ["map.svg", "clouds.svg", "resampling.svg"] {
        assert!(Document::parse(folder.text(name).unwrap()).is_ok(), "{name}");
    }
    let mut hits = 0;
    for seed in 1..=5 {
        let global = Scenario::named("aibo-soccer", &["filter.global=true".into()]).unwrap();
        let run = global.run(Some(seed), Some(&[Method::Mcl]), &mut |_| {}).unwrap();
        hits += usize::from(found(&run).0 < 0.6);
    }
    assert!(hits >= 4, "{hits} of 5");
}

#[test]
fn legs_and_worlds_are_checked() {
    for (change, message) in [
        ("drive.wheels={track=0.4}", "drive.mecanum: expected one of them, got `several`"),
        ("drive.world.name=moon", "world: expected one of office, corridor"),
        ("drive.landmarks=[{id=1,x=0.0,y=0.0}]", "none beside those of the world"),
        ("drive.course=[{duration=1.0,left=0.1,right=0.1}]", "drive.course: expected v"),
        (
            "filter.landmark_mcl.outlier_share=1.0",
            "LandmarkMclSettings.outlier_share: expected a number in [0, 1)",
        ),
        (
            "filter.landmark_mcl.particles=0",
            "LandmarkMclSettings.particles: expected a number >= 1",
        ),
    ] {
        let error = Scenario::named("aibo-soccer", &[change.into()]).unwrap_err();
        assert!(matches!(error, Error::Config { .. }), "{error:?}");
        assert!(error.to_string().contains(message), "{error}");
    }
    let sideways = "drive.course.0.sideways=0.1".to_owned();
    let error = Scenario::named("landmark-drive", &[sideways]).unwrap_err().to_string();
    assert!(error.contains("drive.course: expected v"), "{error}");
}
