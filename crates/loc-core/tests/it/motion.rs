use crate::finite_difference::jacobian;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::motion::{
    Chord, DrivenPath, Integration, OdometryMotion, OdometryNoise, PathNoise, VelocityNoise,
    dead_reckon,
};
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_core::{Error, Gaussian, Pose2, Twist2, angle};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The drive of E8: 140 steps of 0.1 s at 1 m/s and 24 deg/s.
fn e8(integration: Integration) -> Gaussian<3> {
    let degrees = f64::to_radians;
    let noise = VelocityNoise::from_sigmas(0.02, 0.0, degrees(2.0)).unwrap();
    let noise = VelocityNoise { turn_sigma: degrees(5.0), ..noise };
    let twist = Twist2::forward(1.0, degrees(24.0));
    (0..140).fold(Gaussian::certain(Vector3::zeros()), |belief, _| {
        dead_reckon(&belief, twist, 0.1, integration, &noise)
    })
}

/// Compares a belief with printed numbers, to their last digit: mean of the position, and the
/// upper triangle of the covariance row by row.
fn check(belief: &Gaussian<3>, mean: [f64; 2], upper: Option<[f64; 6]>) {
    assert_abs_diff_eq!(belief.mean.x, mean[0], epsilon = 0.6e-7);
    assert_abs_diff_eq!(belief.mean.y, mean[1], epsilon = 0.6e-7);
    assert_abs_diff_eq!(belief.mean.z, 5.8643063 - TAU, epsilon = 0.6e-7);
    let Some([xx, xy, xt, yy, yt, tt]) = upper else {
        return;
    };
    let printed = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
    assert_abs_diff_eq!(belief.covariance, printed, epsilon = 0.6e-8);
}

#[test]
fn e8_with_all_three_rules() {
    let euler = [0.19720637, -0.05694569, 0.05620789, 0.10291737, -0.02541687, 0.02416632];
    check(&e8(Integration::Euler), [-0.9665475, 0.2267017], Some(euler));
    let midpoint = [0.19952121, -0.05490338, 0.05671004, 0.10062718, -0.02431798, 0.02416632];
    check(&e8(Integration::Midpoint), [-0.9710832, 0.2064101], Some(midpoint));
    check(&e8(Integration::ExactArc), [-0.9710122, 0.2063950], None);
    // The exact arc and the midpoint rule part by the square of the step's turn.
    let (exact, middle) = (e8(Integration::ExactArc), e8(Integration::Midpoint));
    assert_abs_diff_eq!(exact.covariance, middle.covariance, epsilon = 1e-4);
}

#[test]
fn the_exact_arc_does_not_depend_on_the_step() {
    let twist = Twist2::new(0.7, -0.2, 0.9);
    let whole = Integration::ExactArc.step(Pose2::new(1.0, 2.0, 3.0), twist, 2.0);
    let parts = (0..50)
        .fold(Pose2::new(1.0, 2.0, 3.0), |pose, _| Integration::ExactArc.step(pose, twist, 0.04));
    assert_abs_diff_eq!(whole.to_vector(), parts.to_vector(), epsilon = 1e-12);
    let by_group = Pose2::new(1.0, 2.0, 3.0) * Pose2::exp(&(twist.to_vector() * 2.0));
    assert_abs_diff_eq!(whole.to_vector(), by_group.to_vector(), epsilon = 1e-12);
}

#[test]
fn the_rules_on_a_quarter_turn() {
    let turn = Twist2::forward(1.0, FRAC_PI_2);
    let end = |rule: Integration| rule.step(Pose2::IDENTITY, turn, 1.0).to_vector();
    let diagonal = 0.5_f64.sqrt();
    assert_abs_diff_eq!(
        end(Integration::Euler),
        Vector3::new(1.0, 0.0, FRAC_PI_2),
        epsilon = 1e-15
    );
    let midpoint = Vector3::new(diagonal, diagonal, FRAC_PI_2);
    assert_abs_diff_eq!(end(Integration::Midpoint), midpoint, epsilon = 1e-15);
    let arc = Vector3::new(2.0 / PI, 2.0 / PI, FRAC_PI_2);
    assert_abs_diff_eq!(end(Integration::ExactArc), arc, epsilon = 1e-15);
}

