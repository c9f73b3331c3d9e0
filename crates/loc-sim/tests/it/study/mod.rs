//! Studies: grids, their journal, their results, and the command.

#[cfg(feature = "cli")]
mod command;
#[cfg(feature = "cli")]
mod interruption;
mod journal;
mod parquet;

use loc_core::stats;
use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Consistency, Summary, ends_near};
use loc_sim::study::{Axis, Grid, Job, Study, StudyOptions, StudySource, Success};
use std::fs;
use tempfile::TempDir;

/// A study of `landmark-drive`, shortened to its first leg.
fn drive(runs: u64, vary: &[&str], methods: &[Method]) -> Study {
    let vary: Vec<Axis> = vary.iter().map(|text| text.parse().unwrap()).collect();
    let course = "drive.course=[{duration=6.0,v=0.5,omega='10 deg/s'}]".to_owned();
    let source = StudySource::named("landmark-drive", &[course]).unwrap();
    let methods = methods.to_vec();
    Study::new(source, StudyOptions { runs, vary, methods, ..Default::default() }).unwrap()
}

fn values(text: &str) -> Vec<String> {
    let axis: Axis = text.parse().unwrap();
    axis.values().iter().map(ToString::to_string).collect()
}

#[test]
fn values_come_as_lists_and_as_ranges() {
    assert_eq!(values("a.b=100,500, 2000"), ["100", "500", "2000"]);
    assert_eq!(values("a.b=0.01:0.1:5"), ["0.01", "0.0325", "0.055", "0.0775", "0.1"]);
    assert_eq!(values("a.b=100:500:5"), ["100", "200", "300", "400", "500"]);
    assert_eq!(values("a.b=1:2:3"), ["1.0", "1.5", "2.0"].map(|v| v.trim_end_matches(".0")));
    assert_eq!(values("a.b=5:-5:3"), ["5", "0", "-5"]);
    assert_eq!(values("a.b=euler,midpoint"), ["euler", "midpoint"]);
    assert_eq!(values("a.b=[1,2],[3,{c=4}]").len(), 2);
    assert_eq!(values("a.b=\"x,y\",true"), ["x,y", "true"]);
    assert_eq!(values("a.b=07:30:00,x"), ["07:30:00", "x"]);
    // Whole numbers stay whole, so that settings that count take them.
    let axis: Axis = "n=100:300:3".parse().unwrap();
    assert_eq!(axis.change(1), "n=200");
    assert_eq!(axis.numbers(), Some(vec![100.0, 200.0, 300.0]));
    assert_eq!("n=1,x".parse::<Axis>().unwrap().numbers(), None);
}

