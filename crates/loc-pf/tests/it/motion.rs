//! Motion models: exact without noise, right in their noise, quiet where the robot is.

use loc_core::kinematics::Ackermann;
use loc_core::motion::{Integration, OdometryMotion, OdometryNoise, VelocityNoise};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2, angle};
use loc_pf::motion::{
    AckermannStep, DifferentialStep, OmnidirectionalNoise, OmnidirectionalStep, VelocityStep,
};
use loc_pf::{Motion, Particles, Workers};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};

const QUIET: OdometryNoise = OdometryNoise { alpha1: 0.0, alpha2: 0.0, alpha3: 0.0, alpha4: 0.0 };
const NOISE: OdometryNoise =
    OdometryNoise { alpha1: 0.1, alpha2: 0.02, alpha3: 0.05, alpha4: 0.01 };
const SAMPLES: usize = 100_000;

/// Poses all around, some of them at the seam of the headings.
fn poses() -> Vec<Pose2> {
    let headings = (0..40).map(|k| -PI + 0.157 * f64::from(k) + 1e-9).chain([PI, -PI + 1e-15, 0.0]);
    headings.enumerate().map(|(k, h)| Pose2::new(k as f64 - 20.0, 3.0 * h, h)).collect()
}

/// What a motion without noise does to [`poses`] must be what `expected` does.
fn assert_exact(motion: &impl Motion, expected: impl Fn(Pose2) -> Pose2) {
    let mut cloud = Particles::from_poses(poses());
    motion.sample(cloud.poses_mut(), &mut stream(1, "motion"));
    for (moved, before) in cloud.poses().iter().zip(poses()) {
        let exact = expected(before);
        let error =
            [moved.x - exact.x, moved.y - exact.y, angle::difference(moved.theta, exact.theta)];
        assert!(error.iter().all(|e| e.abs() < 1e-12), "{before:?}: {moved:?}, not {exact:?}");
        assert!(moved.theta > -PI && moved.theta <= PI);
    }
}

/// Mean and covariance of a motion from one pose.
fn moments(motion: &impl Motion, from: Pose2, seed: u64) -> (Vector3<f64>, Matrix3<f64>) {
    let mut cloud = Particles::from_poses(vec![from; SAMPLES]);
    Workers::one().sample(&mut cloud, motion, &mut stream(seed, "motion"));
    let moved: Vec<_> = cloud.poses().iter().map(Pose2::to_vector).collect();
    let mean = moved.iter().sum::<Vector3<f64>>() / SAMPLES as f64;
    let deviations = moved.iter().map(|pose| (pose - mean) * (pose - mean).transpose());
    (mean, deviations.sum::<Matrix3<f64>>() / SAMPLES as f64)
}

/// Two estimates from as many samples are the same within five standard errors.
fn assert_same(a: (Vector3<f64>, Matrix3<f64>), b: (Vector3<f64>, Matrix3<f64>)) {
    let sigma = |k: usize| b.1[(k, k)].sqrt();
    let error = 5.0 * 2_f64.sqrt() / (SAMPLES as f64).sqrt();
    for row in 0..3 {
        assert!((a.0[row] - b.0[row]).abs() <= error * sigma(row) + 1e-12, "{} {}", a.0, b.0);
        for column in 0..3 {
            let allowed = error * 2_f64.sqrt() * sigma(row) * sigma(column) + 1e-12;
            assert!((a.1 - b.1)[(row, column)].abs() <= allowed, "{} {}", a.1, b.1);
        }
    }
}