#[test]
fn the_chord_is_smooth_where_the_series_takes_over() {
    for phi in [0.0, 1e-300, 1e-9, 1e-3, 9.99999e-3, 0.01, 1.00001e-2, 0.02, 0.5, PI] {
        for phi in [phi, -phi] {
            let chord = Chord::exact(phi);
            let (sinc, half) = if phi == 0.0 {
                (1.0, 0.0)
            } else {
                (phi.sin() / phi, 2.0 * (0.5 * phi).sin().powi(2) / phi)
            };
            assert_abs_diff_eq!(chord.along, sinc, epsilon = 1e-15);
            assert_abs_diff_eq!(chord.across, half, epsilon = 2e-14);
            let h = 1e-5;
            let (above, below) = (Chord::exact(phi + h), Chord::exact(phi - h));
            let slope = Chord::exact_slope(phi);
            assert_abs_diff_eq!(
                slope.along,
                (above.along - below.along) / (2.0 * h),
                epsilon = 1e-9
            );
            assert_abs_diff_eq!(
                slope.across,
                (above.across - below.across) / (2.0 * h),
                epsilon = 3e-9
            );
        }
    }
}

/// Turn rates at 0, near it, on both sides of the turn where the series takes over (0.01 rad in a
/// step of 0.1 s), and anywhere.
fn turn_rates() -> impl Strategy<Value = f64> {
    let magnitude = prop_oneof![
        Just(0.0),
        Just(1e-9),
        Just(1e-3),
        0.0999..0.1001_f64,
        Just(0.1),
        0.0..20.0_f64,
    ];
    (magnitude, any::<bool>()).prop_map(|(w, left)| if left { w } else { -w })
}

/// Poses, also with headings at the seam.
fn poses() -> impl Strategy<Value = Pose2> {
    let heading = prop_oneof![-PI..PI, (-1e-8..1e-8_f64).prop_map(|off| PI + off), Just(0.0)];
    (-10.0..10.0_f64, -10.0..10.0_f64, heading).prop_map(|(x, y, theta)| Pose2::new(x, y, theta))
}

proptest! {
    #[test]
    fn step_jacobians(
        pose in poses(),
        vx in prop_oneof![Just(0.0), -2.0..2.0_f64],
        vy in prop_oneof![Just(0.0), -2.0..2.0_f64],
        omega in turn_rates(),
    ) {
        let (twist, dt) = (Twist2::new(vx, vy, omega), 0.1);
        for rule in Integration::ALL {
            let (moved, jacobians) = rule.step_with_jacobians(pose, twist, dt);
            prop_assert_eq!(moved, rule.step(pose, twist, dt));
            let by_pose = jacobian(
                |v| rule.step(Pose2::from_vector(&v), twist, dt).to_vector(),
                pose.to_vector(),
                Some(2),
            );
            prop_assert!((jacobians.by_pose - by_pose).amax() < 1e-7, "{:?} by pose", rule);
            let by_twist = jacobian(
                |v| rule.step(pose, Twist2::from_vector(&v), dt).to_vector(),
                twist.to_vector(),
                Some(2),
            );
            prop_assert!((jacobians.by_twist - by_twist).amax() < 1e-7, "{:?} by twist", rule);
        }
    }

    #[test]
    fn odometry_jacobians(
        pose in poses(),
        rot1 in -PI..PI,
        trans in prop_oneof![Just(0.0), -2.0..2.0_f64],
        rot2 in -PI..PI,
    ) {
        let step = OdometryMotion { rot1, trans, rot2 };
        let (moved, by_pose, by_step) = step.apply_with_jacobians(pose);
        prop_assert_eq!(moved, step.apply(pose));
        let of_pose = |v: Vector3<f64>| step.apply(Pose2::from_vector(&v)).to_vector();
        prop_assert!((by_pose - jacobian(of_pose, pose.to_vector(), Some(2))).amax() < 1e-7);
        let of_step = |v: Vector3<f64>| {
            OdometryMotion { rot1: v.x, trans: v.y, rot2: v.z }.apply(pose).to_vector()
        };
        let numeric = jacobian(of_step, Vector3::new(rot1, trans, rot2), Some(2));
        prop_assert!((by_step - numeric).amax() < 1e-7);
    }

    #[test]
    fn odometry_steps_lead_where_they_were_read(from in poses(), to in poses(), scale in 0.0..1.0_f64) {
        // From far apart down to standing still.
        let to = Pose2::new(
            from.x + scale.powi(8) * (to.x - from.x),
            from.y + scale.powi(8) * (to.y - from.y),
            to.theta,
        );
        let step = OdometryMotion::between(from, to);
        let back = step.apply(from);
        let lost = if from.distance(to) < 2.0 * OdometryMotion::MIN_TRANSLATION { 2e-6 } else { 1e-12 };
        prop_assert!(back.distance(to) <= lost, "{back} instead of {to}");
        prop_assert!(angle::difference(back.theta, to.theta).abs() < 1e-12);
        prop_assert!(step.rot1.abs() <= FRAC_PI_2 + 1e-12, "never turns round to drive");
    }
}

