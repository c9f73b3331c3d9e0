use approx::assert_relative_eq;
use loc_core::Twist2;
use loc_core::kinematics::Ackermann;
use loc_core::motion::VelocityNoise;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_sensors::encoder::{
    SteeringCount, SteeringEncoder, SteeringNoise, WheelEncoder, WheelTicks,
};
use loc_sensors::wheel::{OdometryCalibration, WheelFaults, WheelOdometry};
use std::f64::consts::PI;

fn report(faults: WheelFaults, twist: Twist2) -> Twist2 {
    let odometry = WheelOdometry::new(0.4).unwrap().with_faults(faults).unwrap();
    odometry.measure(twist, 0.1, &mut stream(1, "odometry"))
}

#[test]
fn perfect_odometry_reports_the_motion() {
    let twist = Twist2::forward(0.7, -0.3);
    let seen = report(WheelFaults::NONE, twist);
    assert_relative_eq!(seen.vx, 0.7, epsilon = 1e-12);
    assert_relative_eq!(seen.omega, -0.3, epsilon = 1e-12);
}

/// Each systematic cause of E7 by hand, on wheels 0.4 m apart.
#[test]
fn faults_by_hand() {
    let straight = Twist2::forward(1.0, 0.0);
    // The left wheel at 0.8 of its radius turns 1/0.8 as fast: 1.25 and 1.0 m/s.
    let seen = report(WheelFaults { left_radius: 0.8, ..WheelFaults::NONE }, straight);
    assert_relative_eq!(seen.vx, 1.125, epsilon = 1e-12);
    assert_relative_eq!(seen.omega, -0.625, epsilon = 1e-12);
    // Contact points 10 % wider than believed: turns are overestimated by as much.
    let seen = report(WheelFaults { track: 1.1, ..WheelFaults::NONE }, Twist2::forward(0.0, 1.0));
    assert_relative_eq!(seen.omega, 1.1, epsilon = 1e-12);
    // Sunk by a fifth: both wheels turn 1.25 as fast.
    let seen = report(WheelFaults { sinkage: 0.2, ..WheelFaults::NONE }, straight);
    assert_relative_eq!(seen.vx, 1.25, epsilon = 1e-12);
    assert_relative_eq!(seen.omega, 0.0, epsilon = 1e-12);
    // Certain slip of a half: the wheels report twice the way.
    let slip = WheelFaults { slip: 0.5, slip_rate: 1e9, ..WheelFaults::NONE };
    assert_relative_eq!(report(slip, straight).vx, 2.0, epsilon = 1e-12);
    // A certain bump of 1 cm in each step of 0.1 s.
    let bump = WheelFaults { bump: 0.01, bumps_per_m: 1e9, ..WheelFaults::NONE };
    assert_relative_eq!(report(bump, straight).vx, 1.1, epsilon = 1e-12);
    assert_relative_eq!(report(bump, Twist2::forward(-1.0, 0.0)).vx, -1.1, epsilon = 1e-12);
}

#[test]
fn noise_has_the_variances_of_the_error_model() {
    let noise = VelocityNoise::default();
    let odometry = WheelOdometry::new(0.4).unwrap().with_noise(noise);
    let twist = Twist2::forward(0.8, -1.2);
    let mut rng = stream(2, "odometry");
    let seen: Vec<Twist2> = (0..20_000).map(|_| odometry.measure(twist, 0.1, &mut rng)).collect();
    let v = RunningMoments::of(seen.iter().map(|t| t.vx)).unwrap();
    let omega = RunningMoments::of(seen.iter().map(|t| t.omega)).unwrap();
    let expected = noise.variances(twist, 0.1);
    assert_relative_eq!(v.mean().unwrap(), 0.8, epsilon = 0.01);
    assert_relative_eq!(omega.mean().unwrap(), -1.2, epsilon = 0.01);
    // 20000 draws know a variance to 1 %; three of those.
    assert_relative_eq!(v.variance().unwrap(), expected.x, max_relative = 0.03);
    assert_relative_eq!(omega.variance().unwrap(), expected.z, max_relative = 0.03);
}

