//! Whole scenarios against the lectures' numbers; every ID of the lectures has a scenario and a
//! figure.

use approx::assert_relative_eq;
use loc_core::kinematics::Kurt2Pose;
use loc_filters::localizer::Estimate;
use loc_sim::localizer::Method;
use loc_sim::output::figures::NAMES;
use loc_sim::record::Run;
use loc_sim::scenario::{Scenario, builtin};
use nalgebra::Matrix3;
use std::collections::BTreeSet;

fn run(name: &str, changes: &[&str]) -> Run {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    Scenario::named(name, &changes).unwrap().run(None, None, &mut |_| {}).unwrap()
}

fn last(run: &Run, method: Method) -> Estimate {
    let record = run.methods.iter().find(|record| record.method == method).unwrap();
    *record.estimates.last().unwrap()
}

/// E5 by each rule of integration, and the exact arc as truth.
#[test]
fn kurt2_example_ends_at_the_corrected_numbers() {
    for (rule, x, z) in [("midpoint", 30.64, 151.15), ("exact-arc", 30.589, 150.900)] {
        let run = run("kurt2-example", &[&format!("filter.robot.integration={rule}")]);
        let pose = Kurt2Pose::from(last(&run, Method::DeadReckoning).pose);
        assert_relative_eq!(100.0 * pose.x, x, epsilon = 5e-3);
        assert_relative_eq!(100.0 * pose.z, z, epsilon = 5e-3);
        assert_relative_eq!(pose.theta, 0.4, epsilon = 1e-12);
        let truth = Kurt2Pose::from(run.truth.last().unwrap().value.pose);
        assert_relative_eq!(100.0 * truth.x, 30.589, epsilon = 5e-4);
    }
    let at_once = run("kurt2-example", &["drive.time_step=2.0"]);
    let pose = Kurt2Pose::from(last(&at_once, Method::DeadReckoning).pose);
    assert_relative_eq!(100.0 * pose.x, 30.79, epsilon = 5e-3);
    assert_relative_eq!(100.0 * pose.z, 151.91, epsilon = 5e-3);
}

/// E8: with perfect measurements the estimate is the one of the nominal controls.
#[test]
fn circle_drive_has_the_printed_mean_and_covariance() {
    let noise =
        "filter.robot.odometry={distance_sigma=0.02,turn_sigma='5 deg',drift_sigma='2 deg'}";
    let perfect = "drive.wheels={track=0.4}";
    let printed = [
        (
            "euler",
            -0.9665475,
            0.2267017,
            [0.19720637, -0.05694569, 0.05620789, 0.10291737, -0.02541687, 0.02416632],
        ),
        (
            "midpoint",
            -0.9710832,
            0.2064101,
            [0.19952121, -0.05490338, 0.05671004, 0.10062718, -0.02431798, 0.02416632],
        ),
    ];
    for (rule, x, y, [xx, xy, xt, yy, yt, tt]) in printed {
        let rule = format!("filter.robot.integration={rule}");
        let estimate = last(&run("circle-drive", &[noise, perfect, &rule]), Method::DeadReckoning);
        assert_relative_eq!(estimate.pose.x, x, epsilon = 5e-8);
        assert_relative_eq!(estimate.pose.y, y, epsilon = 5e-8);
        assert_relative_eq!(estimate.pose.theta, 5.8643063 - std::f64::consts::TAU, epsilon = 5e-8);
        let expected = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
        assert_relative_eq!(estimate.covariance.unwrap(), expected, epsilon = 5e-9);
    }
    let exact = run("circle-drive", &[noise, perfect, "filter.robot.integration=exact-arc"]);
    let pose = last(&exact, Method::DeadReckoning).pose;
    assert_relative_eq!(pose.x, -0.9710122, epsilon = 5e-8);
    assert_relative_eq!(pose.y, 0.2063950, epsilon = 5e-8);
    let truth = exact.truth.last().unwrap().value.pose;
    assert_relative_eq!(pose.distance(truth), 0.0, epsilon = 1e-9);
}

