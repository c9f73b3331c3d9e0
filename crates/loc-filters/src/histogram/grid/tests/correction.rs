//! Predictions and corrections of the whole belief.

use super::*;
use crate::histogram::grid::belief::Belief;
use crate::histogram::grid::correct::{Levels, LogSum};
use approx::assert_relative_eq;
use loc_core::gaussian::pose_belief;
use loc_core::motion::DrivenPath;

fn total(belief: &Belief) -> f64 {
    belief.stack.total() + belief.in_window() + belief.anywhere
}

fn path(to: Pose2) -> DrivenPath {
    let mut path = DrivenPath::starting_at(Pose2::IDENTITY);
    path.extend(to);
    path
}

/// The probability of a coarse cell, wherever it is kept.
fn probabilities(belief: &Belief, space: &PoseSpace) -> Vec<f64> {
    let size = space.size();
    let mut all: Vec<f64> = (0..size.count())
        .map(|k| {
            let (layer, place) = (k / size.layer(), k % size.layer());
            belief.stack.get(layer, place) + belief.anywhere * space.share(place)
        })
        .collect();
    if let Some(window) = &belief.window {
        for (layer, place, mass) in window.stack().cells() {
            let (layer, place) = space.cell_of(window.pose(layer, place)).unwrap();
            all[layer * size.layer() + place] += mass;
        }
    }
    all
}

/// Half the sum of all differences.
fn variation(a: &[f64], b: &[f64]) -> f64 {
    0.5 * a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>()
}

/// Passing over cells changes the belief by no more than it says.
#[test]
fn what_is_passed_over_is_negligible() {
    let map = room();
    let setting = Setting::new(&map, settings());
    let Setting { space, sensor, .. } = &setting;
    let mut rng = rng("negligible");
    for negligible in [1e-2, 1e-4, 1e-6] {
        let scan = setting.scan(&super::scan(&map, place(&map, &mut rng), &mut rng));
        let (mut all, mut some) = (Belief::anywhere(space), Belief::anywhere(space));
        let exact = all.correct(&scan, sensor, space, 0.0);
        let quick = some.correct(&scan, sensor, space, negligible);
        assert_eq!((exact.cells.len(), exact.passed_over), (space.room(), 0.0));
        assert!(quick.cells.len() < space.room() / 2, "{} rated", quick.cells.len());
        assert!(quick.passed_over <= negligible, "{}", quick.passed_over);
        let off = variation(&probabilities(&all, space), &probabilities(&some, space));
        println!("{negligible}: off by {off:e}, {} of {}", quick.cells.len(), space.room());
        // Passed over, and rated but too small to be kept.
        assert!(off <= 2.0 * negligible, "{off}");
        let share = (quick.log_evidence - exact.log_evidence).exp();
        assert!((1.0 - negligible..=1.0 + 1e-9).contains(&share), "{share}");
    }
}

/// Bayes' rule, cell by cell.
#[test]
fn corrections_multiply_prior_and_likelihood() {
    let map = room();
    let setting = Setting::new(&map, settings());
    let Setting { space, sensor, settings } = &setting;
    let mut rng = rng("bayes");
    let truth = place(&map, &mut rng);
    let mut belief = Belief::anywhere(space);
    // Spread too wide for the fine grid.
    let start = pose_belief(truth, [0.5, 0.4, 0.6]);
    belief.start_near(&start, space, settings).unwrap();
    belief.anywhere = 0.0;
    let before = probabilities(&belief, space);
    let scan = setting.scan(&super::scan(&map, truth, &mut rng));
    let log_evidence = belief.correct(&scan, sensor, space, 0.0).log_evidence;
    let size = space.size();
    let mut joint = vec![0.0; size.count()];
    for layer in 0..size.headings {
        let ends = scan.within_layer(space.heading_in_grid(layer));
        for at in (0..size.layer()).filter(|at| space.has_room(*at)) {
            let likelihood = sensor.rate_square(space, &scan, at, &ends).exp();
            joint[layer * size.layer() + at] = likelihood * before[layer * size.layer() + at];
        }
    }
    let evidence: f64 = joint.iter().sum();
    assert_relative_eq!(log_evidence, evidence.ln(), epsilon = 1e-9);
    joint.iter_mut().for_each(|p| *p /= evidence);
    assert!(variation(&probabilities(&belief, space), &joint) < 1e-12);
}

