//! Global search: the likely poses of a robot anywhere on the map, from one scan or a few, without
//! any idea of where it is (A2, A3).
//!
//! The likelihood field rates one pose. Rating all of them (every free cell at every degree) and
//! keeping the best would find the robot for sure, but a map of 100 m x 100 m has 10^9 poses. So
//! poses are rated by the lot: if every beam of the scan ended on the best cell that it can reach
//! while the robot stands anywhere in a square of 16 x 16 cells, how likely would the scan be? No
//! pose in that square is better. Where even this is worse than a pose found elsewhere, the whole
//! square is done with; else its 16 parts are asked, and theirs. This is branch and bound (Hess,
//! Kohler, Rapp and Andor, "Real-time loop closure in 2D lidar SLAM", 2016; Olson, "Real-time
//! correlative scan matching", 2009), here over the whole map and for several answers.
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
//! through, so a scan of which much is wrong may fit a cluttered corner better than its own place.
//! A narrow field that ignores the inside of walls helps. In a simulated office, with 90 beams over
//! 270 deg of which a fifth ended too early, the best was right in 29 of 40 places with the field's
//! default settings, in 36 with [`Obstacles::Surfaces`], and in 40 with that and a `sigma_hit` of
//! two cells. Several scans ([`GlobalSearch::search_many`]) help as well: in the Intel lab, on
//! scans that were not used for the map, the best was within 0.3 m and 5 deg in 451 of
//! 455 places by one scan of 180 beams, in 454 of 454 by two and in 453 of 453 by three.
//!
//! [`Obstacles::Surfaces`]: loc_maps::likelihood_field::Obstacles::Surfaces
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::LikelihoodField;
//! use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_pf::{GlobalSearch, SearchSettings};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! let map = worlds::office(&WorldSettings { width: 200, height: 200, ..Default::default() })?.grid;
//! let field = LikelihoodField::new(&map, &LikelihoodFieldSettings::default())?;
//! let search = GlobalSearch::new(&map, field, SearchSettings::default())?;
//!
//! let robot = Pose2::new(3.0, 2.5, 1.2);
//! let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
//! let scan = laser.scan(&map, robot, &mut loc_core::random::stream(1, "sensor"));
//! let beams = scan.thinned(60).into_iter().map(|beam| beam.point());
//! let ends: Endpoints = beams.map(|end| [end.x, end.y]).collect();
//! let found = search.search(&ends)?;
//! assert!(found[0].pose.distance(robot) < 0.1);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod branch;
mod candidate;
mod coarse;
mod headings;
mod leaves;
mod level;
mod pyramid;
mod refine;
mod seed;
mod settings;
mod sums;
mod zones;

pub use candidate::Candidate;
pub use seed::{SeedSettings, seed_particles};
pub use settings::SearchSettings;

use crate::{Error, Result, Workers};
use branch::Search;
use headings::Turned;
use loc_core::Pose2;
use loc_maps::likelihood_field::Endpoints;
use loc_maps::{LikelihoodField, OccupancyGrid};
use nalgebra::Point2;
use pyramid::Pyramid;
use zones::Answer;

/// Most beams times headings of a search: 1 GiB of ends.
const MAX_ENDS: usize = 1 << 27;

/// Most beams: their codes add up to less than 2^32.
const MAX_BEAMS: usize = 1 << 24;

/// A map made ready for searches.
#[derive(Debug)]
pub struct GlobalSearch {
    field: LikelihoodField,
    pyramid: Pyramid,
    settings: SearchSettings,
    workers: Workers,
}

impl GlobalSearch {
    /// Makes a map ready: `field` must be that of `map`.
    ///
    /// # Errors
    /// Settings out of range, [`Error::NoFreeSpace`], [`Error::OtherFrame`] for a field of another
    /// map, and [`loc_core::Error::Length`] for maps so large that a level takes more than 1.5 GiB
    /// (four bytes a cell).
    pub fn new(
        map: &OccupancyGrid,
        field: LikelihoodField,
        settings: SearchSettings,
    ) -> Result<Self> {
        settings.validate()?;
        if field.frame() != map.frame() {
            return Err(Error::OtherFrame);
        }
        if map.counts().free == 0 {
            return Err(Error::NoFreeSpace { width: map.width(), height: map.height() });
        }
        let pyramid = Pyramid::new(map, &field, settings.headings())?;
        let workers = Workers::new(settings.threads)?;
        Ok(GlobalSearch { field, pyramid, settings, workers })
    }

