use loc_core::{Gaussian, Pose2};
use loc_filters::slam::MapLandmark;
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::event::Payload;
use loc_sim::localizer::{EstimatedMap, Method};
use loc_sim::metrics::{Alignment, Consistency, LandmarkErrors, Summary, landmark_errors};
use loc_sim::output;
use loc_sim::scenario::Scenario;
use nalgebra::{Matrix2, Point2};
use std::sync::Arc;

fn scenario(name: &str, changes: &[&str]) -> Scenario {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    Scenario::named(name, &changes).unwrap()
}

/// The figures of the map that a method draws in a scenario, with the ATE \[m\].
fn drive(name: &str, seed: u64, method: Method) -> (LandmarkErrors, f64) {
    let run = scenario(name, &[]).run(Some(seed), Some(&[method]), &mut |_| {}).unwrap();
    let summary = Summary::of(&run, Some(seed), Alignment::None).unwrap();
    let figures = &summary.methods[0].1;
    (figures.landmarks.unwrap(), figures.errors.as_ref().unwrap().ate_rmse_m)
}

#[test]
fn numbered_landmarks_are_all_found() {
    for (name, method, count, rmse, ate) in [
        ("slam-linear", Method::KfSlam, 10, 0.05, 0.3),
        ("slam-landmarks", Method::EkfSlam, 10, 0.2, 0.6),
        ("slam-loop", Method::EkfSlam, 60, 0.25, 1.5),
    ] {
        for seed in 1..=3 {
            let (map, off) = drive(name, seed, method);
            assert_eq!((map.mapped, map.found, map.extra), (count, Some(count), Some(0)), "{name}");
            assert!(map.rmse_m.unwrap() < rmse && off < ate, "{name} {seed}: {map:?} {off}");
        }
    }
}

#[test]
fn unnumbered_landmarks_are_found_once() {
    for seed in 1..=4 {
        let (map, off) = drive("slam-unnumbered", seed, Method::EkfSlam);
        assert_eq!((map.found, map.extra), (Some(60), Some(0)), "{seed}");
        assert!(map.rmse_m.unwrap() < 0.3 && off < 1.5, "{seed}: {map:?} {off}");
    }
}

#[test]
fn particles_draw_the_map_too() {
    for (name, count, rmse, ate) in [("slam-landmarks", 10, 0.2, 0.6), ("slam-loop", 60, 0.5, 1.8)]
    {
        for seed in 1..=3 {
            let (map, off) = drive(name, seed, Method::FastSlam);
            assert!(map.found.unwrap() >= count - 1 && map.extra == Some(0), "{name} {map:?}");
            assert!(map.rmse_m.unwrap() < rmse && off < ate, "{name} {seed}: {map:?} {off}");
        }
    }
}

/// Each particle decides for itself which landmark it sees; those that were wrong die out. With
/// 200 of them the loop is closed on 12 of 20 drives.
#[test]
fn particles_close_a_loop_without_numbers() {
    let mut right = 0;
    for seed in 5..=8 {
        let (map, off) = drive("slam-unnumbered", seed, Method::FastSlam);
        right += usize::from(map.found.unwrap() >= 55 && map.extra.unwrap() <= 3 && off < 1.5);
    }
    assert!(right >= 2, "{right} of 4");
}

/// The method sees landmarks, but is told of none: without a map in its hands it does the same.
#[test]
fn slam_is_not_told_the_landmarks() {
    let scenario = scenario("slam-landmarks", &[]);
    let settings = scenario.settings().unwrap();
    let mut source = scenario.source(3).unwrap();
    let known = source.setup().clone();
    let mut hidden = known.clone();
    hidden.landmarks = Arc::new(LandmarkMap::default());
    let mut methods =
        [&known, &hidden].map(|setup| Method::EkfSlam.start(setup, &settings).unwrap());
    while let Some(event) = source.next_event().unwrap() {
        for method in &mut methods {
            match &event.payload {
                Payload::Control(control) => method.predict(event.stamp, control).unwrap(),
                Payload::Measurement(seen) => {
                    method.correct(event.stamp, seen).unwrap();
                }
                _ => {}
            }
        }
    }
    let [a, b] = methods.map(|method| (method.estimate(52.0).unwrap(), method.map().unwrap()));
    assert_eq!(a, b);
    assert_eq!(a.1.unwrap().confirmed(), 10);
}

#[test]
fn linear_slam_refuses_a_robot_that_turns() {
    let run = scenario("slam-landmarks", &[]).run(None, Some(&[Method::KfSlam]), &mut |_| {});
    let message = run.unwrap_err().to_string();
    assert!(message.contains("kf-slam") && message.contains("never turns"), "{message}");
}

