//! How well a scan fits a pose, compared with other poses.

use crate::initial::FreeSpace;
use crate::mcl::MountedScan;
use crate::{Particles, Poses, Workers};
use loc_core::Pose2;
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_maps::{LikelihoodField, OccupancyGrid, RayCaster};
use loc_sensors::laser::Beam;
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use rand::Rng;

/// Evidence of a scan for and against the reported pose; all numbers are shares in \[0, 1\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanFit<'a> {
    /// The share of the scan that the map explains at the reported pose: 1 where every beam ends on
    /// an obstacle, 0 where all end far from any, by the mean logarithm of their likelihoods.
    pub here: f64,
    /// The same at random poses of the free space.
    pub elsewhere: &'a [f64],
    /// Beams that a wall of the map would have stopped well before they ended
    /// ([`ScanRater::BEHIND`]). People and new furniture make beams shorter, never longer.
    pub blocked: f64,
    /// Beams that end near an obstacle but not on it ([`ScanRater::NEAR`]). People stand anywhere,
    /// a wrong pose is often wrong by a little.
    pub near: f64,
}

/// Where fewer than this share is left to explain, a margin is not measurable.
const MIN_ROOM: f64 = 0.05;

/// Beams or poses that a thread processes at a time.
const TOGETHER: usize = 16;

impl ScanFit<'_> {
    /// How much better the scan fits here than at the best of the other poses, as a share of what
    /// is left to explain at their mean.
    pub(super) fn margin(&self) -> f64 {
        let count = self.elsewhere.len().max(1) as f64;
        let mean = self.elsewhere.iter().sum::<f64>() / count;
        let best = self.elsewhere.iter().copied().fold(mean, f64::max);
        (self.here - best) / (1.0 - mean).max(MIN_ROOM)
    }
}

/// Rates scans at the reported pose and at random poses of the map's free space.
///
/// It has a likelihood field of its own, so that the figure means the same whatever model the
/// filter uses: one byte and two bits for each cell of the map. The random poses stay the same
/// from scan to scan, as it is their distribution that counts.
#[derive(Debug, Clone)]
pub struct ScanRater {
    walls: RayCaster,
    /// Its rays stop where the known space ends.
    known: RayCaster,
    field: LikelihoodField,
    /// The random poses, and one more element for the reported one.
    poses: Particles,
    shares: Vec<f64>,
}

impl ScanRater {
    /// Random poses that a scan is rated at.
    pub const POSES: usize = 64;

    /// Maximum number of beams of a scan.
    pub const BEAMS: usize = 60;

    /// A beam counts as blocked when it ends this far behind a wall \[m\].
    pub const BEHIND: f64 = 0.5;

    /// A beam counts as near when it ends at such a distance from the nearest obstacle \[m\].
    pub const NEAR: [f64; 2] = [0.2, 0.5];

    /// A beam leaves the map if it runs at least this far through unknown space \[m\] ..
    pub const INTO: f64 = 0.3;

    /// .. and ends farther than this from any obstacle \[m\].
    pub const AT_WALL: f64 = 0.3;

    /// A scan is not rated if fewer than this share of its beams end on the map.
    pub const MIN_SHARE: f64 = 0.2;

    /// A rater for scans taken in a map.
    ///
    /// # Errors
    /// [`loc_maps::Error::NoFreeSpace`] for a map without free cells.
    pub fn new<R: Rng + ?Sized>(map: &OccupancyGrid, rng: &mut R) -> crate::Result<Self> {
        let free_space = FreeSpace::new(map)?;
        let draw = |_| free_space.draw(rng);
        let mut poses = Particles::from_poses((0..Self::POSES).map(draw));
        poses.push(Pose2::IDENTITY, 0.0);
        let field = LikelihoodField::new(map, &LikelihoodFieldSettings::nav2())?;
        let (walls, known) = (RayCaster::new(map), RayCaster::within_known(map));
        Ok(ScanRater { walls, known, field, poses, shares: Vec::new() })
    }

