//! Lateration (D1 to D4): the place at measured distances from landmarks.
//!
//! One distance puts the robot on a circle around a landmark, two where the circles cross, at one
//! of two points; three tell which. [`locate`] finds the place that fits any number of distances
//! best, in the plane or in space, with its covariance and everything that speaks against it:
//! a second place, circles that do not meet, a geometry that magnifies noise. [`two_circles`]
//! gives both points in closed form and [`newton`] the lectures' method with a start.
//! [`SlidingLateration`] follows a robot that measures one distance after the other, with the help
//! of its odometry.
//!
//! ```
//! use loc_filters::lateration::{LaterationSettings, Range, locate};
//! // Two landmarks see the robot at (3, 4) or at (3, -4); the third one decides.
//! let mut ranges = vec![Range::new([0.0, 0.0], 5.0, 0.1), Range::new([6.0, 0.0], 5.0, 0.1)];
//! let two = locate(&ranges, Some([3.0, 1.0].into()), &LaterationSettings::default())?;
//! assert!((two.best.position.y - 4.0).abs() < 1e-9 && !two.is_unique());
//! assert!((two.other.expect("the other side").position.y + 4.0).abs() < 1e-9);
//!
//! ranges.push(Range::new([3.0, 10.0], 6.1, 0.1));
//! let three = locate(&ranges, None, &LaterationSettings::default())?;
//! assert!((three.best.position.y - 3.9).abs() < 0.1 && three.is_unique());
//! # Ok::<(), loc_filters::Error>(())
//! ```
//!
//! # A sensor with a bias
//!
//! Radio ranges are often a few percent too long, or by a constant. With one range more for each,
//! scale and offset can be found beside the place ([`BiasPrior`]).

mod circles;
mod dilution;
mod fix;
mod frame;
mod locate;
mod minimize;
mod newton;
mod place;
mod range;
mod settings;
mod sliding;
mod start;

pub use circles::{Crossing, Miss, two_circles};
pub use dilution::Dilution;
pub use fix::{Caution, Fix, Solution};
pub use locate::locate;
pub use newton::newton;
pub use range::{Range, RangeBias};
pub use settings::{BiasPrior, Cost, LaterationSettings, Loss};
pub use sliding::{RangeOutcome, SlidingLateration, SlidingSettings};
