use crate::finite_difference::jacobian;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::angle::{circular_mean, weighted_circular_mean, wrap};
use loc_core::{Pose2, angle};
use nalgebra::{Isometry2, Point2, SMatrix, Vector2, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Poses at the identity, near it, anywhere, and with headings on both sides of the seam.
fn poses() -> impl Strategy<Value = Pose2> {
    let heading = prop_oneof![
        -PI..PI,
        -1e-8..1e-8_f64,
        (-1e-8..1e-8_f64).prop_map(|off| PI + off),
        Just(0.0),
        Just(PI),
    ];
    prop_oneof![
        1 => Just(Pose2::IDENTITY),
        1 => (-1e-8..1e-8_f64, -1e-8..1e-8_f64, -1e-8..1e-8_f64)
            .prop_map(|(x, y, theta)| Pose2::new(x, y, theta)),
        6 => (-10.0..10.0_f64, -10.0..10.0_f64, heading)
            .prop_map(|(x, y, theta)| Pose2::new(x, y, theta)),
    ]
}

fn points() -> impl Strategy<Value = Point2<f64>> {
    (-10.0..10.0_f64, -10.0..10.0_f64).prop_map(|(x, y)| Point2::new(x, y))
}

fn same(a: Pose2, b: Pose2) -> bool {
    a.distance(b) < 1e-11 && angle::difference(a.theta, b.theta).abs() < 1e-13
}

fn in_range(pose: Pose2) -> bool {
    pose.theta > -PI && pose.theta <= PI
}

/// Whether a Jacobian agrees with its finite differences.
fn agree<const M: usize, const N: usize>(
    analytic: &SMatrix<f64, M, N>,
    numeric: &SMatrix<f64, M, N>,
) -> bool {
    (analytic - numeric).amax() < 2e-7
}

proptest! {
    #[test]
    fn group_laws(a in poses(), b in poses(), c in poses()) {
        prop_assert!(same(a * Pose2::IDENTITY, a) && same(Pose2::IDENTITY * a, a));
        prop_assert!(same(a * a.inverse(), Pose2::IDENTITY));
        prop_assert!(same(a.inverse() * a, Pose2::IDENTITY));
        prop_assert!(same(a.inverse().inverse(), a));
        prop_assert!(same((a * b) * c, a * (b * c)));
        prop_assert!(same((a * b).inverse(), b.inverse() * a.inverse()));
        prop_assert!(same(a.between(b), a.inverse() * b));
        prop_assert!(same(a * a.between(b), b));
        prop_assert!([a * b, a.inverse(), a.between(b)].into_iter().all(in_range));
    }

    #[test]
    fn points_follow_the_group(a in poses(), b in poses(), p in points()) {
        let chained = a.transform(&b.transform(&p));
        prop_assert!(((a * b).transform(&p) - chained).norm() < 1e-11);
        prop_assert!((a.inverse().transform(&a.transform(&p)) - p).norm() < 1e-11);
        let rotation = a.rotation();
        prop_assert!((rotation * rotation.transpose() - SMatrix::identity()).amax() < 1e-15);
    }

    #[test]
    fn exp_and_log_are_inverse(pose in poses(), scale in -1.0..1.0_f64) {
        prop_assert!(same(Pose2::exp(&pose.log()), pose));
        let tangent = pose.to_vector() * 0.999;
        prop_assert!((Pose2::exp(&tangent).log() - tangent).amax() < 1e-11);
        // Motions along one arc add up.
        let (part, rest) = (tangent * scale, tangent * (1.0 - scale));
        prop_assert!(same(Pose2::exp(&part) * Pose2::exp(&rest), Pose2::exp(&tangent)));
        prop_assert!(same(Pose2::exp(&-tangent), Pose2::exp(&tangent).inverse()));
    }

    #[test]
    fn jacobians(a in poses(), b in poses(), p in points()) {
        let (va, vb) = (a.to_vector(), b.to_vector());
        let pose = |v: Vector3<f64>| Pose2::from_vector(&v);

        let (result, by_a, by_b) = a.compose_jacobians(b);
        prop_assert_eq!(result, a * b);
        prop_assert!(agree(&by_a, &jacobian(|v| (pose(v) * b).to_vector(), va, Some(2))));
        prop_assert!(agree(&by_b, &jacobian(|v| (a * pose(v)).to_vector(), vb, Some(2))));

        let (result, by_a) = a.inverse_jacobian();
        prop_assert_eq!(result, a.inverse());
        prop_assert!(agree(&by_a, &jacobian(|v| pose(v).inverse().to_vector(), va, Some(2))));

        let (result, by_a, by_b) = a.between_jacobians(b);
        prop_assert_eq!(result, a.between(b));
        prop_assert!(agree(&by_a, &jacobian(|v| pose(v).between(b).to_vector(), va, Some(2))));
        prop_assert!(agree(&by_b, &jacobian(|v| a.between(pose(v)).to_vector(), vb, Some(2))));

        let (result, by_a, by_p) = a.transform_jacobians(&p);
        prop_assert_eq!(result, a.transform(&p));
        prop_assert!(agree(&by_a, &jacobian(|v| pose(v).transform(&p).coords, va, None)));
        let of_point = |v: Vector2<f64>| a.transform(&Point2::from(v)).coords;
        prop_assert!(agree(&by_p, &jacobian(of_point, p.coords, None)));
    }

    #[test]
    fn isometries_do_the_same(a in poses(), b in poses(), p in points()) {
        let (ia, ib) = (Isometry2::from(a), Isometry2::from(b));
        prop_assert!(same(Pose2::from(ia), a));
        prop_assert!(same(Pose2::from(ia * ib), a * b));
        prop_assert!(same(Pose2::from(ia.inverse()), a.inverse()));
        prop_assert!((ia * p - a.transform(&p)).norm() < 1e-11);
    }
}

#[test]
fn by_hand() {
    let map_from_base = Pose2::new(1.0, 2.0, FRAC_PI_2);
    let ahead = map_from_base * Pose2::new(3.0, 1.0, FRAC_PI_2);
    assert_abs_diff_eq!(ahead.to_vector(), Vector3::new(0.0, 5.0, PI), epsilon = 1e-12);
    let back = map_from_base.inverse();
    assert_abs_diff_eq!(back.to_vector(), Vector3::new(-2.0, 1.0, -FRAC_PI_2), epsilon = 1e-12);
    let seen = map_from_base.between(Pose2::new(1.0, 4.0, 0.0));
    assert_abs_diff_eq!(seen.to_vector(), Vector3::new(2.0, 0.0, -FRAC_PI_2), epsilon = 1e-12);
    let point = map_from_base.transform(&Point2::new(1.0, 0.0));
    assert_abs_diff_eq!(point, Point2::new(1.0, 3.0), epsilon = 1e-12);
    assert_relative_eq!(map_from_base.distance(Pose2::new(4.0, 6.0, 0.0)), 5.0);
    assert_eq!(map_from_base.position(), Point2::new(1.0, 2.0));
    assert_eq!(map_from_base.to_string(), "(1.000 m, 2.000 m, 90.00 deg)");
}

#[test]
fn a_quarter_circle_and_its_logarithm() {
    // Radius 1, a quarter turn to the left: ends at (1, 1), facing left.
    let quarter = Pose2::exp(&Vector3::new(FRAC_PI_2, 0.0, FRAC_PI_2));
    assert_abs_diff_eq!(quarter.to_vector(), Vector3::new(1.0, 1.0, FRAC_PI_2), epsilon = 1e-15);
    let half = Pose2::new(0.0, 2.0, PI).log();
    assert_abs_diff_eq!(half, Vector3::new(PI, 0.0, PI), epsilon = 1e-15);
    let straight = Pose2::exp(&Vector3::new(2.0, -1.0, 0.0));
    assert_eq!(straight, Pose2::new(2.0, -1.0, 0.0));
}

#[test]
fn headings_are_wrapped_and_bad_numbers_show() {
    assert_abs_diff_eq!(Pose2::new(0.0, 0.0, 7.0).theta, 7.0 - 2.0 * PI, epsilon = 1e-15);
    assert_eq!(Pose2::new(0.0, 0.0, -PI).theta, PI);
    assert!(Pose2::IDENTITY.is_finite());
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(!Pose2::new(bad, 0.0, 0.0).is_finite());
        assert!(!Pose2::new(0.0, bad, 0.0).is_finite());
        assert!(!Pose2::new(0.0, 0.0, bad).is_finite());
        assert!(!(Pose2::new(0.0, 0.0, bad) * Pose2::IDENTITY).is_finite());
    }
}

