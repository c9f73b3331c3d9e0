//! Markov localization: the probability of every place, kept as a histogram (F5, K1).
//!
//! A Kalman filter has one estimate and its covariance. A histogram filter divides all the
//! places where the robot can be into cells and keeps a probability for each of them. So it can
//! believe in several places at once, needs no start, and recovers when it was wrong. What it does
//! is Bayes' rule, over and over: a motion carries the probabilities along and blurs them
//! ([`Kernel`]), a measurement multiplies each by how likely it is there.
//!
//! The same filter in four sizes: [`DiscreteFilter`] over a handful of named states,
//! [`TopologicalFilter`] over the rooms of a building, [`LineGrid`] over a corridor, and
//! [`GridLocalizer`] over (x, y, heading) in a building.
//!
//! ```
//! use loc_filters::histogram::LineGrid;
//! // A corridor of 10 m with doors at 2 m and 5 m. The robot sees a door, drives 3 m, sees one.
//! let door = |x: f64| 0.05 + [2.0, 5.0].map(|d| (-0.5 * ((x - d) / 0.3_f64).powi(2)).exp()).iter().sum::<f64>();
//! let mut belief = LineGrid::uniform(10.0, 0.1)?;
//! belief.correct(door)?;
//! belief.predict(3.0, 0.2)?;
//! belief.correct(door)?;
//! assert!((belief.most_likely() - 5.0).abs() < 0.1);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod discrete;
mod grid;
mod kernel;
mod line;
mod topological;

pub use discrete::DiscreteFilter;
pub use grid::{FineSettings, GridLocalizer, GridReport, GridSettings, GridUpdate};
pub use kernel::Kernel;
pub use line::LineGrid;
pub use topological::{PlaceViews, TopologicalFilter};
