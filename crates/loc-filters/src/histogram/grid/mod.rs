//! Markov localization of a robot with a laser: a grid over (x, y, heading) (K1).
//!
//! The free part of a map is divided into squares and the full turn into sectors; each pair of them
//! is a cell with a probability. A motion shifts each layer of one heading by the way that a robot
//! with this heading has driven, and blurs it by what odometry may be off by. A scan multiplies
//! each cell by how likely it is there: P(x | s) = alpha P(s | x) P(x) (Burgard, Fox, Hennig and
//! Schmidt, "Estimating the absolute position of a mobile robot using position probability grids",
//! 1996; Fox, Burgard and Thrun, "Markov localization for mobile robots in dynamic environments",
//! 1999).
//!
//! A cell stands for all of its poses. Its likelihood is therefore the mean over them, taken over
//! the free map cells of the square and several headings of the sector, each a product of lookups
//! in the [likelihood field](loc_maps::likelihood_field). Two things keep that cheap:
//!
//! - **Bounds.** For each cell it is first asked how likely the scan can be at best in any of its
//!   poses, from maxima of the field that are computed once. Cells which even so have together no
//!   more than the share `negligible` of the result are passed over. What the result is off by is
//!   at most that, and [`GridReport::passed_over`] tells it.
//! - **A fine grid** of 0.04 m and half a degree, which follows the most likely place (Burgard,
//!   Derr, Fox and Cremers, "Integrating global position estimation and position tracking for
//!   mobile robots: the dynamic Markov localization approach", 1998). Both grids share one
//!   probability of 1: what is near the most likely place is kept in the fine grid, all else in the
//!   coarse one.
//!
//! A robot that was carried off is found again because no place is ever ruled out: with each motion
//! the share `kidnap_rate` is spread evenly over the map (K1). A scan that does not fit where the
//! robot was, but fits elsewhere, moves the belief there at once. Where odometry has failed (slip,
//! a push), the coarse grid catches the robot: a share of each motion is as uncertain as it is long.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_core::random::stream;
//! use loc_filters::histogram::{GridLocalizer, GridSettings};
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! let map = worlds::office(&WorldSettings { width: 200, height: 200, ..Default::default() })?.grid;
//! let mut localizer = GridLocalizer::new(&map, GridSettings::default())?;
//! let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
//! let robot = Pose2::new(3.0, 2.5, 1.2);
//! let scan = laser.scan(&map, robot, &mut stream(1, "sensor"));
//! localizer.update(Pose2::IDENTITY, &scan, Pose2::IDENTITY)?;
//! assert!(localizer.estimate().pose().distance(robot) < 0.05 && localizer.certainty() > 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod belief;
mod bounds;
mod codes;
mod correct;
mod focus;
mod levels;
mod localizer;
mod moments;
mod motion;
mod picture;
mod readout;
mod scan;
mod sensor;
mod settings;
mod space;
mod stack;
mod start;
#[cfg(test)]
mod tests;
mod window;

pub use localizer::{GridLocalizer, GridReport, GridUpdate};
pub use settings::{FineSettings, GridSettings};
