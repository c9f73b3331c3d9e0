use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::gaussian::{check_covariance, cholesky, pose_belief};
use loc_core::random::stream;
use loc_core::stats::{RunningMoments, sample_gaussian};
use loc_core::{Error, Gaussian, Normal, Pose2};
use nalgebra::{Matrix1, Matrix2, Matrix3, Rotation2, Vector1, Vector2, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn tilted() -> Gaussian<2> {
    Gaussian::new(Vector2::new(1.0, 2.0), Matrix2::new(2.0, 0.6, 0.6, 0.5)).unwrap()
}

#[test]
fn density_and_distance_by_hand() {
    // det S = 0.64, S^-1 = [[0.5, -0.6], [-0.6, 2]] / 0.64, deviation (1, -0.5).
    let x = Vector2::new(2.0, 1.5);
    let squared = (0.5 + 0.6 + 0.5) / 0.64;
    assert_relative_eq!(tilted().mahalanobis_squared(&x).unwrap(), squared, epsilon = 1e-13);
    let log_density = -0.5 * squared - 0.5 * 0.64_f64.ln() - TAU.ln();
    assert_relative_eq!(tilted().log_density(&x).unwrap(), log_density, epsilon = 1e-13);
    assert_relative_eq!(log_density, -2.8647335150951365, epsilon = 1e-14);
}

#[test]
fn density_in_one_and_three_dimensions() {
    let one = Gaussian::new(Vector1::new(1.0), Matrix1::new(0.0625)).unwrap();
    let density = one.log_density(&Vector1::new(1.5)).unwrap().exp();
    assert_relative_eq!(density, 0.21596386605275225, epsilon = 1e-14);
    assert!(one.log_density(&Vector1::new(1.0)).unwrap() > 0.0, "a density above 1");
    let s = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, 0.25, 0.5, 0.25, 2.0);
    let three = Gaussian::new(Vector3::zeros(), s).unwrap();
    let log_density = three.log_density(&Vector3::new(1.0, -1.0, 0.5)).unwrap();
    assert_relative_eq!(log_density, -4.742346988475702, epsilon = 1e-13);
}

#[test]
fn ellipse_of_a_rotated_covariance() {
    for degrees in [-60.0_f64, 0.0, 30.0, 89.0] {
        let turn = Rotation2::new(degrees.to_radians());
        let axes = Matrix2::from_diagonal(&Vector2::new(9.0, 1.0));
        let s = turn * axes * turn.inverse();
        let ellipse = Gaussian::new(Vector2::new(5.0, -1.0), s).unwrap().ellipse(2.0);
        assert_relative_eq!(ellipse.semi_major, 6.0, epsilon = 1e-12);
        assert_relative_eq!(ellipse.semi_minor, 2.0, epsilon = 1e-12);
        assert_relative_eq!(ellipse.angle.to_degrees(), degrees, epsilon = 1e-10);
        assert_eq!(ellipse.center, Vector2::new(5.0, -1.0));
    }
    let upright = Gaussian::new(Vector2::zeros(), Matrix2::new(1.0, 0.0, 0.0, 4.0)).unwrap();
    assert_relative_eq!(upright.ellipse(1.0).angle, FRAC_PI_2);
    let line = Gaussian::new(Vector2::zeros(), Matrix2::new(1.0, 1.0, 1.0, 1.0)).unwrap();
    assert_abs_diff_eq!(line.ellipse(1.0).semi_minor, 0.0, epsilon = 1e-7);
}

#[test]
fn samples_have_the_mean_and_covariance() {
    let mut rng = stream(1, "gaussian");
    let belief = tilted();
    let samples: Vec<_> = (0..100_000).map(|_| belief.sample(&mut rng)).collect();
    let found = sample_gaussian(&samples).unwrap();
    assert_abs_diff_eq!(found.mean, belief.mean, epsilon = 0.02);
    assert_abs_diff_eq!(found.covariance, belief.covariance, epsilon = 0.03);
    let inside = samples.iter().filter(|s| belief.mahalanobis_squared(s).unwrap() < 1.0);
    assert_abs_diff_eq!(inside.count() as f64 / 1e5, 0.3935, epsilon = 0.005);
}

