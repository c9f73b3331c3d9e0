//! Whether reported covariances are honest, over many seeds.

use loc_core::stats;
use loc_sim::localizer::Method;
use loc_sim::metrics::{Consistency, pose_nees};
use loc_sim::runner;
use loc_sim::scenario::Scenario;

const SEEDS: u64 = 200;

/// Share of time steps at which the mean NEES over all seeds lies in its 95 % band.
fn share_in_band(scenario: &str, method: Method, changes: &[String]) -> f64 {
    let scenario = Scenario::named(scenario, changes).unwrap();
    let mut sums: Vec<f64> = Vec::new();
    for seed in 1..=SEEDS {
        let run = scenario.run(Some(seed), Some(&[method]), &mut |_| {}).unwrap();
        sums.resize(run.truth.len(), 0.0);
        for ((sum, estimate), truth) in
            sums.iter_mut().zip(&run.methods[0].estimates).zip(&run.truth)
        {
            *sum += pose_nees(estimate, truth.value.pose).unwrap();
        }
    }
    let band = stats::chi_square_band(3, SEEDS as usize, 0.95).unwrap();
    let inside = sums.iter().filter(|sum| band.contains(&(**sum / SEEDS as f64))).count();
    inside as f64 / sums.len() as f64
}

#[test]
fn landmark_drive_is_consistent() {
    let share = share_in_band("landmark-drive", Method::Ekf, &[]);
    println!("EKF: mean NEES in the band at {:.1} % of the steps", 100.0 * share);
    assert!(share >= 0.9, "{share}");
}

/// The same test must notice a filter that believes its sensors to be twice as good.
#[test]
fn an_optimistic_filter_is_noticed() {
    let boast = "filter.camera={range_sigma_m=0.05,bearing_sigma_deg=1.0}".to_owned();
    assert!(share_in_band("landmark-drive", Method::Ekf, &[boast]) < 0.1);
}

fn consistency(scenario: &Scenario, method: Method, seeds: u64) -> Consistency {
    let mut consistency = Consistency::new(0.95).unwrap();
    for seed in 1..=seeds {
        let run = scenario.run(Some(seed), Some(&[method]), &mut |_| {}).unwrap();
        consistency.push(&run, &run.methods[0]).unwrap();
    }
    consistency
}

/// The library call gives what the loops above count themselves.
#[test]
fn the_library_call_counts_the_same_steps() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let tests = consistency(&scenario, Method::Ekf, SEEDS);
    let figures = tests.figures();
    let share = share_in_band("landmark-drive", Method::Ekf, &[]);
    assert!((figures.nees_share_in_band.unwrap() - share).abs() < 1e-12);
    assert_eq!((figures.runs, tests.nees().steps().len()), (SEEDS, 421));
    assert!((figures.nees_mean.unwrap() - 3.0 * figures.nees_per_degree.unwrap()).abs() < 1e-9);
    // An EKF is honest only as far as its lines follow the curves; here they do, to two percent.
    assert!((figures.nis_per_degree.unwrap() - 1.0).abs() < 0.02, "{figures:?}");
    assert!((figures.nis_share_inside.unwrap() - 0.95).abs() < 0.01);
    assert!(figures.white_share.unwrap() >= 0.8, "{figures:?}");
}

/// A vehicle whose every error is as the Kalman filter believes.
const RAIL: &str = r#"
name = "honest-rail"
title = "A linear system"
seed = 1
methods = ["kf"]
[rail]
time_step_s = 0.1
steps = 60
acceleration_sigma_m_s2 = 0.4
position_sigma_m = 1.0
speed_sigma_m_s = 0.1
sensors = [{ sigma_m = 0.5 }]
"#;

/// Whatever theory promises of the linear filter holds.
#[test]
fn the_linear_filter_is_consistent() {
    let scenario = Scenario::parse("rail", RAIL, &[]).unwrap();
    let figures = consistency(&scenario, Method::Kf, 300).figures();
    let holds = |interval: Option<[f64; 2]>, value: f64| {
        interval.is_some_and(|[low, high]| low <= value && value <= high)
    };
    assert!(holds(figures.nees_interval, 1.0), "{figures:?}");
    assert!(holds(figures.nis_band, figures.nis_per_degree.unwrap()), "{figures:?}");
    assert!(figures.nees_share_in_band.unwrap() >= 0.8, "{figures:?}");
    assert!(figures.white_share.unwrap() >= 0.8, "{figures:?}");
    assert_eq!(figures.measurements, 300 * 60);
}

/// A vehicle that is pushed about more than its filter was told: the errors of one step are still
/// there at the next, so the innovations are not white.
#[test]
fn unmodelled_motion_is_found_in_the_order_of_the_innovations() {
    let scenario = Scenario::parse("rail", RAIL, &["rail.acceleration_sigma_m_s2=4.0".into()]);
    let mut scenario = scenario.unwrap();
    let source = |seed| scenario.source(seed).unwrap();
    let mut sources: Vec<_> = (1..=100).map(source).collect();
    scenario.rail.as_mut().unwrap().acceleration_sigma_m_s2 = 0.4;
    let settings = scenario.settings().unwrap();
    let mut tests = Consistency::new(0.95).unwrap();
    for source in &mut sources {
        let run = runner::run(source.as_mut(), &[Method::Kf], &settings, &mut |_| {}).unwrap();
        tests.push(&run, &run.methods[0]).unwrap();
    }
    let figures = tests.figures();
    assert!(figures.white_share.unwrap() < 0.5, "{figures:?}");
    assert!(figures.autocorrelation[0].unwrap() > 3.0 * figures.whiteness_bound.unwrap());
    assert!(figures.nees_share_in_band.unwrap() < 0.5 && figures.nis_per_degree.unwrap() > 1.5);
}

/// Dead reckoning measures nothing; that is no figure of 0.
#[test]
fn what_has_no_meaning_is_null() {
    let scenario = Scenario::named("circle-drive", &[]).unwrap();
    let figures = consistency(&scenario, Method::DeadReckoning, 3).figures();
    assert_eq!((figures.measurements, figures.nis_mean, figures.nis_band), (0, None, None));
    assert_eq!((figures.whiteness_bound, figures.white_share), (None, None));
    assert!(figures.nees_mean.is_some());
    let json = serde_json::to_value(&figures).unwrap();
    assert!(json["nis_mean"].is_null() && json["autocorrelation"][0].is_null());
}
