use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::stats::consistency::{ChiSquareTally, NeesEnsemble, Whiteness};
use loc_core::stats::{
    RunningMoments, autocorrelation, chi_square_band, chi_square_cdf, chi_square_interval,
    chi_square_quantile, correlation, covariance, covariance_matrix, mean_interval, median, nees,
    quantile, rms, sample_gaussian, whiteness_bound, wilson_interval,
};
use loc_core::{Error, Gaussian, Normal};
use nalgebra::{Matrix2, Vector2};
use proptest::prelude::*;

const FIRST: [f64; 6] = [1.0, 3.0, 2.0, 5.0, 4.0, 4.5];
const SECOND: [f64; 6] = [2.0, 1.0, 4.0, 3.0, 6.0, 5.0];

#[test]
fn running_moments_by_hand() {
    let moments = RunningMoments::of([2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0]).unwrap();
    assert_eq!((moments.count(), moments.mean()), (8, Some(5.0)));
    assert_relative_eq!(moments.population_variance().unwrap(), 4.0);
    assert_relative_eq!(moments.variance().unwrap(), 32.0 / 7.0);
    assert_relative_eq!(moments.standard_deviation().unwrap(), (32.0_f64 / 7.0).sqrt());
    assert_eq!((moments.min(), moments.max()), (Some(2.0), Some(9.0)));
    let one = RunningMoments::of([3.0]).unwrap();
    assert_eq!((one.variance(), one.population_variance()), (None, Some(0.0)));
    let none = RunningMoments::new();
    assert_eq!((none.mean(), none.variance(), none.min(), none.max()), (None, None, None, None));
}

#[test]
fn running_moments_far_from_zero_and_bad_numbers() {
    let mut moments = RunningMoments::of([1e9 + 4.0, 1e9 + 7.0, 1e9 + 13.0, 1e9 + 16.0]).unwrap();
    assert_relative_eq!(moments.variance().unwrap(), 30.0, epsilon = 1e-9);
    let before = moments;
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(moments.push(bad), Err(Error::OutOfRange { .. })));
    }
    assert_eq!(moments, before);
}

#[test]
fn covariance_by_hand() {
    assert_relative_eq!(covariance(&FIRST, &SECOND).unwrap(), 1.25);
    assert_relative_eq!(correlation(&FIRST, &SECOND).unwrap(), 0.43355498476206, epsilon = 1e-13);
    assert_relative_eq!(correlation(&FIRST, &FIRST.map(|v| -3.0 * v)).unwrap(), -1.0);
    let samples: Vec<_> = FIRST.into_iter().zip(SECOND).map(|(a, b)| Vector2::new(a, b)).collect();
    let matrix = covariance_matrix(&samples).unwrap();
    assert_relative_eq!(matrix, Matrix2::new(2.375, 1.25, 1.25, 3.5), epsilon = 1e-14);
    let gaussian = sample_gaussian(&samples).unwrap();
    assert_relative_eq!(gaussian.mean, Vector2::new(3.25, 3.5));
    assert!(matches!(covariance(&[1.0], &[1.0, 2.0]), Err(Error::Length { found: 2, .. })));
    assert!(matches!(covariance(&[1.0], &[1.0]), Err(Error::Length { found: 1, .. })));
    assert!(matches!(correlation(&[1.0, 1.0], &[1.0, 2.0]), Err(Error::OutOfRange { .. })));
    assert!(matches!(covariance(&[1.0, f64::NAN], &[1.0, 2.0]), Err(Error::OutOfRange { .. })));
    assert!(covariance_matrix::<2>(&[]).is_err());
}

#[test]
fn order_statistics() {
    assert_eq!(median(&FIRST).unwrap(), 3.5);
    assert_eq!(median(&[3.0, 1.0, 2.0]).unwrap(), 2.0);
    for (p, value) in [(0.0, 1.0), (0.1, 1.5), (0.25, 2.25), (0.9, 4.75), (1.0, 5.0)] {
        assert_relative_eq!(quantile(&FIRST, p).unwrap(), value, epsilon = 1e-14);
    }
    assert_eq!(quantile(&[7.0], 0.3).unwrap(), 7.0);
    assert_relative_eq!(rms(&[3.0, -4.0]).unwrap(), 12.5_f64.sqrt());
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(median(&[1.0, bad]), Err(Error::OutOfRange { .. })));
        assert!(matches!(rms(&[bad]), Err(Error::OutOfRange { .. })));
        assert!(matches!(quantile(&FIRST, bad), Err(Error::OutOfRange { .. })));
    }
    assert!(matches!(median(&[]), Err(Error::Length { found: 0, .. })));
    assert!(matches!(rms(&[]), Err(Error::Length { found: 0, .. })));
    assert!(quantile(&FIRST, 1.1).is_err());
}