#[test]
fn nothing_is_lost_on_the_way() {
    let map = room();
    let setting = Setting::new(&map, settings());
    let Setting { space, sensor, settings } = &setting;
    for seed in 0..4 {
        let mut rng = loc_core::random::stream(seed, "way");
        let truth = place(&map, &mut rng);
        let mut belief = Belief::anywhere(space);
        for step in 0..4 {
            let by = Pose2::new(rng.random_range(-0.5..0.5), 0.02, rng.random_range(-0.5..0.5));
            belief.predict(&path(by), space, settings).unwrap();
            assert_relative_eq!(total(&belief), 1.0, epsilon = 1e-9);
            for (_, place, _) in belief.stack.cells() {
                assert!(space.has_room(place));
            }
            let scan = setting.scan(&super::scan(&map, truth, &mut rng));
            let correction = belief.correct(&scan, sensor, space, settings.negligible);
            let before = probabilities(&belief, space);
            belief.focus(&correction, &scan, sensor, space, settings).unwrap();
            assert_relative_eq!(total(&belief), 1.0, epsilon = 1e-9);
            if step == 0 {
                // The fine grid is filled without changing the belief.
                let off = variation(&probabilities(&belief, space), &before);
                assert!(off < 1e-3, "seed {seed}: {off}");
            }
        }
    }
}

/// Fine and coarse grid are one belief: closing the fine one gives back what it took.
#[test]
fn a_closed_window_leaves_its_probability() {
    let map = room();
    let Setting { space, settings, .. } = Setting::new(&map, settings());
    let mut belief = Belief::anywhere(&space);
    let start = pose_belief(place(&map, &mut rng("close")), [0.1, 0.1, 0.05]);
    belief.start_near(&start, &space, &settings).unwrap();
    assert_relative_eq!(belief.in_window(), 1.0, epsilon = 1e-9);
    let before = probabilities(&belief, &space);
    belief.close_window(&space);
    assert!(belief.window.is_none());
    assert!(variation(&probabilities(&belief, &space), &before) < 1e-12);
    assert_relative_eq!(belief.stack.total(), 1.0, epsilon = 1e-9);
}

#[test]
fn a_way_beyond_the_map_leaves_no_idea() {
    let map = room();
    let Setting { space, settings, .. } = Setting::new(&map, settings());
    let mut belief = Belief::anywhere(&space);
    belief
        .start_near(&pose_belief(place(&map, &mut rng("far")), [0.1; 3]), &space, &settings)
        .unwrap();
    belief.predict(&path(Pose2::new(100.0, 0.0, 0.0)), &space, &settings).unwrap();
    assert_eq!((belief.anywhere, belief.in_window()), (1.0, 0.0));
}

#[test]
fn logarithms_add_up() {
    let mut sum = LogSum::new();
    assert_eq!(sum.log(), f64::NEG_INFINITY);
    for log in [f64::NEG_INFINITY, -800.0, -801.0, -799.5] {
        sum.add(log);
    }
    let expected = -800.0 + (1.0_f64 + (-1.0_f64).exp() + 0.5_f64.exp()).ln();
    assert_relative_eq!(sum.log(), expected, epsilon = 1e-12);
}

/// Against sorting: no more is passed over than is allowed, and what is needed is not much more
/// than by the best order.
#[test]
fn levels_pass_over_as_much_as_they_may() {
    let mut rng = rng("levels");
    let keys: Vec<f32> = (0..5000).map(|_| rng.random_range(-40.0..3.0)).collect();
    let share = |key: f32| (f64::from(key) - 5.0).exp();
    for negligible in [1e-2, 1e-4] {
        let levels = Levels::of(&keys, 5.0, negligible);
        let (needed, passed_over) = levels.needed(negligible);
        let mut left: Vec<f32> =
            keys.iter().copied().filter(|key| !levels.is_in(*key, needed)).collect();
        let sum: f64 = left.iter().map(|key| share(*key)).sum();
        assert!(sum <= passed_over && passed_over <= negligible, "{sum} {passed_over}");
        // One more level would be too much.
        left.sort_by(f32::total_cmp);
        let next: f64 = keys
            .iter()
            .filter(|key| **key <= left[left.len() - 1] + 0.75)
            .map(|key| share(*key))
            .sum();
        assert!(1.3 * next > negligible, "{next}");
    }
    let levels = Levels::of(&keys, 5.0, 1e-4);
    for most in [1, 10, 1000, 10_000] {
        let level = levels.of_about(most);
        let count = keys.iter().filter(|key| levels.is_in(**key, level)).count();
        assert!(count > 0 && count <= most.max(40), "{count} of {most}");
    }
    let nothing = Levels::of(&[f32::NEG_INFINITY; 3], 0.0, 1e-4);
    assert_eq!(nothing.needed(1e-4).1, 0.0);
    assert!(!nothing.is_in(f32::NEG_INFINITY, 0));
}
