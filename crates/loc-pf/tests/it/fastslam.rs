use loc_core::motion::{Integration, VelocityNoise};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Gaussian, Pose2, Twist2, angle};
use loc_filters::RobotSettings;
use loc_filters::delayed::Delayed;
use loc_filters::localizer::{Decision, Localizer};
use loc_filters::slam::{EkfSlam, Identities, MapLandmark, MapSettings, SlamSettings};
use loc_pf::{Error, FastSlam, FastSlamLocalizer, FastSlamSettings};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::{Matrix3, Point2, Vector3};
use rand_distr::{Distribution, StandardNormal};

const ORIGIN: Pose2 = Pose2::IDENTITY;

fn certain() -> Gaussian<3> {
    Gaussian::certain(ORIGIN.to_vector())
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn settings(particles: usize) -> FastSlamSettings {
    let observation_noise =
        LandmarkNoise { range_sigma: 0.1, bearing_sigma: 0.05, ..Default::default() };
    FastSlamSettings::default()
        .robot(RobotSettings::default().camera(observation_noise))
        .particles(particles)
}

fn slam(settings: FastSlamSettings) -> FastSlam {
    FastSlam::new(certain(), settings, stream(1, "fastslam")).unwrap()
}

fn observation(landmark: u32, range: f64, bearing: f64) -> LandmarkObservation {
    LandmarkObservation { landmark, observed: Observed::RangeBearing { range, bearing } }
}

/// What a robot at `pose` sees of a landmark, with errors of so many sigmas.
fn seen(pose: Pose2, id: u32, place: Point2<f64>, errors: [f64; 2]) -> LandmarkObservation {
    let way = pose.inverse().transform(&place);
    let bearing = way.y.atan2(way.x) + 0.05 * errors[1];
    observation(id, (way.coords.norm() + 0.1 * errors[0]).max(0.0), angle::wrap(bearing))
}

/// A round trip past eight landmarks: each moment has the velocity over the half second before it
/// and what is then seen.
struct Round {
    moments: Vec<(Twist2, Vec<LandmarkObservation>)>,
    places: Vec<Point2<f64>>,
    truth: Pose2,
}

const HALF: f64 = 0.5;

fn round(seed: u64, noise: &VelocityNoise, rounds: usize) -> Round {
    let mut rng = stream(seed, "round");
    let places: Vec<Point2<f64>> = (0..8)
        .map(|k| {
            let (sin, cos) = (f64::from(k) * 0.785).sin_cos();
            Point2::new(3.2 * sin, 2.0 - 3.2 * cos)
        })
        .collect();
    let mut pose = ORIGIN;
    let moments = (0..50 * rounds).map(|_| {
        let reported = Twist2::forward(0.5, 0.25);
        let sigmas = noise.variances(reported, HALF).map(f64::sqrt);
        let mut drove = reported;
        drove.vx += sigmas.x * normal(&mut rng);
        drove.omega += sigmas.z * normal(&mut rng);
        pose = Integration::ExactArc.step(pose, drove, HALF);
        let visible = places.iter().enumerate().filter(|(_, place)| {
            let way = pose.inverse().transform(place);
            way.coords.norm() < 3.0 && way.y.atan2(way.x).abs() < 1.2
        });
        let ids: Vec<usize> = visible.map(|(k, _)| k).collect();
        let errors = ids.iter().map(|&k| {
            let errors = [normal(&mut rng), normal(&mut rng)];
            seen(pose, k as u32, places[k], errors)
        });
        (reported, errors.collect())
    });
    let moments = moments.collect();
    Round { moments, places, truth: pose }
}

fn follow(slam: &mut FastSlam, round: &Round) {
    for (twist, observations) in &round.moments {
        slam.predict(*twist, HALF).unwrap();
        let outcomes = slam.correct(observations).unwrap();
        assert_eq!(outcomes.len(), observations.len());
    }
}

#[test]
fn a_landmark_is_averaged_by_hand() {
    let mut slam = slam(settings(1));
    assert!(slam.landmarks().unwrap().is_empty());
    let born = slam.correct(&[observation(3, 4.0, 0.0)]).unwrap();
    assert_eq!((born[0].landmark, born[0].decision), (Some(3), Decision::NewLandmark));
    let first = slam.landmarks().unwrap()[0];
    // 0.1 m along the ray, 4 m times 0.05 rad across it.
    let [x, y] = [first.position.covariance.m11, first.position.covariance.m22];
    assert!((x - 0.01).abs() < 1e-15 && (y - 0.04).abs() < 1e-15);
    let again = slam.correct(&[observation(3, 4.2, 0.1)]).unwrap()[0];
    // Both innovations have twice the sensor's variance: 0.2^2 / 0.02 + 0.1^2 / 0.005.
    assert!((again.nis.unwrap() - 4.0).abs() < 1e-12 && again.accepted());
    let second = slam.landmarks().unwrap()[0];
    assert!((second.position.mean - nalgebra::Vector2::new(4.1, 0.2)).norm() < 1e-12);
    let [x, y] = [second.position.covariance.m11, second.position.covariance.m22];
    assert!((x - 0.005).abs() < 1e-15 && (y - 0.02).abs() < 1e-15 && second.observations == 2);
}

/// A robot that knows its way makes the two methods one: independent Kalman filters.
#[test]
fn one_particle_without_noise_is_the_kalman_filter() {
    let none = VelocityNoise::NONE;
    let own = settings(1).robot(settings(1).robot.odometry(none));
    let theirs = SlamSettings::default()
        .robot(RobotSettings::default().odometry(none).camera(own.robot.camera));
    let (mut fast, mut ekf) = (slam(own), EkfSlam::new(certain(), theirs).unwrap());
    for (k, (twist, observations)) in round(4, &none, 1).moments.iter().enumerate() {
        let mut observations = observations.clone();
        // Some tell but half.
        for (j, seen) in observations.iter_mut().enumerate().filter(|_| k > 8) {
            let Observed::RangeBearing { range, bearing } = seen.observed else { continue };
            match (k + j) % 4 {
                0 => seen.observed = Observed::Range { range },
                1 => seen.observed = Observed::Bearing { bearing },
                _ => {}
            }
        }
        fast.predict(*twist, HALF).unwrap();
        ekf.predict(*twist, HALF).unwrap();
        let (a, b) = (fast.correct(&observations).unwrap(), ekf.correct(&observations).unwrap());
        for (a, b) in a.iter().zip(&b) {
            assert_eq!((a.landmark, a.accepted()), (b.landmark, b.accepted()));
            let off = a.nis.unwrap_or(0.0) - b.nis.unwrap_or(0.0);
            assert!(off.abs() < 1e-7, "{a:?} {b:?}");
        }
    }
    assert!((fast.pose().unwrap().mean - ekf.pose().unwrap().mean).norm() < 1e-9);
    let of = |mut landmarks: Vec<MapLandmark>| {
        landmarks.sort_by_key(|landmark| landmark.id);
        landmarks
    };
    let (a, b) = (of(fast.landmarks().unwrap()), of(ekf.landmarks().unwrap()));
    assert_eq!((a.len(), b.len()), (8, 8));
    for (a, b) in a.iter().zip(&b) {
        assert!((a.position.mean - b.position.mean).norm() < 1e-8);
        assert!((a.position.covariance - b.position.covariance).norm() < 1e-9);
        assert_eq!((a.id, a.observations, a.confirmed), (b.id, b.observations, b.confirmed));
    }
}

/// One step against importance sampling from odometry alone, written down independently.
#[test]
fn the_proposal_has_the_posterior_of_plain_sampling() {
    let noise = VelocityNoise::from_sigmas(0.1, 0.0, 0.05).unwrap();
    let mut slam = slam(settings(20_000).robot(settings(20_000).robot.odometry(noise)));
    let places = [Point2::new(3.0, 1.0), Point2::new(2.0, -1.5)];
    let first: Vec<LandmarkObservation> =
        (0..2).map(|k| seen(ORIGIN, k as u32, places[k], [0.0; 2])).collect();
    slam.correct(&first).unwrap();
    let map = slam.landmarks().unwrap();
    let reported = Twist2::forward(1.0, 0.0);
    slam.predict(reported, 1.0).unwrap();
    let second: Vec<LandmarkObservation> =
        (0..2).map(|k| seen(Pose2::new(1.06, 0.02, 0.03), k as u32, places[k], [0.0; 2])).collect();
    slam.correct(&second).unwrap();
    let mut rng = stream(9, "brute force");
    let (mut total, mut mean, mut squares) = (0.0, Vector3::zeros(), Matrix3::zeros());
    for _ in 0..400_000 {
        let drove = Twist2::forward(1.0 + 0.1 * normal(&mut rng), 0.05 * normal(&mut rng));
        let pose = Integration::ExactArc.step(ORIGIN, drove, 1.0);
        let mut exponent = 0.0;
        for (landmark, seen) in map.iter().zip(&second) {
            let Observed::RangeBearing { range, bearing } = seen.observed else { unreachable!() };
            let way = pose.inverse().transform(&landmark.position.mean.into());
            let (r, phi) = (way.coords.norm(), way.y.atan2(way.x));
            // Along and across the ray, in the map.
            let (sin, cos) = (pose.theta + phi).sin_cos();
            let along = nalgebra::Vector2::new(cos, sin);
            let across = nalgebra::Vector2::new(-sin, cos) / r;
            let axes = nalgebra::Matrix2::from_columns(&[along, across]);
            let mut s = axes.transpose() * landmark.position.covariance * axes;
            s.m11 += 0.1 * 0.1;
            s.m22 += 0.05 * 0.05;
            let off = nalgebra::Vector2::new(range - r, bearing - phi);
            exponent -= 0.5 * (off.dot(&(s.try_inverse().unwrap() * off)) + s.determinant().ln());
        }
        let (weight, x) = (exponent.exp(), pose.to_vector());
        total += weight;
        mean += weight * x;
        squares += weight * x * x.transpose();
    }
    mean /= total;
    let covariance = squares / total - mean * mean.transpose();
    let pose = slam.pose().unwrap();
    let off = pose.mean - mean;
    for k in 0..3 {
        let sigma = covariance[(k, k)].sqrt();
        assert!(off[k].abs() < 0.05 * sigma + 1e-4, "{k}: {} {}", off[k], sigma);
        assert!((pose.covariance[(k, k)].sqrt() / sigma - 1.0).abs() < 0.06, "{k}");
    }
}

#[test]
fn numbers_of_threads_change_nothing() {
    let noise = VelocityNoise::default();
    let round = round(2, &noise, 1);
    for identities in [Identities::Known, Identities::Unknown] {
        let result = |threads| {
            let own = settings(60).identities(identities).threads(threads);
            let mut slam = slam(own);
            follow(&mut slam, &round);
            let bits: Vec<u64> = slam.pose().unwrap().mean.iter().map(|v| v.to_bits()).collect();
            (bits, slam.landmarks().unwrap(), slam.particles())
        };
        assert_eq!(result(1), result(3));
    }
}

#[test]
fn landmarks_without_numbers_are_found_once() {
    let noise = VelocityNoise::default();
    let mut right = 0;
    for seed in 1..=5 {
        let round = round(seed, &noise, 2);
        let own = settings(100).identities(Identities::Unknown);
        let mut slam = slam(own);
        follow(&mut slam, &round);
        let found = slam.landmarks().unwrap();
        let near = |place: &&Point2<f64>| {
            found.iter().any(|l| (l.position.mean - place.coords).norm() < 0.4)
        };
        let all = round.places.iter().filter(near).count() == 8;
        right += usize::from(all && found.iter().filter(|l| l.confirmed).count() == 8);
    }
    assert!(right >= 4, "{right} of 5");
}

/// What is seen once and then no more is taken from the map, though the robot looks there.
#[test]
fn false_landmarks_are_removed() {
    let mut slam = slam(settings(20).identities(Identities::Unknown));
    let [true_one, ghost, edge] =
        [observation(0, 2.0, 0.1), observation(0, 1.5, -0.3), observation(0, 3.0, 0.6)];
    slam.correct(&[true_one, ghost, edge]).unwrap();
    assert_eq!(slam.landmarks().unwrap().len(), 3);
    for _ in 0..6 {
        slam.correct(&[true_one, edge]).unwrap();
    }
    let left = slam.landmarks().unwrap();
    assert_eq!(left.len(), 2);
    assert!(left.iter().all(|landmark| landmark.confirmed && landmark.observations == 7));
}

/// A number that is misread now and then neither moves its landmark nor the robot.
#[test]
fn a_misread_number_is_turned_away() {
    let mut slam = slam(settings(50));
    for _ in 0..5 {
        slam.correct(&[observation(1, 2.0, 0.3), observation(2, 3.0, -0.4)]).unwrap();
    }
    let before = slam.landmarks().unwrap();
    let outcome = slam.correct(&[observation(2, 2.0, 0.3)]).unwrap()[0];
    assert!(!outcome.accepted() && outcome.nis.unwrap() > 100.0);
    let after = slam.landmarks().unwrap();
    assert!((after[1].position.mean - before[1].position.mean).norm() < 1e-9);
}

/// Over 30 drives the errors are about as large as the filter says; it is known to grow too sure
/// of itself, as every filter of few particles.
#[test]
fn errors_are_about_what_the_filter_says() {
    let noise = VelocityNoise::default();
    let (mut nees, mut off, mut odometry) = (0.0, 0.0, 0.0);
    for seed in 1..=30 {
        let round = round(seed, &noise, 1);
        let mut slam = slam(settings(150));
        follow(&mut slam, &round);
        let pose = slam.pose().unwrap();
        let deviation = pose.pose_deviation(round.truth);
        nees += pose.deviation_squared(&deviation).unwrap() / 30.0;
        off += deviation.fixed_rows::<2>(0).norm() / 30.0;
        let reported = |pose, (twist, _): &(Twist2, Vec<LandmarkObservation>)| {
            Integration::ExactArc.step(pose, *twist, HALF)
        };
        odometry += round.moments.iter().fold(ORIGIN, reported).distance(round.truth) / 30.0;
    }
    assert!(nees > 1.0 && nees < 12.0, "{nees}");
    assert!(off < 0.15 && off < 0.5 * odometry, "{off} {odometry}");
}

#[test]
fn late_inputs_are_applied_at_their_time() {
    let see = |range| [observation(1, range, 0.0), observation(2, range, 0.6)];
    let start = || {
        let rng = stream(3, "fastslam");
        let slam = FastSlamLocalizer::new(settings(30), 0.0, certain(), rng).unwrap();
        Delayed::new(slam, 1.0).unwrap()
    };
    let drive = Twist2::forward(0.5, 0.1);
    let mut in_order = start();
    in_order.velocity(0.0, drive).unwrap();
    in_order.observations(0.2, &see(4.0)).unwrap();
    in_order.observations(0.6, &see(3.8)).unwrap();
    in_order.velocity(0.7, Twist2::ZERO).unwrap();
    let mut late = start();
    late.velocity(0.0, drive).unwrap();
    late.velocity(0.7, Twist2::ZERO).unwrap();
    late.observations(0.6, &see(3.8)).unwrap();
    late.observations(0.2, &see(4.0)).unwrap();
    assert_eq!(in_order.estimate(0.9).unwrap(), late.estimate(0.9).unwrap());
    assert_eq!(in_order.map().unwrap(), late.map().unwrap());
    let refused = late.observations(-0.5, &see(4.0)).unwrap();
    assert!(refused.iter().all(|outcome| outcome.decision == Decision::TooLate));
    assert_eq!(in_order.map().unwrap(), late.map().unwrap());
    assert!(late.estimate(f64::NAN).is_err());
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let mut slam = slam(settings(10));
    slam.correct(&[observation(1, 2.0, 0.3)]).unwrap();
    let before = (slam.pose().unwrap(), slam.landmarks().unwrap());
    for (range, bearing) in [(f64::NAN, 0.0), (-1.0, 0.0), (f64::INFINITY, 0.0), (1.0, f64::NAN)] {
        assert!(slam.correct(&[observation(1, 2.0, 0.3), observation(1, range, bearing)]).is_err());
    }
    assert!(slam.correct(&[]).unwrap().is_empty());
    let bearing_only =
        LandmarkObservation { landmark: 9, observed: Observed::Bearing { bearing: 0.1 } };
    let outcome = slam.correct(&[bearing_only, observation(8, 0.0, 0.0)]).unwrap();
    assert!(outcome.iter().all(|o| o.decision == Decision::Undetermined && !o.accepted()));
    assert!(slam.predict(Twist2::forward(f64::NAN, 0.0), 1.0).is_err());
    assert!(slam.predict(Twist2::ZERO, -1.0).is_err());
    assert_eq!(before, (slam.pose().unwrap(), slam.landmarks().unwrap()));
    let lost = slam.predict(Twist2::forward(1e300, 0.0), 1e300).unwrap_err();
    let expected =
        |e: &Error| matches!(e, Error::Filter(loc_filters::Error::LostPositivity { .. }));
    assert!(expected(&lost), "{lost}");
    let base = settings(10);
    let wrong = [
        base.particles(0),
        base.robot(base.robot.gate_probability(0.0)),
        base.new_share(0.0),
        base.miss_share(1.5),
        base.resample_below(f64::NAN),
        base.robot(base.robot.mounting(Pose2 { theta: f64::NAN, ..ORIGIN })),
        base.robot(base.robot.camera(LandmarkNoise { range_sigma: 0.0, ..base.robot.camera })),
        base.map(base.map.miss_cost(-1.0)),
    ];
    for settings in wrong {
        assert!(FastSlam::new(certain(), settings, stream(1, "x")).is_err(), "{settings:?}");
    }
    let nowhere = Gaussian { mean: Vector3::new(f64::NAN, 0.0, 0.0), covariance: Matrix3::zeros() };
    assert!(FastSlam::new(nowhere, base, stream(1, "x")).is_err());
}

#[test]
fn a_hundred_thousand_sightings_leave_a_finite_state() {
    for identities in [Identities::Known, Identities::Unknown] {
        let map = MapSettings::default().max_landmarks(40);
        let mut slam = slam(settings(2).identities(identities).map(map));
        let many: Vec<LandmarkObservation> = (0..100_000)
            .map(|k| observation(k % 60, 1.0 + f64::from(k % 60) * 0.1, f64::from(k % 7) * 0.3))
            .collect();
        let outcomes = slam.correct(&many).unwrap();
        assert_eq!(outcomes.len(), many.len());
        assert!(outcomes.iter().any(|outcome| outcome.decision == Decision::MapFull));
        let pose = slam.pose().unwrap();
        assert!(pose.mean.iter().chain(pose.covariance.iter()).all(|v| v.is_finite()));
        assert!(slam.landmarks().unwrap().len() <= 40);
    }
}