/// A robot that sees things at an angle and slides along its own axes.
#[test]
fn linear_slam_works_in_any_direction() {
    let run = |heading: f64| {
        let change = format!("drive.start.heading_deg={heading}");
        let scenario = scenario("slam-linear", &[&change, "drive.camera.yaw_deg=20.0"]);
        scenario.run(Some(2), Some(&[Method::KfSlam]), &mut |_| {}).unwrap()
    };
    let run = run(37.0);
    let record = &run.methods[0];
    let off = record.estimates.last().unwrap().pose.distance(run.truth.last().unwrap().value.pose);
    assert!(off < 0.5, "{off}");
    let errors = landmark_errors(&run, record).unwrap().unwrap();
    assert!(errors.extra == Some(0) && errors.rmse_m.unwrap() < 0.1, "{errors:?}");
}

/// A map that is shifted and turned is aligned; without numbers by place, with them by number.
#[test]
fn maps_are_compared_after_a_rigid_alignment() {
    let mut run = scenario("slam-landmarks", &[]).run(None, None, &mut |_| {}).unwrap();
    let truth = [(1, 0.0, 0.0), (2, 4.0, 0.0), (3, 4.0, 3.0), (4, 0.0, 3.0)];
    let landmarks = truth.map(|(id, x, y)| Landmark::planar(id, x, y));
    run.setup.landmarks = Arc::new(LandmarkMap::new(landmarks).unwrap());
    let mut record = run.methods.pop().unwrap();
    let moved = Pose2::new(0.3, -0.2, 0.02);
    let place = |id: u32, x: f64, y: f64| {
        let mean = moved.transform(&Point2::new(x, y)).coords;
        let position = Gaussian { mean, covariance: Matrix2::identity() };
        MapLandmark { id, position, observations: 9, confirmed: true }
    };
    // Displaced by 0.1 m outwards along x on both sides: no rigid motion makes up for that.
    let mut landmarks =
        vec![place(4, -0.1, 0.0), place(3, 4.1, 0.0), place(2, 4.1, 3.0), place(1, -0.1, 3.0)];
    landmarks.push(MapLandmark { confirmed: false, ..place(7, 9.0, 9.0) });
    landmarks.push(place(8, 4.3, 3.2));
    record.map = Some(EstimatedMap { numbered: false, landmarks });
    let errors = landmark_errors(&run, &record).unwrap().unwrap();
    assert_eq!((errors.mapped, errors.found, errors.extra), (5, Some(4), Some(1)));
    assert!((errors.rmse_m.unwrap() - 0.1).abs() < 1e-9, "{errors:?}");
    // By their numbers, 1 and 4 as well as 2 and 3 have changed places: a turn is the best.
    record.map.as_mut().unwrap().numbered = true;
    let errors = landmark_errors(&run, &record).unwrap().unwrap();
    assert_eq!((errors.found, errors.extra), (Some(4), Some(1)));
    assert!(errors.rmse_m.unwrap() > 1.0);
    record.map = None;
    assert!(landmark_errors(&run, &record).unwrap().is_none());
}

#[test]
fn the_map_is_drawn_and_summed_up() {
    let run = scenario("slam-landmarks", &[]).run(None, None, &mut |_| {}).unwrap();
    let summary = Summary::of(&run, Some(1), Alignment::None).unwrap();
    let table = output::table(&summary);
    assert!(table.contains("ekf-slam found 10 landmarks, off by 0."), "{table}");
    let files = output::files(&run, &summary, "title", "command").unwrap();
    assert!(files.text("map.svg").unwrap().contains("landmark of ekf-slam, 2 sigma"));
    let json: serde_json::Value =
        serde_json::from_str(files.text("summary.json").unwrap()).unwrap();
    assert!(json["methods"]["dead-reckoning"]["landmarks"].is_null());
    assert_eq!(json["methods"]["ekf-slam"]["landmarks"]["found"], 10);
}

/// Mean NEES of some loops, which is 3 for an honest filter.
fn mean_nees(jacobians: &str, seeds: u64) -> f64 {
    let change = format!("filter.slam.jacobians={jacobians}");
    let scenario = scenario("slam-loop", &[&change]);
    let mut consistency = Consistency::new(0.95).unwrap();
    for seed in 1..=seeds {
        let run = scenario.run(Some(seed), Some(&[Method::EkfSlam]), &mut |_| {}).unwrap();
        consistency.push(&run, &run.methods[0]).unwrap();
    }
    consistency.figures().nees_mean.unwrap()
}

/// The textbook filter is too sure of itself; the two others take at least half of that away.
#[test]
#[ignore = "150 drives of 160 s, about a minute without optimisation"]
fn the_excess_of_the_nees_is_halved() {
    let [plain, first, invariant] =
        ["current", "first", "invariant"].map(|jacobians| mean_nees(jacobians, 50));
    println!("mean NEES of 50 loops: {plain:.2} plain, {first:.2} first, {invariant:.2} invariant");
    for other in [first, invariant] {
        assert!(plain > 3.5 && other - 3.0 <= 0.5 * (plain - 3.0), "{plain} {first} {invariant}");
    }
}
