//! How well a line of a scan fits a line of the map.

use super::{LineModel, PredictedLine};
use crate::association::{PairInnovation, Pairing};
use crate::extended::MeasurementModel;
use loc_core::{Gaussian, Pose2};
use loc_maps::{LineMap, LineSegment};
use loc_sensors::features::Line;
use nalgebra::{Matrix2, RowVector3, Vector2};

/// The lines of a scan beside those that were predicted.
pub(super) struct Lines<'a> {
    pub(super) map: &'a LineMap,
    pub(super) mounting: Pose2,
    pub(super) seen: &'a [Line],
    pub(super) predicted: &'a [PredictedLine],
    /// The predicted stretches, in the map.
    pub(super) stretches: Vec<LineSegment>,
    /// Least share of the shorter of two lines beside the other one.
    pub(super) min_overlap: f64,
    /// How far a line may be seen beyond the stretch that is predicted \[m\].
    pub(super) slack: f64,
}

impl<'a> Lines<'a> {
    /// Of the lines that a scanner at `scanner` (`map_from_laser`) has seen and should have seen.
    pub(super) fn new(
        map: &'a LineMap,
        (scanner, mounting): (Pose2, Pose2),
        seen: &'a [Line],
        predicted: &'a [PredictedLine],
        (min_overlap, slack): (f64, f64),
    ) -> Self {
        let back = scanner.inverse();
        let stretches = predicted.iter().map(|line| line.stretch.seen_from(back)).collect();
        Lines { map, mounting, seen, predicted, stretches, min_overlap, slack }
    }

    /// (r, alpha) of a line of the scan.
    pub(super) fn measurement(&self, seen: usize) -> Vector2<f64> {
        Vector2::new(self.seen[seen].r, self.seen[seen].alpha)
    }

    /// The model of a predicted line for one that was seen.
    pub(super) fn model(&self, seen: usize, predicted: usize) -> LineModel {
        let (line, predicted) = (&self.seen[seen], &self.predicted[predicted]);
        let normal = self.map.lines()[predicted.line].normal_form();
        // On the other side of the scanner r grows where it shrank.
        let turned = (line.alpha - predicted.normal_form.alpha).cos() < 0.0;
        let mut of_map = predicted.covariance;
        if turned {
            (of_map.m12, of_map.m21) = (-of_map.m12, -of_map.m21);
        }
        LineModel::new(normal, self.mounting).measured(line.alpha, line.covariance + of_map)
    }

    /// Residual of a pair and its covariance, as a belief has them.
    pub(super) fn innovation(
        &self,
        belief: &Gaussian<3>,
        seen: usize,
        predicted: usize,
    ) -> (Vector2<f64>, Matrix2<f64>) {
        let model = self.model(seen, predicted);
        let (expected, h) = model.linearize(&belief.mean);
        let residual = model.residual(&self.measurement(seen), &expected);
        (residual, h * belief.covariance * h.transpose() + model.noise(&expected))
    }

    /// Whether two lines lie beside each other, as far as a belief knows the pose.
    pub(super) fn overlap(&self, belief: &Gaussian<3>, seen: usize, predicted: usize) -> bool {
        let (line, stretch) = (&self.seen[seen], &self.stretches[predicted]);
        let scanner = belief.pose() * self.mounting;
        let (sin, cos) = line.alpha.sin_cos();
        let along = Vector2::new(-sin, cos);
        let [a, b] = span(line.start.coords.dot(&along), line.end.coords.dot(&along));
        // The same direction in the map.
        let turned = scanner.rotation() * along;
        let place = |point: nalgebra::Point2<f64>| (point - scanner.position()).dot(&turned);
        let [c, d] = span(place(stretch.start), place(stretch.end));
        // Two standard deviations of the place along the line; a turn moves it by the distance.
        let by_pose = RowVector3::new(turned.x, turned.y, line.r);
        let variance = (by_pose * belief.covariance * by_pose.transpose()).x;
        let slack = self.slack + 2.0 * variance.max(0.0).sqrt();
        let (c, d) = (c - slack, d + slack);
        let common = b.min(d) - a.max(c);
        common > 0.0 && common >= self.min_overlap * (b - a).min(d - c)
    }
}

fn span(a: f64, b: f64) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

/// The pairs as the rules of [`association`](crate::association) see them.
pub(super) struct WithBelief<'a> {
    pub(super) lines: &'a Lines<'a>,
    pub(super) belief: &'a Gaussian<3>,
}

impl Pairing<2> for WithBelief<'_> {
    fn observations(&self) -> usize {
        self.lines.seen.len()
    }

    fn landmarks(&self) -> usize {
        self.lines.predicted.len()
    }

    fn innovation(&self, seen: usize, predicted: usize) -> Option<PairInnovation<2>> {
        let (residual, covariance) = self.lines.innovation(self.belief, seen, predicted);
        let possible = self.lines.overlap(self.belief, seen, predicted);
        possible.then_some(PairInnovation { residual, covariance })
    }

    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        let jacobian =
            |(seen, predicted)| self.lines.model(seen, predicted).jacobian(&self.belief.mean);
        jacobian(a) * self.belief.covariance * jacobian(b).transpose()
    }
}
