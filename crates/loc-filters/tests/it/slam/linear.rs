//! Linear SLAM against least squares over everything at once.

use loc_core::Gaussian;
use loc_core::random::stream;
use loc_filters::RobotSettings;
use loc_filters::slam::{LinearSlam, MapSettings, RelativeObservation, SlamSettings};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rand_distr::{Distribution, StandardNormal};

const LANDMARKS: usize = 4;
const STEPS: usize = 12;

fn see(landmark: u32, x: f64, y: f64) -> RelativeObservation {
    let covariance = Matrix2::identity() * 0.0025;
    RelativeObservation { landmark, offset: Vector2::new(x, y), covariance }
}

/// The filter's belief about the last position and the map is that of the normal equations over
/// all positions and all measurements: they are solved by nothing that the filter uses.
#[test]
fn equals_least_squares_over_the_whole_drive() {
    let settings = SlamSettings::default().robot(RobotSettings::default().gate_probability(1.0));
    let start = Gaussian::new(Vector2::new(0.5, 0.1), Matrix2::identity() * 0.01);
    let mut slam = LinearSlam::new(start.unwrap(), settings).unwrap();
    // Unknowns along one axis: positions 0 to STEPS, then the landmarks. The axes are independent.
    let size = STEPS + 1 + LANDMARKS;
    let mut information = [0, 1].map(|_| DMatrix::<f64>::zeros(size, size));
    let mut vector = [0, 1].map(|_| DVector::<f64>::zeros(size));
    let mut add = |axis: usize, terms: &[(usize, f64)], z: f64, variance: f64| {
        for &(i, a) in terms {
            vector[axis][i] += a * z / variance;
            terms.iter().for_each(|&(j, b)| information[axis][(i, j)] += a * b / variance);
        }
    };
    add(0, &[(0, 1.0)], 0.5, 0.01);
    add(1, &[(0, 1.0)], 0.1, 0.01);
    let mut rng = stream(6, "linear");
    let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
    for step in 1..=STEPS {
        let velocity = Vector2::new(0.5 + 0.1 * draw(), 0.3 * draw());
        slam.predict(velocity, 0.5).unwrap();
        let seen: Vec<_> = (0..LANDMARKS)
            .filter(|k| !(step + k).is_multiple_of(3))
            .map(|k| {
                let (x, y) = (k as f64 + 0.1 * draw() - 0.25 * step as f64, 2.0 + draw());
                see(10 + k as u32, x, y)
            })
            .collect();
        for axis in 0..2 {
            let way = 0.5 * velocity[axis];
            let variance = settings.robot.odometry.k_d() * way.abs();
            add(axis, &[(step, 1.0), (step - 1, -1.0)], way, variance);
            for observation in &seen {
                let landmark = STEPS + 1 + observation.landmark as usize - 10;
                let z = observation.offset[axis];
                add(axis, &[(landmark, 1.0), (step, -1.0)], z, 0.0025);
            }
        }
        slam.correct(&seen).unwrap();
    }
    for axis in 0..2 {
        let covariance = information[axis].clone().try_inverse().unwrap();
        let x = &covariance * &vector[axis];
        let robot = slam.robot();
        assert!((robot.mean[axis] - x[STEPS]).abs() < 1e-9);
        assert!((robot.covariance[(axis, axis)] - covariance[(STEPS, STEPS)]).abs() < 1e-12);
        for (id, landmark) in slam.landmarks() {
            let k = STEPS + 1 + id as usize - 10;
            assert!((landmark.mean[axis] - x[k]).abs() < 1e-9);
            assert!((landmark.covariance[(axis, axis)] - covariance[(k, k)]).abs() < 1e-12);
        }
    }
}

#[test]
fn a_new_landmark_is_as_uncertain_as_robot_and_sensor_together() {
    let start = Gaussian::new(Vector2::zeros(), Matrix2::identity() * 0.04).unwrap();
    let mut slam = LinearSlam::new(start, SlamSettings::default()).unwrap();
    let seen = [1.0, 1.05].map(|x| see(5, x, 0.0));
    // The second of the two is held against the landmark that the first has put there.
    let innovations = slam.correct(&seen).unwrap();
    assert!(innovations[0].is_none());
    let innovation = innovations[1].unwrap();
    assert!((innovation.covariance.m11 - 0.005).abs() < 1e-12);
    let landmark = slam.landmark(5).unwrap();
    assert!((landmark.mean.x - 1.025).abs() < 1e-12);
    assert!((landmark.covariance.m11 - 0.04125).abs() < 1e-12);
    assert!((slam.robot().covariance.m11 - 0.04).abs() < 1e-12);
    // An outlier changes nothing.
    let far = see(5, 3.0, 0.0);
    assert!(!slam.correct(&[far]).unwrap()[0].unwrap().accepted);
    assert_eq!(slam.landmark(5).unwrap(), landmark);
    assert!(slam.covariance().unwrap()[(0, 2)] > 0.0);
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let start = Gaussian::certain(Vector2::zeros());
    let settings = SlamSettings::default().map(MapSettings::default().max_landmarks(2));
    let mut slam = LinearSlam::new(start, settings).unwrap();
    let see = |landmark, x| see(landmark, x, 0.0);
    assert!(slam.correct(&[see(1, 1.0), see(2, f64::NAN)]).is_err());
    assert!(slam.predict(Vector2::new(f64::INFINITY, 0.0), 0.1).is_err());
    assert!(slam.predict(Vector2::zeros(), -1.0).is_err());
    assert_eq!((slam.landmarks().count(), slam.robot()), (0, start));
    assert!(slam.correct(&[]).unwrap().is_empty());
    slam.correct(&[see(1, 1.0), see(2, 2.0), see(3, 3.0)]).unwrap();
    assert_eq!(slam.landmarks().count(), 2);
    let singular = RelativeObservation { covariance: Matrix2::zeros(), ..see(1, 1.0) };
    assert!(slam.correct(&[singular]).is_err());
    let wrong =
        settings.robot(settings.robot.odometry(loc_core::motion::VelocityNoise {
            distance_sigma: -1.0,
            ..Default::default()
        }));
    assert!(LinearSlam::new(start, wrong).is_err());
}

/// An observation that is good along one diagonal and bad along the other: the gain of the textbook.
#[test]
fn the_axes_of_an_observation_may_be_turned() {
    let start = Gaussian::new(Vector2::zeros(), Matrix2::identity() * 0.04).unwrap();
    let mut slam = LinearSlam::new(start, SlamSettings::default()).unwrap();
    let covariance = Matrix2::new(0.05, 0.03, 0.03, 0.04);
    slam.correct(&[see(1, 1.0, 2.0)]).unwrap();
    slam.predict(Vector2::new(1.0, 0.0), 1.0).unwrap();
    let observation = RelativeObservation { covariance, ..see(1, 0.1, 2.1) };
    let (robot, p) = (slam.robot(), slam.covariance().unwrap());
    slam.correct(&[observation]).unwrap();
    let h = DMatrix::from_row_slice(2, 4, &[-1., 0., 1., 0., 0., -1., 0., 1.]);
    let r = DMatrix::from_row_slice(2, 2, &[0.05, 0.03, 0.03, 0.04]);
    let k = &p * h.transpose() * (&h * &p * h.transpose() + r).try_inverse().unwrap();
    let moved = &k * DVector::from_vec(vec![0.1, 0.1]);
    assert!((slam.robot().mean - robot.mean - moved.fixed_rows::<2>(0)).amax() < 1e-12);
    let after = (DMatrix::identity(4, 4) - k * h) * &p;
    assert!((slam.covariance().unwrap() - after).amax() < 1e-12);
}