#[test]
fn chi_square_tables() {
    for (dof, p, value) in [
        (1, 0.95, 3.841458820694124),
        (2, 0.95, 5.991464547107979),
        (3, 0.99, 11.344866730144373),
        (10, 0.025, 3.2469727802368413),
        (10, 0.975, 20.483177350807388),
        (150, 0.025, 117.9845154029029),
        (150, 0.975, 185.80044700379327),
        (3000, 0.5, 2999.3333596771927),
        (2, 1e-6, 2.000001000000667e-6),
        (1, 1e-12, 1.5707963267948931e-24),
    ] {
        let found = chi_square_quantile(dof, p).unwrap();
        assert_relative_eq!(found / value, 1.0, epsilon = 1e-12);
    }
    assert_relative_eq!(
        chi_square_quantile(2, 0.95).unwrap(),
        -2.0 * 0.05_f64.ln(),
        epsilon = 1e-12
    );
    assert_relative_eq!(chi_square_cdf(3, 7.8).unwrap(), 0.9496689021401467, epsilon = 1e-12);
    assert_eq!(chi_square_cdf(3, 0.0).unwrap(), 0.0);
    assert_eq!(chi_square_quantile(3, 0.0).unwrap(), 0.0);
    assert_eq!(chi_square_quantile(1, 1e-300).unwrap(), 0.0);
}

#[test]
fn chi_square_intervals_and_bands() {
    let interval = chi_square_interval(10, 0.95).unwrap();
    assert_relative_eq!(*interval.start(), 3.2469727802368413, epsilon = 1e-10);
    assert_relative_eq!(*interval.end(), 20.483177350807388, epsilon = 1e-10);
    let band = chi_square_band(3, 50, 0.95).unwrap();
    assert_relative_eq!(*band.start(), 117.9845154029029 / 50.0, epsilon = 1e-10);
    assert_relative_eq!(*band.end(), 185.80044700379327 / 50.0, epsilon = 1e-10);
    assert!(band.contains(&3.0));
    let wide = chi_square_band(1, 100_000_000, 0.95).unwrap();
    assert_abs_diff_eq!(*wide.end(), 1.0002771997, epsilon = 1e-7);
}

#[test]
fn bad_arguments_of_chi_square() {
    for dof in [0, 100_000_001, usize::MAX] {
        assert!(matches!(chi_square_quantile(dof, 0.5), Err(Error::OutOfRange { .. })));
    }
    assert!(chi_square_band(3, 0, 0.95).is_err() && chi_square_band(3, usize::MAX, 0.95).is_err());
    for p in [-0.1, 1.0, f64::NAN] {
        assert!(matches!(chi_square_quantile(2, p), Err(Error::OutOfRange { .. })));
        assert!(matches!(chi_square_band(2, 2, p), Err(Error::OutOfRange { .. })));
        assert!(matches!(whiteness_bound(10, p), Err(Error::OutOfRange { .. })));
    }
    assert!(chi_square_cdf(2, -1.0).is_err() && chi_square_cdf(2, f64::NAN).is_err());
}

#[test]
fn the_mean_nees_of_an_honest_estimator_lies_in_its_band() {
    let claimed = Matrix2::new(2.0, 0.6, 0.6, 0.5);
    let belief = Gaussian::new(Vector2::zeros(), claimed).unwrap();
    let band = chi_square_band(2, 50, 0.95).unwrap();
    let mut rng = stream(8, "nees");
    let mut mean_of_runs = |scale: f64| {
        let values = (0..50).map(|_| nees(&(belief.sample(&mut rng) * scale), &claimed).unwrap());
        RunningMoments::of(values).unwrap().mean().unwrap()
    };
    let inside = (0..400).filter(|_| band.contains(&mean_of_runs(1.0))).count();
    assert_abs_diff_eq!(inside as f64 / 400.0, 0.95, epsilon = 0.03);
    assert!((0..20).all(|_| mean_of_runs(2.0) > *band.end()), "overconfident");
}