#[test]
fn odometry_steps_by_hand() {
    let from = Pose2::new(1.0, 1.0, FRAC_PI_2);
    let ahead = OdometryMotion::between(from, Pose2::new(0.0, 2.0, PI));
    assert_abs_diff_eq!(ahead.rot1, PI / 4.0, epsilon = 1e-12);
    assert_abs_diff_eq!(ahead.trans, 2_f64.sqrt(), epsilon = 1e-12);
    assert_abs_diff_eq!(ahead.rot2, PI / 4.0, epsilon = 1e-12);
    let backwards = OdometryMotion::between(from, Pose2::new(1.0, 0.5, FRAC_PI_2));
    assert_abs_diff_eq!(backwards.rot1, 0.0, epsilon = 1e-12);
    assert_abs_diff_eq!(backwards.trans, -0.5, epsilon = 1e-12);
    assert_abs_diff_eq!(backwards.rot2, 0.0, epsilon = 1e-12);
    let spot = OdometryMotion::between(from, Pose2::new(1.0, 1.0, -3.0));
    assert_eq!((spot.rot1, spot.trans), (0.0, 0.0));
    assert_abs_diff_eq!(spot.rot2, angle::difference(-3.0, FRAC_PI_2), epsilon = 1e-12);
}

#[test]
fn the_jitter_of_a_standing_robot_does_not_add_up() {
    let (a, b) = (Pose2::IDENTITY, Pose2::new(-1e-7, 0.0, 0.0));
    let there_and_back = OdometryMotion::between(a, b).trans + OdometryMotion::between(b, a).trans;
    assert_eq!(there_and_back, 0.0);
}

#[test]
fn samples_of_an_odometry_step_have_its_variances() {
    let noise = OdometryNoise { alpha1: 0.01, alpha2: 0.004, alpha3: 0.02, alpha4: 0.005 };
    let step = OdometryMotion { rot1: 0.4, trans: -2.0, rot2: 3.1 };
    let variances = step.variances(&noise);
    let by_hand = Vector3::new(
        0.01 * 0.16 + 0.004 * 4.0,
        0.02 * 4.0 + 0.005 * (0.16 + 9.61),
        0.01 * 9.61 + 0.004 * 4.0,
    );
    assert_relative_eq!(variances, by_hand, epsilon = 1e-15);
    let mut rng = stream(10, "odometry");
    let mut moments = [RunningMoments::new(); 3];
    for _ in 0..50_000 {
        let drawn = step.sample(&noise, &mut rng);
        assert!(drawn.rot2 > -PI && drawn.rot2 <= PI, "turns stay wrapped");
        moments[0].push(drawn.rot1 - step.rot1).unwrap();
        moments[1].push(drawn.trans - step.trans).unwrap();
        moments[2].push(angle::difference(drawn.rot2, step.rot2)).unwrap();
    }
    for (found, variance) in moments.iter().zip(&variances) {
        let deviation = variance.sqrt();
        assert_abs_diff_eq!(found.mean().unwrap() / deviation, 0.0, epsilon = 0.02);
        assert_abs_diff_eq!(found.variance().unwrap() / variance, 1.0, epsilon = 0.03);
    }
}