    /// What is searched for.
    pub fn settings(&self) -> &SearchSettings {
        &self.settings
    }

    /// The field that rates poses.
    pub fn field(&self) -> &LikelihoodField {
        &self.field
    }

    /// Memory of the levels and the field \[bytes\]: about 13 a cell of the map. A search
    /// takes two more for each heading and 16 x 16 cells (360 headings: 3 a cell).
    pub fn bytes(&self) -> usize {
        self.pyramid.bytes() + self.field.bytes()
    }

    /// The likely poses of the robot whose scan ends at `endpoints`, given in the robot's frame,
    /// best first. There may be fewer than asked for, or none where
    /// [`least`](SearchSettings::least) says so.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for a scan without beams, or with more than 2^24 of them, or
    /// 2^27 over the number of headings.
    pub fn search(&self, endpoints: &Endpoints) -> Result<Vec<Candidate>> {
        let headings = self.settings.headings();
        if endpoints.is_empty() || endpoints.len() > MAX_BEAMS.min(MAX_ENDS / headings) {
            let expected = "1 to 2^24, and no more than 2^27 / headings";
            let (what, found) = ("beams of a global search", endpoints.len());
            return Err(loc_core::Error::Length { what, expected, found }.into());
        }
        let turned = Turned::new(endpoints, self.field.frame(), headings);
        let search = Search {
            pyramid: &self.pyramid,
            turned: &turned,
            frame: self.field.frame(),
            settings: &self.settings,
            workers: &self.workers,
            least: self.least(endpoints.len()),
            within: (self.settings.within / self.field.code_step() * endpoints.len() as f64) as u32,
        };
        let answers = search.run();
        let poses = answers.iter().map(|answer| self.pose(answer));
        if !self.settings.refine {
            return Ok(poses.map(|pose| Candidate::rate(&self.field, pose, endpoints)).collect());
        }
        let mut refined: Vec<Candidate> = poses.map(|pose| self.refine(pose, endpoints)).collect();
        refined.sort_by(|a, b| b.log_likelihood.total_cmp(&a.log_likelihood));
        Ok(refined)
    }

    /// The likely poses at the last of several scans: each comes with the pose of the robot when it
    /// was taken, as seen from the pose that is searched for (odometry; the identity for the last
    /// scan). Together they tell places apart that look alike to one of them.
    ///
    /// ```text
    /// let earlier = odometry_now.between(odometry_then);
    /// search.search_many(&[(earlier, then), (Pose2::IDENTITY, now)])
    /// ```
    ///
    /// # Errors
    /// As [`GlobalSearch::search`], and [`loc_core::Error::OutOfRange`] for a pose that is not
    /// finite.
    pub fn search_many(&self, scans: &[(Pose2, &Endpoints)]) -> Result<Vec<Candidate>> {
        for (pose, _) in scans {
            loc_core::error::finite("pose of a scan, x [m]", pose.x)?;
            loc_core::error::finite("pose of a scan, y [m]", pose.y)?;
            loc_core::error::finite("pose of a scan, heading [rad]", pose.theta)?;
        }
        let ends = scans.iter().flat_map(|(pose, scan)| {
            let points = scan.xs().iter().zip(scan.ys());
            points.map(|(&x, &y)| pose.transform(&Point2::new(f64::from(x), f64::from(y))))
        });
        self.search(&ends.map(|end| [end.x, end.y]).collect())
    }

    /// The least sum of codes that the settings allow.
    fn least(&self, beams: usize) -> u32 {
        let none = self.field.log_likelihood_of(0, beams);
        let least = self.settings.least.map_or(0.0, |least| least * beams as f64 - none);
        (least / self.field.code_step()).ceil() as u32
    }

    fn pose(&self, answer: &Answer) -> Pose2 {
        let cell = loc_maps::grid::Cell::new(answer.column as usize, answer.row as usize);
        let at = self.field.frame().center(cell);
        let theta = headings::heading(answer.heading, self.settings.headings());
        Pose2::new(at.x, at.y, theta)
    }
}
