//! The unscented Kalman filter.

use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::RobotSettings;
use loc_filters::extended::{LinearizedMotion, MeasurementModel, MotionModel};
use loc_filters::kalman::{LinearMeasurement, LinearMotion};
use loc_filters::landmark::{LandmarkEkf, LandmarkUkf};
use loc_filters::{ExtendedKalmanFilter, Gate, KalmanFilter, UnscentedKalmanFilter};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{
    Matrix1, Matrix1x2, Matrix1x4, Matrix2, Matrix4, SMatrix, SVector, Vector1, Vector2, Vector4,
};

/// A linear system of N states of which M numbers are measured.
struct Linear<const N: usize, const M: usize> {
    a: SMatrix<f64, N, N>,
    c: SMatrix<f64, M, N>,
    noise: SMatrix<f64, N, N>,
    sensor: SMatrix<f64, M, M>,
}

impl<const N: usize, const M: usize> MotionModel<N> for Linear<N, M> {
    fn predict(&self, state: &SVector<f64, N>) -> SVector<f64, N> {
        self.a * state
    }
    fn linearize(&self, state: &SVector<f64, N>) -> LinearizedMotion<N> {
        LinearizedMotion { state: self.a * state, jacobian: self.a, noise: self.noise }
    }
}

impl<const N: usize, const M: usize> MeasurementModel<N, M> for Linear<N, M> {
    fn predict(&self, state: &SVector<f64, N>) -> SVector<f64, M> {
        self.c * state
    }
    fn jacobian(&self, _state: &SVector<f64, N>) -> SMatrix<f64, M, N> {
        self.c
    }
    fn noise(&self, _expected: &SVector<f64, M>) -> SMatrix<f64, M, M> {
        self.sensor
    }
}

#[test]
fn a_linear_system_is_filtered_as_by_the_kalman_filter() {
    let a = Matrix4::new(
        1.0, 0.0, 0.1, 0.0, 0.0, 1.0, 0.0, 0.1, 0.0, 0.0, 0.95, 0.02, 0.0, 0.0, -0.02, 0.95,
    );
    let noise = Matrix4::from_diagonal(&Vector4::new(1e-3, 1e-3, 0.02, 0.03));
    let c = Matrix1x4::new(1.0, 0.5, 0.0, 0.1);
    let system = Linear { a, c, noise, sensor: Matrix1::new(0.2) };
    // A start that is certain of one number, and of a sum of two.
    let mut spread = Matrix4::from_diagonal(&Vector4::new(1.0, 1.0, 0.5, 0.0));
    (spread[(0, 1)], spread[(1, 0)]) = (-1.0, -1.0);
    let start = Gaussian::new(Vector4::new(1.0, -2.0, 0.3, 0.1), spread).unwrap();
    let mut ukf = UnscentedKalmanFilter::new(start).unwrap();
    let mut ekf = ExtendedKalmanFilter::new(start).unwrap();
    let mut kf = KalmanFilter::new(start).unwrap();
    let (none, still) = (SMatrix::<f64, 4, 1>::zeros(), Matrix1::new(0.0));
    let motion = LinearMotion::new(a, none, still, noise).unwrap();
    let sensor = LinearMeasurement::new(c, system.sensor).unwrap();
    for k in 0..50 {
        let z = Vector1::new((0.3 * f64::from(k)).sin());
        ukf.predict(&system).unwrap();
        ekf.predict(&system).unwrap();
        kf.predict(&motion, &Vector1::new(0.0)).unwrap();
        let seen = ukf.correct(&system, &z, &Gate::OPEN).unwrap();
        let expected = kf.correct(&sensor, &z, &Gate::OPEN).unwrap();
        ekf.correct(&system, &z, &Gate::OPEN).unwrap();
        assert!((seen.nis - expected.nis).abs() < 1e-10 * (1.0 + expected.nis));
        for other in [kf.belief(), ekf.belief()] {
            assert!((ukf.belief().mean - other.mean).norm() < 1e-11, "step {k}");
            assert!((ukf.belief().covariance - other.covariance).norm() < 1e-11, "step {k}");
        }
    }
}

/// From distance and direction to a place: the textbook's banana.
struct Place;

impl MotionModel<2> for Place {
    fn predict(&self, polar: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(polar.x * polar.y.cos(), polar.x * polar.y.sin())
    }
    fn linearize(&self, polar: &Vector2<f64>) -> LinearizedMotion<2> {
        let (sin, cos) = polar.y.sin_cos();
        let jacobian = Matrix2::new(cos, -polar.x * sin, sin, polar.x * cos);
        LinearizedMotion { state: self.predict(polar), jacobian, noise: Matrix2::zeros() }
    }
}

