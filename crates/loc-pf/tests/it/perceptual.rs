//! The perceptual model: parameters found again, and the histogram against the truth.

use crate::beam::{office, scan_at};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::Pose2;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::sampling::box_muller;
use loc_maps::RayCaster;
use loc_pf::mcl::MountedScan;
use loc_pf::sensor::beam::{BeamLikelihood, BeamModel, BeamModelSettings, RangeModel};
use loc_pf::sensor::perceptual::{
    PerceptualHistogram, PerceptualModel, RangePair, fit_beam_model, range_pairs,
};
use rand::RngExt;

const NOTHING: f64 = f64::INFINITY;

fn truth() -> BeamModelSettings {
    BeamModelSettings::default()
        .z_hit(0.7)
        .z_short(0.15)
        .z_max(0.06)
        .z_rand(0.09)
        .sigma_hit(0.08)
        .lambda_short(0.4)
        .max_range(10.0)
}

/// What a range finder with these parameters measures.
fn measured(expected: f64, model: &BeamModelSettings, rng: &mut ChaCha8Rng) -> f64 {
    let part = rng.random::<f64>();
    if part < model.z_hit {
        if expected >= model.max_range {
            return NOTHING;
        }
        let mut draw = || expected + model.sigma_hit * box_muller(rng).0;
        return std::iter::repeat_with(&mut draw)
            .find(|range| (0.0..model.max_range).contains(range))
            .unwrap();
    }
    if part < model.z_hit + model.z_short {
        // The inverse of the distribution that is cut off at the expected range.
        let end = expected.min(model.max_range);
        let share = 1.0 - (-model.lambda_short * end).exp();
        return -(1.0 - share * rng.random::<f64>()).ln() / model.lambda_short;
    }
    let none = part < model.z_hit + model.z_short + model.z_max;
    if none { NOTHING } else { rng.random_range(0.0..model.max_range) }
}

fn pairs(count: usize, model: &BeamModelSettings, seed: u64) -> Vec<RangePair> {
    let mut rng = stream(seed, "pairs");
    let mut pair = || {
        let expected = if rng.random_bool(0.1) { NOTHING } else { rng.random_range(0.05..10.0) };
        RangePair { expected, measured: measured(expected, model, &mut rng) }
    };
    (0..count).map(|_| pair()).collect()
}

fn mean_log_likelihood(pairs: &[RangePair], settings: &BeamModelSettings) -> f64 {
    let model = BeamModel::new(settings).unwrap();
    let sum: f64 = pairs.iter().map(|pair| model.log_density(pair.expected, pair.measured)).sum();
    sum / pairs.len() as f64
}

#[test]
fn known_parameters_are_found_again() {
    for seed in 1..4 {
        let pairs = pairs(20_000, &truth(), seed);
        let start = BeamModelSettings::default().max_range(10.0);
        let fit = fit_beam_model(&pairs, &start).unwrap();
        let (found, truth) = (fit.settings, truth());
        assert!(fit.converged && fit.pairs == 20_000, "{fit:?}");
        assert_abs_diff_eq!(found.z_hit, truth.z_hit, epsilon = 0.015);
        assert_abs_diff_eq!(found.z_short, truth.z_short, epsilon = 0.015);
        assert_abs_diff_eq!(found.z_max, truth.z_max, epsilon = 0.01);
        assert_abs_diff_eq!(found.z_rand, truth.z_rand, epsilon = 0.015);
        assert_relative_eq!(found.sigma_hit, truth.sigma_hit, max_relative = 0.03);
        assert_relative_eq!(found.lambda_short, truth.lambda_short, max_relative = 0.2);
        let at_truth = mean_log_likelihood(&pairs, &truth);
        let last = *fit.log_likelihoods.last().unwrap();
        assert_abs_diff_eq!(last, mean_log_likelihood(&pairs, &found), epsilon = 1e-9);
        assert!(last >= at_truth, "{last} {at_truth}");
    }
}

#[test]
fn the_likelihood_never_falls_and_ends_at_a_maximum() {
    let pairs = pairs(5_000, &truth(), 9);
    for start in [
        BeamModelSettings::default().max_range(10.0),
        truth().sigma_hit(8.0).lambda_short(30.0).max_range(10.0),
        truth().z_hit(0.0).z_rand(1.0).sigma_hit(0.001),
    ] {
        let fit = fit_beam_model(&pairs, &start).unwrap();
        assert!(fit.log_likelihoods.is_sorted(), "{:?}", fit.log_likelihoods);
        assert!(fit.converged && fit.log_likelihoods.len() > 3);
        // Nothing near by is better: neither another width or rate, nor other shares.
        let best = mean_log_likelihood(&pairs, &fit.settings);
        for factor in [0.9, 1.1] {
            let found = fit.settings;
            for other in [
                found.sigma_hit(found.sigma_hit * factor),
                found.lambda_short(found.lambda_short * factor),
                found.z_hit(found.z_hit * factor),
                found.z_short(found.z_short * factor),
                found.z_max(found.z_max * factor),
                found.z_rand(found.z_rand * factor),
            ] {
                let other = mean_log_likelihood(&pairs, &other);
                assert!(other < best, "{factor} {best} {other} {found:?}");
            }
        }
    }
}

