use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::stats::{
    RunningMoments, autocorrelation, chi_square_band, chi_square_cdf, chi_square_interval,
    chi_square_quantile, correlation, covariance, covariance_matrix, median, nees, quantile, rms,
    sample_gaussian, whiteness_bound,
};
use loc_core::{Error, Gaussian, Normal, random::stream};
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
