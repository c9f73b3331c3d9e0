//! The beam model's parameters by maximum likelihood.

use super::RangePair;
use super::statistics::Statistics;
use crate::Result;
use crate::sensor::beam::{BeamForm, BeamModel, BeamModelSettings};

/// Fewer pairs with both ranges in reach say nothing about six parameters.
const FEWEST: usize = 100;

/// At most so many steps.
const MAX_STEPS: usize = 500;

/// The fit has converged when a step gains less than this a pair.
const GAIN: f64 = 1e-7;

/// How often a step that loses is halved.
const HALVINGS: usize = 30;

/// A share of 0 would stay 0.
const MIN_SHARE: f64 = 0.01;

/// What was fitted, and how.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct FitReport {
    /// The parameters found; shares add up to 1.
    pub settings: BeamModelSettings,
    /// The mean of `ln p(measured | expected)` over the pairs, at the start and after every step;
    /// it never falls.
    pub log_likelihoods: Vec<f64>,
    /// Number of pairs that were used.
    pub pairs: usize,
    /// Whether the last step gained next to nothing; if not, the steps ran out.
    pub converged: bool,
}

/// The parameters of the beam model that make the pairs most likely, found by expectation
/// maximization from `start` (K2; Probabilistic Robotics, table 6.2, with exact normalisers).
///
/// `start` also says the longest range; the form of the model is always the mixture. Shares below
/// 0.01 start from there. `sigma_hit` does not go below 1 mm, nor `lambda_short` below 1e-4 / m.
///
/// # Errors
/// [`loc_core::Error::Length`] for fewer than 100 pairs with both ranges in reach; pairs that are
/// not two ranges (NaN, negative) do not count. Those of [`BeamModelSettings::validate`].
pub fn fit_beam_model(pairs: &[RangePair], start: &BeamModelSettings) -> Result<FitReport> {
    let mut settings = start.normalized()?;
    let z = [&mut settings.z_hit, &mut settings.z_short, &mut settings.z_max, &mut settings.z_rand];
    z.into_iter().for_each(|share| *share = share.max(MIN_SHARE));
    settings.form = BeamForm::Mixture;
    let ranges = |pair: &&RangePair| pair.expected >= 0.0 && pair.measured >= 0.0;
    let pairs: Vec<RangePair> = pairs.iter().filter(ranges).copied().collect();
    let in_reach = |pair: &&RangePair| pair.expected.max(pair.measured) < settings.max_range;
    let found = pairs.iter().filter(in_reach).count();
    if found < FEWEST {
        let what = "pairs of an expected and a measured range within reach";
        return Err(loc_core::Error::Length { what, expected: "at least 100", found }.into());
    }
    climb(&pairs, settings.normalized()?)
}

/// Steps until they gain nothing more.
// ANCHOR: climb
fn climb(pairs: &[RangePair], mut settings: BeamModelSettings) -> Result<FitReport> {
    let mean = |statistics: &Statistics| statistics.log_likelihood / pairs.len() as f64;
    let mut now = Statistics::of(pairs, &BeamModel::new(&settings)?);
    let mut log_likelihoods = vec![mean(&now)];
    let mut converged = false;
    while !converged && log_likelihoods.len() <= MAX_STEPS {
        let mut proposed = now.improve(&settings);
        let mut next = Statistics::of(pairs, &BeamModel::new(&proposed)?);
        for _ in 0..HALVINGS {
            // Written so that NaN loses.
            if next.log_likelihood >= now.log_likelihood {
                break;
            }
            proposed = between(&settings, &proposed);
            next = Statistics::of(pairs, &BeamModel::new(&proposed)?);
        }
        let gain = mean(&next) - mean(&now);
        converged = gain.is_nan() || gain < GAIN;
        if gain >= 0.0 {
            (settings, now) = (proposed, next);
            log_likelihoods.push(mean(&now));
        }
    }
    Ok(FitReport { settings, log_likelihoods, pairs: pairs.len(), converged })
}
// ANCHOR_END: climb

/// Half the way from one set of parameters to another.
fn between(a: &BeamModelSettings, b: &BeamModelSettings) -> BeamModelSettings {
    BeamModelSettings {
        form: a.form,
        max_range: a.max_range,
        z_hit: 0.5 * (a.z_hit + b.z_hit),
        z_short: 0.5 * (a.z_short + b.z_short),
        z_max: 0.5 * (a.z_max + b.z_max),
        z_rand: 0.5 * (a.z_rand + b.z_rand),
        sigma_hit: (a.sigma_hit * b.sigma_hit).sqrt(),
        lambda_short: (a.lambda_short * b.lambda_short).sqrt(),
    }
}
