//! Settings as they stand in scenario files.

use loc_sensors::compass::Compass;
use loc_sensors::features::LineExtractor;
use loc_sensors::imu::ImuSpec;
use loc_sensors::laser::{LaserScanner, LaserSpec};
use loc_sensors::radar::Radar;
use loc_sensors::rgbd::{DepthCamera, VirtualScan};
use loc_sensors::sonar::Sonar;
use loc_sensors::world::{Pane, Surface};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Writes and reads back, and finds a field that does not exist.
fn round_trip<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(settings: &T) {
    let text = toml::to_string(settings).unwrap();
    assert_eq!(toml::from_str::<T>(&text).unwrap(), *settings, "{text}");
    let error = toml::from_str::<T>(&format!("typo = 1\n{text}")).unwrap_err().to_string();
    assert!(error.contains("typo"), "{error}");
}

#[test]
fn settings_survive_a_file() {
    round_trip(&LaserScanner::new(LaserSpec::sick_lms100()).unwrap());
    round_trip(&DepthCamera::default());
    round_trip(&VirtualScan::default());
    round_trip(&LineExtractor::default());
    round_trip(&ImuSpec::adis16448());
    round_trip(&Compass::default());
    round_trip(&Radar::default());
    round_trip(&Sonar::default());
    round_trip(&Pane { from: [0.0, 1.0], to: [2.0, 3.0], surface: Surface::Mirror });
    round_trip(&Pane { from: [0.0, 1.0], to: [2.0, 3.0], surface: Surface::Glass { pass: 0.5 } });
}

/// What is left out of a file keeps its default.
#[test]
fn a_few_lines_are_enough() {
    let scanner: LaserScanner = toml::from_str("faults.dropout = 0.1").unwrap();
    assert_eq!(scanner.spec, LaserSpec::hokuyo_ust_10lx());
    assert_eq!(scanner.faults.dropout, 0.1);
    let extractor: LineExtractor = toml::from_str("min_points = 20").unwrap();
    assert_eq!(extractor, LineExtractor::default().min_points(20));
}