#[test]
fn without_noise_every_pose_moves_exactly() {
    for to in [Pose2::new(0.3, 0.1, 0.7), Pose2::new(-2.0, 0.4, -3.0), Pose2::new(0.0, 0.0, PI)] {
        let motion = OdometryMotion::between(Pose2::IDENTITY, to);
        let step = DifferentialStep::new(motion, &QUIET).unwrap();
        assert_exact(&step, |pose| motion.apply(pose));
        let quiet = OmnidirectionalNoise {
            alpha1: 0.0,
            alpha2: 0.0,
            alpha3: 0.0,
            alpha4: 0.0,
            alpha5: 0.0,
        };
        let from = Pose2::new(4.0, -1.0, 2.0);
        let step = OmnidirectionalStep::between(from, from * to, &quiet).unwrap();
        assert_exact(&step, |pose| pose * to);
    }
    for twist in
        [Twist2::new(1.0, 0.3, 0.8), Twist2::forward(-1.0, 1e-5), Twist2::new(0.0, 0.0, 9.0)]
    {
        for rule in Integration::ALL {
            let step = VelocityStep::new(twist, 0.5, &VelocityNoise::NONE, rule).unwrap();
            assert_exact(&step, |pose| rule.step(pose, twist, 0.5));
        }
    }
    let car = Ackermann::new(0.4).unwrap();
    for [speed, steering] in [[1.5, 0.4], [-1.0, -1.2], [2.0, 0.0]] {
        let step = AckermannStep::new(&car, [speed, steering], [0.0, 0.0], 0.3).unwrap();
        let twist = car.twist(speed, steering);
        assert_exact(&step, |pose| Integration::ExactArc.step(pose, twist, 0.3));
    }
}

#[test]
fn peers_16_a_robot_that_stands_still_keeps_its_particles_to_the_bit() {
    let still = [
        DifferentialStep::between(Pose2::IDENTITY, Pose2::IDENTITY, &NOISE).unwrap().sigmas(),
        OmnidirectionalStep::between(Pose2::IDENTITY, Pose2::IDENTITY, &Default::default())
            .unwrap()
            .sigmas(),
    ];
    assert_eq!(still, [[0.0; 3]; 2]);
    let before = Particles::from_poses(poses());
    let mut cloud = before.clone();
    let step = DifferentialStep::between(poses()[3], poses()[3], &NOISE).unwrap();
    step.sample(cloud.poses_mut(), &mut stream(1, "motion"));
    let step = VelocityStep::new(Twist2::ZERO, 0.1, &Default::default(), Integration::ExactArc);
    step.unwrap().sample(cloud.poses_mut(), &mut stream(1, "motion"));
    assert_eq!(cloud, before);
}

#[test]
fn peers_16_no_wobble_when_turning_on_the_spot() {
    let turn = 0.5;
    let exact = DifferentialStep::between(Pose2::IDENTITY, Pose2::new(0.0, 0.0, turn), &NOISE);
    let expected = (NOISE.alpha1 * turn * turn).sqrt();
    for direction in [0.3, 1.5, FRAC_PI_2, 2.0, -1.6, 3.0] {
        // Wheels slip by half a millimetre in any direction.
        let (sin, cos) = f64::sin_cos(direction);
        let to = Pose2::new(5e-4 * cos, 5e-4 * sin, turn);
        let step = DifferentialStep::between(Pose2::IDENTITY, to, &NOISE).unwrap();
        let [rot1, trans, rot2] = step.sigmas();
        assert!((f64::hypot(rot1, rot2) - expected).abs() < 0.02 * expected, "{direction}");
        let still = exact.as_ref().unwrap().sigmas()[1];
        assert!((trans - still).abs() < 0.02 * still, "{direction}: {trans}");
        // The step itself stays.
        let end = step.motion().apply(Pose2::IDENTITY);
        assert!((end.x - to.x).abs() < 1e-15 && (end.y - to.y).abs() < 1e-15);
    }
    // Where the robot really drives, the noise is the textbook's.
    let motion = OdometryMotion { rot1: 0.4, trans: 0.25, rot2: 0.3 };
    let textbook = motion.variances(&NOISE).map(f64::sqrt);
    let step = DifferentialStep::new(motion, &NOISE).unwrap();
    for (ours, textbook) in step.sigmas().iter().zip(&textbook) {
        assert!((ours / textbook - 1.0).abs() < 3e-3, "{ours} {textbook}");
    }
}

#[test]
fn peers_16_backward_motion_is_as_quiet_as_forward_motion() {
    for (x, y, turn) in [(0.5, 0.02, 0.1), (0.2, 0.1, -0.4), (1.0, 0.0, 0.0)] {
        let forward = DifferentialStep::between(Pose2::IDENTITY, Pose2::new(x, y, turn), &NOISE);
        let back = DifferentialStep::between(Pose2::IDENTITY, Pose2::new(-x, -y, turn), &NOISE);
        for (forward, back) in forward.unwrap().sigmas().iter().zip(back.unwrap().sigmas()) {
            assert!((forward - back).abs() < 1e-12, "{x} {y} {turn}");
        }
    }
}

