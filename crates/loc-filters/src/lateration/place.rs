//! Ranges as a sum to minimise over coordinates, scale and offset.

use super::minimize::{Minimum, OFFSET, Problem, Row, SCALE, Unknowns};
use super::{BiasPrior, Cost, Dilution, Fix, LaterationSettings, Loss, Range, RangeBias};
use crate::Result;
use nalgebra::{Point, SVector};

/// Ranges in a frame in which their extent is 1.
pub(super) struct Place<'a, const D: usize> {
    ranges: &'a [Range<D>],
    settings: LaterationSettings,
    /// Typical sigma of a squared distance, the unit of the SSE.
    square: f64,
}

impl<'a, const D: usize> Place<'a, D> {
    pub(super) fn new(ranges: &'a [Range<D>], settings: LaterationSettings) -> Self {
        let total: f64 = ranges.iter().map(|r| square_sigma(r).powi(2)).sum();
        let square = (total / ranges.len().max(1) as f64).sqrt();
        Place { ranges, settings, square }
    }

    fn row(&self, range: &Range<D>, at: &Unknowns) -> Row {
        let bias = RangeBias { scale: at[SCALE], offset: at[OFFSET] };
        let way = SVector::<f64, D>::from_fn(|k, _| at[k] - range.landmark[k]);
        let distance = way.norm();
        // At a landmark the distance has no direction and says nothing to first order.
        let direction = way.try_normalize(0.0).unwrap_or_else(SVector::zeros);
        let loss = self.settings.loss;
        let mut gradient = Unknowns::zeros();
        let expected = bias.reported(distance);
        let residual = expected - range.distance;
        (0..D).for_each(|k| gradient[k] = bias.scale * direction[k]);
        gradient[SCALE] = distance;
        gradient[OFFSET] = 1.0;
        match self.settings.cost {
            Cost::Distances => Row { residual, gradient, ..Row::like(range.sigma, loss) },
            Cost::Squares => Row {
                residual: residual * (expected + range.distance),
                gradient: 2.0 * expected * gradient,
                scale: self.square,
                ..Row::like(square_sigma(range), loss)
            },
        }
    }

    /// What is known at a minimum.
    pub(super) fn fix(&self, minimum: &Minimum) -> Result<Fix<D>> {
        let position = place_of::<D>(&minimum.at);
        let bias = RangeBias { scale: minimum.at[SCALE], offset: minimum.at[OFFSET] };
        let mut fix = Fix {
            position,
            covariance: minimum.covariance.fixed_view::<D, D>(0, 0).into(),
            bias,
            bias_sigmas: [SCALE, OFFSET].map(|k| minimum.covariance[(k, k)].max(0.0).sqrt()),
            cost: minimum.cost,
            sse: 0.0,
            residuals: Vec::with_capacity(self.ranges.len()),
            weights: Vec::with_capacity(self.ranges.len()),
            dilution: Dilution::at(&position, self.ranges.iter().map(|range| range.landmark))?,
        };
        for range in self.ranges {
            let expected = bias.reported((position - range.landmark).norm());
            let Row { residual, sigma, loss, .. } = self.row(range, &minimum.at);
            fix.sse += ((expected - range.distance) * (expected + range.distance)).powi(2);
            fix.residuals.push(range.distance - expected);
            fix.weights.push(loss.weight(residual / sigma));
        }
        Ok(fix)
    }
}

impl<const D: usize> Problem for Place<'_, D> {
    fn rows(&self, at: &Unknowns, visit: &mut dyn FnMut(&Row)) {
        self.ranges.iter().for_each(|range| visit(&self.row(range, at)));
        bias_rows(&self.settings.bias, at, visit);
    }

    fn reach(&self) -> Unknowns {
        let mut reach = Unknowns::zeros();
        reach.fixed_rows_mut::<D>(0).fill(1.0);
        bias_reach(&self.settings.bias, 1.0, &mut reach);
        reach
    }
}

/// What is known of scale and offset beforehand.
pub(super) fn bias_rows(bias: &BiasPrior, at: &Unknowns, visit: &mut dyn FnMut(&Row)) {
    for (k, usual, sigma) in [(SCALE, 1.0, bias.scale_sigma), (OFFSET, 0.0, bias.offset_sigma)] {
        if sigma > 0.0 && sigma.is_finite() {
            let mut gradient = Unknowns::zeros();
            gradient[k] = 1.0;
            let residual = at[k] - usual;
            visit(&Row { residual, gradient, ..Row::like(sigma, Loss::Quadratic) });
        }
    }
}

/// How far scale and offset can be off: both by as much as what they are part of.
pub(super) fn bias_reach(bias: &BiasPrior, extent: f64, reach: &mut Unknowns) {
    reach[SCALE] = if bias.scale_sigma > 0.0 { 1.0 } else { 0.0 };
    reach[OFFSET] = if bias.offset_sigma > 0.0 { extent } else { 0.0 };
}

/// A place, with a sensor that is right.
pub(super) fn unknowns_at<const D: usize>(place: &Point<f64, D>) -> Unknowns {
    let mut at = Unknowns::zeros();
    at[SCALE] = 1.0;
    at.fixed_rows_mut::<D>(0).copy_from(&place.coords);
    at
}

/// The place among the unknowns.
pub(super) fn place_of<const D: usize>(at: &Unknowns) -> Point<f64, D> {
    Point::from(at.fixed_rows::<D>(0).into_owned())
}

/// Standard deviation of a squared distance.
fn square_sigma<const D: usize>(range: &Range<D>) -> f64 {
    let linear = 2.0 * range.distance * range.sigma;
    f64::hypot(linear, std::f64::consts::SQRT_2 * range.sigma * range.sigma)
}