#[test]
fn nees_by_hand_and_refused() {
    let s = Matrix2::new(2.0, 0.6, 0.6, 0.5);
    assert_relative_eq!(nees(&Vector2::new(1.0, -0.5), &s).unwrap(), 2.5, epsilon = 1e-14);
    assert!(matches!(nees(&Vector2::new(f64::NAN, 0.0), &s), Err(Error::OutOfRange { .. })));
    let zero = nees(&Vector2::zeros(), &Matrix2::zeros());
    assert!(matches!(zero, Err(Error::NotACovariance { .. })));
    assert!(nees(&Vector2::zeros(), &Matrix2::new(f64::NAN, 0.0, 0.0, 1.0)).is_err());
}

#[test]
fn autocorrelation_by_hand() {
    // Deviations -1.5, -0.5, 0.5, 1.5: (0.75 - 0.25 + 0.75) / 5.
    assert_relative_eq!(autocorrelation(&[1.0, 2.0, 3.0, 4.0], 1).unwrap(), 0.25);
    assert_relative_eq!(autocorrelation(&[1.0, -1.0, 1.0, -1.0], 1).unwrap(), -0.75);
    assert_relative_eq!(autocorrelation(&[1.0, 2.0, 4.0], 0).unwrap(), 1.0);
    assert!(matches!(autocorrelation(&[1.0], 1), Err(Error::Length { found: 1, .. })));
    assert!(matches!(autocorrelation(&[2.0, 2.0], 1), Err(Error::OutOfRange { .. })));
    assert!(matches!(autocorrelation(&[2.0, f64::NAN], 1), Err(Error::OutOfRange { .. })));
    assert!(autocorrelation(&[], 0).is_err());
}

#[test]
fn white_sequences_stay_within_the_bound() {
    assert_relative_eq!(whiteness_bound(100, 0.95).unwrap(), 0.1959963984540054, epsilon = 1e-12);
    assert!(whiteness_bound(0, 0.95).is_err());
    let mut rng = stream(9, "whiteness");
    let mut white =
        || -> Vec<f64> { (0..200).map(|_| Normal::STANDARD.sample(&mut rng)).collect() };
    let bound = whiteness_bound(200, 0.95).unwrap();
    let within = (0..400).filter(|_| autocorrelation(&white(), 1).unwrap().abs() < bound).count();
    assert_abs_diff_eq!(within as f64 / 400.0, 0.95, epsilon = 0.03);
    let walk: Vec<f64> = white()
        .iter()
        .scan(0.0, |sum, v| {
            *sum += v;
            Some(*sum)
        })
        .collect();
    assert!(autocorrelation(&walk, 1).unwrap() > 0.8);
}

proptest! {
    #[test]
    fn merging_is_seeing_everything(
        left in prop::collection::vec(-1e3..1e3_f64, 0..30),
        right in prop::collection::vec(-1e3..1e3_f64, 0..30),
    ) {
        let whole = RunningMoments::of(left.iter().chain(&right).copied()).unwrap();
        let mut merged = RunningMoments::of(left).unwrap();
        merged.merge(&RunningMoments::of(right).unwrap());
        prop_assert_eq!(merged.count(), whole.count());
        prop_assert_eq!((merged.min(), merged.max()), (whole.min(), whole.max()));
        let close = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a - b).abs() <= 1e-9 * (1.0 + a.abs()),
            (a, b) => a == b,
        };
        prop_assert!(close(merged.mean(), whole.mean()));
        prop_assert!(close(merged.variance(), whole.variance()));
    }
}

fn draw(rng: &mut ChaCha8Rng) -> f64 {
    Normal::STANDARD.sample(rng)
}

/// Numbers of variance 1 that follow each other with correlation `rho`.
fn correlated(rng: &mut ChaCha8Rng, rho: f64, count: usize) -> Vec<f64> {
    let mut value = draw(rng);
    let mut next = || {
        value = rho * value + (1.0 - rho * rho).sqrt() * draw(rng);
        value
    };
    (0..count).map(|_| next()).collect()
}

#[test]
fn a_tally_of_honest_values_is_1_per_degree_within_its_band() {
    let mut rng = stream(1, "tally");
    let mut tally = ChiSquareTally::new(0.95).unwrap();
    for k in 0..4000 {
        let dof = 1 + k % 3;
        let value = (0..dof).map(|_| draw(&mut rng).powi(2)).sum();
        tally.push(dof, value).unwrap();
    }
    assert_eq!((tally.count(), tally.degrees_of_freedom()), (4000, 7999));
    let band = tally.band_per_degree().unwrap();
    // Wide by 1.96 standard deviations of a mean of 7999 squares, of variance 2 each.
    assert_abs_diff_eq!(
        band.end() - band.start(),
        2.0 * 1.96 * (2.0_f64 / 7999.0).sqrt(),
        epsilon = 1e-4
    );
    assert!(band.contains(&tally.mean_per_degree().unwrap()));
    assert_abs_diff_eq!(tally.share_inside().unwrap(), 0.95, epsilon = 0.015);
    let mut twice = tally.clone();
    twice.merge(&tally);
    assert_eq!(twice.count(), 8000);
    assert_relative_eq!(twice.mean().unwrap(), tally.mean().unwrap(), epsilon = 1e-12);
}

