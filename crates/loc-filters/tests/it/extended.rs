use approx::assert_relative_eq;
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::landmark::{BearingModel, RangeBearingModel, RangeModel, VelocityMotion};
use loc_filters::{ExtendedKalmanFilter, Gate, MeasurementModel, MotionModel};
use loc_sensors::landmark_camera::LandmarkNoise;
use nalgebra::{Matrix3, Point2, SMatrix, SVector, Vector2, Vector3};
use rand::RngExt;

fn slope<const M: usize>(
    model: &impl MeasurementModel<3, M>,
    x: &Vector3<f64>,
) -> SMatrix<f64, M, 3> {
    let mut out = SMatrix::<f64, M, 3>::zeros();
    for column in 0..3 {
        let (mut above, mut below) = (*x, *x);
        above[column] += 1e-6;
        below[column] -= 1e-6;
        let difference: SVector<f64, M> =
            model.residual(&model.predict(&above), &model.predict(&below));
        out.set_column(column, &(difference / 2e-6));
    }
    out
}

/// Every measurement Jacobian against central differences, with and without a lever arm.
#[test]
fn measurement_jacobians_are_the_slopes() {
    let mut rng = stream(11, "poses");
    for _ in 0..300 {
        let mut random = |scale: f64| scale * (2.0 * rng.random::<f64>() - 1.0);
        let pose = Vector3::new(random(5.0), random(5.0), random(3.1));
        let lever = random(1.0);
        let mounting =
            if lever > 0.0 { Pose2::new(lever, random(0.5), random(3.0)) } else { Pose2::IDENTITY };
        let landmark = Point2::new(random(5.0), random(5.0));
        let camera = Pose2::from_vector(&pose) * mounting;
        if nalgebra::distance(&camera.position(), &landmark) < 0.1 {
            continue;
        }
        let model = RangeBearingModel { landmark, mounting, noise: LandmarkNoise::default() };
        assert_relative_eq!(model.jacobian(&pose), slope(&model, &pose), epsilon = 1e-6);
        let range = RangeModel(model);
        assert_relative_eq!(range.jacobian(&pose), slope(&range, &pose), epsilon = 1e-6);
        let bearing = BearingModel(model);
        assert_relative_eq!(bearing.jacobian(&pose), slope(&bearing, &pose), epsilon = 1e-6);
    }
}

/// H2's rows for a camera at the robot's centre, 3-4-5 triangle.
#[test]
fn the_lecture_rows_by_hand() {
    let model = RangeBearingModel {
        landmark: Point2::new(3.0, 4.0),
        mounting: Pose2::IDENTITY,
        noise: LandmarkNoise::default(),
    };
    let h = model.jacobian(&Vector3::zeros());
    let expected = SMatrix::<f64, 2, 3>::new(-0.6, -0.8, 0.0, 0.16, -0.12, -1.0);
    assert_relative_eq!(h, expected, epsilon = 1e-12);
    let on_top = model.jacobian(&Vector3::new(3.0, 4.0, 0.0));
    assert!(on_top.iter().all(|value| value.is_finite()));
}

#[test]
fn motion_noise_is_that_of_dead_reckoning() {
    let noise = VelocityNoise::default();
    let twist = Twist2::forward(0.8, -0.5);
    let start = Gaussian::new(Vector3::new(1.0, 2.0, 3.1), Matrix3::identity() * 0.01).unwrap();
    for integration in Integration::ALL {
        let motion = VelocityMotion { twist, dt: 0.1, integration, noise };
        let mut filter = ExtendedKalmanFilter::new(start).unwrap().with_angles(&[2]);
        filter.predict(&motion).unwrap();
        let reference = loc_core::motion::dead_reckon(&start, twist, 0.1, integration, &noise);
        assert_relative_eq!(filter.belief().mean, reference.mean, epsilon = 1e-12);
        assert_relative_eq!(filter.belief().covariance, reference.covariance, epsilon = 1e-12);
        assert_relative_eq!(motion.predict(&start.mean), reference.mean, epsilon = 1e-12);
    }
}

/// An innovation across +-pi is small, and the heading comes back wrapped.
#[test]
fn angles_are_wrapped_in_innovations_and_states() {
    let model = RangeBearingModel {
        landmark: Point2::new(-4.0, -0.1),
        mounting: Pose2::IDENTITY,
        noise: LandmarkNoise::default(),
    };
    let start = Gaussian::new(Vector3::zeros(), Matrix3::identity() * 0.1).unwrap();
    let mut filter = ExtendedKalmanFilter::new(start).unwrap().with_angles(&[2]);
    let innovation = filter.correct(&model, &Vector2::new(4.0, 3.13), &Gate::OPEN).unwrap();
    assert!(innovation.residual.y.abs() < 0.05);
    assert!(filter.belief().mean.z.abs() < 0.05);

    let near_pi = Gaussian::new(Vector3::new(0.0, 0.0, 3.13), Matrix3::identity() * 0.1).unwrap();
    let mut filter = ExtendedKalmanFilter::new(near_pi).unwrap().with_angles(&[2]);
    let landmark = RangeBearingModel { landmark: Point2::new(-4.0, 0.0), ..model };
    filter.correct(&landmark, &Vector2::new(4.0, -0.1), &Gate::OPEN).unwrap();
    let theta = filter.belief().mean.z;
    assert!(theta > -std::f64::consts::PI && theta < -3.0, "{theta}");
}