#[test]
fn the_interval_is_open_below_and_closed_above() {
    assert_relative_eq!(wrap(PI), PI);
    assert_relative_eq!(wrap(-PI), PI);
    assert_relative_eq!(wrap(3.0 * PI), PI, epsilon = 1e-12);
    assert_relative_eq!(wrap(-0.5), -0.5);
    assert!(wrap(f64::NAN).is_nan() && wrap(f64::INFINITY).is_nan());
}

#[test]
fn means_cross_the_seam() {
    let mean = circular_mean([PI - 0.1, -PI + 0.3]).expect("has a direction");
    assert_relative_eq!(mean, -PI + 0.1, epsilon = 1e-12);
    assert_eq!(circular_mean([0.0, PI]), None);
    assert_eq!(circular_mean([]), None);
    assert_eq!(circular_mean([f64::NAN]), None);
    let weighted = weighted_circular_mean([(0.0, 3.0), (PI / 2.0, 0.0)]).expect("one weight");
    assert_relative_eq!(weighted, 0.0);
}

proptest! {
    #[test]
    fn wrapping_keeps_the_direction(angle in -1e4..1e4_f64) {
        let wrapped = wrap(angle);
        prop_assert!(wrapped > -PI && wrapped <= PI);
        prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9);
        prop_assert!((wrapped.cos() - angle.cos()).abs() < 1e-9);
        prop_assert!(wrap(wrapped) == wrapped);
    }

    #[test]
    fn every_size_of_angle_ends_in_the_interval(angle in proptest::num::f64::NORMAL) {
        let wrapped = wrap(angle);
        prop_assert!(wrapped > -PI && wrapped <= PI, "{angle} became {wrapped}");
    }
}
