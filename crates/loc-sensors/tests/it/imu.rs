use approx::assert_relative_eq;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_core::{Pose2, Twist2};
use loc_sensors::imu::{Imu, ImuReading, ImuSpec, InertialNoise, STANDARD_GRAVITY};
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

fn perfect() -> Imu {
    let none = InertialNoise::NONE;
    Imu::new(ImuSpec { rate: 100.0, accelerometer: none, gyroscope: none }).unwrap()
}

fn feel(mut imu: Imu, twist: Twist2, change: Twist2) -> ImuReading {
    imu.measure(twist, change, 0.01, &mut stream(1, "imu"))
}

#[test]
fn motion_by_hand() {
    let at_rest = feel(perfect(), Twist2::ZERO, Twist2::ZERO);
    assert_eq!(at_rest.acceleration, Vector3::new(0.0, 0.0, STANDARD_GRAVITY));
    assert_eq!(at_rest.angular_velocity, Vector3::zeros());
    // Braking in a left curve.
    let curve = feel(perfect(), Twist2::forward(3.0, 0.5), Twist2::forward(-2.0, 0.0));
    assert_relative_eq!(curve.acceleration.x, -2.0);
    assert_relative_eq!(curve.acceleration.y, 1.5);
    assert_relative_eq!(curve.angular_velocity.z, 0.5);
    // 0.4 m ahead of the middle and turned to the left, on a robot that turns on the spot, ever
    // faster: 0.4 w^2 backwards, 0.4 dw/dt to the left.
    let imu = perfect().with_mounting(Pose2::new(0.4, 0.0, FRAC_PI_2)).unwrap();
    let spin = feel(imu, Twist2::forward(0.0, 2.0), Twist2::forward(0.0, 3.0));
    assert_relative_eq!(spin.acceleration.x, 1.2, epsilon = 1e-12);
    assert_relative_eq!(spin.acceleration.y, 1.6, epsilon = 1e-12);
}

/// The derivative of the velocity in the map frame, turned into the robot's, of a sliding robot.
#[test]
fn force_is_the_derivative_of_velocity() {
    let twist = |t: f64| Twist2::new(1.0 + 0.3 * t, -0.2 + 0.1 * t, 0.4);
    let in_map = |t: f64| Pose2::new(0.0, 0.0, 0.4 * t).rotation() * twist(t).to_vector().xy();
    let h = 1e-5;
    let derivative = (in_map(h) - in_map(-h)) / (2.0 * h);
    let felt = feel(perfect(), twist(0.0), Twist2::new(0.3, 0.1, 0.0)).acceleration;
    assert_relative_eq!(felt.xy(), derivative, epsilon = 1e-8);
}

/// The same density at any rate: averages over one second have the standard deviation of the
/// density.
#[test]
fn white_noise_has_its_density() {
    let spec = ImuSpec::mpu6050();
    let still = |noise| InertialNoise { bias_walk: 0.0, start_bias: 0.0, ..noise };
    let spec = ImuSpec {
        accelerometer: still(spec.accelerometer),
        gyroscope: still(spec.gyroscope),
        ..spec
    };
    for rate in [50, 200] {
        let (mut imu, mut rng) = (Imu::new(spec).unwrap(), stream(2, "imu"));
        let (mut force, mut turn) = (RunningMoments::new(), RunningMoments::new());
        for _ in 0..2000 {
            let mut sum = [0.0; 2];
            for _ in 0..rate {
                let reading =
                    imu.measure(Twist2::ZERO, Twist2::ZERO, 1.0 / f64::from(rate), &mut rng);
                sum[0] += reading.acceleration.x / f64::from(rate);
                sum[1] += reading.angular_velocity.z / f64::from(rate);
            }
            force.push(sum[0]).unwrap();
            turn.push(sum[1]).unwrap();
        }
        let sigma = |moments: RunningMoments| moments.standard_deviation().unwrap();
        assert_relative_eq!(sigma(force), 400e-6 * STANDARD_GRAVITY, max_relative = 0.06);
        assert_relative_eq!(sigma(turn), 0.005_f64.to_radians(), max_relative = 0.06);
    }
}

#[test]
fn biases_start_and_wander_as_they_should() {
    let spec = ImuSpec::mpu6050();
    let (mut start, mut end, mut rng) =
        (RunningMoments::new(), RunningMoments::new(), stream(3, "imu"));
    for _ in 0..1000 {
        let mut imu = Imu::new(spec).unwrap();
        assert!(imu.biases().is_none());
        imu.measure(Twist2::ZERO, Twist2::ZERO, 0.5, &mut rng);
        let first = imu.biases().unwrap().1.z;
        for _ in 0..50 {
            imu.measure(Twist2::ZERO, Twist2::ZERO, 0.5, &mut rng);
        }
        start.push(first).unwrap();
        end.push(imu.biases().unwrap().1.z - first).unwrap();
    }
    let sigma = |moments: RunningMoments| moments.standard_deviation().unwrap();
    assert_relative_eq!(sigma(start), spec.gyroscope.start_bias, max_relative = 0.08);
    assert_relative_eq!(sigma(end), spec.gyroscope.bias_walk * 5.0, max_relative = 0.08);
}

#[test]
fn no_axis_measures_beyond_its_limit() {
    let imu = Imu::new(ImuSpec::mpu6050()).unwrap();
    let reading = feel(imu, Twist2::forward(0.0, -9.0), Twist2::forward(50.0, 0.0));
    assert_relative_eq!(reading.angular_velocity.z, -(250_f64.to_radians()));
    assert_relative_eq!(reading.acceleration.x, 2.0 * STANDARD_GRAVITY);
}

#[test]
fn bad_settings_are_refused() {
    for spec in [ImuSpec::adis16448(), ImuSpec::mpu6050(), ImuSpec::default()] {
        spec.check().unwrap();
        let bad = InertialNoise { density: -1.0, ..spec.gyroscope };
        assert!(Imu::new(ImuSpec { gyroscope: bad, ..spec }).is_err());
        let bad = InertialNoise { limit: 0.0, ..spec.accelerometer };
        assert!(Imu::new(ImuSpec { accelerometer: bad, ..spec }).is_err());
        assert!(Imu::new(ImuSpec { rate: f64::NAN, ..spec }).is_err());
    }
    let nowhere = Pose2 { x: f64::INFINITY, ..Pose2::IDENTITY };
    assert!(perfect().with_mounting(nowhere).is_err());
    let mut reading = feel(perfect(), Twist2::ZERO, Twist2::ZERO);
    reading.check().unwrap();
    reading.acceleration.x = f64::NAN;
    assert!(reading.check().is_err());
}
