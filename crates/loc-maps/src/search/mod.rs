//! Global search: the likely poses of a robot anywhere on the map, from one scan or a few, without
//! any idea of where it is (A2, A3).
//!
//! The likelihood field rates one pose. Rating all of them (every free cell at every degree) and
//! keeping the best would be certain to find the robot, but a map of 100 m x 100 m has 10^9 poses.
//! So poses are rated in groups: if every beam of the scan ended on the best cell that it can reach
//! while the robot stands anywhere in a square of 16 x 16 cells, how likely would the scan be? No
//! pose in that square is better. Where even this is worse than a pose found elsewhere, the whole
//! square is excluded; otherwise its 16 parts are rated, and theirs. This is branch and bound
//! (Hess, Kohler, Rapp and Andor, "Real-time loop closure in 2D lidar SLAM", 2016; Olson,
//! "Real-time correlative scan matching", 2009), here over the whole map and for several answers.
//!
//! What is exact: poses have their position in the centre of a free cell and one of the evenly
//! spaced headings, and the end of a beam counts for the cell that holds it, computed in double
//! precision. Among all of these, the answers are those of brute force: the pose of the highest sum
//! of codes of the field, then the next best that is not in the surroundings of an answer, and so
//! on; of equal sums the lower heading and then the lower row and column comes first. The
//! likelihood handed out is that of [`LikelihoodField::log_likelihood`] at the pose, which in
//! single precision can put a beam that ends within 1/256 of a cell from an edge on the other
//! side. Refinement comes after, and can change the order.
//!
//! How long it takes depends on the scan. One that fits the map somewhere rules out nearly all
//! squares by their bounds, which themselves take most of the time (0.1 s for 180 beams on 2000 x
//! 2000 cells at 360 headings). With a fifth of the beams cut short it takes about twice as long,
//! with half of them twenty times. It ends with the best all the same.
//!
//! The best is not always the right one: the field knows where beams end, not what they pass
//! through, so a scan of which much is wrong may fit a cluttered corner better than its own pose.
//! A narrow field that ignores the inside of walls helps. In a simulated office, with 90 beams over
//! 270 deg of which a fifth ended too early, the best was right in 29 of 40 poses with the field's
//! default settings, in 36 with [`Obstacles::Surfaces`], and in 40 with that and a `sigma_hit` of
//! two cells. Several scans ([`GlobalSearch::search_many`]) help as well: in the Intel lab, on
//! scans that were not used for the map, the best was within 0.3 m and 5 deg in 451 of
//! 455 poses by one scan of 180 beams, in 454 of 454 by two and in 453 of 453 by three.
//!
//! [`LikelihoodField::log_likelihood`]: crate::LikelihoodField::log_likelihood
//! [`Obstacles::Surfaces`]: crate::likelihood_field::Obstacles::Surfaces
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::LikelihoodField;
//! use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_maps::search::{GlobalSearch, SearchSettings};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! let map = worlds::office(&WorldSettings { width: 200, height: 200, ..Default::default() })?.grid;
//! let field = LikelihoodField::new(&map, &LikelihoodFieldSettings::nav2())?;
//! let search = GlobalSearch::new(&map, field, SearchSettings::default())?;
//!
//! let robot = Pose2::new(3.0, 2.5, 1.2);
//! let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
//! let scan = laser.scan(&map, robot, &mut loc_core::random::stream(1, "sensor"));
//! let beams = scan.thinned(60).into_iter().map(|beam| beam.point());
//! let ends: Endpoints = beams.map(|end| [end.x, end.y]).collect();
//! let found = search.search(&ends)?;
//! assert!(found[0].pose.distance(robot) < 0.1);
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod branch;
mod global;
mod pyramid;

pub use global::{Candidate, GlobalSearch, SearchSettings, Ties};
