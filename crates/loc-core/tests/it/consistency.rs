use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::stats::consistency::{ChiSquareTally, NeesEnsemble, Whiteness};
use loc_core::stats::{RunningMoments, chi_square_band, mean_interval, wilson_interval};
use loc_core::{Error, Normal};

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