#[test]
fn what_cannot_be_fitted_is_refused() {
    let start = BeamModelSettings::default().max_range(10.0);
    let few = pairs(60, &truth(), 1);
    let error = fit_beam_model(&few, &start).unwrap_err().to_string();
    assert!(error.starts_with("pairs of an expected and a measured range within reach: "));
    let nothing = vec![RangePair { expected: 3.0, measured: NOTHING }; 5000];
    assert!(fit_beam_model(&nothing, &start).is_err());
    let failed = vec![RangePair { expected: f64::NAN, measured: 1.0 }; 5000];
    assert!(fit_beam_model(&failed, &start).is_err());
    let bad = start.sigma_hit(-1.0);
    assert!(fit_beam_model(&pairs(500, &truth(), 1), &bad).is_err());
    // No noise at all, no outliers at all: the width stays above 0, other shares vanish.
    let exact: Vec<RangePair> = (1..500)
        .map(|k| RangePair { expected: 0.01 * k as f64, measured: 0.01 * k as f64 })
        .collect();
    let fit = fit_beam_model(&exact, &start).unwrap();
    assert!(fit.settings.z_hit > 0.98 && fit.settings.sigma_hit >= 1e-3, "{fit:?}");
    assert!(fit.settings.check().is_ok());
}

#[test]
fn the_histogram_tells_the_density_it_was_drawn_from() {
    let mut histogram = PerceptualHistogram::new(10.0, 0.1).unwrap();
    pairs(400_000, &truth().sigma_hit(0.2), 5).into_iter().for_each(|pair| histogram.add(pair));
    let model = histogram.model();
    let real = BeamModel::new(&truth().sigma_hit(0.2)).unwrap();
    for (expected, measured) in [
        (5.0, 5.0),
        (5.0, 5.2),
        (5.0, 4.6),
        (5.03, 5.03),
        (5.03, 4.8),
        (5.07, 5.25),
        (2.0, 1.0),
        (8.0, 2.5),
        (5.0, 9.0),
        (5.0, NOTHING),
        (NOTHING, NOTHING),
        (NOTHING, 4.0),
    ] {
        let (counted, real) =
            (model.log_density(expected, measured), real.log_density(expected, measured));
        assert_abs_diff_eq!(counted, real, epsilon = 0.2);
    }
    for expected in [0.05, 0.5, 3.33, 9.95, NOTHING] {
        let finite: f64 =
            (0..10_000).map(|k| model.density(expected, 0.001 * (k as f64 + 0.5))).sum();
        let total = 0.001 * finite + model.density(expected, NOTHING);
        assert_abs_diff_eq!(total, 1.0, epsilon = 0.02);
    }
}

#[test]
fn an_empty_histogram_knows_nothing_and_pairs_are_binned_where_they_belong() {
    let mut histogram = PerceptualHistogram::new(8.0, 0.5).unwrap();
    let flat = histogram.model();
    assert_abs_diff_eq!(flat.density(3.0, 1.0), flat.density(7.0, 6.0), epsilon = 1e-6);
    assert!(flat.log_density(f64::NAN, f64::NAN).is_finite());
    for (expected, measured) in
        [(0.0, 0.49), (0.5, 8.0), (7.99, NOTHING), (NOTHING, 7.99), (f64::NAN, 1.0), (1.0, -1.0)]
    {
        histogram.add(RangePair { expected, measured });
    }
    assert_eq!((histogram.pairs(), histogram.bins()), (4, 16));
    assert_eq!([histogram.row(0)[0], histogram.row(1)[16], histogram.row(15)[16]], [1, 1, 1]);
    assert_eq!((histogram.row(16)[15], histogram.row(17)), (1, &[][..]));
    for (range, width) in [(0.0, 0.1), (10.0, f64::NAN), (10.0, 1e-5)] {
        assert!(PerceptualHistogram::new(range, width).is_err());
    }
}

#[test]
fn a_learned_model_rates_scans() {
    let grid = office();
    let caster = RayCaster::new(&grid);
    let mut rng = stream(3, "scans");
    let mut histogram = PerceptualHistogram::new(10.0, 0.1).unwrap();
    let noisy = |pose: Pose2, rng: &mut ChaCha8Rng| {
        let mut scan = scan_at(&grid, pose, 180, 10.0);
        scan.ranges.iter_mut().for_each(|range| *range = measured(*range, &truth(), rng));
        scan
    };
    for _ in 0..60 {
        let mut at = || rng.random_range(1.0..11.0);
        let pose = Pose2::new(at(), at(), 0.3 * at());
        let scan = noisy(pose, &mut rng);
        let pairs = range_pairs(&caster, pose, &scan, 30.0);
        assert!(pairs.iter().all(|pair| pair.expected < 10.0 || pair.expected == NOTHING));
        pairs.into_iter().for_each(|pair| histogram.add(pair));
    }
    let model: PerceptualModel = histogram.model();
    let pose = Pose2::new(6.0, 6.0, 0.4);
    let scan = noisy(pose, &mut rng);
    let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
    let beams: Vec<usize> = (0..180).collect();
    let rated = BeamLikelihood::with_model(&caster, &model, &mounted, &beams, 1.0).unwrap();
    let here = rated.log_likelihood(pose);
    for off in [0.1, 0.3, 1.0] {
        for (x, y, theta) in [(off, 0.0, 0.0), (0.0, -off, 0.0), (0.0, 0.0, 0.5 * off)] {
            let there = Pose2::new(pose.x + x, pose.y + y, pose.theta + theta);
            assert!(here > rated.log_likelihood(there) + 3.0, "{off}");
        }
    }
}
