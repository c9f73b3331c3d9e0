//! The search of a map: its settings, its answers, and their refinement.

use super::branch::{GridPose, Search};
use super::pyramid::{self, Pyramid, RotatedScan};
use crate::likelihood_field::Endpoints;
use crate::{Error, LikelihoodField, OccupancyGrid, Result};
use loc_core::error::{in_range, non_negative};
use loc_core::{Pose2, angle};
use nalgebra::Point2;
use std::f64::consts::TAU;

/// Maximum of beams times headings of a search: 1 GiB of ends.
const MAX_ENDS: usize = 1 << 27;

/// Maximum number of beams: their codes add up to less than 2^32.
const MAX_BEAMS: usize = 1 << 24;

/// How many times the steps to the peak are halved: from half a cell to an eighth.
const HALVINGS: usize = 3;

/// The mean is taken over this many poses to each side in each coordinate ..
const SIDE: i32 = 4;

/// .. which reach this far \[cells\].
const REACH: f64 = 2.0;

/// How many times the mean is taken, each about the last one.
const PASSES: usize = 2;

/// Settings of a [`GlobalSearch`](super::GlobalSearch).
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct SearchSettings {
    /// Largest step from one heading to the next \[rad\], 0.001 to 1; the full turn is divided
    /// evenly. A beam of length r ends up to half a step times r from where it should.
    pub angle_step: f64,
    /// Maximum number of candidates.
    pub candidates: usize,
    /// Two candidates are at least this far apart \[m\] ..
    pub separation_distance: f64,
    /// .. or turned this much against each other \[rad\].
    pub separation_angle: f64,
    /// How far a candidate's log-likelihood may be below the best one's, mean over the beams.
    pub within: f64,
    /// The minimum log-likelihood of a candidate, mean over the beams.
    pub least: Option<f64>,
    /// Whether candidates are refined, see [`GlobalSearch::refine`](super::GlobalSearch::refine).
    pub refine: bool,
    /// Number of threads.
    pub threads: usize,
}

impl Default for SearchSettings {
    fn default() -> Self {
        SearchSettings {
            angle_step: 1_f64.to_radians(),
            candidates: 5,
            separation_distance: 1.0,
            separation_angle: 30_f64.to_radians(),
            within: 0.1,
            least: None,
            refine: true,
            threads: 1,
        }
    }
}