#[test]
fn bad_values_are_named() {
    for (text, message) in [
        ("laser.sigma", "expected KEY=VALUE,VALUE,.. or KEY=FIRST:LAST:COUNT, got `laser.sigma`"),
        ("=1", "expected a key such as filter.particles, got ``"),
        ("a..b=1", "expected a key such as filter.particles, got `a..b`"),
        ("a=1,,2", "--vary a: expected a value between the commas, got nothing"),
        ("a=", "--vary a: expected a value between the commas, got nothing"),
        ("a=1,2,1", "--vary a: expected values that differ, got `1 twice`"),
        ("a=0:1:1", "expected FIRST:LAST:COUNT with a COUNT of 2 to 1000000, got `1`"),
        ("a=0:1:2.5", "got `2.5`"),
        ("a=0:inf:3", "got `0:inf:3`"),
        ("a=1:1:3", "expected values that differ, got `1 twice`"),
        ("seed=1,2", "--vary seed: expected a setting: seeds come from --runs and --seed"),
    ] {
        let error = text.parse::<Axis>().unwrap_err().to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
}

#[test]
fn a_grid_has_every_combination_once() {
    let axes = vec!["a=1,2,3".parse().unwrap(), "b=x,y".parse().unwrap()];
    let grid = Grid::new(axes, 7, 4).unwrap();
    assert_eq!((grid.cells(), grid.len(), grid.is_empty()), (6, 24, false));
    assert_eq!(grid.job(0), Job { cell: 0, seed: 7 });
    assert_eq!(grid.job(23), Job { cell: 5, seed: 10 });
    assert!((0..24).all(|index| grid.index(grid.job(index)) == Some(index)));
    assert_eq!(grid.index(Job { cell: 6, seed: 7 }), None);
    assert_eq!(
        (grid.index(Job { cell: 0, seed: 6 }), grid.index(Job { cell: 0, seed: 11 })),
        (None, None)
    );
    assert_eq!(grid.changes(1), ["a=1", "b=\"y\""]);
    let mut all: Vec<_> = (0..6).map(|cell| grid.changes(cell)).collect();
    all.sort();
    all.dedup();
    assert_eq!(all.len(), 6);
}

#[test]
fn grids_that_make_no_sense_are_refused() {
    let wide = || "a=1:1000:1000".parse::<Axis>().unwrap();
    let refused = |axes: Vec<Axis>, seed: u64, runs: u64| {
        Grid::new(axes, seed, runs).unwrap_err().to_string()
    };
    assert_eq!(refused(vec![], 1, 0), "--runs: expected at least 1, got `0`");
    assert_eq!(
        refused(vec![wide()], 1, 1001),
        "--runs, --vary: expected at most 1000000 runs, got `1000 settings x 1001 runs = 1001000`"
    );
    assert!(Grid::new(vec![wide()], 1, 1000).is_ok());
    assert!(refused(vec![], 1, u64::MAX).contains("at most 1000000 runs"));
    let more = (0..20).map(|k| format!("k{k}=1:1000:1000").parse().unwrap()).collect();
    assert!(refused(more, 1, u64::MAX).contains("at most 1000000 runs"));
    assert!(
        refused(vec![], u64::MAX, 2).contains("--seed: expected seeds up to 18446744073709551615")
    );
    assert!(Grid::new(vec![], u64::MAX, 1).is_ok());
    let twice = vec!["a=1".parse().unwrap(), "a=2".parse().unwrap()];
    assert_eq!(refused(twice, 1, 1), "--vary: expected every key once, got `a twice`");
}

fn study(scenario: &str, vary: &[&str], methods: &[Method]) -> Result<Study, String> {
    let vary: Vec<Axis> = vary.iter().map(|text| text.parse().unwrap()).collect();
    let source = StudySource::named(scenario, &[]).unwrap();
    let options = StudyOptions { runs: 2, vary, methods: methods.to_vec(), ..Default::default() };
    Study::new(source, options).map_err(|error| error.to_string())
}

/// An error names the setting and what there is instead.
#[test]
fn unknown_settings_are_named_with_what_exists() {
    for (scenario, vary, message) in [
        (
            "position-tracking",
            "laser.sigm=0.1",
            "--vary laser.sigm=0.1: unknown field `sigm`, expected one of `preset`, `every`",
        ),
        (
            "landmark-drive",
            "filter.partcles=5",
            "--vary filter.partcles=5: unknown field `partcles`, expected one of `robot`",
        ),
        (
            "landmark-drive",
            "filter.robot.integration=euler,simpson",
            "--vary filter.robot.integration=\"simpson\": unknown variant `simpson`, expected one of `euler`",
        ),
        ("landmark-drive", "drive.camera.every=-1.0", "--vary drive.camera.every=-1.0"),
        ("landmark-drive", "filter.particles=many", "expected usize"),
        ("landmark-drive", "drive.course.9.v=1", "expected the key of a table or array, got `9`"),
    ] {
        let error = study(scenario, &[vary], &[Method::Ekf]).unwrap_err();
        assert!(error.contains(message), "{vary}: {error}");
    }
    // A typing error is found beside a setting that is right.
    let error =
        study("landmark-drive", &["filter.particles=50", "camera.noize.x=1"], &[]).unwrap_err();
    assert!(error.contains("--vary camera.noize.x=1: unknown field `noize`"), "{error}");
    // Two values that do not go together are found before the first run.
    let both = [
        "filter.mcl.particles.min_particles=100,900",
        "filter.mcl.particles.max_particles=500,1000",
    ];
    let error = study("position-tracking", &both, &[]).unwrap_err();
    assert!(error.contains("max_particles: expected at least min_particles, got 500"), "{error}");
}

#[test]
fn studies_that_cannot_run_are_refused() {
    let refused = |scenario: &str, methods: &[Method]| study(scenario, &[], methods).unwrap_err();
    assert!(
        refused("probability-map", &[Method::Mcl])
            .contains("expected a scenario with a robot that moves")
    );
    assert!(
        refused("landmark-drive", &[Method::Ekf, Method::Ekf])
            .contains("every method once, got `ekf twice`")
    );
    for bad in ["ate", "ate_rmse_m<x", "<1", "ate_rmse_m<inf"] {
        let error = bad.parse::<Success>().unwrap_err().to_string();
        assert!(error.contains("expected FIGURE<LIMIT, as ate_rmse_m<0.1"), "{error}");
    }
}

/// The short names of the settings that people vary most.
#[test]
fn short_names_stand_for_full_ones() {
    let tour =
        study("position-tracking", &["filter.particles=100,300", "laser.sigma=0.01:0.1:2"], &[]);
    assert_eq!(tour.unwrap().grid().cells(), 4);
    let of = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|&c| c.to_owned()).collect();
        loc_sim::scenario::Scenario::named("position-tracking", &changes).unwrap()
    };
    let short = of(&["filter.particles=300", "laser.sigma=0.05", "laser.every=0.4"]);
    let particles = &short.settings().unwrap().mcl.particles;
    assert_eq!((particles.min_particles, particles.max_particles), (300, 300));
    let laser = short.tour.as_ref().unwrap().laser;
    assert_eq!((laser.sigma, laser.every), (Some(0.05), 0.4));
    let drive = drive(1, &["camera.range_sigma=0.1,0.3"], &[Method::Ekf]);
    assert_eq!(drive.grid().cells(), 2);
}

