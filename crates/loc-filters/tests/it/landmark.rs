use approx::assert_relative_eq;
use loc_core::gaussian::pose_belief;
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::RobotSettings;
use loc_filters::delayed::Delayed;
use loc_filters::landmark::{LandmarkEkf, LandmarkLocalizer};
use loc_filters::localizer::{Decision, Localizer};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::{
    LandmarkCamera, LandmarkNoise, LandmarkObservation, Observed, ObservedKind,
};
use nalgebra::{DMatrix, DVector, Matrix3};

fn map() -> LandmarkMap {
    LandmarkMap::new([
        Landmark::planar(1, 4.0, 0.0),
        Landmark::planar(2, 0.0, 4.0),
        Landmark::planar(3, -3.0, -3.0),
    ])
    .unwrap()
}

fn see(landmark: u32, range: f64, bearing: f64) -> LandmarkObservation {
    LandmarkObservation { landmark, observed: Observed::RangeBearing { range, bearing } }
}

/// One landmark through the whole filter, against the formulas of H1 and H2 on plain matrices.
#[test]
fn one_step_against_plain_matrices() {
    let (twist, dt) = (Twist2::forward(1.0, 0.4), 0.1);
    let start = Gaussian::new(
        nalgebra::Vector3::new(0.5, -0.2, 0.3),
        Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.05, 0.002, 0.0, 0.002, 0.01),
    )
    .unwrap();
    let settings = RobotSettings::default().integration(Integration::Euler);
    let mut ekf = LandmarkEkf::new(start, settings).unwrap();
    ekf.predict(twist, dt).unwrap();
    ekf.correct(&map(), &see(1, 3.4, -0.25)).unwrap();

    let dyn3 = |m: &Matrix3<f64>| DMatrix::from_iterator(3, 3, m.iter().copied());
    let (x, y, th) = (0.5 + 0.1 * 0.3_f64.cos(), -0.2 + 0.1 * 0.3_f64.sin(), 0.34);
    let gx = DMatrix::from_row_slice(
        3,
        3,
        &[1., 0., -0.1 * 0.3_f64.sin(), 0., 1., 0.1 * 0.3_f64.cos(), 0., 0., 1.],
    );
    let gu =
        DMatrix::from_row_slice(3, 2, &[0.1 * 0.3_f64.cos(), 0., 0.1 * 0.3_f64.sin(), 0., 0., 0.1]);
    let noise = VelocityNoise::default();
    let su = DMatrix::from_diagonal(&DVector::from_vec(vec![
        noise.k_d() / dt,
        noise.k_theta() / dt * 0.4 + noise.k_drift() / dt,
    ]));
    let p = &gx * dyn3(&start.covariance) * gx.transpose() + &gu * su * gu.transpose();
    let (dx, dy) = (x - 4.0, y);
    let r = dx.hypot(dy);
    let h = DMatrix::from_row_slice(2, 3, &[dx / r, dy / r, 0., -dy / r / r, dx / r / r, -1.]);
    let q = DMatrix::from_diagonal(&DVector::from_vec(vec![
        0.05_f64.powi(2),
        1_f64.to_radians().powi(2),
    ]));
    let k = &p * h.transpose() * (&h * &p * h.transpose() + q).try_inverse().unwrap();
    let residual = DVector::from_vec(vec![3.4 - r, -0.25 - ((-dy).atan2(-dx) - th)]);
    let mean = DVector::from_vec(vec![x, y, th]) + &k * residual;
    let covariance = (DMatrix::identity(3, 3) - &k * h) * p;
    for i in 0..3 {
        assert_relative_eq!(ekf.belief().mean[i], mean[i], epsilon = 1e-10);
        for j in 0..3 {
            assert_relative_eq!(
                ekf.belief().covariance[(i, j)],
                covariance[(i, j)],
                epsilon = 1e-10
            );
        }
    }
}

#[test]
fn unknown_landmarks_and_outliers_change_nothing() {
    let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
    let mut ekf = LandmarkEkf::new(start, RobotSettings::default()).unwrap();
    let unknown = ekf.correct(&map(), &see(77, 4.0, 0.0)).unwrap();
    assert_eq!((unknown.decision, unknown.nis), (Decision::UnknownLandmark, None));
    let wrong_number = ekf.correct(&map(), &see(2, 4.0, 0.0)).unwrap();
    assert!(!wrong_number.accepted() && wrong_number.nis.unwrap() > 100.0);
    assert_eq!(*ekf.belief(), start);
    for observed in [
        Observed::RangeBearing { range: -1.0, bearing: 0.0 },
        Observed::RangeBearing { range: 1.0, bearing: f64::NAN },
        Observed::Range { range: f64::INFINITY },
    ] {
        assert!(ekf.correct(&map(), &LandmarkObservation { landmark: 1, observed }).is_err());
    }
    assert!(ekf.predict(Twist2::forward(f64::NAN, 0.0), 0.1).is_err());
    assert!(ekf.predict(Twist2::ZERO, -0.1).is_err());
    assert_eq!(*ekf.belief(), start);
    let noiseless = RobotSettings::default().camera(LandmarkNoise::NONE);
    assert!(LandmarkEkf::new(start, noiseless).is_err());
}

/// Range only and bearing only each find the pose, given three landmarks.
#[test]
fn each_kind_of_sight_finds_the_pose() {
    let truth = Pose2::new(0.7, -0.4, 0.3);
    for kind in [ObservedKind::RangeBearing, ObservedKind::Range, ObservedKind::Bearing] {
        let camera =
            LandmarkCamera { kind, noise: LandmarkNoise::NONE, ..LandmarkCamera::default() };
        let start = pose_belief(Pose2::new(0.5, -0.1, 0.3), [0.3, 0.3, 0.1]);
        let mut ekf = LandmarkEkf::new(start, RobotSettings::default()).unwrap();
        for _ in 0..20 {
            for observation in camera.observe(&map(), truth, &mut stream(1, "camera")) {
                assert!(ekf.correct(&map(), &observation).unwrap().accepted());
            }
        }
        let found = ekf.belief().pose();
        assert!(found.distance(truth) < 0.02, "{kind:?}: {found}");
    }
}