impl SearchSettings {
    /// Number of headings: even steps of at most `angle_step` in a full turn.
    pub(super) fn headings(&self) -> usize {
        // A step that divides the turn but for rounding is not cut.
        (std::f64::consts::TAU / self.angle_step - 1e-6).ceil().max(1.0) as usize
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`] naming the first that is not
    /// allowed.
    pub fn check(&self) -> Result<()> {
        let step = |step: f64| (0.001..=1.0).contains(&step);
        in_range("angle_step [rad]", "0.001 to 1", self.angle_step, step)?;
        if self.candidates == 0 {
            let (what, expected) = ("candidates", "at least 1");
            return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
        }
        non_negative("separation_distance [m]", self.separation_distance)?;
        non_negative("separation_angle [rad]", self.separation_angle)?;
        non_negative("within", self.within)?;
        if let Some(least) = self.least {
            loc_core::error::finite("least", least)?;
        }
        Ok(())
    }
}

/// A pose where the robot may be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Candidate {
    /// The pose.
    pub pose: Pose2,
    /// Logarithm of the likelihood of the scan there, the sum over its beams.
    pub log_likelihood: f64,
}

impl Candidate {
    /// A pose with its likelihood.
    pub(super) fn rate(field: &LikelihoodField, pose: Pose2, endpoints: &Endpoints) -> Self {
        Candidate { pose, log_likelihood: field.log_likelihood(pose, endpoints) }
    }
}

/// A sample of all poses that are about as good as the best one, see
/// [`GlobalSearch::ties`](super::GlobalSearch::ties).
#[derive(Debug, Clone, PartialEq)]
pub struct Ties {
    /// The poses, evenly from all of them.
    pub poses: Vec<Pose2>,
    /// The volume of all of them, with those that are not handed out \[m^2 rad\].
    pub volume: f64,
}

/// A map prepared for searches.
#[derive(Debug)]
pub struct GlobalSearch {
    field: LikelihoodField,
    pyramid: Pyramid,
    settings: SearchSettings,
    threads: Threads,
}

impl GlobalSearch {
    /// Prepares a map: `field` must be that of `map`.
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
        settings.check()?;
        if field.frame() != map.frame() {
            return Err(Error::OtherFrame);
        }
        if map.counts().free == 0 {
            return Err(Error::NoFreeSpace { width: map.width(), height: map.height() });
        }
        let pyramid = Pyramid::new(map, &field, settings.headings())?;
        let threads = Threads::new(settings.threads)?;
        Ok(GlobalSearch { field, pyramid, settings, threads })
    }

    /// The settings.
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
    /// best first. There may be fewer than [`candidates`](SearchSettings::candidates), or none
    /// where
    /// [`least`](SearchSettings::least) says so.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for a scan without beams, or with more than 2^24 of them, or
    /// 2^27 over the number of headings.
    pub fn search(&self, endpoints: &Endpoints) -> Result<Vec<Candidate>> {
        let rotated = self.rotated(endpoints)?;
        let answers = self.search_for(&rotated, endpoints.len()).run();
        let poses = answers.iter().map(|answer| self.pose(answer));
        if !self.settings.refine {
            return Ok(poses.map(|pose| Candidate::rate(&self.field, pose, endpoints)).collect());
        }
        let mut refined: Vec<Candidate> = poses.map(|pose| self.refine(pose, endpoints)).collect();
        refined.sort_by(|a, b| b.log_likelihood.total_cmp(&a.log_likelihood));
        Ok(refined)
    }

    /// A sample of all poses of the search's grid at which the scan is at most `drop` \[nats\] less
    /// likely than at the best one, whatever their number: of a scan that sees one bare wall, a
    /// continuum. At most about `max` are handed out, spread evenly over all of them.
    ///
    /// # Errors
    /// As [`GlobalSearch::search`].
    pub fn ties(&self, endpoints: &Endpoints, drop: f64, max: usize) -> Result<Ties> {
        let rotated = self.rotated(endpoints)?;
        let within = (drop / self.field.code_step()) as u32;
        let search = Search { within, ..self.search_for(&rotated, endpoints.len()) };
        let (ties, every) = search.ties(max);
        let [cell, turn] = [self.field.frame().resolution(), TAU / self.settings.headings() as f64];
        let volume = ties.len() as f64 * f64::from(every) * cell * cell * turn;
        Ok(Ties { poses: ties.iter().map(|tie| self.pose(tie)).collect(), volume })
    }

    /// The likely poses at the last of several scans: each comes with the pose of the robot when it
    /// was taken, as seen from the pose that is searched for (odometry; the identity for the last
    /// scan). Together they distinguish poses that one of them cannot.
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

    /// A scan at all headings.
    fn rotated(&self, endpoints: &Endpoints) -> Result<RotatedScan> {
        let headings = self.settings.headings();
        if endpoints.is_empty() || endpoints.len() > MAX_BEAMS.min(MAX_ENDS / headings) {
            let expected = "1 to 2^24, and no more than 2^27 / headings";
            let (what, found) = ("beams of a global search", endpoints.len());
            return Err(loc_core::Error::Length { what, expected, found }.into());
        }
        Ok(RotatedScan::new(endpoints, self.field.frame(), headings))
    }

    fn search_for<'a>(&'a self, rotated: &'a RotatedScan, beams: usize) -> Search<'a> {
        Search {
            pyramid: &self.pyramid,
            rotated,
            frame: self.field.frame(),
            settings: &self.settings,
            threads: &self.threads,
            min_sum: self.min_sum(beams),
            within: (self.settings.within / self.field.code_step() * beams as f64) as u32,
        }
    }

    /// The smallest sum of codes that the settings allow.
    fn min_sum(&self, beams: usize) -> u32 {
        let none = self.field.log_likelihood_of(0, beams);
        let least = self.settings.least.map_or(0.0, |least| least * beams as f64 - none);
        (least / self.field.code_step()).ceil() as u32
    }

    fn pose(&self, answer: &GridPose) -> Pose2 {
        let cell = crate::grid::Cell::new(answer.column as usize, answer.row as usize);
        let at = self.field.frame().center(cell);
        let theta = pyramid::heading(answer.heading, self.settings.headings());
        Pose2::new(at.x, at.y, theta)
    }
}

impl GlobalSearch {
    /// The pose near `start` that explains the scan, finer than the search's grid.
    ///
    /// First uphill, by pattern search (Hooke and Jeeves, 1961): steps from half a cell and half an
    /// angle step to an eighth, no farther than a cell and an angle step from `start` in each
    /// coordinate. The field has one value a cell, so the top is a jagged plateau of about a cell;
    /// the answer is the mean of the posterior over it (729 poses that move the beams by up to two
    /// cells, weighted by their likelihood). It may be a little less likely than the peak, and is
    /// nearer to the truth: with 180 beams in an office at 5 cm by 1.2 cm and 0.14 deg (medians;
    /// 0.8 cm and 0.08 deg where [`Obstacles::Surfaces`] made the field) instead of 2 cm and
    /// 0.16 deg.
    ///
    /// [`Obstacles::Surfaces`]: crate::likelihood_field::Obstacles::Surfaces
    pub fn refine(&self, start: Pose2, endpoints: &Endpoints) -> Candidate {
        let mut pose = self.peak(start, endpoints);
        let reach = REACH * self.field.frame().resolution();
        let turn = (reach / length(endpoints)).min(0.2);
        for _ in 0..PASSES {
            pose = self.mean(pose, [reach, reach, turn], endpoints);
        }
        Candidate::rate(&self.field, pose, endpoints)
    }

    /// The best pose near `start`.
    fn peak(&self, start: Pose2, endpoints: &Endpoints) -> Pose2 {
        let cell = self.field.frame().resolution();
        let reach = [cell, cell, TAU / self.settings.headings() as f64];
        let mut best = Candidate::rate(&self.field, start, endpoints);
        let mut share = 0.5;
        for _ in 0..HALVINGS {
            while let Some(better) = self
                .rate_around(best.pose, reach.map(|reach| reach * share), 1, endpoints)
                .filter(|tried| is_near(tried.pose, start, reach))
                .filter(|tried| tried.log_likelihood > best.log_likelihood)
                .max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))
            {
                best = better;
            }
            share *= 0.5;
        }
        best.pose
    }

    /// The mean of the posterior within `reach` of a pose.
    fn mean(&self, about: Pose2, reach: [f64; 3], endpoints: &Endpoints) -> Pose2 {
        let step = reach.map(|reach| reach / f64::from(SIDE));
        let tried: Vec<Candidate> = self.rate_around(about, step, SIDE, endpoints).collect();
        let likelihoods = tried.iter().map(|tried| tried.log_likelihood);
        let best = likelihoods.fold(f64::NEG_INFINITY, f64::max);
        let (mut total, mut sum) = (0.0, [0.0; 3]);
        for Candidate { pose, log_likelihood } in tried {
            let weight = (log_likelihood - best).exp();
            let turn = angle::difference(pose.theta, about.theta);
            let away = [pose.x - about.x, pose.y - about.y, turn];
            sum.iter_mut().zip(away).for_each(|(sum, away)| *sum += weight * away);
            total += weight;
        }
        let [x, y, turn] = sum.map(|sum| sum / total);
        Pose2::new(about.x + x, about.y + y, about.theta + turn)
    }

    /// The poses on a grid about one, up to `side` steps away in each coordinate.
    fn rate_around(
        &self,
        pose: Pose2,
        step: [f64; 3],
        side: i32,
        endpoints: &Endpoints,
    ) -> impl Iterator<Item = Candidate> + use<> {
        let ways = move || (-side..=side).map(f64::from);
        let [mut xs, mut ys, mut thetas] = [(); 3].map(|()| Vec::new());
        for turn in ways() {
            for y in ways() {
                for x in ways() {
                    xs.push(pose.x + x * step[0]);
                    ys.push(pose.y + y * step[1]);
                    thetas.push(angle::wrap(pose.theta + turn * step[2]));
                }
            }
        }
        let mut rated = vec![0.0; xs.len()];
        self.field.log_likelihoods([&xs, &ys, &thetas], endpoints, &mut rated);
        xs.into_iter().zip(ys).zip(thetas).zip(rated).map(|(((x, y), theta), log_likelihood)| {
            Candidate { pose: Pose2 { x, y, theta }, log_likelihood }
        })
    }
}

/// The length of the beams, root mean square \[m\].
fn length(endpoints: &Endpoints) -> f64 {
    let squares = endpoints.xs().iter().zip(endpoints.ys());
    let squares = squares.map(|(&x, &y)| f64::from(x).powi(2) + f64::from(y).powi(2));
    let length = (squares.sum::<f64>() / endpoints.len().max(1) as f64).sqrt();
    length.max(f64::MIN_POSITIVE)
}

fn is_near(pose: Pose2, start: Pose2, reach: [f64; 3]) -> bool {
    let turn = angle::difference(pose.theta, start.theta);
    let away = [pose.x - start.x, pose.y - start.y, turn];
    away.iter().zip(reach).all(|(away, reach)| away.abs() <= reach * (1.0 + 1e-9))
}

/// The threads that share the work of a search.
#[derive(Debug)]
pub(super) struct Threads {
    #[cfg(feature = "threads")]
    pool: Option<rayon::ThreadPool>,
}

impl Threads {
    /// `threads` threads; with 0 or 1, or without the feature `threads`, the calling one alone.
    #[cfg(feature = "threads")]
    pub(super) fn new(threads: usize) -> Result<Self> {
        let start = || rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let failed = |error: rayon::ThreadPoolBuildError| crate::Error::Threads {
            threads,
            reason: error.to_string(),
        };
        Ok(Threads { pool: (threads > 1).then(start).transpose().map_err(failed)? })
    }

    /// `threads` threads; without the feature `threads`, the calling one alone.
    #[cfg(not(feature = "threads"))]
    #[expect(clippy::unnecessary_wraps, reason = "the same signature as with the feature")]
    pub(super) fn new(_threads: usize) -> Result<Self> {
        Ok(Threads {})
    }

    /// Does `work` on every item, in any order.
    pub(super) fn for_each<T: Send>(
        &self,
        items: impl Iterator<Item = T> + Send,
        work: impl Fn(T) + Sync + Send,
    ) {
        #[cfg(feature = "threads")]
        if let Some(pool) = &self.pool
            && items.size_hint().1 != Some(1)
        {
            use rayon::iter::{ParallelBridge, ParallelIterator};
            return pool.install(|| items.par_bridge().for_each(work));
        }
        items.for_each(work);
    }
}
