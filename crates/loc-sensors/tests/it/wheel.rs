use approx::assert_relative_eq;
use loc_core::Twist2;
use loc_core::motion::VelocityNoise;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_sensors::wheel::{OdometryCalibration, WheelFaults, WheelOdometry};

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
