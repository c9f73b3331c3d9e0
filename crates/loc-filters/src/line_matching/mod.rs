//! Localization by the walls of a building: lines of a laser scan against lines of a map (H4).
//!
//! Indoors a scan is mostly straight walls. Each is two numbers that are known very well: its
//! distance r from the scanner, and the direction alpha of its normal
//! ([`loc_sensors::features`]). At the estimated pose the map predicts which walls
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
mod model;
mod pairing;

pub use ekf::{LineEkf, LineFilter, LinePair, LineUkf, LineUpdate, Tracking};
pub use model::{FieldOfView, LineModel, PredictedLine, STATES};

use crate::RobotSettings;
use crate::association::Rule;
use loc_sensors::features::LineExtractor;
use nalgebra::Vector2;

loc_core::settings! {
    /// Settings of line matching, with defaults for a small indoor robot.
    #[derive(Copy)]
    pub struct LineMatchingSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// What odometry may get wrong all the time; the filter finds out.
        pub systematic: SystematicErrors = SystematicErrors::default() => check;
        /// How lines are found in scans, and what the scanner's noise is.
        pub extractor: LineExtractor = LineExtractor::default().min_points(6) => check;
        /// How far each end of a map line may be off across it, as a standard deviation \[m\]: 0
        /// for a drawing, about one cell for lines that were found in a grid.
        pub map_sigma: f64 = 0.0 => non_negative;
        /// Map lines that are shorter are not matched; they still hide others \[m\].
        pub min_map_length: f64 = 0.3 => positive;
        /// How pairs are found.
        pub pairing: LinePairing = LinePairing::default() => any;
        /// The share of the shorter of two lines that must lie beside the other one.
        pub min_overlap: f64 = 0.5 => probability;
        /// How far a wall may be seen beyond the stretch that is predicted, two standard deviations
        /// of the position beside \[m\].
        pub slack: f64 = 0.3 => non_negative;
        /// When the robot counts as lost.
        pub lost: LostSettings = LostSettings::default() => check;
    }
}

/// How the lines of a scan are paired with those of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum LinePairing {
    /// The set of pairs that is most likely as a whole, things that the map does not know included.
    #[default]
    MostLikelySet,
    /// By a rule of [`association`](crate::association), each predicted stretch at most once.
    Rule(Rule),
}

loc_core::settings! {
    /// Systematic errors of an odometry, as standard deviations about none; 0 for an error that it
    /// does not have.
    ///
    /// 2 degrees per metre and 3 %, of which a fiftieth may change on each metre.
    #[derive(Copy)]
    pub struct SystematicErrors {
        /// Drift of the heading, as of wheels that are not of one size \[rad/m\].
        #[serde(with = "loc_core::settings::angle_per_m")]
        pub drift: f64 = 2_f64.to_radians() => non_negative;
        /// Error of distances, as of wheels of another size \[-\].
        pub scale: f64 = 0.03 => non_negative;
        /// How much both change over 1 m of path, as a share of the above.
        pub wander: f64 = 0.02 => non_negative;
    }
}

loc_core::settings! {
    /// When line matching says that it has lost the robot.
    ///
    /// Ten scans in a row of which less than a third of the lines, by length, has partners.
    #[derive(Copy)]
    pub struct LostSettings {
        /// A scan fits where at least this share of its lines has partners, by length.
        pub min_share: f64 = 1.0 / 3.0 => probability;
        /// After so many scans in a row that do not fit, the robot is lost.
        pub scans: usize = 10 => at_least(1);
    }
}

impl SystematicErrors {
    /// Variances that drift and scale gain over a path length \[m\].
    fn changes(&self, length: f64) -> Vector2<f64> {
        let change = |sigma: f64| (sigma * self.wander).powi(2) * length;
        Vector2::new(change(self.drift), change(self.scale))
    }
}
