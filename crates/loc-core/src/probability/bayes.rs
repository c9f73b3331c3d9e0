//! Bayes' rule: from the likelihood of an observation under each cause to the probability of each
//! cause (F1).
//!
//! Example: known is how often the flag is up on a full mailbox, and how often on an empty one.
//! Wanted is the converse: given that the flag is up, is the mailbox full? Bayes' rule gives
//! P(cause | effect) = alpha P(effect | cause) P(cause), where the normaliser alpha = 1 / P(effect)
//! makes the probabilities of all causes sum to 1. In a localizer the causes are the states of the
//! robot, and the effect is a measurement.
//!
//! ```
//! use loc_core::probability::{Discrete, bayes};
//! let mailbox = Discrete::new([("full", 0.3), ("empty", 0.7)])?;
//! let flag_up = |&state: &&str| if state == "full" { 0.9 } else { 0.1 };
//! let posterior = bayes::posterior(&mailbox, flag_up)?;
//! assert!((posterior.evidence() - 0.34).abs() < 1e-12);
//! let full = posterior.distribution.probability(|&state| state == "full");
//! assert!((full - 0.27 / 0.34).abs() < 1e-12);
//! # Ok::<(), loc_core::Error>(())
//! ```

use super::Discrete;
use crate::error::{in_range, non_negative, probability};
use crate::{Error, Result};

/// The posterior distribution, given the evidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Posterior<T> {
    /// P(hypothesis | evidence), in the order of the prior.
    pub distribution: Discrete<T>,
    /// Natural logarithm of P(evidence), or of its density where the likelihood is one.
    pub log_evidence: f64,
}

impl<T> Posterior<T> {
    /// P(evidence) = sum of P(evidence | h) P(h) over all hypotheses h.
    ///
    /// 0 where it is smaller than any number; `log_evidence` still holds it.
    pub fn evidence(&self) -> f64 {
        self.log_evidence.exp()
    }

    /// The normaliser `1 / P(evidence)`.
    pub fn alpha(&self) -> f64 {
        (-self.log_evidence).exp()
    }
}

/// Bayes' rule for one hypothesis: P(h | e) = P(e | h) P(h) / P(e).
///
/// # Errors
/// [`Error::OutOfRange`] where an argument is not a probability, or where they contradict each
/// other, P(e | h) P(h) > P(e); [`Error::ImpossibleEvidence`] where P(e) is 0.
pub fn rule(likelihood: f64, prior: f64, evidence: f64) -> Result<f64> {
    let joint = probability("likelihood P(e | h)", likelihood)? * probability("prior P(h)", prior)?;
    if probability("evidence P(e)", evidence)? <= 0.0 {
        return Err(impossible());
    }
    let what = "posterior P(e | h) P(h) / P(e)";
    // Two roundings may lift a certain conclusion above 1.
    let at_most_one = |p: f64| p <= 1.0 + 4.0 * f64::EPSILON;
    Ok(in_range(what, "a probability in [0, 1]", joint / evidence, at_most_one)?.min(1.0))
}

/// Bayes' rule for all hypotheses of `prior`: `likelihood(h)` is P(evidence | h), up to a common
/// factor; a density is fine.
///
/// For a sequence of measurements that are independent given the hypothesis, the posterior of one
/// is the prior of the next.
///
/// # Errors
/// [`Error::OutOfRange`] for a likelihood that is negative or not finite,
/// [`Error::ImpossibleEvidence`] where no possible hypothesis explains the evidence.
pub fn posterior<T: Clone>(
    prior: &Discrete<T>,
    likelihood: impl Fn(&T) -> f64,
) -> Result<Posterior<T>> {
    let logs = prior.outcomes().iter().map(|hypothesis| {
        let value = non_negative("likelihood", likelihood(hypothesis))?;
        Ok(value.ln())
    });
    from_log_likelihoods(prior, logs.collect::<Result<_>>()?)
}

/// The same from the natural logarithm of the likelihood, for products of many measurements that
/// would underflow; minus infinity stands for 0.
///
/// # Errors
/// [`Error::OutOfRange`] for NaN and plus infinity, [`Error::ImpossibleEvidence`] where no possible
/// hypothesis explains the evidence.
pub fn posterior_from_log<T: Clone>(
    prior: &Discrete<T>,
    log_likelihood: impl Fn(&T) -> f64,
) -> Result<Posterior<T>> {
    let logs = prior.outcomes().iter().map(|hypothesis| {
        let allowed = |value: f64| value < f64::INFINITY;
        let value = log_likelihood(hypothesis);
        in_range("log likelihood", "a number below infinity", value, allowed)
    });
    from_log_likelihoods(prior, logs.collect::<Result<_>>()?)
}

fn from_log_likelihoods<T: Clone>(prior: &Discrete<T>, logs: Vec<f64>) -> Result<Posterior<T>> {
    let log_joint: Vec<f64> = prior
        .probabilities()
        .iter()
        .zip(logs)
        .map(|(p, log_likelihood)| p.ln() + log_likelihood)
        .collect();
    let largest = log_joint.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if !largest.is_finite() {
        return Err(impossible());
    }
    // Relative to the largest, only negligible weights underflow.
    let weights: Vec<f64> = log_joint.iter().map(|log| (log - largest).exp()).collect();
    let total: f64 = weights.iter().sum();
    let probabilities = weights.iter().map(|weight| weight / total).collect();
    Ok(Posterior {
        distribution: Discrete::from_checked(prior.outcomes().to_vec(), probabilities),
        log_evidence: largest + total.ln(),
    })
}

fn impossible() -> Error {
    let what = "posterior distribution";
    Error::ImpossibleEvidence { what }
}