#[test]
fn moments_of_a_bend_are_nearer_to_those_of_many_draws() {
    let spread = Matrix2::new(0.02 * 0.02, 0.0, 0.0, 0.4 * 0.4);
    let polar = Gaussian::new(Vector2::new(1.0, 0.3), spread).unwrap();
    let mut rng = stream(8, "draws");
    let draws: Vec<Vector2<f64>> =
        (0..200_000).map(|_| Place.predict(&polar.sample(&mut rng))).collect();
    let count = draws.len() as f64;
    let mean = draws.iter().sum::<Vector2<f64>>() / count;
    let square = |draw: &Vector2<f64>| (draw - mean) * (draw - mean).transpose();
    let covariance = draws.iter().map(square).sum::<Matrix2<f64>>() / count;
    let mut ukf = UnscentedKalmanFilter::new(polar).unwrap();
    let mut ekf = ExtendedKalmanFilter::new(polar).unwrap();
    ukf.predict(&Place).unwrap();
    ekf.predict(&Place).unwrap();
    let off = |belief: &Gaussian<2>| {
        [(belief.mean - mean).norm(), (belief.covariance - covariance).norm() / covariance.norm()]
    };
    let (unscented, extended) = (off(ukf.belief()), off(ekf.belief()));
    println!("mean and covariance off: ukf {unscented:.4?}, ekf {extended:.4?}");
    assert!(unscented[0] < 0.004 && unscented[0] < 0.1 * extended[0]);
    assert!(unscented[1] < 0.03 && unscented[1] < 0.3 * extended[1]);
}

/// Headings about +-pi are averaged where they are, in motions and in measurements.
#[test]
fn angles_are_averaged_on_the_circle() {
    struct Heading;
    impl MotionModel<1> for Heading {
        fn predict(&self, state: &Vector1<f64>) -> Vector1<f64> {
            Vector1::new(loc_core::angle::wrap(state.x + 0.05))
        }
        fn linearize(&self, state: &Vector1<f64>) -> LinearizedMotion<1> {
            let jacobian = Matrix1::new(1.0);
            LinearizedMotion {
                state: MotionModel::predict(self, state),
                jacobian,
                noise: Matrix1::new(0.0),
            }
        }
    }
    impl MeasurementModel<1, 1> for Heading {
        fn predict(&self, state: &Vector1<f64>) -> Vector1<f64> {
            Vector1::new(loc_core::angle::wrap(state.x))
        }
        fn jacobian(&self, _state: &Vector1<f64>) -> Matrix1<f64> {
            Matrix1::new(1.0)
        }
        fn noise(&self, _expected: &Vector1<f64>) -> Matrix1<f64> {
            Matrix1::new(0.04)
        }
        fn residual(&self, z: &Vector1<f64>, expected: &Vector1<f64>) -> Vector1<f64> {
            Vector1::new(loc_core::angle::difference(z.x, expected.x))
        }
    }
    let start = Gaussian::new(Vector1::new(3.1), Matrix1::new(0.04)).unwrap();
    let mut filter = UnscentedKalmanFilter::new(start).unwrap().with_angles(&[0]);
    filter.predict(&Heading).unwrap();
    let turned = filter.belief();
    assert!((loc_core::angle::difference(turned.mean.x, 3.15)).abs() < 1e-12, "{turned:?}");
    assert!((turned.covariance.x - 0.04).abs() < 1e-12);
    let innovation = filter.correct(&Heading, &Vector1::new(-3.1), &Gate::OPEN).unwrap();
    let expected = loc_core::angle::difference(-3.1, 3.15);
    assert!((innovation.residual.x - expected).abs() < 1e-12);
    let moved = loc_core::angle::difference(filter.belief().mean.x, 3.15);
    assert!((moved - 0.5 * expected).abs() < 1e-12 && filter.belief().mean.x.abs() <= 3.15);
}

/// Far off across the line of sight: the innovation has the variance of many draws.
#[test]
fn a_near_landmark_is_expected_as_it_is_seen() {
    let map = LandmarkMap::new([Landmark::planar(1, 1.5, 0.0)]).unwrap();
    let start = pose_belief(Pose2::IDENTITY, [0.05, 0.8, 0.01]);
    let mut settings = RobotSettings::default().gate_probability(1.0);
    settings.camera.range_sigma = 0.05;
    let mut rng = stream(4, "draws");
    let ranges: Vec<f64> = (0..100_000)
        .map(|_| start.sample(&mut rng))
        .map(|pose| f64::hypot(1.5 - pose.x, pose.y))
        .collect();
    let mean = ranges.iter().sum::<f64>() / ranges.len() as f64;
    let observation =
        LandmarkObservation { landmark: 1, observed: Observed::Range { range: mean } };
    let mut ukf = LandmarkUkf::new(start, settings).unwrap();
    let mut ekf = LandmarkEkf::new(start, settings).unwrap();
    assert!(ukf.correct(&map, &observation).unwrap().nis.unwrap() < 0.02);
    assert!(ekf.correct(&map, &observation).unwrap().nis.unwrap() > 5.0, "0.2 m that it denies");
    assert!(ukf.belief().mean.x.abs() < 0.02 && ekf.belief().mean.x < -0.08);
    // A motion, too, through the common code.
    ukf.predict(Twist2::forward(1.0, 0.1), 0.5).unwrap();
    assert!(ukf.belief().mean.x > 0.4);
}

