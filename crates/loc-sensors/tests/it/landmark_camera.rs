use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_sensors::landmark_camera::{
    CameraCalibration, LandmarkCamera, LandmarkNoise, Observed, ObservedKind,
};
use loc_sensors::world::Landmarks;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

fn perfect() -> LandmarkCamera {
    LandmarkCamera { noise: LandmarkNoise::NONE, ..LandmarkCamera::default() }
}

/// A camera 1 m ahead of a robot at (1, 2) that faces north, itself turned to the left.
#[test]
fn mounting_and_pose_by_hand() {
    let camera = LandmarkCamera { mounting: Pose2::new(1.0, 0.0, FRAC_PI_2), ..perfect() };
    let world = Landmarks::from([(3, [-1.0, 3.0])]);
    let seen = camera.observe(&world, Pose2::new(1.0, 2.0, FRAC_PI_2), &mut stream(1, "c"));
    assert_relative_eq!(seen[0].observed.range().unwrap(), 2.0, epsilon = 1e-12);
    assert_relative_eq!(seen[0].observed.bearing().unwrap(), 0.0, epsilon = 1e-12);
}

#[test]
fn only_what_is_in_view_is_seen() {
    let camera = LandmarkCamera { fov: FRAC_PI_2, min_range: 1.0, max_range: 5.0, ..perfect() };
    let world = Landmarks::from([
        (1, [3.0, 0.0]),
        (2, [0.5, 0.0]),
        (3, [6.0, 0.0]),
        (4, [2.0, 1.99]),
        (5, [2.0, 2.01]),
        (6, [-3.0, 0.0]),
    ]);
    let seen = camera.observe(&world, Pose2::IDENTITY, &mut stream(1, "c"));
    assert_eq!(seen.iter().map(|s| s.landmark).collect::<Vec<_>>(), [1, 4]);
    // Straight behind, the direction jumps from pi to -pi; a camera that sees all around does not.
    let behind = perfect().observe(&world, Pose2::new(0.0, 0.0, 0.1), &mut stream(1, "c"));
    assert_relative_eq!(behind[5].observed.bearing().unwrap(), PI - 0.1, epsilon = 1e-12);
}

#[test]
fn kinds_deliver_their_numbers() {
    let world = Landmarks::from([(1, [3.0, 3.0])]);
    for (kind, range, bearing) in [
        (ObservedKind::RangeBearing, Some(18_f64.sqrt()), Some(FRAC_PI_4)),
        (ObservedKind::Range, Some(18_f64.sqrt()), None),
        (ObservedKind::Bearing, None, Some(FRAC_PI_4)),
    ] {
        let camera = LandmarkCamera { kind, ..perfect() };
        let seen = camera.observe(&world, Pose2::IDENTITY, &mut stream(1, "c"));
        assert_eq!((seen[0].observed.range(), seen[0].observed.bearing()), (range, bearing));
    }
}

#[test]
fn noise_detection_and_wrong_numbers_have_their_rates() {
    let noise = LandmarkNoise { range_sigma: 0.1, range_sigma_per_m: 0.02, bearing_sigma: 0.03 };
    let camera = LandmarkCamera {
        noise,
        detection_probability: 0.7,
        wrong_identity_probability: 0.1,
        ..LandmarkCamera::default()
    };
    let world = Landmarks::from([(1, [5.0, 0.0]), (2, [0.0, 4.0])]);
    let mut rng = stream(3, "camera");
    let (mut range, mut bearing) = (RunningMoments::new(), RunningMoments::new());
    let (mut seen, mut wrong, rounds) = (0, 0, 20_000);
    for _ in 0..rounds {
        for observation in camera.observe(&world, Pose2::IDENTITY, &mut rng) {
            seen += 1;
            let at_first = observation.observed.bearing().unwrap().abs() < 0.5;
            wrong += u32::from(at_first != (observation.landmark == 1));
            if at_first {
                range.push(observation.observed.range().unwrap()).unwrap();
                bearing.push(observation.observed.bearing().unwrap()).unwrap();
            }
        }
    }
    assert_relative_eq!(f64::from(seen) / f64::from(2 * rounds), 0.7, epsilon = 0.01);
    assert_relative_eq!(f64::from(wrong) / f64::from(seen), 0.1, epsilon = 0.005);
    assert_relative_eq!(range.mean().unwrap(), 5.0, epsilon = 0.01);
    assert_relative_eq!(range.standard_deviation().unwrap(), 0.2, max_relative = 0.03);
    assert_relative_eq!(bearing.standard_deviation().unwrap(), 0.03, max_relative = 0.03);
}

#[test]
fn a_depth_becomes_a_distance() {
    let calibration =
        CameraCalibration { range_scale: 1.1, range_is_depth: true, ..CameraCalibration::NONE };
    for bearing in [-1.0_f64, 0.0, 0.5] {
        let recorded = Observed::RangeBearing { range: 1.1 * 4.0 * bearing.cos(), bearing };
        let corrected = calibration.correct(recorded);
        assert_relative_eq!(corrected.range().unwrap(), 4.0, epsilon = 1e-12);
        assert_relative_eq!(corrected.bearing().unwrap(), bearing, epsilon = 1e-12);
    }
    let sideways = Observed::RangeBearing { range: 0.1, bearing: 1.5 };
    assert_eq!(calibration.correct(sideways), Observed::Bearing { bearing: 1.5 });
    let any = Observed::RangeBearing { range: 2.0, bearing: -1.5 };
    assert_eq!(CameraCalibration::NONE.correct(any), any);
    let turned = CameraCalibration { bearing_bias: 0.1, ..CameraCalibration::NONE };
    assert_eq!(
        turned.correct(Observed::Bearing { bearing: 0.1 }),
        Observed::Bearing { bearing: 0.0 }
    );
}

#[test]
fn bad_settings_and_sights_are_refused() {
    for camera in [
        LandmarkCamera { fov: 0.0, ..perfect() },
        LandmarkCamera { min_range: 10.0, ..perfect() },
        LandmarkCamera { detection_probability: 1.1, ..perfect() },
        LandmarkCamera { wrong_identity_probability: f64::NAN, ..perfect() },
        LandmarkCamera {
            noise: LandmarkNoise { range_sigma: -1.0, ..LandmarkNoise::NONE },
            ..perfect()
        },
    ] {
        assert!(camera.check().is_err(), "{camera:?}");
    }
    assert!(CameraCalibration { range_scale: 0.0, ..CameraCalibration::NONE }.check().is_err());
    assert!(Observed::Range { range: -0.1 }.check().is_err());
    assert!(Observed::Bearing { bearing: f64::NAN }.check().is_err());
    assert!(Observed::RangeBearing { range: 0.0, bearing: 3.0 }.check().is_ok());
}