#[test]
fn slip_and_bumps_come_at_their_rates() {
    let faults = WheelFaults {
        slip: 0.5,
        slip_rate: 2.0,
        bump: 0.01,
        bumps_per_m: 3.0,
        ..WheelFaults::NONE
    };
    let odometry = WheelOdometry::new(0.4).unwrap().with_faults(faults).unwrap();
    let mut rng = stream(4, "odometry");
    let count = 20_000;
    let mean: f64 = (0..count)
        .map(|_| odometry.measure(Twist2::forward(1.0, 0.0), 0.1, &mut rng).vx)
        .sum::<f64>()
        / f64::from(count);
    let expected = 1.0 + (1.0 - (-0.2_f64).exp()) + 0.1 * (1.0 - (-0.3_f64).exp());
    assert_relative_eq!(mean, expected, epsilon = 0.01);
}

#[test]
fn bad_faults_and_calibrations_are_refused() {
    let odometry = WheelOdometry::new(0.4).unwrap();
    for faults in [
        WheelFaults { left_radius: 0.0, ..WheelFaults::NONE },
        WheelFaults { sinkage: 1.0, ..WheelFaults::NONE },
        WheelFaults { slip: 1.0, ..WheelFaults::NONE },
        WheelFaults { bumps_per_m: -1.0, ..WheelFaults::NONE },
        WheelFaults { track: f64::NAN, ..WheelFaults::NONE },
    ] {
        assert!(odometry.with_faults(faults).is_err(), "{faults:?}");
    }
    assert!(WheelOdometry::new(-0.4).is_err());
    let backwards = OdometryCalibration { speed_scale: -1.0, ..OdometryCalibration::NONE };
    assert!(backwards.check().is_err());
}

#[test]
fn calibration_by_hand() {
    let calibration = OdometryCalibration {
        delay: 0.25,
        speed_scale: 1.1,
        turn_slowdown: 0.5,
        turn_scale: 0.9,
        curvature: 0.2,
    };
    let driven = calibration.correct(Twist2::forward(2.0, -1.0));
    assert_relative_eq!(driven.vx, 1.1, epsilon = 1e-12);
    assert_relative_eq!(driven.omega, -0.5, epsilon = 1e-12);
    assert_eq!(calibration.correct(Twist2::forward(2.0, 4.0)).vx, 0.0);
    let any = Twist2::forward(0.3, 0.7);
    assert_eq!(OdometryCalibration::NONE.correct(any), any);
}

#[test]
fn ticks_by_hand() {
    // 100 counts a turn, 1 m around: a count is 1 cm.
    let mut wheel = WheelEncoder::new(100, 0.5 / PI).unwrap();
    assert_relative_eq!(wheel.resolution(), 0.01, epsilon = 1e-15);
    assert_eq!(wheel.roll(0.025), WheelTicks(2));
    assert_eq!(wheel.roll(0.006), WheelTicks(1), "half a count was left");
    assert_eq!(wheel.roll(-0.05), WheelTicks(-5));
    assert_relative_eq!(wheel.distance(WheelTicks(-3)), -0.03, epsilon = 1e-15);
    assert_eq!(wheel.roll(f64::NAN), WheelTicks(0));
    assert_eq!(wheel.roll(f64::INFINITY), WheelTicks(0));
    assert_eq!(wheel.roll(0.02), WheelTicks(2), "and it still works");
}

#[test]
fn no_way_is_lost() {
    let mut wheel = WheelEncoder::new(512, 0.1).unwrap();
    let (mut ticks, mut way) = (0, 0.0);
    for k in 0..100_000 {
        let step = 3e-4 * (0.01 * f64::from(k)).sin() + 1e-4;
        ticks += wheel.roll(step).0;
        way += step;
    }
    let error = wheel.distance(WheelTicks(ticks)) - way;
    assert!(error.abs() <= wheel.resolution(), "{error}");
}