/// The figures of a group are those of its runs, made here one by one.
#[test]
fn groups_are_what_their_runs_are() {
    let study = drive(
        12,
        &["filter.robot.gate_probability=0.5,0.999"],
        &[Method::DeadReckoning, Method::Ekf],
    );
    let folder = TempDir::new().unwrap();
    assert!(study.run(folder.path(), 2, &mut |_| true).unwrap());
    let results = study.results(folder.path()).unwrap();
    assert_eq!((results.groups.len(), results.runs, results.failed), (4, 24, 0));
    let group = &results.groups[1];
    assert_eq!(
        (group.method.as_str(), group.runs, group.settings[0].1.as_float()),
        ("ekf", 12, Some(0.5))
    );
    let mut scenario = study.scenario().clone();
    scenario.set_filter("robot.gate_probability=0.5").unwrap();
    let (mut errors, mut tests) = (Vec::new(), Consistency::new(0.95).unwrap());
    let mut near = 0;
    for seed in 1..=12 {
        let run = scenario.run(Some(seed), Some(&[Method::Ekf]), &mut |_| {}).unwrap();
        let summary = Summary::of(&run, Some(seed), Alignment::None).unwrap();
        errors.push(summary.methods[0].1.errors.unwrap().ate_rmse_m);
        near += u64::from(ends_near(&run, &run.methods[0]).unwrap());
        tests.push(&run, &run.methods[0]).unwrap();
    }
    let spread = group.ate_rmse_m.unwrap();
    let mean = errors.iter().sum::<f64>() / 12.0;
    assert!((spread.mean - mean).abs() < 1e-12);
    assert_eq!(spread.median, stats::median(&errors).unwrap());
    // t of 11 degrees at 0.975 is 2.20099.
    let sigma = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 11.0).sqrt();
    let [low, high] = spread.interval.unwrap();
    assert!((high - mean - 2.20099 * sigma / 12.0_f64.sqrt()).abs() < 1e-5 * mean && low < mean);
    assert_eq!(group.consistency.measurements, tests.nis().count());
    assert!((group.consistency.nees_mean.unwrap() - tests.nees().mean().unwrap()).abs() < 1e-9);
    assert_eq!(group.consistency.autocorrelation, tests.figures().autocorrelation);
    assert_eq!(group.successes, near);
    let wilson = stats::wilson_interval(near, 12, 0.95).unwrap();
    assert_eq!(group.success_interval, Some([*wilson.start(), *wilson.end()]));
    // A gate that rejects half of the good measurements is detected.
    let open = &results.groups[3];
    assert!(
        group.consistency.nis_per_degree < Some(0.6) && open.consistency.nis_per_degree > Some(0.8)
    );
    let dead = &results.groups[0];
    assert!(dead.consistency.nis_mean.is_none() && dead.consistency.white_share.is_none());
}