/// The belief after driving 4 m straight in `steps` equal steps.
fn straight(steps: u32, heading: f64, noise: &VelocityNoise) -> Gaussian<3> {
    let dt = 4.0 / f64::from(steps);
    let start = Gaussian::certain(Vector3::new(1.0, 2.0, heading));
    (0..steps).fold(start, |belief, _| {
        dead_reckon(&belief, Twist2::forward(-1.0, 0.0), dt, Integration::ExactArc, noise)
    })
}

#[test]
fn the_error_of_a_straight_drive_does_not_depend_on_the_steps() {
    let noise = VelocityNoise::from_sigmas(0.05, 0.1, 0.03).unwrap();
    for steps in [1, 2, 40, 1000] {
        let covariance = straight(steps, 0.0, &noise).covariance;
        assert_relative_eq!(covariance.m11, 4.0 * noise.k_d(), epsilon = 1e-12);
        assert_relative_eq!(covariance.m33, 4.0 * noise.k_drift(), epsilon = 1e-12);
        // Sideways the heading's random walk adds up to k_drift d^3 / 3, from below: the error
        // within a step acts from its middle.
        let n = f64::from(steps);
        let sideways = noise.k_drift() * 64.0 / 3.0 * (1.0 - 0.25 / (n * n));
        assert_relative_eq!(covariance.m22, sideways, epsilon = 1e-12);
        assert_relative_eq!(covariance.m23, -noise.k_drift() * 8.0, epsilon = 1e-12);
    }
    // Without drift, the whole covariance is the same, in every direction.
    let noise = VelocityNoise { drift_sigma: 0.0, ..noise };
    let (coarse, fine) = (straight(1, 0.7, &noise), straight(500, 0.7, &noise));
    assert_abs_diff_eq!(coarse.mean, fine.mean, epsilon = 1e-12);
    assert_abs_diff_eq!(coarse.covariance, fine.covariance, epsilon = 1e-14);
}

#[test]
fn velocity_noise_by_hand() {
    let noise = VelocityNoise::from_sigmas(0.05, 5_f64.to_radians(), 2_f64.to_radians()).unwrap();
    assert_relative_eq!(noise.k_d(), 0.0025, epsilon = 1e-15);
    assert_relative_eq!(noise.k_theta(), 5_f64.to_radians().powi(2) / TAU, epsilon = 1e-15);
    let variances = noise.variances(Twist2::new(-3.0, 4.0, -0.5), 0.1);
    let turning = 10.0 * (noise.k_theta() * 0.5 + noise.k_drift() * 5.0);
    assert_relative_eq!(variances, Vector3::new(0.075, 0.1, turning), epsilon = 1e-13);
    assert_eq!(noise.variances(Twist2::forward(1.0, 1.0), 0.0), Vector3::zeros());
    assert_eq!(noise.variances(Twist2::ZERO, 0.1), Vector3::zeros());
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        for sigmas in [[bad, 0.0, 0.0], [0.0, bad, 0.0], [0.0, 0.0, bad]] {
            let [distance, turn, drift] = sigmas;
            let noise = VelocityNoise::from_sigmas(distance, turn, drift);
            assert!(matches!(noise, Err(Error::OutOfRange { .. })));
        }
    }
}

fn path(poses: &[Pose2]) -> DrivenPath {
    let mut path = DrivenPath::starting_at(poses[0]);
    poses[1..].iter().for_each(|pose| path.extend(*pose));
    path
}

