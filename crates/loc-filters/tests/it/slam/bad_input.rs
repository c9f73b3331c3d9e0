use loc_core::gaussian::pose_belief;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::Error;
use loc_filters::RobotSettings;
use loc_filters::localizer::Decision;
use loc_filters::slam::{EkfSlam, Identities, MapSettings, SlamSettings};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::{Matrix3, Vector3};

fn certain() -> Gaussian<3> {
    Gaussian::certain(Pose2::IDENTITY.to_vector())
}

fn see(landmark: u32, range: f64, bearing: f64) -> LandmarkObservation {
    LandmarkObservation { landmark, observed: Observed::RangeBearing { range, bearing } }
}

#[test]
fn refused_input_changes_nothing() {
    let mut slam = EkfSlam::new(certain(), SlamSettings::default()).unwrap();
    slam.correct(&[see(1, 4.0, 0.0)]).unwrap();
    let before = (slam.pose().unwrap(), slam.covariance().unwrap(), slam.step());
    for bad in [
        see(1, f64::NAN, 0.0),
        see(1, -1.0, 0.0),
        see(2, 1.0, f64::INFINITY),
        LandmarkObservation { landmark: 1, observed: Observed::Range { range: f64::INFINITY } },
    ] {
        assert!(slam.correct(&[see(1, 4.1, 0.0), bad]).is_err());
    }
    assert!(slam.predict(Twist2::forward(f64::NAN, 0.0), 0.1).is_err());
    assert!(slam.predict(Twist2::ZERO, -0.1).is_err());
    assert!(slam.correct(&[]).unwrap().is_empty());
    assert_eq!((slam.pose().unwrap(), slam.covariance().unwrap(), slam.step()), before);

    let refused = |settings: SlamSettings| EkfSlam::new(certain(), settings).is_err();
    assert!(refused(
        SlamSettings::default().robot(RobotSettings::default().camera(LandmarkNoise::NONE))
    ));
    let map = MapSettings::default().new_landmark_probability(2.0);
    assert!(refused(SlamSettings::default().map(map)));
    let negative = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    let start = Gaussian { mean: Vector3::zeros(), covariance: negative };
    assert!(EkfSlam::new(start, SlamSettings::default()).is_err());
}

#[test]
fn observations_that_cannot_be_used_have_a_reason() {
    let map = MapSettings::default().max_landmarks(2);
    let settings = SlamSettings::default().map(map);
    let mut slam = EkfSlam::new(certain(), settings).unwrap();
    let bearing = LandmarkObservation { landmark: 9, observed: Observed::Bearing { bearing: 0.3 } };
    let seen = [see(1, 4.0, 0.0), bearing, see(2, 0.0, 0.0), see(3, 2.0, 1.0), see(4, 2.0, -1.0)];
    let verdicts: Vec<_> = slam.correct(&seen).unwrap().iter().map(|o| o.decision).collect();
    let [born, unplaceable] = [Decision::NewLandmark, Decision::Undetermined];
    assert_eq!(verdicts, [born, unplaceable, unplaceable, born, Decision::MapFull]);
    // One that contradicts what is known is turned away.
    let wrong = slam.correct(&[see(3, 2.0, 2.0)]).unwrap()[0];
    assert!(!wrong.accepted() && wrong.nis.unwrap() > 100.0);
}

/// Two observations of a number that contradict each other: the landmark goes, and comes back where
/// the next one puts it.
#[test]
fn a_landmark_that_was_wrong_from_the_start_is_removed() {
    let mut slam = EkfSlam::new(certain(), SlamSettings::default()).unwrap();
    slam.correct(&[see(3, 2.0, 0.0), see(4, 3.0, 0.5), see(5, 2.0, -1.0)]).unwrap();
    slam.correct(&[see(3, 4.0, 0.0), see(4, 3.0, 0.5), see(5, 2.0, -1.0)]).unwrap();
    assert!(slam.landmark(3).unwrap().is_none() && slam.len() == 2);
    assert!(
        (slam.landmark(4).unwrap().unwrap().position.mean.y - 3.0 * 0.5_f64.sin()).abs() < 1e-9
    );
    assert_eq!(slam.covariance().unwrap().nrows(), 7);
    slam.correct(&[see(3, 4.0, 0.0)]).unwrap();
    assert_eq!(slam.landmark(3).unwrap().unwrap().position.mean.x, 4.0);
}

#[test]
fn a_hundred_thousand_observations_in_one_step() {
    for identities in [Identities::Known, Identities::Unknown] {
        let settings = SlamSettings::default().identities(identities);
        let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
        let mut slam = EkfSlam::new(start, settings).unwrap();
        let seen: Vec<_> = (0..100_000).map(|k| see(k % 3, 3.0, f64::from(k % 3))).collect();
        let outcomes = slam.correct(&seen).unwrap();
        assert_eq!((outcomes.len(), slam.len()), (seen.len(), 3));
        let pose = slam.pose().unwrap();
        assert!(pose.mean.iter().all(|value| value.is_finite()));
        slam.covariance().unwrap();
    }
}

/// Numbers so far apart that rounding eats the covariance: the filter says so, and when.
#[test]
fn lost_positivity_is_reported_with_its_step() {
    let settings = SlamSettings::default().robot(RobotSettings::default().camera(LandmarkNoise {
        range_sigma: 1e-9,
        range_sigma_per_m: 0.0,
        bearing_sigma: 1e-9,
    }));
    let start = pose_belief(Pose2::new(0.1, 0.2, 0.7), [1e8, 3e7, 1e3]);
    let mut slam = EkfSlam::new(start, settings).unwrap();
    let error = (0..50).find_map(|_| {
        let seen: Vec<_> = (0..5).map(|id| see(id, 3.3, f64::from(id))).collect();
        slam.predict(Twist2::forward(1e-9, 1e-9), 0.1).unwrap();
        slam.correct(&seen).err().or_else(|| slam.covariance().err())
    });
    let error = error.expect("rounding at 17 orders of magnitude");
    assert!(matches!(error, Error::LostPositivity { step: 2.., .. }), "{error}");
    let mut far = EkfSlam::new(certain(), SlamSettings::default()).unwrap();
    let error = far.predict(Twist2::forward(1e200, 1e-3), 1e100).unwrap_err().to_string();
    assert!(error.contains("covariance of the robot: lost its positivity at step 1"), "{error}");
    assert!(far.pose().is_ok_and(|pose| pose.mean.iter().all(|value| value.is_finite())));
}
