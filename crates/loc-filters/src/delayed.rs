//! Inputs that come late: the filter goes back, takes them in, and comes forward again.
//!
//! Cameras need time to compute; their measurements arrive after odometry that is younger. A
//! [`DelayedFilter`] remembers the inputs of the last seconds with the state before each, so that
//! a late input is applied where it belongs. The result is the same, to the bit, as if everything
//! had come in order of its stamps; inputs of one stamp keep the order in which they came, unless
//! the filter ranks them.
//!
//! ```
//! use loc_filters::delayed::{DelayedFilter, Step};
//!
//! /// Writes down what it is given.
//! #[derive(Clone)]
//! struct Diary(String);
//! impl Step for Diary {
//!     type Input = char;
//!     type Report = ();
//!     fn step(&mut self, _stamp: f64, letter: &char) -> loc_filters::Result<()> {
//!         self.0.push(*letter);
//!         Ok(())
//!     }
//! }
//!
//! let mut diary = DelayedFilter::new(Diary(String::new()), 1.0)?;
//! for (stamp, letter) in [(0.0, 'a'), (0.1, 'b'), (0.3, 'd'), (0.2, 'c')] {
//!     diary.input("letter", stamp, letter)?;
//! }
//! assert_eq!(diary.newest().0, "abcd");
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::{Error, Result};
use std::collections::VecDeque;
use std::fmt::Debug;

/// A filter that takes one stamped input after the other.
pub trait Step: Clone {
    /// What it is given: a control, a measurement.
    type Input: Clone + Debug;
    /// What it answers.
    type Report;
    /// Takes in an input whose stamp \[s\] is not before the last one.
    ///
    /// # Errors
    /// As the filter says; it must then be as it was before.
    fn step(&mut self, stamp: f64, input: &Self::Input) -> Result<Self::Report>;
    /// The place of an input among others of the same stamp, the lowest first. Inputs of one rank
    /// keep the order in which they came.
    fn rank(_input: &Self::Input) -> u64 {
        0
    }
}

/// A filter with a memory of the recent past.
#[derive(Debug, Clone)]
pub struct DelayedFilter<F: Step> {
    now: F,
    past: VecDeque<Moment<F>>,
    horizon: f64,
}

/// An input, and the filter as it was before it.
#[derive(Debug, Clone)]
struct Moment<F: Step> {
    stamp: f64,
    input: F::Input,
    before: F,
}

impl<F: Step> DelayedFilter<F> {
    /// A filter that accepts inputs up to `horizon` \[s\] late; 0 for inputs in order only.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a negative horizon.
    pub fn new(filter: F, horizon: f64) -> Result<Self> {
        let horizon = loc_core::error::non_negative("horizon for late inputs [s]", horizon)?;
        Ok(DelayedFilter { now: filter, past: VecDeque::new(), horizon })
    }

    /// The filter after its newest input.
    pub fn newest(&self) -> &F {
        &self.now
    }

    /// The filter after its last input up to `stamp` \[s\]; the oldest remembered one where that
    /// is too far back.
    pub fn at(&self, stamp: f64) -> &F {
        let later = self.past.partition_point(|moment| moment.stamp <= stamp);
        self.past.get(later).map_or(&self.now, |moment| &moment.before)
    }

    /// Takes in an input where its stamp belongs. `what` names it in errors.
    ///
    /// # Errors
    /// [`Error::TooLate`] beyond the horizon, [`loc_core::Error::OutOfRange`] for a stamp that is
    /// not finite, and what the filter itself refuses; the filter is then as it was before.
    pub fn input(&mut self, what: &'static str, stamp: f64, input: F::Input) -> Result<F::Report> {
        loc_core::error::finite("stamp [s]", stamp)?;
        let rank = F::rank(&input);
        let before = |moment: &Moment<F>| {
            moment.stamp < stamp || (moment.stamp <= stamp && F::rank(&moment.input) <= rank)
        };
        let place = self.past.partition_point(before);
        let Some(newest) = self.past.back().map(|moment| moment.stamp) else {
            return self.append(stamp, input);
        };
        if place == self.past.len() {
            return self.append(stamp, input);
        }
        if stamp < newest - self.horizon {
            return Err(Error::TooLate { what, stamp, newest, horizon: self.horizon });
        }
        self.insert(place, stamp, input)
    }

    /// The common case: an input that is the newest.
    fn append(&mut self, stamp: f64, input: F::Input) -> Result<F::Report> {
        let before = self.now.clone();
        let report = self.now.step(stamp, &input)?;
        self.past.push_back(Moment { stamp, input, before });
        // The newest moment stays, so that there is always a last stamp to compare with.
        while self.past.len() > 1 && self.past[0].stamp < stamp - self.horizon {
            self.past.pop_front();
        }
        Ok(report)
    }

    /// Goes back to `place`, takes the input in and repeats what came after it.
    fn insert(&mut self, place: usize, stamp: f64, input: F::Input) -> Result<F::Report> {
        let mut filter = self.past[place].before.clone();
        let before = filter.clone();
        let report = filter.step(stamp, &input)?;
        let mut repeated = Vec::with_capacity(self.past.len() - place);
        for moment in self.past.range(place..) {
            repeated.push(filter.clone());
            filter.step(moment.stamp, &moment.input)?;
        }
        for (moment, before) in self.past.range_mut(place..).zip(repeated) {
            moment.before = before;
        }
        self.past.insert(place, Moment { stamp, input, before });
        self.now = filter;
        Ok(report)
    }
}