/// G3.
#[test]
fn two_sensors_give_the_exact_mean_and_variance() {
    let run = run("two-sensors", &[]);
    let belief = last(&run, Method::Kf).rail.unwrap();
    assert_relative_eq!(belief.mean.x, 9.5445545, epsilon = 5e-8);
    assert_relative_eq!(belief.covariance.m11, 0.1980198, epsilon = 5e-8);
    let prediction = last(&run, Method::DeadReckoning).rail.unwrap();
    assert_relative_eq!(prediction.covariance.m11, 20.0, epsilon = 1e-12);
}

/// G4: 51 predictions and one correction.
#[test]
fn accelerated_vehicle_ends_at_the_printed_numbers() {
    let run = run("accelerated-vehicle", &[]);
    let predicted = last(&run, Method::DeadReckoning).rail.unwrap();
    assert_relative_eq!(predicted.mean.x, 12.75, epsilon = 1e-12);
    assert_relative_eq!(predicted.mean.y, 5.1, epsilon = 1e-12);
    assert_relative_eq!(predicted.covariance.m11, 1.9469, epsilon = 5e-5);
    assert_relative_eq!(predicted.covariance.m12, 0.2550, epsilon = 5e-5);
    assert_relative_eq!(predicted.covariance.m22, 0.0916, epsilon = 5e-5);
    let corrected = last(&run, Method::Kf).rail.unwrap();
    assert_relative_eq!(corrected.mean.x, 11.8992, epsilon = 5e-5);
    assert_relative_eq!(corrected.mean.y, 4.9886, epsilon = 5e-5);
    assert_relative_eq!(corrected.covariance.m11, 0.2215508, epsilon = 5e-8);
    assert_relative_eq!(corrected.covariance.m12, 0.0290182, epsilon = 5e-8);
    assert_relative_eq!(corrected.covariance.m22, 0.0620015, epsilon = 5e-8);
}

#[test]
fn one_seed_gives_one_result_and_methods_do_not_disturb_each_other() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let run =
        |seed, methods: &[Method]| scenario.run(Some(seed), Some(methods), &mut |_| {}).unwrap();
    let both = run(5, &[Method::DeadReckoning, Method::Ekf]);
    let alone = run(5, &[Method::Ekf]);
    assert_eq!(both.methods[1].estimates, alone.methods[0].estimates);
    assert_ne!(both.methods[1].estimates, run(6, &[Method::Ekf]).methods[0].estimates);
}

/// A camera with a latency delivers late; the filter ends as without latency.
#[test]
fn latency_delays_but_does_not_lose() {
    let late = run("landmark-drive", &["drive.camera.latency=0.35"]);
    let punctual = run("landmark-drive", &[]);
    let count = |run: &Run| run.methods[1].outcomes.len();
    // Only observations of the last 0.35 s may still be pending at the last truth.
    assert!(count(&late) == count(&punctual) && count(&punctual) > 50);
    let error = |run: &Run| {
        let estimates = run.methods[1].estimates.iter().zip(&run.truth);
        estimates.map(|(e, t)| e.pose.distance(t.value.pose)).fold(0.0, f64::max)
    };
    assert!(error(&late) < 0.25 && error(&late) >= error(&punctual));
}

#[test]
fn every_built_in_scenario_is_named_after_its_file_and_runs() {
    for (name, text) in builtin::ALL {
        let scenario = Scenario::parse(name, text, &[]).unwrap();
        assert_eq!(scenario.name, name);
        // Long ones have tests of their own.
        let short = match (&scenario.tour, &scenario.probability_map) {
            (Some(_), _) => vec!["tour.duration=1.0".to_owned()],
            (_, Some(_)) => vec!["probability_map.step=0.5".to_owned()],
            _ => Vec::new(),
        };
        let kidnapped = scenario.tour.as_ref().is_some_and(|tour| tour.kidnap.is_some());
        let kidnap = kidnapped.then(|| "tour.kidnap.at=0.5".to_owned());
        let changes: Vec<String> = short.into_iter().chain(kidnap).collect();
        let scenario = Scenario::parse(name, text, &changes).unwrap();
        if scenario.illustrate(scenario.seed).unwrap().is_some() {
            continue;
        }
        let run = scenario.run(None, None, &mut |_| {}).unwrap();
        assert!(run.methods.iter().all(|record| record.estimates.len() == run.truth.len()));
    }
}