#[test]
fn differential_noise_is_that_of_draws_one_by_one() {
    let motion = OdometryMotion { rot1: 0.3, trans: 1.2, rot2: -0.5 };
    let from = Pose2::new(1.0, 2.0, 0.9);
    let ours = moments(&DifferentialStep::new(motion, &NOISE).unwrap(), from, 1);
    let one_by_one = |pose: Pose2, rng: &mut ChaCha8Rng| motion.sample(&NOISE, rng).apply(pose);
    assert_same(ours, moments(&one_by_one, from, 2));
}

#[test]
fn velocity_noise_has_the_covariance_asked_for() {
    let control = Matrix3::new(0.04, 0.01, -0.006, 0.01, 0.02, 0.004, -0.006, 0.004, 0.03);
    let (twist, dt) = (Twist2::new(0.8, -0.2, 0.5), 0.5);
    let step = VelocityStep::with_covariance(twist, dt, &control, Integration::Euler).unwrap();
    let (mean, covariance) = moments(&step, Pose2::IDENTITY, 3);
    assert_same((mean, covariance), (twist.to_vector() * dt, control * dt * dt));
    // The error model of the lectures, through the exact arc, against draws of the velocity.
    let noise =
        VelocityNoise::from_sigmas(0.1, (0.02 * std::f64::consts::TAU).sqrt(), 0.005_f64.sqrt())
            .unwrap();
    let step = VelocityStep::new(twist, dt, &noise, Integration::ExactArc).unwrap();
    let belief = loc_core::Gaussian::new(twist.to_vector(), noise.covariance(twist, dt)).unwrap();
    let one_by_one = |pose: Pose2, rng: &mut ChaCha8Rng| {
        Integration::ExactArc.step(pose, Twist2::from_vector(&belief.sample(rng)), dt)
    };
    let from = Pose2::new(-3.0, 1.0, -0.4);
    assert_same(moments(&step, from, 4), moments(&one_by_one, from, 5));
}

#[test]
fn omnidirectional_noise_lies_along_and_across_the_way() {
    let noise = OmnidirectionalNoise {
        alpha1: 0.1,
        alpha2: 0.02,
        alpha3: 0.05,
        alpha4: 0.01,
        alpha5: 0.002,
    };
    // 0.5 m to the left and ahead, with a turn of 0.2.
    let step = OmnidirectionalStep::between(Pose2::IDENTITY, Pose2::new(0.3, 0.4, 0.2), &noise);
    let (way, turn) = (0.25, 0.04);
    let variances = [0.05 * way + 0.01 * turn, 0.002 * way + 0.01 * turn, 0.1 * turn + 0.02 * way];
    for heading in [0.0, 2.0] {
        let from = Pose2::new(0.0, 0.0, heading);
        let direction = nalgebra::Rotation3::from_axis_angle(
            &Vector3::z_axis(),
            heading + f64::atan2(0.4, 0.3),
        );
        let along = direction.matrix();
        let expected = along * Matrix3::from_diagonal(&variances.into()) * along.transpose();
        let mean = (from * Pose2::new(0.3, 0.4, 0.2)).to_vector();
        assert_same(moments(step.as_ref().unwrap(), from, 6), (mean, expected));
    }
}

#[test]
fn ackermann_noise_is_that_of_draws_one_by_one() {
    let car = Ackermann::new(0.5).unwrap();
    let step = AckermannStep::new(&car, [1.0, 0.3], [0.1, 0.05], 0.4).unwrap();
    let [speed, steering] =
        [(1.0, 0.1), (0.3, 0.05)].map(|(mean, sigma)| loc_core::Normal::new(mean, sigma).unwrap());
    let one_by_one = |pose: Pose2, rng: &mut ChaCha8Rng| {
        let twist = car.twist(speed.sample(rng), steering.sample(rng));
        Integration::ExactArc.step(pose, twist, 0.4)
    };
    let from = Pose2::new(1.0, 1.0, 1.0);
    assert_same(moments(&step, from, 7), moments(&one_by_one, from, 8));
}

