//! Distributions over a finite set of outcomes.

use crate::error::{in_range, non_negative};
use crate::sampling::CumulativeTable;
use crate::{Error, Result};
use rand::Rng;

/// How far a sum of probabilities may be from 1, and a product from the probability of two
/// independent events.
pub(super) const TOLERANCE: f64 = 1e-9;

/// A distribution over labelled outcomes: at least one, their probabilities >= 0 with sum 1.
///
/// Outcomes need not differ: equal labels are separate outcomes of the same name.
#[derive(Debug, Clone, PartialEq)]
pub struct Discrete<T> {
    outcomes: Vec<T>,
    probabilities: Vec<f64>,
    cumulative: CumulativeTable,
}

impl<T> Discrete<T> {
    /// A distribution from pairs (outcome, probability).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a probability that is negative or not finite, and where their sum
    /// is not 1 within 1e-9 (no pairs included).
    pub fn new(pairs: impl IntoIterator<Item = (T, f64)>) -> Result<Self> {
        let (outcomes, probabilities): (Vec<T>, Vec<f64>) = pairs.into_iter().unzip();
        check_probabilities(&probabilities)?;
        Ok(Discrete::from_checked(outcomes, probabilities))
    }

    /// Every outcome with the same probability.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] without outcomes.
    pub fn uniform(outcomes: impl IntoIterator<Item = T>) -> Result<Self> {
        Discrete::from_weights(outcomes.into_iter().map(|outcome| (outcome, 1.0)))
    }

    /// Probabilities in proportion to the weights of pairs (outcome, weight).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for a weight that is negative or not finite, and where their sum is
    /// 0 (no pairs included) or overflows.
    pub fn from_weights(pairs: impl IntoIterator<Item = (T, f64)>) -> Result<Self> {
        let (outcomes, weights): (Vec<T>, Vec<f64>) = pairs.into_iter().unzip();
        let total = CumulativeTable::new(weights.iter().copied())?.total();
        let probabilities = weights.iter().map(|weight| weight / total).collect();
        Ok(Discrete::from_checked(outcomes, probabilities))
    }

    /// A distribution of probabilities that are known to be finite, >= 0, and to sum to 1.
    pub(super) fn from_checked(outcomes: Vec<T>, probabilities: Vec<f64>) -> Self {
        Discrete {
            outcomes,
            cumulative: CumulativeTable::from_checked(&probabilities),
            probabilities,
        }
    }

    /// The outcomes, in the order given.
    pub fn outcomes(&self) -> &[T] {
        &self.outcomes
    }

    /// The probabilities, in the order of the outcomes.
    pub fn probabilities(&self) -> &[f64] {
        &self.probabilities
    }

    /// Pairs (outcome, probability).
    pub fn iter(&self) -> impl Iterator<Item = (&T, f64)> {
        self.outcomes.iter().zip(self.probabilities.iter().copied())
    }

    /// Probability of the event that holds the outcomes for which `event` is true.
    pub fn probability(&self, event: impl Fn(&T) -> bool) -> f64 {
        let members = self.iter().filter(|(outcome, _)| event(outcome));
        members.map(|(_, p)| p).sum()
    }

    /// The distribution once it is known that `event` happened: P(a | e) = P(a and e) / P(e).
    ///
    /// # Errors
    /// [`Error::ImpossibleEvidence`] where the event has probability 0.
    pub fn given(&self, event: impl Fn(&T) -> bool) -> Result<Discrete<T>>
    where
        T: Clone,
    {
        let members: Vec<(T, f64)> = self
            .iter()
            .filter(|(outcome, _)| event(outcome))
            .map(|(outcome, p)| (outcome.clone(), p))
            .collect();
        if members.iter().all(|&(_, p)| p <= 0.0) {
            let what = "conditional distribution";
            return Err(Error::ImpossibleEvidence { what });
        }
        Discrete::from_weights(members)
    }

    /// Whether two events are independent: P(a and b) = P(a) P(b) within 1e-9.
    pub fn independent(&self, a: impl Fn(&T) -> bool, b: impl Fn(&T) -> bool) -> bool {
        let both = self.probability(|outcome| a(outcome) && b(outcome));
        (both - self.probability(a) * self.probability(b)).abs() <= TOLERANCE
    }

    /// Expected value of a number that depends on the outcome: E(f) = sum f(x) P(x).
    ///
    /// Outcomes of probability 0 do not count, whatever `f` says of them.
    pub fn expectation(&self, f: impl Fn(&T) -> f64) -> f64 {
        let possible = self.iter().filter(|&(_, p)| p > 0.0);
        possible.map(|(outcome, p)| f(outcome) * p).sum()
    }

    /// Variance of a number that depends on the outcome: E((f - E(f))^2).
    pub fn variance(&self, f: impl Fn(&T) -> f64) -> f64 {
        let mean = self.expectation(&f);
        self.expectation(|outcome| (f(outcome) - mean).powi(2))
    }

    /// Covariance of two numbers that depend on the outcome: E((f - E(f)) (g - E(g))).
    pub fn covariance(&self, f: impl Fn(&T) -> f64, g: impl Fn(&T) -> f64) -> f64 {
        let (f_mean, g_mean) = (self.expectation(&f), self.expectation(&g));
        self.expectation(|outcome| (f(outcome) - f_mean) * (g(outcome) - g_mean))
    }

    /// The outcome of the highest probability, the first of several.
    pub fn most_likely(&self) -> &T {
        let mut best = 0;
        for (index, &p) in self.probabilities.iter().enumerate() {
            if p > self.probabilities[best] {
                best = index;
            }
        }
        &self.outcomes[best]
    }

    /// Entropy `-sum p ln p` \[nat\]: 0 for certainty, ln n where n outcomes are equally likely.
    pub fn entropy(&self) -> f64 {
        let possible = self.probabilities.iter().filter(|&&p| p > 0.0);
        possible.map(|&p| -p * p.ln()).sum::<f64>().max(0.0)
    }

    /// Draws an outcome by the inverse of the cumulative distribution (F4).
    pub fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> &T {
        &self.outcomes[self.cumulative.sample(rng)]
    }

    /// The distribution of a random variable, a function of the outcome; outcomes with equal
    /// values are added up.
    pub fn map<U: PartialEq>(&self, variable: impl Fn(&T) -> U) -> Discrete<U> {
        let (mut values, mut sums): (Vec<U>, Vec<f64>) = (Vec::new(), Vec::new());
        for (outcome, p) in self.iter() {
            let value = variable(outcome);
            match values.iter().position(|known| *known == value) {
                Some(index) => sums[index] += p,
                None => {
                    values.push(value);
                    sums.push(p);
                }
            }
        }
        Discrete::from_checked(values, sums)
    }
}

/// Checks that probabilities are >= 0, finite, and sum to 1 within 1e-9.
pub(super) fn check_probabilities(probabilities: &[f64]) -> Result<()> {
    let mut sum = 0.0;
    for &p in probabilities {
        sum += non_negative("probability", p)?;
    }
    let normalized = |sum: f64| (sum - 1.0).abs() <= TOLERANCE;
    in_range("sum of the probabilities", "1 within 1e-9", sum, normalized)?;
    Ok(())
}
