//! Landmarks without numbers (I4).

use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::association::{AssociationSettings, Rule};
use loc_filters::localizer::Decision;
use loc_filters::slam::{EkfSlam, Identities, SlamSettings};
use loc_sensors::landmark_camera::{LandmarkCamera, LandmarkObservation, Observed};
use loc_sensors::world::Landmarks;
use rand::RngExt;

const PLACES: [[f64; 2]; 9] = [
    [4.0, 1.0],
    [6.0, 3.5],
    [5.5, 6.0],
    [2.0, 7.5],
    [-1.0, 6.0],
    [-3.0, 3.0],
    [-2.0, 0.0],
    [1.0, -2.0],
    [1.5, 3.0],
];

fn unknown(rule: Rule) -> EkfSlam {
    let association = AssociationSettings::default().rule(rule);
    let settings = SlamSettings::default().identities(Identities::Unknown).association(association);
    EkfSlam::new(Gaussian::certain(Pose2::IDENTITY.to_vector()), settings).unwrap()
}

#[test]
fn two_rounds_find_every_landmark_once() {
    let mut number = 0..;
    let world = Landmarks::from(PLACES.map(|place| (number.next().unwrap_or(0), place)));
    let camera = LandmarkCamera { max_range: 4.0, fov: 2.8, ..LandmarkCamera::default() };
    for rule in [Rule::NearestNeighbor, Rule::MaximumLikelihood, Rule::JointCompatibility] {
        let mut slam = unknown(rule);
        let mut rng = stream(1, "camera");
        let twist = Twist2::forward(0.5, 0.5 / 3.0);
        let mut truth = Pose2::IDENTITY;
        for _ in 0..380 {
            // Odometry reports a little too much.
            truth = slam.settings().robot.integration.step(truth, twist, 0.2);
            slam.predict(Twist2::forward(0.51, 0.51 / 3.0), 0.2).unwrap();
            let mut seen = camera.observe(&world, truth, &mut rng);
            seen.iter_mut().for_each(|observation| observation.landmark = 0);
            slam.correct(&seen).unwrap();
        }
        assert_eq!(slam.len(), PLACES.len(), "{rule:?}");
        for landmark in slam.landmarks().unwrap() {
            let off = |place: &[f64; 2]| {
                (landmark.position.mean - nalgebra::Vector2::from(*place)).norm()
            };
            let nearest = PLACES.iter().map(off).fold(f64::INFINITY, f64::min);
            assert!(landmark.confirmed && nearest < 0.3, "{rule:?} {landmark:?} {nearest}");
        }
        assert!(slam.pose().unwrap().pose().distance(truth) < 0.3);
    }
}

#[test]
fn what_is_seen_once_and_never_again_is_removed() {
    let mut slam = unknown(Rule::JointCompatibility);
    let see = |range, bearing| LandmarkObservation {
        landmark: 0,
        observed: Observed::RangeBearing { range, bearing },
    };
    let real = [see(3.0, 0.5), see(4.0, -0.5), see(2.0, 0.9)];
    for _ in 0..4 {
        slam.correct(&real).unwrap();
    }
    let ghost = slam.correct(&[see(2.0, 0.0)]).unwrap()[0];
    assert_eq!(ghost.decision, Decision::NewLandmark);
    let id = ghost.landmark.unwrap();
    assert!(!slam.landmark(id).unwrap().unwrap().confirmed);
    for _ in 0..5 {
        slam.correct(&real).unwrap();
    }
    assert!(slam.landmark(id).unwrap().is_none() && slam.len() == 3);
    assert!(slam.landmarks().unwrap().iter().all(|landmark| landmark.confirmed));
    // Its number is not given again.
    let next = slam.correct(&[see(2.0, 0.0)]).unwrap()[0].landmark.unwrap();
    assert!(next > id);
    // Neither close enough to a landmark nor far enough from all.
    let near = slam.correct(&[see(3.17, 0.5)]).unwrap()[0];
    assert!(near.decision == Decision::Ambiguous && near.nis.unwrap() > 9.2, "{near:?}");
}

/// A round of 44 m among 28 landmarks, of which few are in view at a time: when the robot comes
/// back it is off by about a metre, and many landmarks fit what it sees. It takes those of old for
/// new ones, until several of them lie as the old ones do.
#[test]
fn coming_back_from_a_long_way_closes_the_loop() {
    let (mut number, mut rng) = (0.., stream(5, "world"));
    let world = Landmarks::from([(); 28].map(|()| {
        let k: u32 = number.next().unwrap_or(0);
        let angle = f64::from(k) * 0.2244 + rng.random_range(-0.08..0.08);
        let radius = [5.0, 8.5][k as usize % 2] + rng.random_range(-0.8..0.8);
        (k, [radius * angle.sin(), 7.0 - radius * angle.cos()])
    }));
    let camera = LandmarkCamera { max_range: 3.0, fov: 3.0, ..LandmarkCamera::default() };
    let (mut right, mut off) = (0, 0.0);
    for seed in 1..=12 {
        let mut slam = unknown(Rule::JointCompatibility);
        let mut rng = stream(seed, "camera");
        let mut truth = Pose2::IDENTITY;
        for _ in 0..276 {
            let twist = Twist2::forward(0.5, 0.5 / 7.0);
            truth = slam.settings().robot.integration.step(truth, twist, 0.5);
            slam.predict(Twist2::forward(0.502, 0.5 / 7.0 + 0.0002), 0.5).unwrap();
            slam.correct(&camera.observe(&world, truth, &mut rng)).unwrap();
        }
        right += usize::from((28..=29).contains(&slam.len()));
        off += slam.pose().unwrap().pose().distance(truth) / 12.0;
    }
    assert!(right >= 11 && off < 0.6, "{right} of 12 right, off by {off} m");
}