#[test]
fn peers_14_the_same_for_any_number_of_threads_and_on_every_machine() {
    let motion = OdometryMotion { rot1: 0.25, trans: 1.5, rot2: -0.5 };
    let step = DifferentialStep::new(motion, &NOISE).unwrap();
    let run = |threads| {
        let mut cloud = Particles::from_poses(vec![Pose2::new(1.0, 2.0, 3.0); 3001]);
        let workers = Workers::new(threads).unwrap();
        let mut rng = stream(9, "motion");
        for _ in 0..3 {
            workers.sample(&mut cloud, &step, &mut rng);
        }
        cloud
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(3));
    let poses = one.poses();
    let numbers = poses.iter().flat_map(|pose| [pose.x, pose.y, pose.theta]);
    let bits = super::fnv1a(numbers.map(f64::to_bits));
    assert_eq!(bits, 0x4d8c_e0d1_df31_28c3, "{bits:#x}");
}

#[test]
fn absurd_noise_leaves_poses_finite() {
    let huge = OdometryNoise { alpha1: 1e300, alpha2: 1e300, alpha3: 1e300, alpha4: 1e300 };
    let to = Pose2::new(100.0, -30.0, 3.0);
    let mut cloud = Particles::from_poses(poses());
    for _ in 0..100 {
        let step = DifferentialStep::between(Pose2::IDENTITY, to, &huge).unwrap();
        step.sample(cloud.poses_mut(), &mut stream(1, "motion"));
        let covariance = Matrix3::identity() * 1e30;
        let step =
            VelocityStep::with_covariance(Twist2::ZERO, 1e-7, &covariance, Integration::ExactArc);
        step.unwrap().sample(cloud.poses_mut(), &mut stream(1, "motion"));
        let car = Ackermann::new(1e-6).unwrap();
        let step = AckermannStep::new(&car, [1e6, 1.4], [1e8, 1e8], 1.0).unwrap();
        step.sample(cloud.poses_mut(), &mut stream(1, "motion"));
    }
    for pose in cloud.poses().iter() {
        assert!(pose.x.is_finite() && pose.y.is_finite(), "{pose:?}");
        assert!(pose.theta > -PI && pose.theta <= PI, "{pose:?}");
    }
}

#[test]
fn bad_steps_and_noise_are_refused() {
    let nan = Pose2 { x: f64::NAN, y: 0.0, theta: 0.0 };
    let far = Pose2::new(1e300, 0.0, 0.0);
    for to in [nan, far] {
        assert!(DifferentialStep::between(Pose2::IDENTITY, to, &NOISE).is_err());
        assert!(OmnidirectionalStep::between(Pose2::IDENTITY, to, &Default::default()).is_err());
    }
    let negative = OdometryNoise { alpha3: -0.1, ..NOISE };
    let error = DifferentialStep::new(OdometryMotion::default(), &negative).unwrap_err();
    assert_eq!(error.to_string(), "alpha3: expected a finite number >= 0, got -0.1");
    let strafe = OmnidirectionalNoise { alpha5: f64::NAN, ..Default::default() };
    assert!(OmnidirectionalStep::between(Pose2::IDENTITY, Pose2::IDENTITY, &strafe).is_err());
    let (twist, rule) = (Twist2::forward(1.0, 0.0), Integration::ExactArc);
    assert!(VelocityStep::new(twist, -0.1, &VelocityNoise::NONE, rule).is_err());
    assert!(VelocityStep::new(twist, f64::INFINITY, &VelocityNoise::NONE, rule).is_err());
    let odd = Matrix3::new(1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0);
    assert!(VelocityStep::with_covariance(twist, 0.1, &odd, rule).is_err());
    let car = Ackermann::new(0.5).unwrap();
    for (control, sigmas) in
        [([f64::NAN, 0.0], [0.0, 0.0]), ([1.0, 1.5], [0.0, 0.0]), ([1.0, 0.0], [0.1, -0.1])]
    {
        assert!(AckermannStep::new(&car, control, sigmas, 0.1).is_err());
    }
}
