//! The Bayes filter over named states (F5).
//!
//! The smallest localizer: the states are few, each has a probability, and between two measurements
//! the state may change. Is the mailbox full? Its flag is a measurement, and the mail comes every
//! day.
//!
//! ```
//! use loc_core::probability::Discrete;
//! use loc_filters::histogram::DiscreteFilter;
//! let mut mailbox = DiscreteFilter::new(Discrete::new([("full", 0.0), ("empty", 1.0)])?);
//! // Mail comes with probability 0.6, and a full mailbox stays full.
//! mailbox.predict(|from, to| match (*from, *to) {
//!     ("full", "full") => 1.0,
//!     ("empty", "full") => 0.6,
//!     ("empty", "empty") => 0.4,
//!     _ => 0.0,
//! })?;
//! // The flag is up, which it is for 0.9 of all mail, and in 0.1 of the cases without any.
//! mailbox.correct(|state| if *state == "full" { 0.9 } else { 0.1 })?;
//! let full = mailbox.belief().probability(|state| *state == "full");
//! assert!((full - 0.54 / 0.58).abs() < 1e-12);
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::Result;
use loc_core::error::{in_range, probability};
use loc_core::probability::{Discrete, bayes};

/// How far the probabilities of what follows a state may be from the sum 1.
const TOLERANCE: f64 = 1e-9;

/// A belief over states, and how it follows motions and measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteFilter<T> {
    belief: Discrete<T>,
}

impl<T: Clone> DiscreteFilter<T> {
    /// A filter that starts from a distribution over the states.
    pub fn new(start: Discrete<T>) -> Self {
        DiscreteFilter { belief: start }
    }

    /// The current belief.
    pub fn belief(&self) -> &Discrete<T> {
        &self.belief
    }

    /// The state changes: `transition(from, to)` is P(to | from), which for every `from` adds up to
    /// 1 over all states. P'(to) = sum of P(to | from) P(from).
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a transition that is no probability, and where they do
    /// not add up to 1 within 1e-9; the belief is kept then.
    // ANCHOR: predict
    pub fn predict(&mut self, transition: impl Fn(&T, &T) -> f64) -> Result<()> {
        let states = self.belief.outcomes();
        let mut after = vec![0.0; states.len()];
        for (from, p) in self.belief.iter() {
            let mut sum = 0.0;
            for (to, after) in states.iter().zip(&mut after) {
                let share = probability("transition P(to | from)", transition(from, to))?;
                *after += p * share;
                sum += share;
            }
            let complete = |sum: f64| (sum - 1.0).abs() <= TOLERANCE;
            in_range("sum of the transitions from a state", "1 within 1e-9", sum, complete)?;
        }
        self.belief = Discrete::from_weights(states.iter().cloned().zip(after))?;
        Ok(())
    }
    // ANCHOR_END: predict

    /// A measurement: `likelihood(state)` is P(measurement | state), up to a common factor. Returns
    /// the logarithm of P(measurement).
    ///
    /// # Errors
    /// Those of [`bayes::posterior`]; the belief is kept then.
    pub fn correct(&mut self, likelihood: impl Fn(&T) -> f64) -> Result<f64> {
        let posterior = bayes::posterior(&self.belief, likelihood)?;
        self.belief = posterior.distribution;
        Ok(posterior.log_evidence)
    }
}