    /// Rates the scans of all lasers; `None` without valid beams.
    pub fn rate(&mut self, reported: Pose2, scans: &[MountedScan<'_>]) -> Option<ScanFit<'_>> {
        self.rate_by(&Workers::one(), reported, scans, false)
    }

    /// The same by several threads; with `on_map`, by the beams that do not leave the map, `None`
    /// where those are few.
    pub(crate) fn rate_by(
        &mut self,
        workers: &Workers,
        reported: Pose2,
        scans: &[MountedScan<'_>],
        on_map: bool,
    ) -> Option<ScanFit<'_>> {
        let mut beams = Vec::new();
        for &MountedScan { scan, mounting } in scans {
            beams.extend(scan.thinned(Self::BEAMS).into_iter().map(|beam| (mounting, beam)));
        }
        if on_map {
            let min = Self::MIN_SHARE * beams.len() as f64;
            beams.retain(|(mounting, beam)| !self.leaves_map(reported * *mounting, beam));
            if (beams.len() as f64) < min {
                return None;
            }
        }
        let end = |&(mounting, beam): &(Pose2, Beam)| mounting.transform(&beam.point()).coords;
        let endpoints: Endpoints = beams.iter().map(|beam| <[f64; 2]>::from(end(beam))).collect();
        let blocked = workers.map(beams.chunks(TOGETHER), |beams| {
            beams.iter().filter(|beam| self.is_blocked(reported, beam)).count()
        });
        let blocked = blocked.into_iter().sum();
        let [on, around] = Self::NEAR.map(|distance| self.ends(distance, reported, &endpoints));
        self.explain(workers, reported, &endpoints);

        let share = |count: usize| count as f64 / beams.len() as f64;
        let (here, elsewhere) = self.shares.split_last()?;
        let (blocked, near) = (share(blocked), share(around.saturating_sub(on)));
        here.is_finite().then_some(ScanFit { here: *here, elsewhere, blocked, near })
    }

    /// Whether a beam of a laser ends in unknown space, before any obstacle of the map and near
    /// none: the map says nothing about where it should end.
    pub fn leaves_map(&self, laser: Pose2, beam: &Beam) -> bool {
        let (origin, direction) = (laser.position(), laser.theta + beam.angle);
        let (sin, cos) = direction.sin_cos();
        let end = Point2::new(origin.x + beam.range * cos, origin.y + beam.range * sin);
        let free = beam.range - Self::INTO;
        let is_known = self.known.cast(&origin, direction, free).is_none()
            && self.known.frame().cell_at(&end).is_some();
        !is_known && !self.is_at_wall(&end) && self.walls.cast(&origin, direction, free).is_none()
    }

    /// Whether an obstacle is near a point.
    fn is_at_wall(&self, point: &Point2<f64>) -> bool {
        let limit = self.field.settings().likelihood(Self::AT_WALL).ln();
        self.field.log_likelihood_at(point) >= limit
    }

    fn is_blocked(&self, reported: Pose2, &(mounting, beam): &(Pose2, Beam)) -> bool {
        let laser = reported * mounting;
        let free = beam.range - Self::BEHIND;
        self.walls.cast(&laser.position(), laser.theta + beam.angle, free).is_some()
    }

    /// How many beams end at most `distance` \[m\] from an obstacle.
    fn ends(&self, distance: f64, reported: Pose2, endpoints: &Endpoints) -> usize {
        let Pose2 { x, y, theta } = reported;
        let hits = self.field.hits(distance, [&[x], &[y], &[theta]], endpoints);
        hits.into_iter().map(|hits| hits as usize).sum()
    }

    /// Fills `shares` with what is explained at each of the poses, the reported one last.
    fn explain(&mut self, workers: &Workers, reported: Pose2, endpoints: &Endpoints) {
        self.poses.set_pose(self.poses.len() - 1, reported);
        self.shares.clear();
        self.shares.resize(self.poses.len(), 0.0);
        let parts = self.poses.poses().chunks(TOGETHER).zip(self.shares.chunks_mut(TOGETHER));
        workers.for_each(parts, |(Poses { x, y, theta }, shares)| {
            self.field.log_likelihoods([x, y, theta], endpoints, shares);
        });
        let settings = self.field.settings();
        let nearest = settings.likelihood(0.0).ln();
        let farthest = settings.likelihood(settings.max_distance).ln();
        for share in &mut self.shares {
            *share = (*share / endpoints.len() as f64 - farthest) / (nearest - farthest);
        }
    }
}
