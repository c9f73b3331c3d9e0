use approx::assert_relative_eq;
use loc_core::kinematics::{Ackermann, Differential, Mecanum, MecanumWheels};
use loc_core::kinematics::{Kurt2Drive, Kurt2Pose};
use loc_core::motion::Integration;
use loc_core::{Error, Pose2, Twist2};
use nalgebra::{Vector2, Vector4};
use proptest::prelude::*;

use crate::finite_difference;

/// E5: both seconds of document 003's example, corrected (30.64, not 29.83).
#[test]
fn kurt2_drives_the_printed_example() {
    let drive = Kurt2Drive::new(0.25).unwrap();
    let first = drive.step(Kurt2Pose::default(), 0.80, 0.75, 1.0);
    let second = drive.step(first, 0.80, 0.75, 1.0);
    let at_once = drive.step(Kurt2Pose::default(), 0.80, 0.75, 2.0);
    for (pose, (x, z, theta)) in [
        (first, (7.74, 77.11, 0.2)),
        (second, (30.64, 151.15, 0.4)),
        (at_once, (30.79, 151.91, 0.4)),
    ] {
        assert_relative_eq!(100.0 * pose.x, x, epsilon = 5e-3);
        assert_relative_eq!(100.0 * pose.z, z, epsilon = 5e-3);
        assert_relative_eq!(pose.theta, theta, epsilon = 1e-12);
    }
}

/// E5 once more through the right-handed drive, and with the exact arc.
#[test]
fn kurt2_agrees_with_the_right_handed_drive() {
    let twist = Differential::new(0.25).unwrap().twist(0.80, 0.75);
    for (rule, seconds) in [
        (Integration::Midpoint, [(7.74, 77.11), (30.64, 151.15)]),
        (Integration::ExactArc, [(7.724, 76.984), (30.589, 150.900)]),
    ] {
        let mut pose = Pose2::IDENTITY;
        for (x, z) in seconds {
            pose = rule.step(pose, twist, 1.0);
            let kurt2 = Kurt2Pose::from(pose);
            assert_relative_eq!(100.0 * kurt2.x, x, epsilon = 5e-3);
            assert_relative_eq!(100.0 * kurt2.z, z, epsilon = 5e-3);
            assert_relative_eq!(Pose2::from(kurt2).y, pose.y);
        }
    }
}

#[test]
fn drives_refuse_what_they_cannot_do() {
    assert!(matches!(Differential::new(0.0), Err(Error::OutOfRange { .. })));
    assert!(matches!(Ackermann::new(f64::NAN), Err(Error::OutOfRange { .. })));
    assert!(Mecanum::new(0.4, -1.0).is_err());
    let sideways = Twist2::new(1.0, 0.2, 0.0);
    let message = Differential::new(0.4).unwrap().wheels(sideways).unwrap_err().to_string();
    assert_eq!(message, "differential drive: cannot slide sideways at 0.2 m/s");
    let on_the_spot = Twist2::forward(0.0, 1.0);
    assert!(Ackermann::new(0.4).unwrap().wheels(on_the_spot).is_err());
    assert_eq!(Ackermann::new(0.4).unwrap().wheels(Twist2::ZERO).unwrap(), (0.0, 0.0));
}

/// A car of 2 m wheelbase steered by 45 degrees turns on a circle of 2 m.
#[test]
fn ackermann_turns_about_the_meeting_point_of_its_axles() {
    let car = Ackermann::new(2.0).unwrap();
    let twist = car.twist(1.0, 45_f64.to_radians());
    assert_relative_eq!(twist.omega, 0.5, epsilon = 1e-12);
    // Centre of rotation 2 m to the left: inner wheel at 1.5 m, outer at 2.5 m from it.
    let (left, right) = car.front_wheel_angles(45_f64.to_radians(), 1.0);
    assert_relative_eq!(left, (2.0_f64 / 1.5).atan(), epsilon = 1e-12);
    assert_relative_eq!(right, (2.0_f64 / 2.5).atan(), epsilon = 1e-12);
    assert_eq!(car.front_wheel_angles(0.0, 1.0), (0.0, 0.0));
}

#[test]
fn mecanum_slides_and_notices_slip() {
    let drive = Mecanum::new(0.6, 0.4).unwrap();
    let left =
        MecanumWheels { front_left: -1.0, front_right: 1.0, rear_left: 1.0, rear_right: -1.0 };
    assert_eq!(drive.twist(left), Twist2::new(0.0, 1.0, 0.0));
    assert_relative_eq!(drive.slip(left), 0.0);
    let spin =
        MecanumWheels { front_left: -1.0, front_right: 1.0, rear_left: -1.0, rear_right: 1.0 };
    assert_relative_eq!(drive.twist(spin).omega, 2.0);
    let fighting =
        MecanumWheels { front_left: 1.0, front_right: 1.0, rear_left: -1.0, rear_right: -1.0 };
    assert_relative_eq!(drive.slip(fighting), 2.0);
}

proptest! {
    #[test]
    fn wheels_and_back(v in -2.0..2.0_f64, vy in -1.0..1.0_f64, omega in -3.0..3.0_f64) {
        let rolling = Twist2::forward(v, omega);
        let differential = Differential::new(0.35).unwrap();
        let (left, right) = differential.wheels(rolling).unwrap();
        prop_assert!((differential.twist(left, right).to_vector() - rolling.to_vector()).norm() < 1e-12);

        let car = Ackermann::new(0.35).unwrap();
        let (speed, steering) = car.wheels(rolling).unwrap();
        prop_assert!((car.twist(speed, steering).to_vector() - rolling.to_vector()).norm() < 1e-9);

        let sliding = Twist2::new(v, vy, omega);
        let mecanum = Mecanum::new(0.5, 0.4).unwrap();
        let wheels = mecanum.wheels(sliding);
        prop_assert!((mecanum.twist(wheels).to_vector() - sliding.to_vector()).norm() < 1e-12);
        prop_assert!(mecanum.slip(wheels).abs() < 1e-12);
    }

    #[test]
    fn jacobians_are_the_slopes(a in -2.0..2.0_f64, b in -1.0..1.0_f64) {
        let differential = Differential::new(0.35).unwrap();
        let numeric = finite_difference::jacobian(
            |w: Vector2<f64>| differential.twist(w.x, w.y).to_vector(), Vector2::new(a, b), None);
        prop_assert!((numeric - differential.jacobian()).amax() < 1e-8);

        let car = Ackermann::new(0.35).unwrap();
        let numeric = finite_difference::jacobian(
            |w: Vector2<f64>| car.twist(w.x, w.y).to_vector(), Vector2::new(a, b), None);
        prop_assert!((numeric - car.jacobian(a, b)).amax() < 1e-6);

        let mecanum = Mecanum::new(0.5, 0.4).unwrap();
        let numeric = finite_difference::jacobian(
            |w: Vector4<f64>| mecanum.twist(MecanumWheels {
                front_left: w[0], front_right: w[1], rear_left: w[2], rear_right: w[3],
            }).to_vector(), Vector4::new(a, b, -a, 0.3), None);
        prop_assert!((numeric - mecanum.jacobian()).amax() < 1e-8);
    }
}
