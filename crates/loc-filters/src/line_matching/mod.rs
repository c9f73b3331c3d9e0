//! Localization by the walls of a building: lines of a laser scan against lines of a map (H4).
//!
//! Indoors a scan is mostly straight walls. Each is two numbers that are known very well: its
//! distance r from the scanner, and the direction alpha of its normal
//! ([`loc_sensors::features`]). From where the robot believes to be, the map predicts which walls
//! it should see, and where ([`LineEkf::predicted`]). A line of the scan and a predicted one that lie
//! beside each other, and are no farther apart than both are uncertain, are the same wall; each
//! such pair pulls the pose into place. Lines without a partner, of things that the map does not
//! know, are left alone (H3).
//!
//! A wall says nothing about the place along it: in a long corridor the covariance stays large
//! that way, until a wall across comes into view.
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_filters::line_matching::{LineEkf, LineMatchingSettings};
//! use loc_maps::LineMap;
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//!
//! let room = LineMap::parse_csv("room.csv", "0,0,6,0\n6,0,6,4\n6,4,0,4\n0,4,0,0\n")?;
//! let (truth, mounting) = (Pose2::new(2.5, 1.5, 0.3), Pose2::new(0.1, 0.0, 0.0));
//! let scanner = LaserScanner { mounting, ..LaserScanner::new(LaserSpec::sick_lms100())? };
//! let scan = scanner.scan(&room, truth, &mut stream(1, "laser"));
//!
//! let start = pose_belief(Pose2::new(2.3, 1.6, 0.25), [0.2, 0.2, 0.1]);
//! let mut ekf = LineEkf::new(room, LineMatchingSettings::default(), start)?;
//! let update = ekf.scan(&scan, mounting)?;
//! assert_eq!(update.matched(), 4);
//! assert!(ekf.belief().pose().distance(truth) < 0.01);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod ekf;
mod lines;
mod model;
mod predicted;
mod search;
mod settings;
mod state;
mod update;

pub use ekf::{LineEkf, LineFilter, LineUkf};
pub use model::LineModel;
pub use predicted::{FieldOfView, PredictedLine};
pub use settings::{LineMatchingSettings, LinePairing, LostSettings, SystematicErrors};
pub use state::STATES;
pub use update::{LinePair, LineUpdate, Tracking};
