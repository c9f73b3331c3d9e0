//! The model of a line, and one correction with it.

use super::{all_around, map, seen, settings};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, angle};
use loc_filters::MeasurementModel;
use loc_filters::line_matching::{LineEkf, LineModel};
use loc_maps::line::NormalForm;
use loc_maps::{LineMap, LineSegment};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};
use rand::RngExt;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

#[test]
fn a_wall_by_hand() {
    // The scanner sits at (1, 2.2), looking along y; the wall x = 4 is 3 m to its right.
    let wall = NormalForm { r: 4.0, alpha: 0.0 };
    let model = LineModel::new(wall, Pose2::new(0.2, 0.0, 0.0));
    let state = Vector3::new(1.0, 2.0, FRAC_PI_2);
    assert_abs_diff_eq!(model.predict(&state), Vector2::new(3.0, -FRAC_PI_2), epsilon = 1e-15);
    let h = model.jacobian(&state);
    let by_hand = Matrix2x3::new(-1.0, 0.0, 0.2, 0.0, 0.0, -1.0);
    assert_abs_diff_eq!(h, by_hand, epsilon = 1e-15);
    // From beyond the wall, and measured from this side of it all the same.
    let beyond = Vector3::new(4.1, 2.0, FRAC_PI_2);
    assert_abs_diff_eq!(model.predict(&beyond), Vector2::new(0.1, FRAC_PI_2), epsilon = 1e-15);
    let measured = model.measured(-1.6, Matrix2::identity());
    assert_abs_diff_eq!(measured.predict(&beyond), Vector2::new(-0.1, -FRAC_PI_2), epsilon = 1e-15);
    let residual = measured.residual(&Vector2::new(0.05, 3.1), &Vector2::new(-0.1, -3.1));
    assert_abs_diff_eq!(residual, Vector2::new(0.15, 6.2 - TAU), epsilon = 1e-12);
}

#[test]
fn jacobians_are_the_slopes() {
    let mut rng = stream(3, "lines");
    for _ in 0..300 {
        let mut random = |scale: f64| scale * (2.0 * rng.random::<f64>() - 1.0);
        let state = Vector3::new(random(5.0), random(5.0), random(3.1));
        let mounting = Pose2::new(random(0.5), random(0.5), random(3.0));
        let wall = NormalForm { r: random(4.0).abs(), alpha: random(PI) };
        let model = LineModel::new(wall, mounting).measured(random(PI), Matrix2::identity());
        // At a right angle to what was measured, the sides change.
        let alpha = wall.alpha - state.z - mounting.theta;
        if (alpha - model.predict(&state).y).sin().abs() > 0.99 {
            continue;
        }
        let mut slope = Matrix2x3::zeros();
        for column in 0..3 {
            let (mut above, mut below) = (state, state);
            above[column] += 1e-6;
            below[column] -= 1e-6;
            let difference = model.residual(&model.predict(&above), &model.predict(&below));
            slope.set_column(column, &(difference / 2e-6));
        }
        assert_abs_diff_eq!(model.jacobian(&state), slope, epsilon = 1e-7);
    }
}

/// One line through the filter against the formulas of H1 on plain matrices.
#[test]
fn one_line_against_plain_matrices() {
    let start = Gaussian::new(
        Vector3::new(1.0, 1.2, 0.1),
        Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.05, 0.002, 0.0, 0.002, 0.01),
    )
    .unwrap();
    let mut defaults = settings();
    (defaults.robot.path.min_position, defaults.robot.path.min_heading) = (0.0, 0.0);
    let mut ekf = LineEkf::new(map("4,-3,4,3\n"), defaults, start).unwrap();
    let line = seen(Pose2::new(1.1, 1.1, 0.15), [4.0, -2.0], [4.0, 2.0], [0.02, 0.01]);
    let update = ekf.lines(vec![line], all_around(), Pose2::IDENTITY).unwrap();
    assert_eq!(update.matched(), 1);

    let h = Matrix2x3::new(-1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    let s = h * start.covariance * h.transpose() + line.covariance;
    let gain = start.covariance * h.transpose() * s.try_inverse().unwrap();
    let residual = Vector2::new(-0.1, -0.05);
    assert_abs_diff_eq!(ekf.belief().mean, start.mean + gain * residual, epsilon = 1e-12);
    let covariance = (Matrix3::identity() - gain * h) * start.covariance;
    assert_abs_diff_eq!(ekf.belief().covariance, covariance, epsilon = 1e-12);
    let innovation = update.pairs[0].unwrap().innovation;
    assert_abs_diff_eq!(innovation.residual, residual, epsilon = 1e-12);
}

/// The uncertainty of a map line as the scanner sees it, by moving its ends.
#[test]
fn ends_of_map_lines_that_are_off_move_r_and_alpha() {
    let (sigma, pose) = (0.03, Pose2::new(-1.0, 0.5, 0.4));
    let wall = LineSegment::new([1.0, 3.0], [4.0, 2.0]);
    let with_map = settings().map_sigma(sigma);
    let ekf = LineEkf::new(LineMap::new([wall]).unwrap(), with_map, pose_belief(pose, [0.01; 3]));
    let predicted = ekf.unwrap().predicted(all_around(), Pose2::IDENTITY).unwrap();
    let across = Vector2::new(1.0, 3.0).normalize();
    let expected = predicted[0].normal_form;
    let (mut sum, mut rng, draws) = (Matrix2::zeros(), stream(5, "ends"), 20_000);
    for _ in 0..draws {
        let draw = pose_belief(Pose2::IDENTITY, [sigma, sigma, 0.0]).sample(&mut rng);
        let moved =
            LineSegment { start: wall.start + across * draw.x, end: wall.end + across * draw.y };
        let form = moved.seen_from(pose).normal_form();
        let off = Vector2::new(form.r - expected.r, angle::difference(form.alpha, expected.alpha));
        sum += off * off.transpose();
    }
    let sampled = sum / f64::from(draws);
    assert_relative_eq!(predicted[0].covariance, sampled, max_relative = 0.04, epsilon = 1e-9);
}