/// Late, doubled and missing inputs: whatever the order of arrival, the same belief to the bit.
#[test]
fn late_measurements_end_where_punctual_ones_do() {
    let mut rng = stream(9, "drive");
    let camera = LandmarkCamera { max_range: 20.0, ..LandmarkCamera::default() };
    let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
    let make = || {
        let robot = LandmarkLocalizer::new(map(), RobotSettings::default(), 0.0, start);
        Delayed::new(robot.unwrap(), 2.0).unwrap()
    };
    let (mut punctual, mut late) = (make(), make());
    let twist = Twist2::forward(0.5, 0.3);
    let mut waiting: Vec<(f64, Vec<LandmarkObservation>)> = Vec::new();
    for k in 0..100 {
        let stamp = 0.05 * f64::from(k);
        punctual.velocity(stamp, twist).unwrap();
        late.velocity(stamp, twist).unwrap();
        let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, stamp);
        // Every fifth step a measurement, every tenth two at one stamp; between them none.
        for _ in 0..[2, 0, 0, 0, 0, 1, 0, 0, 0, 0][k as usize % 10] {
            let observations = camera.observe(&map(), truth, &mut rng);
            punctual.observations(stamp, &observations).unwrap();
            waiting.push((stamp, observations));
        }
        // They reach the second filter 0.4 s late.
        while waiting.first().is_some_and(|(seen, _)| seen + 0.4 <= stamp) {
            let (seen, observations) = waiting.remove(0);
            late.observations(seen, &observations).unwrap();
        }
    }
    for (seen, observations) in waiting {
        late.observations(seen, &observations).unwrap();
    }
    let (a, b) = (punctual.estimate(6.0).unwrap(), late.estimate(6.0).unwrap());
    assert_eq!(a, b);
    let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, 6.0);
    assert!(a.pose.distance(truth) < 0.2);
    let refused = late.observations(1.0, &[see(1, 4.0, 0.0)]).unwrap();
    assert_eq!(refused[0].decision, Decision::TooLate);
    assert_eq!(late.estimate(6.0).unwrap(), b);
}

/// Between inputs the held velocity carries the estimate, and asking changes nothing.
#[test]
fn estimates_between_inputs_follow_the_held_velocity() {
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let robot = LandmarkLocalizer::new(map(), RobotSettings::default(), 10.0, start);
    let mut robot = Delayed::new(robot.unwrap(), 2.0).unwrap();
    robot.velocity(10.0, Twist2::forward(1.0, 0.0)).unwrap();
    robot.velocity(12.0, Twist2::ZERO).unwrap();
    assert_relative_eq!(robot.estimate(11.5).unwrap().pose.x, 1.5, epsilon = 1e-12);
    assert_relative_eq!(robot.estimate(20.0).unwrap().pose.x, 2.0, epsilon = 1e-12);
    assert_relative_eq!(robot.estimate(9.0).unwrap().pose.x, 0.0);
    assert!(robot.estimate(f64::NAN).is_err());
}

/// A filter that has gone wrong by more than it admits rejects everything. It notices that, is led
/// back by its observations, and says so; one outlier in five is no reason.
#[test]
fn a_diverged_filter_notices_and_comes_back() {
    let landmarks = [(1, 4.0, 1.0), (2, -3.0, 5.0), (3, 2.0, -4.0), (4, -5.0, -2.0)];
    let map = LandmarkMap::new(landmarks.map(|(id, x, y)| Landmark::planar(id, x, y))).unwrap();
    let see = |pose: Pose2, outlier: bool| {
        let seen = landmarks.iter().enumerate().map(|(k, (id, x, y))| {
            let at = pose.inverse().transform(&nalgebra::Point2::new(*x, *y));
            let range = at.coords.norm() + if outlier && k == 0 { 3.0 } else { 0.0 };
            let observed = Observed::RangeBearing { range, bearing: at.y.atan2(at.x) };
            LandmarkObservation { landmark: *id, observed }
        });
        Measurement::Landmarks(seen.collect())
    };
    for (wrong, diverges) in [
        (Pose2::new(0.1, 0.0, 0.02), false),
        (Pose2::new(4.0, -3.0, 0.5), true),
        (Pose2::new(-1.0, 2.0, 2.5), true),
    ] {
        let truth = Pose2::new(0.5, 0.2, 0.3);
        let start = pose_belief(truth * wrong, [0.05, 0.05, 0.02]);
        let settings = RobotSettings::default();
        let mut robot = LandmarkLocalizer::new(map.clone(), settings, 0.0, start).unwrap();
        robot.predict(0.0, &Control::Velocity(Twist2::ZERO)).unwrap();
        let mut back = None;
        for step in 1..=40 {
            let stamp = 0.5 * f64::from(step);
            robot.correct(stamp, &see(truth, step % 2 == 0)).unwrap();
            let pose = robot.estimate(stamp).unwrap().pose;
            if back.is_none() && pose.distance(truth) < 0.2 {
                back = Some(stamp);
            }
        }
        let end = robot.estimate(20.0).unwrap().pose;
        assert!(end.distance(truth) < 0.1, "{wrong}: {end}");
        assert!(back.is_some_and(|back| back <= 6.0), "{wrong}: {back:?}");
        assert_eq!(!robot.notes().is_empty(), diverges, "{wrong}: {:?}", robot.notes());
    }
}
