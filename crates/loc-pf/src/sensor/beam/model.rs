//! The density of a range.

use super::range_model::rows;
use super::{BeamForm, BeamModelSettings, RangeModel};
use crate::Result;
use loc_core::Normal;
use std::f64::consts::TAU;

/// No range is less likely than this \[1/m\], so that a share of 0 rules no pose out for good.
const MIN: f64 = 1e-12;

/// Parts of `sigma_hit` between which the logarithm is interpolated.
const STEPS_PER_SIGMA: f64 = 8.0;

/// Most steps from 0 to the longest range.
const MAX_STEPS: f64 = 16384.0;

/// Farther from the expected range than this nothing counts as a hit \[sigma_hit\].
const REACH: f64 = 8.0;

/// The beam model of a range finder (M6; Thrun, Burgard and Fox, Probabilistic Robotics, 6.3.1):
/// `p(d | d*) = z_hit p_hit + z_short p_short + z_max p_max + z_rand p_rand`.
///
/// * `p_hit` is `N(d; d*, sigma_hit^2)`, normalised on `[0, max_range]`;
/// * `p_short` is `lambda exp(-lambda d)`, normalised on `[0, d*]`;
/// * `p_max` is the probability of no return;
/// * `p_rand` is `1 / max_range`.
///
/// Where nothing is expected (`d* = +inf`), no return is what a hit looks like: its probability is
/// `z_hit + z_max`. The book has half a Gaussian there, which makes a scanner that rightly sees
/// nothing an outlier. For every `d*` above 0 the densities and the probability of no return add
/// up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamModel {
    settings: BeamModelSettings,
}

impl BeamModel {
    /// A model; the shares need not add up to 1.
    ///
    /// # Errors
    /// Those of [`BeamModelSettings::validate`].
    pub fn new(settings: &BeamModelSettings) -> Result<Self> {
        Ok(BeamModel { settings: settings.normalized()? })
    }

    /// The parameters, with shares that add up to 1.
    pub fn settings(&self) -> &BeamModelSettings {
        &self.settings
    }

    /// The parts of `p(measured | expected)` in the order hit, short, max, random, each with its
    /// share: densities \[1/m\] for a finite `measured`, probabilities for +inf.
    // ANCHOR: parts
    pub fn parts(&self, expected: f64, measured: f64) -> [f64; 4] {
        let BeamModelSettings { z_hit, z_short, z_max, z_rand, max_range, .. } = self.settings;
        let expects = expected < max_range;
        if measured >= max_range {
            return [if expects { 0.0 } else { z_hit }, 0.0, z_max, 0.0];
        }
        let hit = if expects { z_hit * self.hit(expected, measured) } else { 0.0 };
        let expected = expected.min(max_range);
        let before = measured <= expected && expected > 0.0;
        let short = if before { z_short * self.short(expected, measured) } else { 0.0 };
        [hit, short, 0.0, z_rand / max_range]
    }
    // ANCHOR_END: parts

    fn hit(&self, expected: f64, measured: f64) -> f64 {
        let sigma = self.settings.sigma_hit;
        let deviation = (measured - expected) / sigma;
        (-0.5 * deviation * deviation).exp() / (sigma * TAU.sqrt() * self.inside(expected))
    }

    /// The share of the bell about `expected` that lies within `[0, max_range]`.
    fn inside(&self, expected: f64) -> f64 {
        let BeamModelSettings { sigma_hit, max_range, .. } = self.settings;
        let (low, high) = (-expected / sigma_hit, (max_range - expected) / sigma_hit);
        if low < -REACH && high > REACH { 1.0 } else { Normal::STANDARD.probability(low, high) }
    }

    fn short(&self, expected: f64, measured: f64) -> f64 {
        let lambda = self.settings.lambda_short;
        lambda * (-lambda * measured).exp() / -(-lambda * expected).exp_m1()
    }

    fn log_gaussian(&self, expected: f64, measured: f64) -> f64 {
        let BeamModelSettings { sigma_hit, max_range, .. } = self.settings;
        let deviation = (measured.min(max_range) - expected.min(max_range)) / sigma_hit;
        -0.5 * (deviation * deviation + TAU.ln()) - sigma_hit.ln()
    }
}

impl RangeModel for BeamModel {
    fn max_range(&self) -> f64 {
        self.settings.max_range
    }

    fn step(&self) -> f64 {
        let BeamModelSettings { sigma_hit, max_range, .. } = self.settings;
        (sigma_hit / STEPS_PER_SIGMA).clamp(max_range / MAX_STEPS, max_range / 2.0)
    }

    fn log_density(&self, expected: f64, measured: f64) -> f64 {
        match self.settings.form {
            BeamForm::Gaussian => self.log_gaussian(expected, measured),
            BeamForm::Mixture => {
                let parts: f64 = self.parts(expected, measured).iter().sum();
                parts.max(MIN).ln()
            }
        }
    }

    /// The same numbers as by single calls, without what is the same for many pairs of ranges.
    fn tabulate(&self, measured: &[f64], step: f64, tables: &mut [f32]) {
        let BeamModelSettings { z_short, z_rand, max_range, sigma_hit, lambda_short, .. } =
            self.settings;
        let mixture = self.settings.form == BeamForm::Mixture;
        let entries = tables.len().checked_div(measured.len()).unwrap_or(0);
        // What the densities of short ranges are divided by.
        let before = |k: usize| -(-lambda_short * k as f64 * step).exp_m1();
        let stopped: Vec<f64> = (0..entries).map(|k| z_short * lambda_short / before(k)).collect();
        let random = (z_rand / max_range).max(MIN);
        for (&measured, table) in measured.iter().zip(rows(tables, measured.len())) {
            let Some((finite, nothing)) = table.split_last_chunk_mut::<2>() else { return };
            nothing.fill(self.log_density(f64::INFINITY, measured) as f32);
            if mixture && measured >= max_range {
                finite.fill(self.log_density(0.0, measured) as f32);
                continue;
            }
            let decay = (-lambda_short * measured).exp();
            let far = random.ln() as f32;
            for (k, logarithm) in finite.iter_mut().enumerate() {
                // The longest range itself would be no return already.
                let expected = (k as f64 * step).min(max_range.next_down());
                let near = (expected - measured).abs() < REACH * sigma_hit;
                *logarithm = if near || !mixture {
                    self.log_density(expected, measured) as f32
                } else if expected < measured {
                    far
                } else {
                    (stopped[k] * decay + random).ln() as f32
                };
            }
        }
    }
}
