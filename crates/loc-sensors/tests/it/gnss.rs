use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::stats::{RunningMoments, autocorrelation};
use loc_sensors::gnss::{Geodetic, Gnss, GnssNoise, LocalFrame, Outages};
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

fn frame() -> LocalFrame {
    LocalFrame::new(Geodetic::from_degrees(52.2719, 8.0443, 64.0).unwrap()).unwrap()
}

/// Axes of the ellipsoid, and a point whose ECEF coordinates are published with the EPSG method
/// 9602 (guidance note 7-2).
#[test]
fn ecef_by_hand() {
    let ecef = |lat, lon, h| Geodetic::from_degrees(lat, lon, h).unwrap().to_ecef();
    assert_relative_eq!(ecef(0.0, 0.0, 0.0), Vector3::new(6_378_137.0, 0.0, 0.0));
    assert_relative_eq!(ecef(0.0, 90.0, 10.0), Vector3::new(0.0, 6_378_147.0, 0.0), epsilon = 1e-8);
    let pole = Vector3::new(0.0, 0.0, 6_356_752.314_245_179);
    assert_relative_eq!(ecef(90.0, 0.0, 0.0), pole, epsilon = 1e-8);
    let published = Vector3::new(3_771_793.968, 140_253.342, 5_124_304.349);
    let latitude = 53.0 + 48.0 / 60.0 + 33.820 / 3600.0;
    let longitude = 2.0 + 7.0 / 60.0 + 46.380 / 3600.0;
    assert_relative_eq!(ecef(latitude, longitude, 73.0), published, epsilon = 1e-3);
}

#[test]
fn ecef_and_back_everywhere() {
    for latitude in [-90.0, -89.999_999, -45.0, -1e-9, 0.0, 33.3, 60.0, 89.0, 90.0] {
        for longitude in [-179.9, -90.0, 0.0, 12.3, 180.0] {
            for height in [-10_000.0, 0.0, 500.0, 400_000.0, 9e6] {
                let place = Geodetic::from_degrees(latitude, longitude, height).unwrap();
                let back = Geodetic::from_ecef(&place.to_ecef());
                let off = (back.to_ecef() - place.to_ecef()).norm();
                assert!(off < 1e-8, "{latitude} {longitude} {height}: {off} m");
                assert!((back.height - height).abs() < 1e-8);
            }
        }
    }
}

#[test]
fn enu_and_back_over_ten_kilometres() {
    for latitude in [-89.0, -35.0, 0.0, 52.2719, 80.0] {
        let origin = Geodetic::from_degrees(latitude, 170.0, 64.0).unwrap();
        let frame = LocalFrame::new(origin).unwrap();
        for (east, north) in [(0.0, 0.0), (10_000.0, 0.0), (-7000.0, 7000.0), (0.0, -10_000.0)] {
            let enu = Vector3::new(east, north, 12.0);
            let back = frame.to_enu(&frame.to_geodetic(&enu));
            assert!((back - enu).norm() < 1e-7, "{latitude}: {}", (back - enu).norm());
        }
    }
}

/// One minute of latitude is the meridian's radius of curvature times its angle; the frame bends
/// down from the ellipsoid by about d^2 / 2 R.
#[test]
fn enu_by_hand() {
    let origin = frame().origin();
    let minute = (1.0_f64 / 60.0).to_radians();
    let north = Geodetic { latitude: origin.latitude + minute, ..origin };
    let sin = (origin.latitude + 0.5 * minute).sin();
    let (a, e2) = (6_378_137.0, 0.006_694_379_990_141);
    let meridian = a * (1.0 - e2) / (1.0 - e2 * sin * sin).powf(1.5) + 64.0;
    let enu = frame().to_enu(&north);
    assert_relative_eq!(enu.y, meridian * minute, epsilon = 1e-3);
    assert_relative_eq!(enu.x, 0.0, epsilon = 1e-9);
    assert_relative_eq!(enu.z, -enu.y * enu.y / (2.0 * meridian), epsilon = 1e-3);
    let east = Geodetic { longitude: origin.longitude + minute, ..origin };
    let sin = origin.latitude.sin();
    let parallel = (a / (1.0 - e2 * sin * sin).sqrt() + 64.0) * origin.latitude.cos();
    assert_relative_eq!(frame().to_enu(&east).x, parallel * minute, epsilon = 1e-3);
}

