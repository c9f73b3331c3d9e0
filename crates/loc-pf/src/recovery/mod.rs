//! Finding the robot again after it was carried off, or lost for another reason (A3).
//!
//! A cloud that follows one place never looks at another by itself. [`AugmentedMcl`] replaces a
//! share of it by particles from all over the map when scans fit worse than they used to.
//! [`Suspicion`] is sharper: it weighs the evidence that the robot is where the cloud says against
//! that of its being anywhere else, as a Bayes filter over these two, and calls for a global search
//! only when the second gains ground.
//!
//! ```
//! use loc_pf::recovery::{AugmentedMcl, AugmentedSettings};
//! let mut recovery = AugmentedMcl::new(AugmentedSettings::default())?;
//! assert_eq!(recovery.update(-50.0), 0.0);
//! // A scan that fits e^30 times worse: the fast average loses a tenth, the slow one hardly any.
//! assert!((recovery.update(-80.0) - (1.0 - 0.9 / 0.999)).abs() < 1e-9);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod augmented;
mod suspicion;

pub use augmented::{AugmentedMcl, AugmentedSettings};
pub use suspicion::{Suspicion, SuspicionSettings, UsualEvidence};