#[test]
fn samples_of_a_singular_covariance_stay_on_its_line() {
    let mut rng = stream(2, "gaussian");
    // All three move together by (1, 2, 0): rank 1, with a certain third number.
    let s = Matrix3::new(1.0, 2.0, 0.0, 2.0, 4.0, 0.0, 0.0, 0.0, 0.0);
    let belief = Gaussian::new(Vector3::new(1.0, 1.0, 7.0), s).unwrap();
    let samples: Vec<_> = (0..20_000).map(|_| belief.sample(&mut rng)).collect();
    for sample in &samples {
        assert_abs_diff_eq!(sample.y - 1.0, 2.0 * (sample.x - 1.0), epsilon = 1e-6);
        assert_eq!(sample.z, 7.0);
    }
    let found = sample_gaussian(&samples).unwrap();
    assert_abs_diff_eq!(found.covariance, s, epsilon = 0.1);
    let certain = Gaussian::certain(Vector2::new(3.0, 4.0));
    assert_eq!(certain.sample(&mut rng), Vector2::new(3.0, 4.0));
}

#[test]
fn a_small_variance_beside_a_large_one_still_moves() {
    let mut rng = stream(3, "gaussian");
    let s = Matrix2::from_diagonal(&Vector2::new(1e8, 1e-8));
    let belief = Gaussian::new(Vector2::zeros(), s).unwrap();
    let samples: Vec<_> = (0..20_000).map(|_| belief.sample(&mut rng)).collect();
    let found = sample_gaussian(&samples).unwrap().covariance;
    assert_relative_eq!(found.m22, 1e-8, max_relative = 0.05);
}

#[test]
fn matrices_that_are_no_covariances_are_refused() {
    let refused = |s: Matrix2<f64>| {
        let error = Gaussian::new(Vector2::zeros(), s).unwrap_err();
        assert!(matches!(error, Error::NotACovariance { .. }), "{s}: {error}");
    };
    refused(Matrix2::new(1.0, 0.5, 0.4, 1.0));
    refused(Matrix2::new(1.0, 2.0, 2.0, 1.0));
    refused(Matrix2::new(1.0, 1.00001, 1.00001, 1.0));
    refused(Matrix2::new(-1.0, 0.0, 0.0, 1.0));
    refused(Matrix2::new(0.0, 0.1, 0.1, 1.0));
    refused(Matrix2::new(1e6, 0.0, 0.0, -1e-4));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(Matrix2::new(bad, 0.0, 0.0, 1.0));
        refused(Matrix2::new(1.0, bad, bad, 1.0));
        let mean = Gaussian::new(Vector2::new(bad, 0.0), Matrix2::identity());
        assert!(matches!(mean, Err(Error::OutOfRange { .. })));
    }
}

#[test]
fn covariances_off_by_rounding_are_accepted() {
    for s in [
        Matrix2::zeros(),
        Matrix2::new(1.0, 1.0, 1.0, 1.0),
        Matrix2::new(1.0, 1e-17, 0.0, -1e-17),
        Matrix2::new(1.0, 0.5, 0.5 + 1e-15, 1.0),
        Matrix2::new(1e-30, 0.0, 0.0, 1e-30),
        Matrix2::new(1e12, 0.3, 0.3, 1e-12),
    ] {
        check_covariance("s", &s).unwrap();
    }
}

#[test]
fn singular_covariances_have_no_density() {
    let certain = Gaussian::certain(Vector2::zeros());
    let x = Vector2::zeros();
    assert!(matches!(certain.log_density(&x), Err(Error::NotACovariance { .. })));
    assert!(matches!(certain.mahalanobis_squared(&x), Err(Error::NotACovariance { .. })));
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(cholesky("s", &Matrix2::new(bad, 0.0, 0.0, 1.0)).is_err());
    }
    let message = certain.log_density(&x).unwrap_err().to_string();
    assert!(message.contains("positive definite") && message.contains("[0.0, 0.0]"), "{message}");
}

#[test]
fn pose_beliefs() {
    let belief = pose_belief(Pose2::new(1.0, 2.0, PI - 0.1), [0.5, 0.25, 0.1]);
    assert_eq!(belief.covariance.diagonal(), Vector3::new(0.25, 0.0625, 0.1 * 0.1));
    assert_eq!(belief.pose(), Pose2::new(1.0, 2.0, PI - 0.1));
    assert_eq!(belief.position().mean, Vector2::new(1.0, 2.0));
    assert_eq!(belief.position().covariance.m22, 0.0625);
    let deviation = belief.pose_deviation(Pose2::new(1.5, 2.0, -PI + 0.1));
    assert_abs_diff_eq!(deviation, Vector3::new(0.5, 0.0, 0.2), epsilon = 1e-12);
    let squared = belief.deviation_squared(&deviation).unwrap();
    assert_relative_eq!(squared, 5.0, epsilon = 1e-9);
}

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
