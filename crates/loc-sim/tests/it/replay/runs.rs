//! Methods over recordings.

use super::*;
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::record::Run;
use loc_sim::runner;
use loc_sim::source::laser_log::{Scans, Start};
use std::path::Path;
use std::sync::Arc;

fn options() -> ReplayOptions {
    let start_sigmas = [0.2, 0.2, 0.1];
    ReplayOptions { map: Some(Arc::new(hall())), start_sigmas, ..Default::default() }
}

fn run(text: &str, options: &ReplayOptions, global: bool) -> (Run, Summary) {
    let mut source = open(text, options).unwrap();
    let settings = MethodSettings { global, seed: 1, ..Default::default() };
    let methods = [Method::DeadReckoning, Method::Mcl];
    let run = runner::run(&mut source, &methods, &settings, &mut |_| {}).unwrap();
    let summary = Summary::of(&run, None, Alignment::None).unwrap();
    (run, summary)
}

#[test]
fn dead_reckoning_is_the_odometry_carried_into_the_map() {
    let (run, summary) = run(&corrected(), &options(), false);
    let (truth, odometry) = (drive(), odometry(&drive()));
    for (k, estimate) in run.methods[0].estimates.iter().enumerate() {
        let expected = truth[0] * odometry[0].between(odometry[k]);
        assert!(estimate.pose.distance(expected) < 1e-9, "{k}");
    }
    let sigma = |k: usize| run.methods[0].estimates[k].covariance.unwrap().m22.sqrt();
    assert!((sigma(0) - 0.2).abs() < 1e-12 && sigma(63) > sigma(20) && sigma(20) > 0.2);
    let nees = summary.methods[0].1.nees_mean.unwrap();
    assert!((0.01..3.0).contains(&nees), "{nees}");
}

#[test]
fn mcl_keeps_to_the_truth_where_odometry_does_not() {
    let (_, summary) = run(&corrected(), &options(), false);
    let error = |k: usize| summary.methods[k].1.errors.unwrap();
    assert!(error(0).final_error_m > 0.8, "{:?}", error(0));
    assert!(error(1).ate_rmse_m < 0.1 && error(1).final_error_m < 0.15, "{:?}", error(1));
    let mcl = &summary.methods[1].1;
    assert!(mcl.measurements_used > 55 && mcl.converged_at_s.is_none());
    assert_eq!((summary.duration_s, mcl.recovered_after_s), (31.5, None));
}

#[test]
fn without_a_truth_every_figure_of_errors_is_null() {
    let start = Start::At(drive()[0]);
    let (run, summary) = run(&uncorrected(), &ReplayOptions { start, ..options() }, false);
    // The estimates are those at the scans.
    assert_eq!((run.stamps.len(), run.truth.len()), (64, 0));
    assert_eq!((run.stamps[0], run.stamps[63]), (50.0, 81.5));
    assert!(run.methods.iter().all(|record| record.estimates.len() == 64));
    let json = serde_json::to_value(&summary).unwrap();
    assert!(json["distance_m"].is_null() && json["duration_s"] == 31.5);
    let judged = loc_sim::metrics::PlanarErrors::NAMES.into_iter().chain(["nees_mean"]);
    for name in judged.chain(["converged_at_s", "recovered_after_s"]) {
        let figure = json["methods"]["mcl"].get(name);
        assert!(figure.is_some_and(serde_json::Value::is_null), "{name}: {figure:?}");
    }
    let files = loc_sim::output::files(&run, &summary, "hall", "loc-sim").unwrap();
    let names: Vec<&str> = files.names().collect();
    assert!(names.contains(&"estimate_mcl.tum") && names.contains(&"map.svg"), "{names:?}");
    assert!(!names.contains(&"truth.tum") && !names.contains(&"errors.svg"), "{names:?}");
    assert_eq!(files.text("estimate_mcl.tum").unwrap().lines().count(), 65);
    let table = loc_sim::output::table(&summary);
    assert!(table.starts_with("hall: 31.5 s\n") && table.lines().all(|l| l.len() <= 80), "{table}");
    assert!(table.contains("\nmcl: 100.0 % of the last scan's beams"), "{table}");
    assert_eq!(json["methods"]["mcl"]["beam_fit_at_end"], 1.0);
    // The estimates are sound all the same.
    let last = run.methods[1].estimates[63].pose;
    assert!(last.distance(drive()[63]) < 0.15, "{last}");
}

#[test]
fn names_of_the_errors_are_those_that_are_written() {
    let (_, summary) = run(&corrected(), &options(), false);
    let errors = serde_json::to_value(summary.methods[0].1.errors.unwrap()).unwrap();
    let names: Vec<&str> = errors.as_object().unwrap().keys().map(String::as_str).collect();
    let mut known = loc_sim::metrics::PlanarErrors::NAMES;
    known.sort_unstable();
    assert_eq!(names, known);
}

#[test]
fn a_map_is_needed_and_free_space_in_it() {
    let start = |map| {
        let mut source = open(&corrected(), &ReplayOptions { map, ..options() }).unwrap();
        let settings = MethodSettings::default();
        runner::run(&mut source, &[Method::Mcl], &settings, &mut |_| {}).unwrap_err().to_string()
    };
    assert_eq!(start(None), "method mcl: expected a map, which hall has not");
    let walls = OccupancyGrid::filled(*hall().frame(), 100);
    assert_eq!(
        start(Some(Arc::new(walls))),
        "map of 200 x 60 cells: expected free cells, got none"
    );
}

#[test]
fn intel_is_tracked_on_the_scans_that_its_map_has_not_seen() {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let folder = Path::new(&folder).join("carmen");
    let map = loc_maps::grid::io::load(folder.join("intel_even.yaml")).unwrap();
    let options = ReplayOptions { map: Some(Arc::new(map)), scans: Scans::Odd, ..options() };
    let text = std::fs::read_to_string(folder.join("intel.log")).unwrap();
    let (run, summary) = run(&text, &options, false);
    assert_eq!((run.truth.len(), run.duration().round()), (455, 2649.0));
    let errors = |k: usize| summary.methods[k].1.errors.unwrap();
    // Raw odometry ends 61.8 m off.
    assert!((errors(0).final_error_m - 61.7).abs() < 0.5, "{:?}", errors(0));
    assert!(errors(1).ate_rmse_m < 0.5 && errors(1).ate_median_m < 0.045, "{:?}", errors(1));
}
