use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_sensors::sonar::{Sonar, SonarNoise, SonarRange, SonarSpec};
use loc_sensors::world::{Glazed, Pane, RangeWorld, Room, Surface};

fn perfect() -> Sonar {
    Sonar::default()
}

fn hear(sonar: &Sonar, world: &impl RangeWorld, pose: Pose2) -> f64 {
    let echo = sonar.measure(world, pose, &mut stream(1, "sonar"));
    echo.check().unwrap();
    echo.range
}

fn deg(theta: f64) -> Pose2 {
    Pose2::new(0.0, 0.0, theta.to_radians())
}

/// A wall 2 m ahead: within the cone its foot is heard, beyond it the nearest edge of the cone, and
/// at more than 25 degrees of slant nothing.
#[test]
fn a_wall_by_hand() {
    let wall = Room::new([-90.0, -90.0], [2.0, 90.0]).unwrap();
    for (theta, range) in [
        (0.0, 2.0),
        (10.0, 2.0),
        (-15.0, 2.0),
        (30.0, 2.0 / 15_f64.to_radians().cos()),
        (-39.0, 2.0 / 24_f64.to_radians().cos()),
        (45.0, f64::INFINITY),
    ] {
        let heard = hear(&perfect(), &wall, deg(theta));
        if range.is_finite() {
            assert_relative_eq!(heard, range, epsilon = 2e-3);
        } else {
            assert_eq!(heard, range, "{theta} degrees");
        }
    }
}

#[test]
fn pillars_and_glass_are_heard() {
    let room = Room::new([-9.0, -9.0], [4.0, 9.0]).unwrap();
    let pillar = room.clone().with_pillar([2.0, 0.3], 0.1).unwrap();
    let heard = hear(&perfect(), &pillar, Pose2::IDENTITY);
    // Rays a degree apart meet a pillar of 10 cm up to half a degree beside its nearest point.
    assert_relative_eq!(heard, f64::hypot(2.0, 0.3) - 0.1, epsilon = 2e-3);
    let pane = Pane { from: [3.0, -2.0], to: [3.0, 2.0], surface: Surface::Glass { pass: 1.0 } };
    let glazed = Glazed::new(room, [pane]).unwrap();
    assert_relative_eq!(hear(&perfect(), &glazed, Pose2::IDENTITY), 3.0, epsilon = 1e-9);
}

#[test]
fn limits_and_mounting() {
    let room = Room::new([-9.0, -9.0], [3.0, 9.0]).unwrap();
    let sonar = Sonar { mounting: Pose2::new(0.5, 0.0, 0.0), ..perfect() };
    assert_relative_eq!(hear(&sonar, &room, Pose2::IDENTITY), 2.5, epsilon = 1e-9);
    assert_eq!(hear(&sonar, &room, Pose2::new(2.49, 0.0, 0.0)), f64::NEG_INFINITY);
    assert_eq!(hear(&sonar, &room, Pose2::new(-3.0, 0.0, 0.0)), f64::INFINITY);
    let one_ray = Sonar { spec: SonarSpec { rays: 1, ..SonarSpec::default() }, ..perfect() };
    assert_relative_eq!(hear(&one_ray, &room, Pose2::IDENTITY), 3.0, epsilon = 1e-9);
}

#[test]
fn noise_and_faults_have_their_rates() {
    let noise = SonarNoise { sigma: 0.01, sigma_per_m: 0.01, dropout: 0.1, crosstalk: 0.05 };
    let spec = SonarSpec { noise, ..SonarSpec::default() };
    let sonar = Sonar::new(spec).unwrap();
    let room = Room::new([-9.0, -9.0], [2.0, 9.0]).unwrap();
    let mut rng = stream(2, "sonar");
    let heard: Vec<f64> = (0..20_000)
        .map(|_| sonar.measure(&room, Pose2::IDENTITY, &mut rng))
        .map(|echo: SonarRange| echo.range)
        .collect();
    let share = |of: &dyn Fn(&f64) -> bool| {
        heard.iter().filter(|range| of(range)).count() as f64 / 20_000.0
    };
    assert_relative_eq!(share(&|range| *range == f64::INFINITY), 0.1, epsilon = 0.01);
    assert_relative_eq!(share(&|range| *range < 1.8), 0.05 * 0.9, epsilon = 0.006);
    let near = heard.iter().copied().filter(|range| *range > 1.8 && range.is_finite());
    let sigma = RunningMoments::of(near).unwrap().standard_deviation().unwrap();
    assert_relative_eq!(sigma, 0.03, max_relative = 0.05);
}

#[test]
fn bad_settings_are_refused() {
    for spec in [SonarSpec::hc_sr04(), SonarSpec::polaroid_6500()] {
        Sonar::new(spec).unwrap().check().unwrap();
        for bad in [
            SonarSpec { cone: 0.0, ..spec },
            SonarSpec { cone: 7.0, ..spec },
            SonarSpec { widest_incidence: f64::NAN, ..spec },
            SonarSpec { rays: 0, ..spec },
            SonarSpec { range_max: 0.0, ..spec },
            SonarSpec { noise: SonarNoise { dropout: 0.7, crosstalk: 0.7, ..spec.noise }, ..spec },
        ] {
            assert!(Sonar::new(bad).is_err(), "{bad:?}");
        }
    }
}
