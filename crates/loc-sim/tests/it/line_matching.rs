//! `line-ekf` in the office, on the Intel recording, and where it cannot run (H4).

use crate::replay::{corrected, drive, hall, open};
use loc_core::stats::chi_square_band;
use loc_filters::line_matching::{LinePairing, Tracking};
use loc_maps::LineMap;
use loc_maps::grid::io;
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, Consistency, Summary};
use loc_sim::output::figures;
use loc_sim::record::Run;
use loc_sim::scenario::Scenario;
use loc_sim::source::carmen::CarmenLog;
use loc_sim::source::laser_log::{LaserRecording, ReplayOptions, Scans};
use loc_sim::{Error, runner};
use std::path::PathBuf;
use std::sync::Arc;

fn scenario(changes: &[&str]) -> Scenario {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    Scenario::named("line-matching", &changes).unwrap()
}

/// Position RMSE \[m\] and heading RMSE \[deg\] of the only method.
fn errors(run: &Run) -> (f64, f64) {
    let summary = Summary::of(run, None, Alignment::None).unwrap();
    let errors = summary.methods[0].1.errors.unwrap();
    (errors.ate_rmse_m, errors.heading_rmse_deg.unwrap())
}

#[test]
fn in_the_office_it_is_within_millimetres() {
    let scenario = scenario(&["tour.duration=8.0"]);
    let run = scenario.run(None, Some(&[Method::LineEkf]), &mut |_| {}).unwrap();
    let (position, heading) = errors(&run);
    assert!(position <= 0.02 && heading <= 0.3, "{position} m, {heading} deg");
    let record = &run.methods[0];
    let accepted = record.outcomes.iter().filter(|outcome| outcome.value.accepted()).count();
    assert!(accepted > 300 && accepted as f64 > 0.95 * record.outcomes.len() as f64);
    // The first scan corrects the rough start, and is drawn.
    let moments: Vec<_> = record.lines.iter().collect();
    assert_eq!((moments.len(), moments[0].stamp), (6, 0.0));
    assert!(moments.iter().all(|moment| moment.value.tracking == Tracking::Sure));
    let figures = figures::all(&run, "lines");
    let lines = figures.iter().find(|figure| figure.file == "lines.svg").unwrap();
    assert!(lines.svg.contains("predicted pose") && lines.svg.contains("0.0 s: "));
}

/// 50 seeds of the whole tour: position, heading, and consistent covariances.
#[test]
#[ignore = "minutes; run with --release"]
fn over_50_seeds_the_covariance_is_consistent() {
    let scenario = scenario(&[]);
    let mut tests = Consistency::new(0.95).unwrap();
    let (mut squares, mut worst) = ([0.0; 2], 0.0_f64);
    for seed in 1..=50 {
        let run = scenario.run(Some(seed), Some(&[Method::LineEkf]), &mut |_| {}).unwrap();
        tests.push(&run, &run.methods[0]).unwrap();
        let (position, heading) = errors(&run);
        squares = [squares[0] + position * position, squares[1] + heading * heading];
        worst = worst.max(position);
    }
    let [position, heading] = squares.map(|sum| (sum / 50.0).sqrt());
    let figures = tests.figures();
    let (nees, share) = (figures.nees_mean.unwrap(), figures.nees_share_in_band.unwrap());
    println!("RMSE {position:.4} m, {heading:.3} deg; NEES {nees:.2}, in the band at {share:.3}");
    assert!(position <= 0.02 && worst <= 0.02 && heading <= 0.3);
    // The mean of 50 runs lies in the band of a single step.
    assert!(chi_square_band(3, 50, 0.95).unwrap().contains(&nees), "{nees}");
    assert!(share >= 0.85, "{share}");
}

/// A grid without a drawing: its lines are found, and serve as well as the drawing.
#[test]
fn lines_come_from_a_file_or_from_the_grid() {
    let (text, grid) = (corrected(), Arc::new(hall()));
    let run = |lines: Option<LineMap>| {
        let options = ReplayOptions {
            map: Some(grid.clone()),
            lines: lines.map(Arc::new),
            start_sigmas: [0.2, 0.2, 0.1],
            ..Default::default()
        };
        let mut source = open(&text, &options).unwrap();
        let settings = MethodSettings::default();
        runner::run(&mut source, &[Method::LineEkf], &settings, &mut |_| {}).unwrap()
    };
    let (drawn, _) = errors(&run(Some(LineMap::outline(&grid).unwrap())));
    let (found, _) = errors(&run(None));
    assert!(drawn < 0.02 && found < 0.08, "{drawn} m, {found} m");
    assert_eq!(drive().len(), run(None).methods[0].estimates.len());
}

#[test]
fn without_walls_the_error_names_the_need() {
    let settings = MethodSettings::default();
    let source = open(&corrected(), &ReplayOptions::default());
    let error = runner::run(&mut source.unwrap(), &[Method::LineEkf], &settings, &mut |_| {});
    assert!(matches!(&error, Err(Error::Unsuitable { expected: "a map", .. })), "{error:?}");
    for (change, message) in [
        ("filter.line_matching.map_sigma=-1.0", "LineMatchingSettings.map_sigma"),
        ("filter.line_matching.pairing=\"by-luck\"", "unknown variant `by-luck`"),
        ("filter.line_matching.extractor.roughness=nan", "LineExtractor.roughness"),
    ] {
        let error = Scenario::named("line-matching", &[change.into()]).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let rule = "filter.line_matching.pairing={rule=\"joint-compatibility\"}";
    let pairing = scenario(&[rule]).settings().unwrap().line_matching.pairing;
    assert!(matches!(pairing, LinePairing::Rule(_)));
}

/// Intel, the odd scans in the map of the even ones, lines found in that map.
#[test]
fn on_intel_it_is_within_8_cm() {
    let Some(data) = std::env::var_os("LOC_DATA_DIR").map(PathBuf::from) else {
        println!("LOC_DATA_DIR is not set: the Intel recording is not replayed");
        return;
    };
    let log = CarmenLog::open(data.join("carmen/intel.log")).unwrap().laser_log().unwrap();
    let options = ReplayOptions {
        map: Some(Arc::new(io::load(data.join("carmen/intel_even.yaml")).unwrap())),
        scans: Scans::Odd,
        start_sigmas: [0.2, 0.2, 5_f64.to_radians()],
        ..Default::default()
    };
    let mut source = LaserRecording::new(log, &options).unwrap();
    let settings = MethodSettings::default();
    let run = runner::run(&mut source, &[Method::LineEkf], &settings, &mut |_| {}).unwrap();
    let (position, heading) = errors(&run);
    println!("Intel: RMSE {position:.3} m, {heading:.2} deg");
    assert!(position <= 0.08, "{position} m");
    assert!(heading <= 1.5, "{heading} deg");
}