#[test]
fn steering_by_hand() {
    let mut encoder = SteeringEncoder::new(3600).unwrap();
    let mut rng = stream(1, "steering");
    let tenth = 0.1_f64.to_radians();
    assert_relative_eq!(encoder.resolution(), tenth, epsilon = 1e-15);
    assert_eq!(encoder.measure(2.44 * tenth, &mut rng), SteeringCount(2));
    assert_eq!(encoder.measure(-2.6 * tenth, &mut rng), SteeringCount(-3));
    assert_relative_eq!(encoder.angle(SteeringCount(-3)), -3.0 * tenth, epsilon = 1e-15);
    assert_eq!(encoder.measure(99.0, &mut rng), SteeringCount(1800));
}

#[test]
fn play_follows_at_a_distance() {
    let noise = SteeringNoise { backlash: 0.02, zero_offset: 0.1, ..SteeringNoise::NONE };
    let mut encoder = SteeringEncoder::new(1 << 24).unwrap().with_noise(noise).unwrap();
    let mut rng = stream(1, "steering");
    let mut angle = |steering| {
        let count = encoder.measure(steering, &mut rng);
        encoder.angle(count) - 0.1
    };
    assert_relative_eq!(angle(0.005), 0.0, epsilon = 1e-6);
    assert_relative_eq!(angle(0.30), 0.29, epsilon = 1e-6);
    assert_relative_eq!(angle(0.285), 0.29, epsilon = 1e-6);
    assert_relative_eq!(angle(0.20), 0.21, epsilon = 1e-6);
}

/// The speed of the rear wheels and the steering angle make the velocity of a car.
#[test]
fn counts_give_a_cars_velocity() {
    let car = Ackermann::new(2.5).unwrap();
    let mut rear = WheelEncoder::new(4096, 0.3).unwrap();
    let mut steering = SteeringEncoder::new(1 << 14).unwrap();
    let ticks = rear.roll(0.8);
    let count = steering.measure(0.2, &mut stream(1, "steering"));
    let seen = car.twist(rear.distance(ticks) / 0.1, steering.angle(count));
    let truth = car.twist(8.0, 0.2);
    assert_relative_eq!(seen.vx, truth.vx, epsilon = rear.resolution() / 0.1);
    assert_relative_eq!(seen.omega, truth.omega, epsilon = 2e-3);
}

#[test]
fn noise_has_its_variance() {
    let noise = SteeringNoise { sigma: 0.01, ..SteeringNoise::NONE };
    let mut encoder = SteeringEncoder::new(1 << 16).unwrap().with_noise(noise).unwrap();
    let mut rng = stream(2, "steering");
    let counts: Vec<_> = (0..20_000).map(|_| encoder.measure(0.3, &mut rng)).collect();
    let moments = RunningMoments::of(counts.into_iter().map(|c| encoder.angle(c))).unwrap();
    assert_relative_eq!(moments.mean().unwrap(), 0.3, epsilon = 3e-4);
    assert_relative_eq!(moments.standard_deviation().unwrap(), 0.01, max_relative = 0.03);
}

#[test]
fn bad_settings_are_refused() {
    assert!(WheelEncoder::new(0, 0.1).is_err());
    assert!(WheelEncoder::new(100, 0.0).is_err());
    assert!(WheelEncoder::new(100, f64::NAN).is_err());
    assert!(SteeringEncoder::new(3).is_err() && SteeringEncoder::new(u32::MAX).is_err());
    let encoder = SteeringEncoder::new(1000).unwrap();
    assert!(encoder.with_noise(SteeringNoise { sigma: -1.0, ..SteeringNoise::NONE }).is_err());
    assert!(encoder.with_noise(SteeringNoise { backlash: -1.0, ..SteeringNoise::NONE }).is_err());
}