/// Each row is the `summary.json` of its run.
#[test]
fn a_row_has_the_figures_of_the_summary() {
    let study = drive(2, &["filter.robot.integration=euler,midpoint"], &[Method::Ekf]);
    let folder = TempDir::new().unwrap();
    assert!(study.run(folder.path(), 1, &mut |_| true).unwrap());
    study.write(folder.path(), "test").unwrap();
    let csv = fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let mut scenario = study.scenario().clone();
    scenario.set_filter("robot.integration=midpoint").unwrap();
    let run = scenario.run(Some(2), Some(&[Method::Ekf]), &mut |_| {}).unwrap();
    let summary = Summary::of(&run, Some(2), Alignment::None).unwrap();
    let json = serde_json::to_value(&summary).unwrap();
    assert_eq!(rows[4][..4], ["midpoint", "2", "ekf", "true"]);
    for (name, cell) in rows[0].iter().zip(&rows[4]).skip(4) {
        let value = match *name {
            "duration_s" | "distance_m" => &json[*name],
            name => &json["methods"]["ekf"][name],
        };
        match value.as_f64() {
            Some(value) => assert_eq!(cell.parse::<f64>().unwrap(), value, "{name}"),
            None => assert_eq!(*cell, "", "{name}"),
        }
    }
    assert!(!rows[0].contains(&"runtime_s"), "times are no part of what must be the same");
    let names = |json: &serde_json::Value| json["methods"]["ekf"].as_object().unwrap().len();
    // All figures but two of time and two lists, and settings, seed, method, success, duration,
    // distance, error.
    assert_eq!(rows[0].len(), names(&json) - 2 - 2 + 7);
    let times = fs::read_to_string(folder.path().join("times.csv")).unwrap();
    assert!(times.starts_with(
        "filter.robot.integration,seed,method,runtime_s,realtime_factor\neuler,1,ekf,"
    ));
}

#[test]
fn success_is_defined_by_the_user() {
    let with = |success: &str| {
        let source = StudySource::named("landmark-drive", &[]).unwrap();
        let success = success.parse().unwrap();
        let methods = vec![Method::Ekf];
        let study =
            Study::new(source, StudyOptions { runs: 10, methods, success, ..Default::default() })
                .unwrap();
        let folder = TempDir::new().unwrap();
        assert!(study.run(folder.path(), 2, &mut |_| true).unwrap());
        study.results(folder.path()).map(|results| results.groups[0].successes)
    };
    assert_eq!(with("ate_rmse_m<0.001").unwrap(), 0);
    assert_eq!(with("ate_rmse_m < 10").unwrap(), 10);
    assert!((1..10).contains(&with("ate_rmse_m<0.05").unwrap()));
    // A figure without a meaning is neither.
    assert_eq!(with("recovered_after_s<5").unwrap(), 0);
    let error = with("rmse<1").unwrap_err().to_string();
    assert!(error.contains("--success: expected one of ate_rmse_m, ate_median_m"), "{error}");
}

/// A method that cannot run on the source at all is an error, not a thousand failures.
#[test]
fn an_unsuitable_method_stops_the_study() {
    let study = drive(1000, &[], &[Method::Kf]);
    let folder = TempDir::new().unwrap();
    let error = study.run(folder.path(), 2, &mut |_| true).unwrap_err().to_string();
    assert!(error.contains("method kf: expected a vehicle on a rail"), "{error}");
    assert_eq!(study.results(folder.path()).unwrap().groups.len(), 0);
}
