use approx::assert_abs_diff_eq;
use loc_core::sampling::{CumulativeTable, box_muller, inverse_cdf, triangular, twelve_rule};
use loc_core::stats::{RunningMoments, covariance};
use loc_core::{Error, Normal, random::ChaCha8Rng, random::stream};
use proptest::prelude::*;

const DRAWS: usize = 200_000;

/// Moments of draws, and their kurtosis: 3 for the normal distribution.
fn moments(draw: impl FnMut() -> f64) -> (RunningMoments, f64) {
    let mut draw = draw;
    let values: Vec<f64> = (0..DRAWS).map(|_| draw()).collect();
    let moments = RunningMoments::of(values.iter().copied()).unwrap();
    let (mean, variance) = (moments.mean().unwrap(), moments.population_variance().unwrap());
    let fourth: f64 = values.iter().map(|v| (v - mean).powi(4)).sum();
    (moments, fourth / DRAWS as f64 / (variance * variance))
}

fn rng() -> ChaCha8Rng {
    stream(7, "sampling")
}

/// Checks mean 0, standard deviation 2, and the kurtosis.
fn check(draw: impl FnMut() -> f64, kurtosis: f64) -> RunningMoments {
    let (moments, found) = moments(draw);
    assert_abs_diff_eq!(moments.mean().unwrap(), 0.0, epsilon = 0.015);
    assert_abs_diff_eq!(moments.standard_deviation().unwrap(), 2.0, epsilon = 0.015);
    assert_abs_diff_eq!(found, kurtosis, epsilon = 0.04);
    moments
}

#[test]
fn twelve_rule_moments_and_range() {
    let mut rng = rng();
    // Kurtosis of a sum of n uniform numbers: 3 - 6 / (5 n).
    let moments = check(|| twelve_rule(2.0, &mut rng), 2.9);
    assert!(moments.min().unwrap() >= -12.0 && moments.max().unwrap() <= 12.0);
}

#[test]
fn triangular_moments_and_range() {
    let mut rng = rng();
    let moments = check(|| triangular(2.0, &mut rng), 2.4);
    let limit = 2.0 * 6_f64.sqrt();
    assert!(moments.min().unwrap() >= -limit && moments.max().unwrap() <= limit);
    assert!(moments.max().unwrap() > 0.97 * limit, "the corners are reached");
}

#[test]
fn box_muller_gives_two_independent_normal_numbers() {
    let mut rng = rng();
    let pairs: Vec<(f64, f64)> = (0..DRAWS).map(|_| box_muller(&mut rng)).collect();
    let (first, second): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    for values in [&first, &second] {
        let mut next = values.iter();
        check(|| 2.0 * next.next().unwrap(), 3.0);
        let share = values.iter().filter(|v| v.abs() < 1.0).count() as f64 / DRAWS as f64;
        assert_abs_diff_eq!(share, 0.6827, epsilon = 0.003);
    }
    assert_abs_diff_eq!(covariance(&first, &second).unwrap(), 0.0, epsilon = 0.008);
    // Independent, not only uncorrelated: their squares are uncorrelated as well.
    let square = |values: &[f64]| values.iter().map(|v| v * v).collect::<Vec<f64>>();
    let of_squares = covariance(&square(&first), &square(&second)).unwrap();
    assert_abs_diff_eq!(of_squares, 0.0, epsilon = 0.02);
}

#[test]
fn the_inverse_of_a_cumulative_distribution() {
    let mut rng = rng();
    let normal = Normal::new(0.0, 2.0).unwrap();
    check(|| inverse_cdf(|p| normal.quantile(p).unwrap(), &mut rng), 3.0);
    // Exponential of rate 1: mean 1, variance 1, kurtosis 9.
    let (moments, _) = moments(|| inverse_cdf(|p| -(1.0 - p).ln(), &mut rng));
    assert_abs_diff_eq!(moments.mean().unwrap(), 1.0, epsilon = 0.01);
    assert_abs_diff_eq!(moments.variance().unwrap(), 1.0, epsilon = 0.03);
    assert!(moments.min().unwrap() > 0.0 && moments.max().unwrap().is_finite());
}

#[test]
fn table_heights_lead_to_their_index() {
    let table = CumulativeTable::new([0.0, 1.0, 0.0, 3.0, 0.0]).unwrap();
    assert_eq!(table.total(), 4.0);
    for (p, index) in [(0.0, 1), (0.2499, 1), (0.25, 3), (0.9, 3), (1.0, 3)] {
        assert_eq!(table.index_at(p).unwrap(), index, "at {p}");
    }
    for bad in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(table.index_at(bad), Err(Error::OutOfRange { .. })));
    }
    let bad: [&[f64]; 6] =
        [&[], &[0.0], &[1.0, -1.0], &[f64::NAN], &[f64::INFINITY], &[f64::MAX, f64::MAX]];
    for weights in bad {
        let table = CumulativeTable::new(weights.iter().copied());
        assert!(matches!(table, Err(Error::OutOfRange { .. })), "{weights:?}");
    }
    let mut rng = rng();
    let threes = (0..DRAWS).filter(|_| table.sample(&mut rng) == 3).count();
    assert_abs_diff_eq!(threes as f64 / DRAWS as f64, 0.75, epsilon = 0.004);
}

#[test]
fn the_same_seed_draws_the_same() {
    assert_eq!(box_muller(&mut rng()), box_muller(&mut rng()));
    assert_eq!(twelve_rule(1.0, &mut rng()), twelve_rule(1.0, &mut rng()));
    assert_eq!(twelve_rule(0.0, &mut rng()).abs(), 0.0);
    assert!(triangular(f64::NAN, &mut rng()).is_nan());
}

proptest! {
    #[test]
    fn no_index_without_weight(
        weights in prop::collection::vec(prop_oneof![Just(0.0), 0.0..1.0, 1e-300..1e-290], 1..20),
        p in 0.0..=1.0,
    ) {
        prop_assume!(weights.iter().any(|&w| w > 0.0));
        let table = CumulativeTable::new(weights.iter().copied()).unwrap();
        prop_assert!(weights[table.index_at(p).unwrap()] > 0.0);
    }
}
