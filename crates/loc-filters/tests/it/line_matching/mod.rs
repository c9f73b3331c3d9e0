//! Lines of scans against lines of maps (H4).

mod bad_input;
mod drives;
mod model;
mod pairing;

use loc_core::Pose2;
use loc_filters::line_matching::{FieldOfView, LineMatchingSettings};
use loc_maps::line::NormalForm;
use loc_maps::{LineMap, LineSegment};
use loc_sensors::features::Line;
use loc_sensors::laser::{LaserScanner, LaserSpec};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::TAU;

const ROOM: &str = "0,0,6,0\n6,0,6,4\n6,4,2,4\n2,4,2,3\n2,3,0,3\n0,3,0,0\n3,1,3.8,1\n";

fn map(csv: &str) -> LineMap {
    LineMap::parse_csv("map.csv", csv).unwrap()
}

/// A scanner off the robot's middle, with 541 beams.
fn scanner() -> LaserScanner {
    let mounting = Pose2::new(0.2, -0.1, 0.3);
    LaserScanner {
        mounting,
        ..LaserScanner::new(LaserSpec { range_min: 0.05, ..LaserSpec::sick_lms100_50_hz() })
            .unwrap()
    }
}

/// Settings for perfect walls and beams.
fn settings() -> LineMatchingSettings {
    let defaults = LineMatchingSettings::default();
    let noise = scanner().spec.noise;
    let extractor = defaults.extractor.noise(noise).roughness(0.0).angle_sigma(0.0);
    defaults.extractor(extractor)
}

fn all_around() -> FieldOfView {
    FieldOfView { middle: 0.0, angle: TAU, max_range: f64::INFINITY }
}

/// A line as a perfect scanner at `pose` would have it.
fn seen(pose: Pose2, start: [f64; 2], end: [f64; 2], sigmas: [f64; 2]) -> Line {
    let segment = LineSegment::new(start, end).seen_from(pose);
    let NormalForm { r, alpha } = segment.normal_form();
    let covariance = Matrix2::from_diagonal(&Vector2::from(sigmas.map(|s| s * s)));
    Line { r, alpha, covariance, start: segment.start, end: segment.end, points: 50 }
}
