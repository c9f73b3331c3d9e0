//! Poses drawn from observations.

use loc_core::random::stream;
use loc_core::{Pose2, angle};
use loc_maps::{Bounds, Landmark, LandmarkMap};
use loc_pf::sensor::landmark::{LandmarkLikelihood, ObservationModel, SensorResetting};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed, ObservedKind};
use nalgebra::Point2;

const TRUTH: Pose2 = Pose2 { x: 1.0, y: -0.5, theta: 2.5 };

fn map() -> LandmarkMap {
    let places = [(1, 3.0, 4.0), (2, -2.0, 1.0), (3, 0.0, -3.0)];
    LandmarkMap::new(places.map(|(id, x, y)| Landmark::planar(id, x, y))).unwrap()
}

fn region() -> Bounds {
    Bounds { min: Point2::new(-6.0, -6.0), max: Point2::new(6.0, 6.0) }
}

fn model() -> ObservationModel {
    ObservationModel { mounting: Pose2::new(0.2, 0.1, -0.4), ..ObservationModel::default() }
}

/// What is seen without error of some landmarks.
fn seen(landmarks: &[(u32, ObservedKind)]) -> LandmarkLikelihood {
    let (map, camera) = (map(), TRUTH * model().mounting);
    let see = |&(landmark, kind): &(u32, ObservedKind)| {
        let way = map.get(landmark).unwrap().position.xy() - camera.position();
        let bearing = angle::wrap(way.y.atan2(way.x) - camera.theta);
        LandmarkObservation { landmark, observed: Observed::new(kind, way.norm(), bearing) }
    };
    let observations: Vec<LandmarkObservation> = landmarks.iter().map(see).collect();
    LandmarkLikelihood::new(&map, &observations, &model()).unwrap()
}

fn draws(seen: &LandmarkLikelihood, spread: f64, count: usize) -> Vec<Pose2> {
    let resetting = SensorResetting::new(seen, region()).with_spread(spread);
    let mut rng = stream(1, "resetting");
    (0..count).map(|_| resetting.draw(&mut rng)).collect()
}

fn is_truth(pose: &Pose2) -> bool {
    pose.distance(TRUTH) < 1e-9 && angle::difference(pose.theta, TRUTH.theta).abs() < 1e-9
}

#[test]
fn two_sightings_fix_the_pose() {
    use ObservedKind::RangeBearing as Both;
    assert!(draws(&seen(&[(1, Both), (3, Both)]), 0.0, 20).iter().all(is_truth));
    assert!(draws(&seen(&[(1, Both), (2, Both), (3, Both)]), 0.0, 20).iter().all(is_truth));
}

/// Whatever was measured, a draw without blur fits the observations that it believes: all, where
/// there is one or two; and the true pose is among the draws wherever they are a finite set.
#[test]
fn draws_fit_what_they_believe() {
    use ObservedKind::{Bearing, Range, RangeBearing};
    for kinds in [
        vec![(1, RangeBearing)],
        vec![(2, Range)],
        vec![(3, Bearing)],
        vec![(1, Range), (2, Range)],
        vec![(1, Range), (2, Bearing)],
        vec![(2, Range), (3, RangeBearing)],
    ] {
        let seen = seen(&kinds);
        let poses = draws(&seen, 0.0, 200);
        assert!(poses.iter().all(|pose| region().contains(&pose.position())));
        for pose in &poses {
            let lost = seen.log_peak() - seen.log_likelihood(*pose);
            assert!(lost < 1e-6, "{kinds:?}: {pose:?} loses {lost}");
        }
        let nearest = poses.iter().map(|pose| pose.distance(TRUTH)).fold(f64::MAX, f64::min);
        assert!(nearest < 1.0, "{kinds:?}: {nearest}");
    }
}

/// The ring is drawn evenly: its mean is the landmark.
#[test]
fn one_sighting_leaves_a_ring() {
    let seen = seen(&[(3, ObservedKind::RangeBearing)]);
    let poses = draws(&seen, 2.0, 4000);
    let camera = |pose: &Pose2| (*pose * model().mounting).position();
    let sum = poses.iter().fold([0.0, 0.0], |s, p| [s[0] + camera(p).x, s[1] + camera(p).y]);
    let mean = sum.map(|s| s / 4000.0);
    // Radius 2.5 m; 4 standard errors.
    assert!(f64::hypot(mean[0], mean[1] + 3.0) < 4.0 * 2.5 / 4000_f64.sqrt(), "{mean:?}");
    let truth = camera(&TRUTH);
    let range = nalgebra::distance(&truth, &Point2::new(0.0, -3.0));
    let errors =
        poses.iter().map(|p| nalgebra::distance(&camera(p), &Point2::new(0.0, -3.0)) - range);
    let rms = (errors.map(|e| e * e).sum::<f64>() / 4000.0).sqrt();
    assert!((rms - 0.1).abs() < 0.006, "twice 5 cm: {rms}");
}

/// Nothing seen, or seen from outside only: a pose anywhere inside.
#[test]
fn without_a_fit_the_pose_is_anywhere_inside() {
    let poses = draws(&seen(&[]), 1.0, 500);
    assert!(poses.iter().all(|pose| region().contains(&pose.position())));
    let quadrants = [1.0, -1.0].map(|sign| poses.iter().filter(|p| p.x * sign > 0.0).count());
    assert!(quadrants.iter().all(|&count| count > 200));
    let observed = Observed::Range { range: 100.0 };
    let far = [LandmarkObservation { landmark: 1, observed }];
    let far = LandmarkLikelihood::new(&map(), &far, &model()).unwrap();
    assert!(draws(&far, 1.0, 50).iter().all(|pose| region().contains(&pose.position())));
}
