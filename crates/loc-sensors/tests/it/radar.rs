use approx::assert_relative_eq;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_core::{Pose2, Twist2};
use loc_sensors::radar::{Radar, RadarNoise, RadarReturn, RadarSpec};
use loc_sensors::world::{MovingObject, Room};
use nalgebra::{Point2, Vector2};
use std::f64::consts::FRAC_PI_2;

fn perfect() -> Radar {
    Radar::new(RadarSpec { noise: RadarNoise::NONE, ..RadarSpec::ars408_near() }).unwrap()
}

fn object(x: f64, y: f64, vx: f64, vy: f64) -> MovingObject {
    MovingObject { position: Point2::new(x, y), velocity: Vector2::new(vx, vy), radius: 0.0 }
}

fn field() -> Room {
    Room::new([-200.0; 2], [200.0; 2]).unwrap()
}

fn see(radar: &Radar, object: MovingObject, pose: Pose2, twist: Twist2) -> Option<RadarReturn> {
    let echoes = radar.observe(&field(), &[object][..], pose, twist, &mut stream(1, "radar"));
    echoes.first().copied()
}

#[test]
fn radial_speed_by_hand() {
    let still = Twist2::ZERO;
    let echo = see(&perfect(), object(3.0, 4.0, 1.0, 2.0), Pose2::IDENTITY, still).unwrap();
    echo.check().unwrap();
    assert_relative_eq!(echo.range, 5.0);
    assert_relative_eq!(echo.bearing, 4_f64.atan2(3.0));
    assert_relative_eq!(echo.radial_speed, (3.0 + 8.0) / 5.0);
    // What crosses the view has no radial speed, what stands approaches a robot that drives.
    let crossing = see(&perfect(), object(5.0, 0.0, 0.0, 3.0), Pose2::IDENTITY, still).unwrap();
    assert_relative_eq!(crossing.radial_speed, 0.0);
    let north = Pose2::new(1.0, 1.0, FRAC_PI_2);
    let standing = see(&perfect(), object(1.0, 9.0, 0.0, 0.0), north, Twist2::forward(2.0, 0.0));
    assert_relative_eq!(standing.unwrap().radial_speed, -2.0, epsilon = 1e-12);
    let ball = MovingObject { radius: 0.3, ..object(5.0, 0.0, 0.0, 0.0) };
    assert_relative_eq!(see(&perfect(), ball, Pose2::IDENTITY, still).unwrap().range, 4.7);
}

/// The radial speed is the derivative of the distance, on a robot that drives a curve with the
/// radar at its corner.
#[test]
fn radial_speed_is_the_derivative_of_range() {
    let radar = Radar { mounting: Pose2::new(0.8, -0.5, 0.2), ..perfect() };
    let (start, twist) = (Pose2::new(1.0, 2.0, 0.6), Twist2::new(1.5, 0.2, 0.7));
    let range = |t: f64| {
        let pose = start * Pose2::exp(&(twist.to_vector() * t));
        let there = object(9.0 - t, 8.0 + 0.4 * t, -1.0, 0.4);
        see(&radar, there, pose, twist).unwrap()
    };
    let h = 1e-5;
    let derivative = (range(h).range - range(-h).range) / (2.0 * h);
    assert_relative_eq!(range(0.0).radial_speed, derivative, epsilon = 1e-7);
}

#[test]
fn only_what_is_in_view_is_seen() {
    let seen =
        |x, y, vx| see(&perfect(), object(x, y, vx, 0.0), Pose2::IDENTITY, Twist2::ZERO).is_some();
    assert!(seen(69.9, 0.0, 0.0) && !seen(70.1, 0.0, 0.0) && !seen(0.1, 0.0, 0.0));
    assert!(seen(1.0, 1.73, 0.0) && !seen(1.0, 1.74, 0.0) && !seen(-5.0, 0.0, 0.0));
    assert!(seen(30.0, 0.0, 55.0) && !seen(30.0, 0.0, 56.0));
    // Behind a pillar nothing is seen.
    let walls = field().with_pillar([5.0, 0.0], 0.5).unwrap();
    let objects = [object(10.0, 0.0, 1.0, 0.0), object(10.0, 3.0, 1.0, 0.0)];
    let (pose, twist) = (Pose2::IDENTITY, Twist2::ZERO);
    let echoes = perfect().observe(&walls, &objects[..], pose, twist, &mut stream(1, "radar"));
    assert_eq!(echoes.len(), 1);
    assert!(echoes[0].bearing > 0.2);
}

#[test]
fn noise_and_rates() {
    let noise =
        RadarNoise { detection_probability: 0.8, clutter: 0.5, ..RadarSpec::ars408_near().noise };
    let radar = Radar::new(RadarSpec { noise, ..RadarSpec::ars408_near() }).unwrap();
    let target = object(20.0, 5.0, -3.0, 1.0);
    let truth = see(&perfect(), target, Pose2::IDENTITY, Twist2::ZERO).unwrap();
    let (mut rng, rounds) = (stream(2, "radar"), 20_000);
    let (mut errors, mut total) = ([RunningMoments::new(); 3], 0);
    for _ in 0..rounds {
        let echoes =
            radar.observe(&field(), &[target][..], Pose2::IDENTITY, Twist2::ZERO, &mut rng);
        total += echoes.len();
        let near = |echo: &&RadarReturn| (echo.range - truth.range).abs() < 1.0;
        for echo in echoes.iter().take(1).filter(near) {
            if (echo.bearing - truth.bearing).abs() < 0.2 {
                errors[0].push(echo.range - truth.range).unwrap();
                errors[1].push(echo.bearing - truth.bearing).unwrap();
                if (echo.radial_speed - truth.radial_speed).abs() < 0.5 {
                    errors[2].push(echo.radial_speed - truth.radial_speed).unwrap();
                }
            }
        }
    }
    assert_relative_eq!(total as f64 / f64::from(rounds), 0.8 + 0.5, epsilon = 0.02);
    for (moments, sigma) in
        errors.iter().zip([noise.range_sigma, noise.bearing_sigma, noise.speed_sigma])
    {
        assert_relative_eq!(moments.standard_deviation().unwrap(), sigma, max_relative = 0.04);
        assert_relative_eq!(moments.mean().unwrap(), 0.0, epsilon = 0.04 * sigma);
    }
}

#[test]
fn bad_settings_are_refused() {
    let spec = RadarSpec::ars408_near();
    for bad in [
        RadarSpec { fov: 0.0, ..spec },
        RadarSpec { range_max: 0.1, ..spec },
        RadarSpec { speed_max: f64::NAN, ..spec },
        RadarSpec { rate: -1.0, ..spec },
        RadarSpec { noise: RadarNoise { clutter: 1e9, ..spec.noise }, ..spec },
        RadarSpec { noise: RadarNoise { detection_probability: 1.1, ..spec.noise }, ..spec },
    ] {
        assert!(Radar::new(bad).is_err(), "{bad:?}");
    }
    assert!(object(0.0, f64::NAN, 0.0, 0.0).check().is_err());
    assert!(MovingObject { radius: -1.0, ..object(0.0, 0.0, 0.0, 0.0) }.check().is_err());
    assert!(RadarReturn { range: -1.0, bearing: 0.0, radial_speed: 0.0 }.check().is_err());
}
