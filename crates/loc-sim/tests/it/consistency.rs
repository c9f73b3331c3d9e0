//! Whether reported covariances are honest, over many seeds.

use loc_core::stats;
use loc_sim::localizer::Method;
use loc_sim::metrics::pose_nees;
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