/// A heading that may be anything: its sigma points would pass half a turn, and a prediction that
/// wraps them would narrow the belief. It may only widen it.
#[test]
fn a_prediction_never_narrows_a_wide_heading() {
    for sigma in [1.0, 1.8, 2.5, 3.6, 10.0] {
        let start = pose_belief(Pose2::new(1.0, 2.0, 0.5), [0.1, 0.1, sigma]);
        let mut ukf = LandmarkUkf::new(start, RobotSettings::default()).unwrap();
        ukf.predict(Twist2::ZERO, 1.0).unwrap();
        let kept = ukf.belief().covariance;
        assert!((kept - start.covariance).amax() < 1e-9 * sigma * sigma, "{sigma}: {kept}");
        ukf.predict(Twist2::forward(0.5, 0.3), 1.0).unwrap();
        let moved = ukf.belief();
        assert!(moved.covariance.m33 >= start.covariance.m33, "{sigma}: {}", moved.covariance);
        // It may have gone anywhere within 0.5 m.
        assert!(moved.covariance.m11 >= 0.01 && moved.covariance.m22 >= 0.01);
        assert!((moved.mean.xy() - start.mean.xy()).norm() <= 0.5);
    }
}

/// A landmark ahead tells the heading, however uncertain it was.
#[test]
fn a_wide_heading_is_found_from_landmarks() {
    let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0), Landmark::planar(2, 0.0, 5.0)]);
    let map = map.unwrap();
    for truth in [0.0, 1.5, -2.5, 3.0] {
        let start = pose_belief(Pose2::new(0.0, 0.0, 0.4), [0.05, 0.05, 3.6]);
        let mut ukf = LandmarkUkf::new(start, RobotSettings::default()).unwrap();
        for (landmark, direction, range) in [(1, 0.0, 4.0), (2, std::f64::consts::FRAC_PI_2, 5.0)] {
            let bearing = loc_core::angle::wrap(direction - truth);
            let observed = Observed::RangeBearing { range, bearing };
            ukf.correct(&map, &LandmarkObservation { landmark, observed }).unwrap();
        }
        let off = loc_core::angle::difference(ukf.belief().mean.z, truth);
        assert!(off.abs() < 0.05, "{truth}: {off}");
    }
}

struct Distance;

impl MeasurementModel<2, 1> for Distance {
    fn predict(&self, x: &Vector2<f64>) -> Vector1<f64> {
        Vector1::new(x.norm())
    }
    fn jacobian(&self, x: &Vector2<f64>) -> Matrix1x2<f64> {
        x.normalize().transpose()
    }
    fn noise(&self, _: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(0.01)
    }
}

#[test]
fn bad_input_is_refused_and_the_belief_kept() {
    struct Wrong(Vector2<f64>, Matrix2<f64>);
    impl MotionModel<2> for Wrong {
        fn predict(&self, state: &Vector2<f64>) -> Vector2<f64> {
            state + self.0
        }
        fn linearize(&self, state: &Vector2<f64>) -> LinearizedMotion<2> {
            let jacobian = Matrix2::identity();
            LinearizedMotion { state: self.predict(state), jacobian, noise: self.1 }
        }
    }
    let start = Gaussian::new(Vector2::new(3.0, 0.0), Matrix2::identity()).unwrap();
    let mut filter = UnscentedKalmanFilter::new(start).unwrap();
    for value in [f64::NAN, f64::INFINITY] {
        assert!(filter.correct(&Distance, &Vector1::new(value), &Gate::OPEN).is_err());
        assert!(filter.predict(&Wrong(Vector2::new(value, 0.0), Matrix2::zeros())).is_err());
        assert!(filter.predict(&Wrong(Vector2::zeros(), Matrix2::repeat(value))).is_err());
    }
    assert_eq!(*filter.belief(), start);
    let gate = Gate::probability(0.99).unwrap();
    assert!(!filter.correct(&Distance, &Vector1::new(40.0), &gate).unwrap().accepted);
    assert_eq!(*filter.belief(), start);
    // A model that takes noise away makes a covariance that is none; the next step says so.
    filter.predict(&Wrong(Vector2::zeros(), -2.0 * Matrix2::identity())).unwrap();
    let error = filter.correct(&Distance, &Vector1::new(3.0), &Gate::OPEN).unwrap_err();
    assert!(error.to_string().contains("lost its positivity at step 2"), "{error}");
    let negative = Gaussian { mean: Vector2::zeros(), covariance: -Matrix2::identity() };
    assert!(UnscentedKalmanFilter::new(negative).is_err());
}
