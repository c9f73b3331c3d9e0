//! Scenarios of the particle filter: what it finds, and what is drawn of it.

use loc_core::Pose2;
use loc_maps::LikelihoodField;
use loc_maps::grid::Occupancy;
use loc_sim::localizer::{Cloud, Method};
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::output;
use loc_sim::probability_map::ProbabilityMap;
use loc_sim::record::{Run, Snapshots};
use loc_sim::scenario::Scenario;
use roxmltree::Document;

fn run(name: &str, changes: &[&str]) -> Run {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    Scenario::named(name, &changes).unwrap().run(None, None, &mut |_| {}).unwrap()
}

/// Distances of a method's estimates from the truth, with their stamps.
fn errors(run: &Run, method: Method) -> Vec<(f64, f64)> {
    let record = run.methods.iter().find(|record| record.method == method).unwrap();
    let pairs = record.estimates.iter().zip(&run.truth);
    pairs.map(|(e, t)| (t.stamp, e.pose.distance(t.value.pose))).collect()
}

fn rmse(errors: &[(f64, f64)]) -> f64 {
    (errors.iter().map(|(_, e)| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

fn figures(run: &Run) -> output::Folder {
    let summary = Summary::of(run, Some(1), Alignment::None).unwrap();
    let folder = output::files(run, &summary, "A title", "loc-sim").unwrap();
    for name in folder.names().filter(|name| name.ends_with(".svg")) {
        assert!(Document::parse(folder.text(name).unwrap()).is_ok(), "{name}");
    }
    folder
}

/// A1.
#[test]
fn position_tracking_follows_where_odometry_drifts_away() {
    let run = run("position-tracking", &["tour.duration_s=60.0"]);
    let (mcl, odometry) = (errors(&run, Method::Mcl), errors(&run, Method::DeadReckoning));
    assert!(rmse(&mcl) < 0.1, "{}", rmse(&mcl));
    assert!(rmse(&odometry) > 1.0, "{}", rmse(&odometry));
    let folder = figures(&run);
    assert!(folder.text("map.svg").unwrap().contains("<image"));
    assert!(folder.text("errors.svg").unwrap().contains("spread of the position"));
}

/// A2, M3: the cloud begins everywhere and ends at the truth.
#[test]
fn global_localization_ends_at_the_truth() {
    let run = run("global-localization", &["tour.duration_s=25.0"]);
    let errors = errors(&run, Method::Mcl);
    let (first, last) = (errors[0].1, errors[errors.len() - 1].1);
    assert!(first > 1.0 && last < 0.2, "{first} {last}");
    let spread = |cloud: &Cloud| {
        let of = |k: fn(&Pose2) -> f64| {
            let values = || cloud.particles.iter().map(|(pose, _)| k(pose));
            values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
        };
        f64::hypot(of(|pose| pose.x), of(|pose| pose.y))
    };
    let clouds: Vec<_> = run.methods[0].snapshots.iter().collect();
    assert!(clouds.len() <= Snapshots::MAX && clouds[0].stamp == 0.0);
    assert!(clouds.iter().all(|cloud| cloud.value.particles.len() <= Cloud::MAX));
    assert!(spread(&clouds[0].value) > 20.0);
    let end = spread(&clouds[clouds.len() - 1].value);
    assert!(end < 3.0, "{end}");
    // Twelve frames, of one image.
    let folder = figures(&run);
    let svg = folder.text("clouds.svg").unwrap();
    assert_eq!((svg.matches("<use").count(), svg.matches("<image").count()), (12, 1));
    let summary = Summary::of(&run, Some(1), Alignment::None).unwrap();
    assert!(summary.methods[0].1.converged_at_s.is_some());
}

/// A3: found again after it was carried off; the way that it is carried is none that it drives.
#[test]
fn a_kidnapping_is_seen_in_errors_and_figures() {
    let run = run("kidnapped-robot", &["tour.kidnap.at_s=10.0", "tour.duration_s=20.0"]);
    let errors = errors(&run, Method::Mcl);
    let before = errors.iter().filter(|(stamp, _)| *stamp < 9.95);
    assert!(before.clone().all(|(_, error)| *error < 0.6), "{before:?}");
    assert!(errors[errors.len() - 1].1 < 0.3, "{:?}", errors[errors.len() - 1]);
    let odometry = self::errors(&run, Method::DeadReckoning);
    assert!(odometry[100].1 - odometry[99].1 > 2.0);
    assert!(run.distance().unwrap() < 20.0 * 0.7);
    let folder = figures(&run);
    let texts = |name: &str| folder.text(name).unwrap().to_owned();
    assert!(texts("errors.svg").contains(">kidnapped<"));
    assert!(texts("map.svg").contains(">put down<"));
    assert!(texts("clouds.svg").contains(", kidnapped<"));
}

#[test]
fn the_seed_of_a_run_reaches_the_particles() {
    let short = ["tour.duration_s=5.0"].map(str::to_owned);
    let scenario = Scenario::named("position-tracking", &short).unwrap();
    let run = |seed| scenario.run(Some(seed), Some(&[Method::Mcl]), &mut |_| {}).unwrap();
    let (first, again, other) = (run(4), run(4), run(5));
    assert_eq!(first.methods[0].estimates, again.methods[0].estimates);
    assert_eq!(first.methods[0].snapshots, again.methods[0].snapshots);
    assert_ne!(first.methods[0].estimates, other.methods[0].estimates);
    assert_eq!(other.settings.seed, 5);
}

/// M12: the highest likelihood is where the scan was taken, and the sums are those of its beams.
#[test]
fn the_probability_map_is_highest_at_the_truth() {
    let changes = ["step_m=0.2", "headings=36"].map(|c| format!("probability_map.{c}"));
    let config = Scenario::named("probability-map", &changes).unwrap().probability_map.unwrap();
    let map = ProbabilityMap::new(&config, 1).unwrap();
    let turned = loc_core::angle::difference(map.best.theta, map.truth.theta);
    assert!(map.best.distance(map.truth) < 0.25 && turned.abs() < 0.1, "{:?}", map.best);
    let field = LikelihoodField::new(&map.map, &config.field).unwrap();
    let ends: Vec<_> =
        map.scan.thinned(60).iter().map(|b| map.mounting.transform(&b.point())).collect();
    let mut looked_at = 0;
    for (index, cell) in map.frame.cells().enumerate().step_by(97) {
        let place = map.frame.center(cell);
        let free = map.map.occupancy_at(&place) == Occupancy::Free;
        assert_eq!(map.true_heading[index].is_finite(), free);
        if !free {
            continue;
        }
        let pose = Pose2::new(place.x, place.y, map.truth.theta);
        let one_by_one: f64 =
            ends.iter().map(|end| field.log_likelihood_at(&pose.transform(end))).sum();
        // A beam's end that lies on the edge of a cell may count for either.
        assert!((map.true_heading[index] - one_by_one).abs() < 0.3);
        assert!(map.any_heading[index] >= map.true_heading[index]);
        looked_at += 1;
    }
    assert!(looked_at > 30, "{looked_at}");
}

#[test]
fn a_scenario_without_a_robot_that_moves_is_an_illustration() {
    let scenario = Scenario::named("probability-map", &["probability_map.step_m=0.5".into()]);
    let scenario = scenario.unwrap();
    let illustration = scenario.illustrate(1).unwrap().unwrap();
    let folder = illustration.files(&scenario.title, "loc-sim run probability-map").unwrap();
    let names: Vec<&str> = folder.names().collect();
    assert_eq!(names, ["summary.json", "report.html", "probability.svg"]);
    assert!(Document::parse(folder.text("probability.svg").unwrap()).is_ok());
    assert!(folder.text("report.html").unwrap().contains("most likely pose"));
    assert!(scenario.run(None, Some(&[Method::Mcl]), &mut |_| {}).is_err());
    let drive = Scenario::named("landmark-drive", &[]).unwrap();
    assert!(drive.illustrate(1).unwrap().is_none());
    for (change, message) in [
        ("probability_map.pose.x_m=500.0", "probability_map.pose: expected a place in free space"),
        ("probability_map.headings=0", "probability_map.headings: expected 1 to 3600"),
        ("probability_map.beams=0", "probability_map.beams: expected at least 1"),
    ] {
        let scenario = Scenario::named("probability-map", &[change.into()]);
        let error = scenario.and_then(|scenario| scenario.illustrate(1)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
