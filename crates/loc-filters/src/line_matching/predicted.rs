//! The lines that a scanner should see from a pose (H4).

use super::LineMatchingSettings;
use crate::Result;
use loc_core::error::{finite, positive};
use loc_core::{Gaussian, Pose2};
use loc_maps::line::NormalForm;
use loc_maps::{LineMap, LineSegment};
use loc_sensors::laser::LaserScan;
use nalgebra::{Matrix2, Vector2};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// A position that is known this well looks the same from all places where it may be \[m\].
const WELL_KNOWN: f64 = 0.1;

/// What a scanner can see: an angle, about a direction of its own, and a distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldOfView {
    /// The middle of it, from the scanner's x axis \[rad\].
    pub middle: f64,
    /// The whole angle \[rad\].
    pub angle: f64,
    /// The greatest distance \[m\]; may be infinite.
    pub max_range: f64,
}

/// A stretch of a map line, as a scanner should see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedLine {
    /// Index of the line in the map.
    pub line: usize,
    /// The visible stretch, in the scanner's frame \[m\].
    pub stretch: LineSegment,
    /// (r, alpha) of the line in the scanner's frame.
    pub normal_form: NormalForm,
    /// Covariance of (r, alpha) that comes of the map.
    pub covariance: Matrix2<f64>,
}

impl FieldOfView {
    /// Checks that something can be seen.
    fn check(&self) -> Result<()> {
        finite("middle of a field of view [rad]", self.middle)?;
        positive("angle of a field of view [rad]", self.angle)?;
        Ok(())
    }

    /// That of the scanner that made a scan.
    pub fn of(scan: &LaserScan) -> Self {
        let (first, last) = (scan.angle_min, scan.angle_max);
        FieldOfView {
            middle: 0.5 * (first + last),
            angle: (last - first).abs().max(scan.angle_increment.abs()),
            max_range: scan.range_max,
        }
    }
}

/// The stretches of map lines that the scanner of a robot should see, in the order of the map.
///
/// What a wall hides depends on where the scanner is: where that is not well known, the view from
/// two standard deviations on each side counts as well. Lines shorter than `min_map_length` are
/// left out, but hide what is behind them.
///
/// # Errors
/// Those of [`LineMap::visible_lines`].
pub(super) fn predicted_lines(
    map: &LineMap,
    belief: &Gaussian<3>,
    mounting: Pose2,
    view: FieldOfView,
    settings: &LineMatchingSettings,
) -> Result<Vec<PredictedLine>> {
    view.check()?;
    let mut parts: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    // Where the heading is off, the view reaches farther on one side.
    let angle = view.angle + 4.0 * belief.covariance.m33.max(0.0).sqrt();
    for pose in viewpoints(belief) {
        let scanner = pose * mounting;
        let ahead = Pose2::new(scanner.x, scanner.y, scanner.theta + view.middle);
        for visible in map.visible_lines(ahead, angle, view.max_range)? {
            parts.entry(visible.line).or_default().extend(visible.parts);
        }
    }
    let scanner = belief.pose() * mounting;
    let mut predicted = Vec::new();
    for (line, parts) in parts {
        let segment = map.lines()[line].seen_from(scanner);
        if segment.length() < settings.min_map_length {
            continue;
        }
        let normal_form = segment.normal_form();
        let covariance = map_covariance(&segment, &normal_form, settings.map_sigma);
        predicted.extend(joined(parts).into_iter().map(|[from, to]| {
            let stretch = LineSegment { start: segment.at(from), end: segment.at(to) };
            PredictedLine { line, stretch, normal_form, covariance }
        }));
    }
    Ok(predicted)
}

/// The pose and, where the position is known worse than [`WELL_KNOWN`], four more around it.
fn viewpoints(belief: &Gaussian<3>) -> Vec<Pose2> {
    let pose = belief.pose();
    let ellipse = belief.position().ellipse(2.0);
    let mut poses = vec![pose];
    for (half, direction) in
        [(ellipse.semi_major, ellipse.angle), (ellipse.semi_minor, ellipse.angle + FRAC_PI_2)]
    {
        if half > 2.0 * WELL_KNOWN {
            let (sin, cos) = direction.sin_cos();
            let offset = |far: f64| Pose2 { x: pose.x + far * cos, y: pose.y + far * sin, ..pose };
            poses.extend([offset(half), offset(-half)]);
        }
    }
    poses
}

/// Parts of a line in order, those that touch as one.
fn joined(mut parts: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::with_capacity(parts.len());
    for part in parts {
        match joined.last_mut().filter(|last| part[0] <= last[1]) {
            Some(last) => last[1] = last[1].max(part[1]),
            None => joined.push(part),
        }
    }
    joined
}

/// Covariance of (r, alpha) where both ends of a segment may be off across it, independently.
fn map_covariance(segment: &LineSegment, normal: &NormalForm, sigma: f64) -> Matrix2<f64> {
    let (sin, cos) = normal.alpha.sin_cos();
    // The middle is off by half the sum of both, the direction by their difference over the
    // length; a turn about the middle moves the foot of the perpendicular by their distance.
    let middle = segment.at(0.5).coords.dot(&Vector2::new(-sin, cos));
    let (across, turn) = (sigma * sigma / 2.0, 2.0 * (sigma / segment.length()).powi(2));
    let both = middle * turn;
    Matrix2::new(across + middle * both, both, both, turn)
}
