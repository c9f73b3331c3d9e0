use approx::assert_relative_eq;
use loc_core::Gaussian;
use loc_core::random::stream;
use loc_filters::kalman::{KalmanFilter, LinearMeasurement, LinearMotion};
use loc_filters::{Gate, ScalarKalmanFilter};
use nalgebra::{Matrix1, Matrix1x2, Matrix2, Matrix2x1, SMatrix, SVector, Vector1, Vector2};
use rand::RngExt;

const T: f64 = 0.1;

/// G3: a robot at rest, both sensors at once.
#[test]
fn two_sensors_of_a_stationary_robot() {
    let start = Gaussian::new(Vector1::new(0.0), Matrix1::new(20.0)).unwrap();
    let mut filter = KalmanFilter::new(start).unwrap();
    let noise = Matrix2::new(0.25, 0.0, 0.0, 1.0);
    let sensors = LinearMeasurement::new(Vector2::new(1.0, 1.0), noise).unwrap();
    let z = Vector2::new(9.4, 10.6);
    let innovation = filter.correct(&sensors, &z, &Gate::OPEN).unwrap();
    assert_relative_eq!(filter.belief().mean.x, 9.544_554_5, epsilon = 5e-8);
    assert_relative_eq!(filter.belief().covariance.x, 0.198_019_8, epsilon = 5e-8);
    let gain =
        20.0 * Vector2::new(1.0, 1.0).transpose() * innovation.covariance.try_inverse().unwrap();
    assert_relative_eq!(gain, Vector2::new(0.792_079_2, 0.198_019_8).transpose(), epsilon = 5e-8);
}

/// G3 again, one sensor after the other in one dimension: the same belief.
#[test]
fn one_dimension_agrees_with_many() {
    let mut filter = ScalarKalmanFilter::new(0.0, 20.0).unwrap();
    filter.correct(1.0, 9.4, 0.25, &Gate::OPEN).unwrap();
    filter.correct(1.0, 10.6, 1.0, &Gate::OPEN).unwrap();
    assert_relative_eq!(filter.mean(), 9.544_554_455, epsilon = 1e-9);
    assert_relative_eq!(filter.variance(), 0.198_019_802, epsilon = 1e-9);
}

/// G1 by hand: a = 2, b = 1, c = 2.
#[test]
fn one_dimension_by_hand() {
    let mut filter = ScalarKalmanFilter::new(1.0, 0.5).unwrap();
    filter.predict(2.0, 1.0, 3.0, 1.0).unwrap();
    assert_eq!((filter.mean(), filter.variance()), (5.0, 3.0));
    // k = 2*3/(4*3 + 4) = 0.375; mu = 5 + 0.375 (14 - 10); s^2 = (1 - 0.75) 3.
    let innovation = filter.correct(2.0, 14.0, 4.0, &Gate::OPEN).unwrap();
    assert_relative_eq!(innovation.nis, 1.0);
    assert_relative_eq!(filter.mean(), 6.5);
    assert_relative_eq!(filter.variance(), 0.75);
    assert!(filter.correct(1.0, 1.0, 0.0, &Gate::OPEN).is_err());
    assert!(filter.correct(1.0, f64::INFINITY, 1.0, &Gate::OPEN).is_err());
    assert!(filter.predict(1.0, 0.0, 0.0, -1.0).is_err());
    assert!(ScalarKalmanFilter::new(0.0, -1.0).is_err());
    assert_relative_eq!(filter.mean(), 6.5);
}

fn vehicle() -> (KalmanFilter<2>, LinearMotion<2, 1>) {
    let a = Matrix2::new(1.0, T, 0.0, 1.0);
    let motion =
        LinearMotion::new(a, Matrix2x1::new(0.0, T), Matrix1::new(0.16), Matrix2::zeros()).unwrap();
    let start = Gaussian::new(Vector2::zeros(), Matrix2::new(1.0, 0.0, 0.0, 0.01)).unwrap();
    (KalmanFilter::new(start).unwrap(), motion)
}

