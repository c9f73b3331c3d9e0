//! Probabilities of events, tables of them, and Bayes' rule (F1).
//!
//! An experiment has outcomes, each with a probability; an event is a set of outcomes, given here
//! by a function that says whether an outcome belongs to it. [`Discrete`] holds the outcomes of
//! one variable, [`Joint`] the table of two, and [`bayes`] turns the probability of a measurement
//! in each state into the probability of each state after the measurement: the step that every
//! localizer of this workspace takes. [`Uniform`] is the simplest distribution of a continuous
//! number.
//!
//! ```
//! use loc_core::probability::Discrete;
//! let die = Discrete::uniform(1..=6)?;
//! assert!((die.probability(|eyes| eyes % 2 == 0) - 0.5).abs() < 1e-12);
//! assert!((die.expectation(|&eyes| f64::from(eyes)) - 3.5).abs() < 1e-12);
//! # Ok::<(), loc_core::Error>(())
//! ```

pub mod bayes;
mod discrete;

pub use crate::sampling::Uniform;
pub use discrete::{Discrete, Joint};
