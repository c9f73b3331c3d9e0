use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::stats::RunningMoments;
use loc_core::{Error, Gaussian, Normal, random::stream};
use nalgebra::Vector1;
use proptest::prelude::*;

#[test]
fn shares_within_one_two_and_three_sigma() {
    let exact = [0.6826894921370859, 0.9544997361036416, 0.9973002039367398];
    for (k, (printed, exact)) in (1..).zip([0.68, 0.955, 0.997].into_iter().zip(exact)) {
        let normal = Normal::new(-3.0, 0.5).unwrap();
        let share = normal.probability(-3.0 - 0.5 * f64::from(k), -3.0 + 0.5 * f64::from(k));
        assert_abs_diff_eq!(share, printed, epsilon = 0.003);
        assert_relative_eq!(share, exact, epsilon = 1e-14);
    }
}

#[test]
fn a_density_may_exceed_one() {
    let narrow = Normal::new(1.0, 0.25).unwrap();
    assert_relative_eq!(narrow.density(1.0), 1.5957691216057308, epsilon = 1e-14);
    assert_relative_eq!(narrow.density(1.5), 0.21596386605275225, epsilon = 1e-14);
    assert_relative_eq!(narrow.log_density(1.5), 0.21596386605275225_f64.ln(), epsilon = 1e-14);
    assert_relative_eq!(Normal::STANDARD.log_density(100.0), -5000.918938533205, epsilon = 1e-9);
}

#[test]
fn tails_keep_their_digits() {
    let z = Normal::STANDARD;
    assert_relative_eq!(z.cdf(-10.0) / 7.61985302416047e-24, 1.0, epsilon = 1e-12);
    assert_relative_eq!(z.probability(8.0, 9.0), 6.219831985865787e-16, max_relative = 1e-12);
    assert_relative_eq!(z.cdf(-35.0) / 1.1249107064724061e-268, 1.0, epsilon = 1e-11);
    assert_eq!((z.cdf(-40.0), z.cdf(40.0)), (0.0, 1.0));
    for (x, cdf) in
        [(0.7, 0.758036347776927), (-0.71, 0.23885206808998668), (1.3, 0.9031995154143897)]
    {
        assert_relative_eq!(z.cdf(x), cdf, epsilon = 1e-14);
    }
    assert_eq!(z.probability(f64::NEG_INFINITY, f64::INFINITY), 1.0);
    assert_eq!(z.probability(1.0, -1.0), 0.0);
    assert!(z.probability(f64::NAN, 1.0).is_nan() && z.cdf(f64::NAN).is_nan());
}

#[test]
fn quantiles_of_the_table() {
    let quantile = |p| Normal::STANDARD.quantile(p).unwrap();
    assert_abs_diff_eq!(quantile(0.5), 0.0, epsilon = 1e-15);
    assert_relative_eq!(quantile(0.975), 1.959963984540054, epsilon = 1e-13);
    assert_relative_eq!(quantile(0.001), -3.090232306167813, epsilon = 1e-13);
    assert_relative_eq!(quantile(1e-300), -37.0470962993612, epsilon = 1e-11);
    assert_eq!((quantile(0.0), quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
    for bad in [-0.1, 1.1, f64::NAN] {
        assert!(matches!(Normal::STANDARD.quantile(bad), Err(Error::OutOfRange { .. })));
    }
}

#[test]
fn bad_parameters_are_refused() {
    for (mean, sigma) in [
        (f64::NAN, 1.0),
        (f64::INFINITY, 1.0),
        (0.0, 0.0),
        (0.0, -1.0),
        (0.0, f64::NAN),
        (0.0, f64::INFINITY),
    ] {
        assert!(matches!(Normal::new(mean, sigma), Err(Error::OutOfRange { .. })));
    }
}

#[test]
fn samples_and_the_vector_of_one() {
    let normal = Normal::new(2.0, 3.0).unwrap();
    let mut rng = stream(4, "normal");
    let moments = RunningMoments::of((0..100_000).map(|_| normal.sample(&mut rng))).unwrap();
    assert_abs_diff_eq!(moments.mean().unwrap(), normal.mean(), epsilon = 0.03);
    assert_abs_diff_eq!(moments.variance().unwrap(), normal.variance(), epsilon = 0.12);
    let vector = Gaussian::from(normal).log_density(&Vector1::new(4.5)).unwrap();
    assert_relative_eq!(vector, normal.log_density(4.5), epsilon = 1e-13);
}

proptest! {
    #[test]
    fn the_quantile_undoes_the_cdf(mean in -10.0..10.0, sigma in 0.01..10.0, z in -5.0..5.0_f64) {
        let normal = Normal::new(mean, sigma).unwrap();
        let x = mean + sigma * z;
        // Near 1 the cdf itself has only 1e-16 / density left to tell values of x apart.
        let back = normal.quantile(normal.cdf(x)).unwrap();
        prop_assert!((back - x).abs() <= 1e-9 * sigma, "{back} {x}");
    }
}
