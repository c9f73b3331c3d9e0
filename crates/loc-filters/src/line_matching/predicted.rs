//! The lines that a scanner should see from a pose (H4).

use crate::Result;
use loc_core::Pose2;
use loc_maps::line::{NormalForm, VisibleLine};
use loc_maps::{LineMap, LineSegment};
use loc_sensors::laser::LaserScan;
use nalgebra::{Matrix2, Vector2};

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

/// The stretches of map lines that a scanner at `scanner` (`map_from_laser`) should see, in the
/// order of the map. Lines shorter than `min_length` \[m\] are left out, but hide what is behind
/// them; each end of a line may be off across it by `map_sigma` \[m\].
///
/// # Errors
/// Those of [`LineMap::visible_lines`].
pub fn predicted_lines(
    map: &LineMap,
    scanner: Pose2,
    view: FieldOfView,
    min_length: f64,
    map_sigma: f64,
) -> Result<Vec<PredictedLine>> {
    let ahead = Pose2::new(scanner.x, scanner.y, scanner.theta + view.middle);
    let mut predicted = Vec::new();
    for visible in map.visible_lines(ahead, view.angle, view.max_range)? {
        let segment = map.lines()[visible.line].seen_from(scanner);
        if segment.length() >= min_length {
            predicted.extend(stretches(&visible, &segment, map_sigma));
        }
    }
    Ok(predicted)
}

/// One prediction for each visible part of a line, whole in the scanner's frame.
fn stretches<'a>(
    visible: &'a VisibleLine,
    segment: &'a LineSegment,
    map_sigma: f64,
) -> impl Iterator<Item = PredictedLine> + 'a {
    let normal_form = segment.normal_form();
    let covariance = map_covariance(segment, &normal_form, map_sigma);
    visible.parts.iter().map(move |[from, to]| PredictedLine {
        line: visible.line,
        stretch: LineSegment { start: segment.at(*from), end: segment.at(*to) },
        normal_form,
        covariance,
    })
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