#[test]
fn errors_have_their_variance_and_last() {
    let noise =
        GnssNoise { white_sigma: 0.5, drift_sigma: 2.0, drift_time: 10.0, vertical_factor: 2.0 };
    let mut receiver = Gnss::new(frame()).with_noise(noise).unwrap();
    let mut rng = stream(1, "gnss");
    let pose = Pose2::new(300.0, -200.0, FRAC_PI_2);
    let fixes: Vec<_> = (0..40_000)
        .map(|_| receiver.measure(pose, 1.0, &mut rng).unwrap())
        .map(|fix| (frame().to_enu(&fix.position), fix.covariance))
        .collect();
    let east: Vec<f64> = fixes.iter().map(|(enu, _)| enu.x).collect();
    let moments = RunningMoments::of(east.iter().copied()).unwrap();
    // An error that lasts 10 s leaves 40000 / 20 independent ones.
    assert_relative_eq!(moments.mean().unwrap(), 300.0, epsilon = 0.15);
    assert_relative_eq!(moments.variance().unwrap(), 4.25, max_relative = 0.1);
    assert_relative_eq!(fixes[0].1.m11, 4.25, epsilon = 1e-9);
    let up = RunningMoments::of(fixes.iter().map(|(enu, _)| enu.z)).unwrap();
    assert_relative_eq!(up.variance().unwrap(), 17.0, max_relative = 0.1);
    assert_relative_eq!(fixes[0].1.m33, 17.0, epsilon = 1e-9);
    // Only the drift is remembered.
    let expected = 4.0 / 4.25 * (-0.5_f64).exp();
    assert_relative_eq!(autocorrelation(&east, 5).unwrap(), expected, epsilon = 0.05);
}

#[test]
fn the_first_fix_is_as_bad_as_the_others() {
    let (mut moments, mut rng) = (RunningMoments::new(), stream(2, "gnss"));
    for _ in 0..5000 {
        let fix = Gnss::new(frame()).measure(Pose2::IDENTITY, 1.0, &mut rng).unwrap();
        moments.push(fix.in_plane(&frame()).mean.y).unwrap();
    }
    let sigma = GnssNoise::neo_m8().sigma();
    assert_relative_eq!(moments.standard_deviation().unwrap(), sigma, max_relative = 0.05);
}

#[test]
fn outages_come_and_go_at_their_rates() {
    let outages = Outages { rate: 0.05, mean_duration: 5.0 };
    let mut receiver = Gnss::new(frame()).with_outages(outages).unwrap();
    let mut rng = stream(3, "gnss");
    let seen: Vec<bool> =
        (0..50_000).map(|_| receiver.measure(Pose2::IDENTITY, 0.5, &mut rng).is_some()).collect();
    let out = seen.iter().filter(|seen| !**seen).count() as f64;
    assert_relative_eq!(out / 50_000.0, 0.05 / (0.05 + 0.2), epsilon = 0.02);
    let begun = seen.windows(2).filter(|pair| pair[0] && !pair[1]).count() as f64;
    // Seen every half second, an outage that is shorter is missed: 5 s become a little more.
    assert_relative_eq!(out * 0.5 / begun, 5.3, epsilon = 0.4);
}

#[test]
fn antenna_by_hand() {
    let receiver = Gnss::new(frame()).with_noise(GnssNoise::NONE).unwrap();
    let mut receiver = receiver.with_mounting(Pose2::new(0.5, 0.0, 0.0)).unwrap();
    let pose = Pose2::new(10.0, 20.0, FRAC_PI_2);
    let fix = receiver.measure(pose, 1.0, &mut stream(1, "gnss")).unwrap();
    let place = fix.in_plane(&frame());
    assert_relative_eq!(place.mean.x, 10.0, epsilon = 1e-7);
    assert_relative_eq!(place.mean.y, 20.5, epsilon = 1e-7);
}

#[test]
fn bad_values_are_refused() {
    assert!(Geodetic::from_degrees(90.1, 0.0, 0.0).is_err());
    assert!(Geodetic::from_degrees(0.0, f64::NAN, 0.0).is_err());
    assert!(Geodetic::from_degrees(0.0, 0.0, f64::INFINITY).is_err());
    let noise = GnssNoise::neo_m8();
    assert!(Gnss::new(frame()).with_noise(GnssNoise { white_sigma: -1.0, ..noise }).is_err());
    assert!(Gnss::new(frame()).with_noise(GnssNoise { drift_time: 0.0, ..noise }).is_err());
    let outages = Outages { rate: f64::NAN, mean_duration: 1.0 };
    assert!(Gnss::new(frame()).with_outages(outages).is_err());
}
