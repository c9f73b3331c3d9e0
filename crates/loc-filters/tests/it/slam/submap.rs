//! The submap form against the whole filter: the same numbers to rounding.

use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::slam::{EkfSlam, Identities, Jacobians, SlamSettings};
use loc_sensors::landmark_camera::LandmarkCamera;
use loc_sensors::world::Landmarks;
use rand::RngExt;

/// 28 landmarks on both sides of a round course, 1.5 rounds of it.
fn drive(settings: SlamSettings, mut look: impl FnMut(usize, &EkfSlam, &EkfSlam)) {
    let (mut number, mut rng) = (0.., stream(5, "world"));
    let world = Landmarks::from([(); 28].map(|()| {
        let k = number.next().unwrap_or(0);
        let angle = f64::from(k) * 0.2244 + rng.random_range(-0.08..0.08);
        let radius = [5.0, 8.5][k as usize % 2] + rng.random_range(-0.8..0.8);
        (k, [radius * angle.sin(), 7.0 - radius * angle.cos()])
    }));
    let camera = LandmarkCamera { max_range: 3.0, fov: 3.0, ..LandmarkCamera::default() };
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let mut whole = EkfSlam::new(start, settings).unwrap();
    let submap_radius = Some(4.0);
    let mut parts = EkfSlam::new(start, settings.submap_radius(submap_radius)).unwrap();
    let mut truth = Pose2::IDENTITY;
    let mut rng = stream(6, "camera");
    for step in 0..276 {
        let twist = Twist2::forward(0.5, 0.5 / 7.0);
        truth = settings.robot.integration.step(truth, twist, 0.5);
        let slipping = Twist2::forward(0.502, 0.5 / 7.0 + 0.0002);
        let seen = camera.observe(&world, truth, &mut rng);
        let mut outcomes = [&mut whole, &mut parts].map(|slam| {
            slam.predict(slipping, 0.5).unwrap();
            slam.correct(&seen).unwrap().into_iter()
        });
        let [a, b] = &mut outcomes;
        assert!(a.zip(b).all(|(a, b)| a.landmark == b.landmark && a.accepted() == b.accepted()));
        look(step, &whole, &parts);
    }
    let off = whole.pose().unwrap().pose().distance(truth);
    assert!(whole.len() == 28 && off < 1.0, "{} landmarks, off by {off} m", whole.len());
}

fn compare(whole: &EkfSlam, parts: &EkfSlam) {
    let (a, b) = (whole.pose().unwrap(), parts.pose().unwrap());
    assert!((a.mean - b.mean).amax() < 1e-9 && (a.covariance - b.covariance).amax() < 1e-10);
    let (a, b) = (whole.landmarks().unwrap(), parts.landmarks().unwrap());
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!((a.id, a.observations, a.confirmed), (b.id, b.observations, b.confirmed));
        assert!((a.position.mean - b.position.mean).amax() < 1e-9, "{a:?} {b:?}");
        assert!((a.position.covariance - b.position.covariance).amax() < 1e-10, "{a:?} {b:?}");
    }
}

#[test]
fn equals_the_whole_filter_to_rounding() {
    for (identities, jacobians) in [
        (Identities::Known, Jacobians::Current),
        (Identities::Known, Jacobians::First),
        (Identities::Unknown, Jacobians::Current),
    ] {
        let settings = SlamSettings::default().identities(identities).jacobians(jacobians);
        drive(settings, |step, whole, parts| {
            // Also in the middle of a submap, while the rest of the map is owed its corrections.
            if step % 23 == 0 || step == 275 {
                compare(whole, parts);
            }
            if step % 69 == 68 {
                let (a, b) = (whole.covariance().unwrap(), parts.covariance().unwrap());
                assert!((a - b).amax() < 1e-10);
            }
        });
    }
}
