use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_sensors::compass::{Compass, CompassNoise, CompassReading, Disturbance};
use std::f64::consts::PI;

fn perfect() -> Compass {
    Compass { noise: CompassNoise::NONE, ..Compass::default() }
}

fn read(compass: &Compass, pose: Pose2) -> CompassReading {
    let reading = compass.measure(pose, &mut stream(1, "compass"));
    reading.check().unwrap();
    reading
}

fn facing(theta: f64) -> Pose2 {
    Pose2::new(1.0, 2.0, theta)
}

#[test]
fn headings_all_around() {
    for k in 0..12 {
        let theta = -PI + 0.1 + 0.5 * f64::from(k);
        let reading = read(&perfect(), facing(theta));
        assert_relative_eq!(reading.heading, theta, epsilon = 1e-12);
        assert_relative_eq!(reading.strength, 20.0, epsilon = 1e-12);
        // Wherever north is in the map.
        let turned = Compass { north: -2.0, ..perfect() };
        assert_relative_eq!(read(&turned, facing(theta)).heading, theta, epsilon = 1e-12);
    }
}

/// Magnetic north 0.1 rad east of north: without knowing, a robot that looks true north sees
/// magnetic north to its right, and takes itself to look 0.1 rad west.
#[test]
fn declination_by_hand() {
    let east = Compass { declination: 0.1, ..perfect() };
    assert_relative_eq!(read(&east, facing(PI / 2.0)).heading, PI / 2.0 + 0.1, epsilon = 1e-12);
    let known = Compass { assumed_declination: 0.1, ..east };
    assert_relative_eq!(read(&known, facing(PI / 2.0)).heading, PI / 2.0, epsilon = 1e-12);
}

/// As strong as the Earth's field and across it: 45 degrees off in the middle, nothing far away.
#[test]
fn disturbances_by_hand() {
    let door = Disturbance { center: [0.0, 0.0], radius: 0.5, field: [20.0, 0.0] };
    let compass = Compass { disturbances: vec![door], ..perfect() };
    let beside = read(&compass, Pose2::new(0.0, 0.0, 0.3));
    assert_relative_eq!(beside.heading, 0.3 + PI / 4.0, epsilon = 1e-12);
    assert_relative_eq!(beside.strength, 20.0 * 2_f64.sqrt(), epsilon = 1e-12);
    let one_radius = read(&compass, Pose2::new(0.0, 0.5, 0.3));
    assert_relative_eq!(one_radius.heading, 0.3 + (-0.5_f64).exp().atan(), epsilon = 1e-12);
    assert_relative_eq!(read(&compass, Pose2::new(5.0, 0.0, 0.3)).heading, 0.3, epsilon = 1e-9);
}

/// Iron on the robot pulls to one side on one course and to the other on the opposite one.
#[test]
fn hard_iron_by_hand() {
    let noise = CompassNoise { hard_iron: [0.0, 2.0], ..CompassNoise::NONE };
    let compass = Compass { noise, ..perfect() };
    let off = |theta: f64| read(&compass, facing(theta)).heading - theta;
    assert_relative_eq!(off(PI / 2.0), -(0.1_f64.atan()), epsilon = 1e-12);
    assert_relative_eq!(off(-PI / 2.0), 0.1_f64.atan(), epsilon = 1e-12);
    assert_relative_eq!(off(0.0), 0.0, epsilon = 1e-12);
}

#[test]
fn noise_has_its_variance() {
    let (compass, mut rng) = (Compass::default(), stream(2, "compass"));
    let headings = (0..20_000).map(|_| compass.measure(facing(0.4), &mut rng).heading);
    let moments = RunningMoments::of(headings).unwrap();
    assert_relative_eq!(moments.mean().unwrap(), 0.4, epsilon = 5e-4);
    let sigma = moments.standard_deviation().unwrap();
    assert_relative_eq!(sigma, compass.heading_sigma(), max_relative = 0.03);
}

#[test]
fn bad_settings_are_refused() {
    let far = Disturbance { center: [0.0, f64::NAN], radius: 1.0, field: [1.0, 1.0] };
    let small = Disturbance { center: [0.0, 0.0], radius: 0.0, field: [1.0, 1.0] };
    for bad in [
        Compass { north: f64::NAN, ..perfect() },
        Compass { horizontal_field: 0.0, ..perfect() },
        Compass { noise: CompassNoise { sigma: -0.1, ..CompassNoise::NONE }, ..perfect() },
        Compass { disturbances: vec![far], ..perfect() },
        Compass { disturbances: vec![small], ..perfect() },
    ] {
        assert!(bad.check().is_err(), "{bad:?}");
    }
    Compass::default().check().unwrap();
    assert!(CompassReading { heading: f64::NAN, strength: 20.0 }.check().is_err());
}