#[test]
fn a_tally_refuses_what_is_no_square() {
    let mut tally = ChiSquareTally::new(0.95).unwrap();
    assert_eq!((tally.mean(), tally.mean_per_degree(), tally.share_inside()), (None, None, None));
    assert_eq!(tally.band_per_degree(), None);
    for (dof, value) in [(2, -1.0), (2, f64::NAN), (2, f64::INFINITY), (0, 1.0)] {
        assert!(matches!(tally.push(dof, value), Err(Error::OutOfRange { .. })), "{dof} {value}");
    }
    assert_eq!(tally.count(), 0);
    assert!(ChiSquareTally::new(1.0).is_err() && ChiSquareTally::new(f64::NAN).is_err());
}

/// Runs of 60 steps whose errors (x, y) hang together in time; the covariance claims variances
/// that are `claim` of the real ones.
fn ensemble(seed: u64, runs: usize, claim: f64) -> NeesEnsemble {
    let mut rng = stream(seed, "ensemble");
    let mut ensemble = NeesEnsemble::new(0.95).unwrap();
    for _ in 0..runs {
        let [x, y] = [0, 1].map(|_| correlated(&mut rng, 0.9, 60));
        let nees = x.iter().zip(&y).map(|(x, y)| Some((2, (x * x + y * y) / claim)));
        ensemble.push_run(nees).unwrap();
    }
    ensemble
}

#[test]
fn an_ensemble_knows_honest_from_optimistic() {
    let mut held = 0;
    for seed in 0..40 {
        let honest = ensemble(seed, 50, 1.0);
        assert!(honest.share_in_band().unwrap() > 0.6);
        held += usize::from(honest.interval_per_degree().unwrap().contains(&1.0));
    }
    assert!((35..=40).contains(&held), "{held} of 40 intervals of 95 % hold the truth");
    let optimistic = ensemble(1, 50, 0.5);
    assert!(optimistic.share_in_band().unwrap() < 0.1);
    assert!(*optimistic.interval_per_degree().unwrap().start() > 1.5);
    assert_abs_diff_eq!(optimistic.mean().unwrap(), 4.0, epsilon = 0.5);
    assert!(ensemble(1, 50, 2.0).share_in_band().unwrap() < 0.1, "timid ones are noticed too");
}

#[test]
fn an_ensemble_by_hand() {
    let mut ensemble = NeesEnsemble::new(0.95).unwrap();
    assert_eq!((ensemble.mean(), ensemble.share_in_band()), (None, None));
    ensemble.push_run([None, Some((3, 3.0)), Some((1, 2.0))]).unwrap();
    assert_eq!(ensemble.interval_per_degree(), None);
    ensemble.push_run([None, Some((3, 6.0))]).unwrap();
    ensemble.push_run([None]).unwrap();
    assert_eq!(ensemble.runs(), 2);
    let steps: Vec<_> =
        ensemble.steps().iter().map(|s| (s.runs, s.degrees_of_freedom, s.sum)).collect();
    assert_eq!(steps, [(0, 0, 0.0), (2, 6, 9.0), (1, 1, 2.0)]);
    assert_relative_eq!(ensemble.mean().unwrap(), 11.0 / 3.0);
    // The runs have 5 by 4 and 6 by 3 per degree.
    assert_relative_eq!(ensemble.mean_per_degree().unwrap(), 0.5 * (1.25 + 2.0));
    assert!(ensemble.push_run([Some((3, f64::NAN))]).is_err());
    assert_eq!(ensemble.runs(), 2);
}

