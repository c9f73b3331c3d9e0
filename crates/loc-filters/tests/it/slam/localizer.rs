use loc_core::motion::Integration;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::Error;
use loc_filters::slam::{SlamLocalizer, SlamSettings};
use loc_sensors::landmark_camera::LandmarkCamera;
use loc_sensors::world::Landmarks;

/// Late observations end where punctual ones do, to the bit; beyond the horizon they are refused.
#[test]
fn late_observations_end_where_punctual_ones_do() {
    let world = Landmarks::from([(1, [4.0, 0.0]), (2, [0.0, 4.0]), (3, [-3.0, -3.0])]);
    let camera = LandmarkCamera::default();
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let make = || SlamLocalizer::new(SlamSettings::default(), 0.0, start, 1.0).unwrap();
    let (mut punctual, mut late, mut rng) = (make(), make(), stream(9, "camera"));
    let twist = Twist2::forward(0.5, 0.3);
    let mut waiting = Vec::new();
    for k in 0..100 {
        let stamp = 0.05 * f64::from(k);
        punctual.velocity(stamp, twist).unwrap();
        late.velocity(stamp, twist).unwrap();
        if k % 5 == 0 {
            let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, stamp);
            let seen = camera.observe(&world, truth, &mut rng);
            punctual.observations(stamp, &seen).unwrap();
            waiting.push((stamp, seen));
        }
        while waiting.first().is_some_and(|(seen, _)| seen + 0.4 <= stamp) {
            let (seen, observations) = waiting.remove(0);
            late.observations(seen, &observations).unwrap();
        }
    }
    for (seen, observations) in waiting {
        late.observations(seen, &observations).unwrap();
    }
    assert_eq!(punctual.estimate(6.0).unwrap(), late.estimate(6.0).unwrap());
    assert_eq!(punctual.landmarks().unwrap(), late.landmarks().unwrap());
    let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, 6.0);
    assert!(punctual.estimate(6.0).unwrap().pose().distance(truth) < 0.3);
    assert!(matches!(late.observations(1.0, &[]), Err(Error::TooLate { .. })));
    assert!(late.velocity(7.0, Twist2::forward(f64::NAN, 0.0)).is_err());
    assert_eq!(punctual.estimate(7.0).unwrap(), late.estimate(7.0).unwrap());
    assert!(late.estimate(f64::NAN).is_err());
}
