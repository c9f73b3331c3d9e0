//! Which of the predicted lines each line of a scan is.

use super::{LineModel, PredictedLine};
use crate::extended::MeasurementModel;
use crate::innovation::Innovation;
use crate::{Gate, Result};
use loc_core::{Gaussian, Pose2};
use loc_maps::LineMap;
use loc_sensors::features::Line;
use nalgebra::{Matrix2, Matrix2x3, Vector2};

/// The lines of a scan beside those that a belief predicts, all in the scanner's frame.
pub(super) struct Pairs<'a> {
    pub(super) belief: &'a Gaussian<3>,
    pub(super) map: &'a LineMap,
    pub(super) mounting: Pose2,
    pub(super) seen: &'a [Line],
    pub(super) predicted: &'a [PredictedLine],
    /// Least share of the shorter of two lines beside the other one.
    pub(super) min_overlap: f64,
    /// How far a line may be seen beyond the stretch that is predicted \[m\].
    pub(super) slack: f64,
}

impl Pairs<'_> {
    /// The model of a predicted line for one that was seen.
    pub(super) fn model(&self, seen: usize, predicted: usize) -> LineModel {
        let (line, predicted) = (&self.seen[seen], &self.predicted[predicted]);
        let normal = self.map.lines()[predicted.line].normal_form();
        let model = LineModel::new(normal, self.mounting);
        // On the other side of the scanner r grows where it shrank.
        let expected = model.measured(line.alpha, Matrix2::zeros()).predict(&self.belief.mean);
        let turned = (expected.y - predicted.normal_form.alpha).cos() < 0.0;
        let mut of_map = predicted.covariance;
        if turned {
            (of_map.m12, of_map.m21) = (-of_map.m12, -of_map.m21);
        }
        model.measured(line.alpha, line.covariance + of_map)
    }

    /// Residual, Jacobian, and covariance of the innovation of a pair.
    pub(super) fn linearized(
        &self,
        seen: usize,
        predicted: usize,
    ) -> (Vector2<f64>, Matrix2x3<f64>, Matrix2<f64>) {
        let model = self.model(seen, predicted);
        let (expected, h) = model.linearize(&self.belief.mean);
        let residual = model.residual(&self.measurement(seen), &expected);
        let covariance = h * self.belief.covariance * h.transpose() + model.noise(&expected);
        (residual, h, covariance)
    }

    /// (r, alpha) of a line of the scan.
    pub(super) fn measurement(&self, seen: usize) -> Vector2<f64> {
        Vector2::new(self.seen[seen].r, self.seen[seen].alpha)
    }

    /// Whether two lines lie beside each other, as far as the pose is known.
    pub(super) fn overlap(&self, seen: usize, predicted: usize) -> bool {
        let (line, stretch) = (&self.seen[seen], &self.predicted[predicted].stretch);
        let (sin, cos) = line.alpha.sin_cos();
        let along = Vector2::new(-sin, cos);
        let span = |a: f64, b: f64| [a.min(b), a.max(b)];
        let [a, b] = span(line.start.coords.dot(&along), line.end.coords.dot(&along));
        let [c, d] = span(stretch.start.coords.dot(&along), stretch.end.coords.dot(&along));
        // Two standard deviations of the position along the line.
        let turned = (self.belief.pose() * self.mounting).rotation() * along;
        let position = self.belief.position().covariance;
        let sigma = turned.dot(&(position * turned)).max(0.0).sqrt();
        let slack = self.slack + 2.0 * sigma;
        let (c, d) = (c - slack, d + slack);
        let common = b.min(d) - a.max(c);
        common > 0.0 && common >= self.min_overlap * (b - a).min(d - c)
    }

    /// For each line of the scan the predicted line that is most likely, of those that overlap it
    /// and lie within the gate.
    pub(super) fn most_likely(&self, gate: &Gate) -> Result<Vec<Option<usize>>> {
        let mut partners = Vec::with_capacity(self.seen.len());
        for seen in 0..self.seen.len() {
            let mut best: Option<(f64, usize)> = None;
            for predicted in (0..self.predicted.len()).filter(|&k| self.overlap(seen, k)) {
                let (residual, _, covariance) = self.linearized(seen, predicted);
                let (innovation, _) = Innovation::new(residual, covariance, gate)?;
                let likelihood = innovation.log_likelihood();
                if innovation.accepted && best.is_none_or(|(most, _)| likelihood > most) {
                    best = Some((likelihood, predicted));
                }
            }
            partners.push(best.map(|(_, predicted)| predicted));
        }
        Ok(partners)
    }
}