#[test]
fn whiteness_finds_correlation_and_bias() {
    let mut rng = stream(3, "whiteness");
    let mut of = |rho: f64, bias: f64| {
        let mut whiteness = Whiteness::new(10).unwrap();
        for _ in 0..40 {
            let mut run = correlated(&mut rng, rho, 50);
            run.iter_mut().for_each(|value| *value += bias);
            whiteness.push(&run).unwrap();
        }
        whiteness
    };
    let white = of(0.0, 0.0);
    assert!(white.share_within(0.95).unwrap() >= 0.8);
    assert_relative_eq!(
        white.bound(1, 0.95).unwrap(),
        1.959964 / (40.0 * 49.0_f64).sqrt(),
        epsilon = 1e-6
    );
    let coloured = of(0.5, 0.0);
    for (lag, rho) in [(1, 0.5), (2, 0.25), (3, 0.125)] {
        assert_abs_diff_eq!(coloured.correlation(lag).unwrap(), rho, epsilon = 0.06);
    }
    assert!(coloured.share_within(0.95).unwrap() < 0.8);
    // A constant bias b shows as b^2 / (1 + b^2) at every lag.
    assert_abs_diff_eq!(of(0.0, 0.5).correlation(7).unwrap(), 0.2, epsilon = 0.06);
}

#[test]
fn whiteness_of_odd_sequences() {
    let mut whiteness = Whiteness::new(3).unwrap();
    assert_eq!(
        (whiteness.correlation(1), whiteness.bound(1, 0.95), whiteness.share_within(0.95)),
        (None, None, None)
    );
    whiteness.push(&[]).unwrap();
    whiteness.push(&[2.0]).unwrap();
    assert_eq!(whiteness.correlation(1), None, "a single number has none after it");
    whiteness.push(&[1.0, -3.0]).unwrap();
    // One product of -3, over a mean square of 14 / 3.
    assert_relative_eq!(whiteness.correlation(1).unwrap(), -9.0 / 14.0);
    assert_eq!(
        (whiteness.correlation(0), whiteness.correlation(2), whiteness.correlation(4)),
        (None, None, None)
    );
    for bad in [[f64::NAN, 1.0], [f64::INFINITY, 1.0], [1e200, 1.0]] {
        assert!(whiteness.push(&bad).is_err());
    }
    assert_relative_eq!(whiteness.correlation(1).unwrap(), -9.0 / 14.0);
    let mut merged = Whiteness::new(3).unwrap();
    merged.merge(&whiteness);
    assert_eq!(merged, whiteness);
    assert!(Whiteness::new(0).is_err());
    let mut still = Whiteness::new(1).unwrap();
    still.push(&[0.0, 0.0]).unwrap();
    assert_eq!(still.correlation(1), None);
}

#[test]
fn bands_go_on_beyond_the_tables() {
    let mut tally = ChiSquareTally::new(0.95).unwrap();
    for _ in 0..3 {
        tally.push(100_000_000, 1e8).unwrap();
    }
    let band = tally.band_per_degree().unwrap();
    assert_relative_eq!(*band.end(), 1.0 + 1.959964 * (2.0 / 3e8_f64).sqrt(), epsilon = 1e-9);
    let exact = chi_square_band(1, 100_000_000, 0.95).unwrap();
    assert_relative_eq!(*exact.end(), 1.0 + 1.959964 * (2.0 / 1e8_f64).sqrt(), epsilon = 1e-7);
}

#[test]
fn intervals_of_the_tables() {
    // Student's t at 0.975: 12.7062 for 1 degree, 2.77645 for 4, 1.98422 for 99.
    for (count, t) in [(2, 12.7062), (5, 2.77645), (100, 1.98422)] {
        let moments = RunningMoments::of((0..count).map(f64::from)).unwrap();
        let interval = mean_interval(&moments, 0.95).unwrap().unwrap();
        let reach = t * moments.standard_deviation().unwrap() / f64::from(count).sqrt();
        assert_relative_eq!(interval.end() - moments.mean().unwrap(), reach, max_relative = 1e-5);
        assert_relative_eq!(
            interval.start() + interval.end(),
            2.0 * moments.mean().unwrap(),
            epsilon = 1e-9
        );
    }
    let one = RunningMoments::of([1.0]).unwrap();
    assert_eq!(mean_interval(&one, 0.95).unwrap(), None);
    assert!(mean_interval(&one, 1.0).is_err());
    // Newcombe 1998, table I: 81 of 263, 15 of 148, 0 of 20, 1 of 29.
    for (successes, count, low, high) in [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ] {
        let interval = wilson_interval(successes, count, 0.95).unwrap();
        assert_abs_diff_eq!(*interval.start(), low, epsilon = 5e-5);
        assert_abs_diff_eq!(*interval.end(), high, epsilon = 5e-5);
    }
    assert!(wilson_interval(0, 0, 0.95).is_err() && wilson_interval(3, 2, 0.95).is_err());
}