#[test]
fn bad_configurations_name_file_line_and_key() {
    let text = builtin::text("circle-drive").unwrap();
    let broken = |from: &str, to: &str| {
        let text = text.replace(from, to);
        Scenario::parse("my.toml", &text, &[]).unwrap_err().to_string()
    };
    for (from, to, message) in [
        (
            "time_step = 0.1",
            "time_step = -0.1",
            "my.toml: drive.time_step: expected a finite number > 0, got -0.1",
        ),
        (
            "duration = 14.0",
            "duration = 14.03",
            "my.toml: drive.course.duration: expected a multiple of the time step 0.1 s, got `14.03`",
        ),
        ("time_step", "timestep", "my.toml: line 10: `timestep = 0.1`: unknown field `timestep`"),
        (
            "seed = 1",
            "seed = \"one\"",
            "my.toml: line 6: `seed = \"one\"`: invalid type: string \"one\", expected u64",
        ),
        (
            "\"dead-reckoning\"",
            "\"gps\"",
            "my.toml: method: expected one of dead-reckoning, lateration, kf, ekf, ukf, line-ekf, line-ukf, fusion, fusion-ukf, histogram, mcl, kf-slam, ekf-slam, fastslam, got `gps`",
        ),
        ("\"midpoint\"", "\"simpson\"", "unknown variant `simpson`"),
        (
            "turn_sigma = \"5 deg\"",
            "turn_sigma = nan",
            "my.toml: turn_sigma of the odometry [rad per turn]: expected a finite number >= 0, got NaN",
        ),
        (
            "name = \"circle-drive\"",
            "name = \"../x\"",
            "my.toml: name: expected a name of letters, digits, `-` and `_`, got `../x`",
        ),
    ] {
        let error = broken(from, to);
        assert!(error.contains(message), "{error}");
    }
    for (change, message) in [
        ("drive.nothing=1", "unknown field `nothing`"),
        ("drive", "expected key.subkey=value, got `drive`"),
        ("drive.course.7.v=1", "expected the key of a table or array, got `7`"),
    ] {
        let error = Scenario::named("circle-drive", &[change.into()]).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

/// Numbers of the last ID of each letter; L has none.
const LAST: [(char, usize); 11] = [
    ('A', 3),
    ('B', 11),
    ('C', 6),
    ('D', 4),
    ('E', 8),
    ('F', 5),
    ('G', 5),
    ('H', 4),
    ('I', 4),
    ('K', 3),
    ('M', 12),
];

#[test]
fn no_id_is_missing() {
    let mut expected: Vec<String> = LAST
        .iter()
        .flat_map(|(letter, last)| (1..=*last).map(move |k| format!("{letter}{k}")))
        .collect();
    expected.push("L".into());
    let expected: BTreeSet<String> = expected.into_iter().collect();
    let found: BTreeSet<String> = builtin::IDS.iter().map(|shown| shown.id.to_owned()).collect();
    assert_eq!(found, expected);
    assert_eq!(builtin::IDS.len(), expected.len());
}

/// The scenario lists the ID and writes the figure.
#[test]
fn scenarios_show_what_is_said_of_them() {
    for shown in builtin::IDS {
        let scenario = Scenario::named(shown.scenario, &[]).unwrap();
        assert!(scenario.ids.iter().any(|id| id == shown.id), "{shown:?}: {:?}", scenario.ids);
        match scenario.illustrate(scenario.seed).unwrap() {
            Some(illustration) => {
                let mut files = illustration.figures.iter().map(|figure| &figure.file);
                assert!(files.any(|file| file == shown.figure), "{shown:?}");
                assert!(!illustration.lines.is_empty(), "{shown:?}");
            }
            None => assert!(NAMES.contains(&shown.figure), "{shown:?}"),
        }
    }
}

/// Every ID that a scenario lists is in the table.
#[test]
fn scenarios_claim_known_ids() {
    for (name, _) in builtin::ALL {
        for id in Scenario::named(name, &[]).unwrap().ids {
            assert!(builtin::IDS.iter().any(|shown| shown.id == id), "{name}: {id}");
        }
    }
}

#[test]
fn the_table_of_the_guide_is_this_one() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/ids.md");
    let text = std::fs::read_to_string(file).unwrap();
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    let expected = builtin::IDS.map(|builtin::Shown { id, what, scenario, figure }| {
        format!("| {id} | {what} | `{scenario}` | `{figure}` |")
    });
    assert_eq!(rows, expected);
}