/// G4: the printed covariance is that of 51 predictions; so are the corrected numbers.
#[test]
fn accelerated_vehicle() {
    let (mut filter, motion) = vehicle();
    for _ in 0..50 {
        filter.predict(&motion, &Vector1::new(1.0)).unwrap();
    }
    assert_relative_eq!(filter.belief().mean, Vector2::new(12.25, 5.0), epsilon = 1e-12);
    let after_50 = Matrix2::new(1.8968, 0.2460, 0.2460, 0.0900);
    assert_relative_eq!(filter.belief().covariance, after_50, epsilon = 5e-5);

    filter.predict(&motion, &Vector1::new(1.0)).unwrap();
    assert_relative_eq!(filter.belief().mean, Vector2::new(12.75, 5.1), epsilon = 1e-12);
    let after_51 = Matrix2::new(1.9469, 0.2550, 0.2550, 0.0916);
    assert_relative_eq!(filter.belief().covariance, after_51, epsilon = 5e-5);

    let sensor = LinearMeasurement::new(Matrix1x2::new(1.0, 0.0), Matrix1::new(0.25)).unwrap();
    filter.correct(&sensor, &Vector1::new(11.79), &Gate::OPEN).unwrap();
    assert_relative_eq!(filter.belief().mean, Vector2::new(11.8992, 4.9886), epsilon = 5e-5);
    let corrected = Matrix2::new(0.221_550_8, 0.029_018_2, 0.029_018_2, 0.062_001_5);
    assert_relative_eq!(filter.belief().covariance, corrected, epsilon = 5e-8);
}

/// Against the textbook's formulas with an explicit inverse, on random systems.
#[test]
fn joseph_form_agrees_with_the_simple_form() {
    let mut rng = stream(3, "systems");
    for _ in 0..200 {
        let mut random = |_, _| 2.0 * rng.random::<f64>() - 1.0;
        let a = SMatrix::<f64, 4, 4>::from_fn(&mut random);
        let b = SMatrix::<f64, 4, 2>::from_fn(&mut random);
        let c = SMatrix::<f64, 3, 4>::from_fn(&mut random);
        let root = SMatrix::<f64, 4, 4>::from_fn(&mut random);
        let start = SVector::<f64, 4>::from_fn(&mut random);
        let u = SVector::<f64, 2>::from_fn(&mut random);
        let z = SVector::<f64, 3>::from_fn(&mut random);
        let p0 = root * root.transpose();
        let (s_u, r) = (Matrix2::identity() * 0.3, SMatrix::<f64, 4, 4>::identity() * 0.1);
        let q = SMatrix::<f64, 3, 3>::identity() * 0.2;

        let mut filter = KalmanFilter::new(Gaussian::new(start, p0).unwrap()).unwrap();
        filter.predict(&LinearMotion::new(a, b, s_u, r).unwrap(), &u).unwrap();
        filter.correct(&LinearMeasurement::new(c, q).unwrap(), &z, &Gate::OPEN).unwrap();

        let x = a * start + b * u;
        let p = a * p0 * a.transpose() + b * s_u * b.transpose() + r;
        let k = p * c.transpose() * (c * p * c.transpose() + q).try_inverse().unwrap();
        let belief = filter.belief();
        assert_relative_eq!(belief.mean, x + k * (z - c * x), epsilon = 1e-9);
        let simple = (SMatrix::<f64, 4, 4>::identity() - k * c) * p;
        assert_relative_eq!(belief.covariance, simple, epsilon = 1e-9);
        assert_eq!(belief.covariance, belief.covariance.transpose());
    }
}

/// The simple form loses positivity here; Joseph's does not.
#[test]
fn covariances_survive_a_million_to_one() {
    let start = Gaussian::new(Vector2::zeros(), Matrix2::identity() * 1e8).unwrap();
    let mut filter = KalmanFilter::new(start).unwrap();
    let sensor = LinearMeasurement::new(Matrix1x2::new(1.0, 1.0), Matrix1::new(1e-8)).unwrap();
    for _ in 0..100 {
        filter.correct(&sensor, &Vector1::new(1.0), &Gate::OPEN).unwrap();
        let belief = filter.belief();
        Gaussian::new(belief.mean, belief.covariance).unwrap();
    }
}
