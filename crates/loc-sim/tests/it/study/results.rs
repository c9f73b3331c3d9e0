use super::drive;
use loc_core::stats;
use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Consistency, Summary, ends_near};
use loc_sim::study::{Study, StudyOptions, StudySource};
use std::fs;
use tempfile::TempDir;

/// The figures of a group are those of its runs, made here one by one.
#[test]
fn groups_are_what_their_runs_are() {
    let study =
        drive(12, &["filter.gate_probability=0.5,0.999"], &[Method::DeadReckoning, Method::Ekf]);
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
    scenario.filter.get_or_insert_default().gate_probability = Some(0.5);
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
    // A gate that turns half of the good measurements away is noticed.
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
    let study = drive(2, &["filter.integration=euler,midpoint"], &[Method::Ekf]);
    let folder = TempDir::new().unwrap();
    assert!(study.run(folder.path(), 1, &mut |_| true).unwrap());
    study.write(folder.path(), "test").unwrap();
    let csv = fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let mut scenario = study.scenario().clone();
    scenario.filter.get_or_insert_default().integration = loc_core::motion::Integration::Midpoint;
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
    // All figures but two of time, and settings, seed, method, success, duration, distance, error.
    assert_eq!(rows[0].len(), names(&json) - 2 + 7);
    let times = fs::read_to_string(folder.path().join("times.csv")).unwrap();
    assert!(
        times.starts_with("filter.integration,seed,method,runtime_s,realtime_factor\neuler,1,ekf,")
    );
}

#[test]
fn success_is_what_the_user_says() {
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