/// Out and back: the way counts, not where it ends.
#[test]
fn variances_add_up_along_the_way() {
    let turned = Pose2::new(2.0, 0.0, 0.5);
    let there_and_back = path(&[Pose2::IDENTITY, turned, Pose2::IDENTITY]);
    assert_eq!((there_and_back.length(), there_and_back.turned()), (4.0, 1.0));
    let noise = PathNoise::default().along(0.1).across(0.2).pivot(0.05);
    let variances = noise.variances(&there_and_back);
    assert_relative_eq!(variances.x, 4.0 * 0.01 + 0.0025, epsilon = 1e-15);
    assert_relative_eq!(variances.y, 4.0 * 0.04 + 0.0025, epsilon = 1e-15);
    let heading = 4.0 * 3_f64.to_radians().powi(2) + 5_f64.to_radians().powi(2);
    assert_relative_eq!(variances.z, heading, epsilon = 1e-15);
}

#[test]
fn the_step_is_linearised_right() {
    let way = path(&[Pose2::new(1.0, 2.0, 0.4), Pose2::new(1.8, 2.6, 1.1)]);
    let pose = Pose2::new(-3.0, 5.0, 2.9);
    let step = PathNoise::step(&way, pose, &Vector3::new(0.01, 0.02, 0.03));
    let moved = |x: Vector3<f64>| (Pose2::from_vector(&x) * way.step()).to_vector();
    let numeric = jacobian(moved, pose.to_vector(), Some(2));
    assert_abs_diff_eq!(step.by_pose, numeric, epsilon = 1e-8);
    assert_eq!(step.pose, pose * way.step());
    // An error of the heading comes to be evenly on the way: half of it turns the whole step.
    let erring = |error: Vector3<f64>| {
        let turn = Pose2::new(0.0, 0.0, 0.5 * error.z);
        let at_the_end = Pose2::new(error.x, error.y, 0.0);
        let end = pose * at_the_end * turn * way.step() * turn;
        end.to_vector()
    };
    let by_noise = jacobian(erring, Vector3::zeros(), Some(2));
    let variances = nalgebra::Matrix3::from_diagonal(&Vector3::new(0.01, 0.02, 0.03));
    let noise = by_noise * variances * by_noise.transpose();
    assert_abs_diff_eq!(step.noise, noise, epsilon = 1e-8);
}

/// E7: however many steps a straight way is cut into, heading and distance vary as much.
#[test]
fn cutting_a_way_changes_little() {
    let noise = PathNoise::default();
    let ahead = |x: f64| Pose2::new(x, 0.0, 0.0);
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let whole = noise.belief_after(&path(&[ahead(0.0), ahead(2.0)]), &start);
    let cut = (0..200).fold(start, |belief, k| {
        let step = path(&[ahead(0.01 * f64::from(k)), ahead(0.01 * f64::from(k + 1))]);
        noise.belief_after(&step, &belief)
    });
    assert_relative_eq!(whole.covariance.m11, cut.covariance.m11, epsilon = 1e-12);
    assert_relative_eq!(whole.covariance.m33, cut.covariance.m33, epsilon = 1e-12);
    assert_relative_eq!(whole.covariance.m23, cut.covariance.m23, max_relative = 0.01);
    // Half the turn over the whole way has 3/4 of the variance across of turns along the way.
    let drift = noise.drift.powi(2);
    assert_relative_eq!(
        cut.covariance.m22 - 2.0 * noise.across.powi(2),
        8.0 / 3.0 * drift,
        max_relative = 0.01
    );
    assert_relative_eq!(
        whole.covariance.m22 - 2.0 * noise.across.powi(2),
        2.0 * drift,
        max_relative = 1e-9
    );
}

#[test]
fn bad_noise_is_named() {
    for (noise, message) in [
        (PathNoise::default().along(-1.0), "PathNoise.along: "),
        (PathNoise::default().turn(f64::NAN), "PathNoise.turn: "),
        (PathNoise::default().fault_probability(1.5), "PathNoise.fault_probability: "),
    ] {
        assert!(noise.check().unwrap_err().to_string().contains(message));
    }
}
