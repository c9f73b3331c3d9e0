//! Scans and the map, prepared to rate poses.

use super::{MclSettings, NoveltyFilter, ScanModel, ScanView};
use crate::initial::FreeSpace;
use crate::novelty::{BeliefSample, by_field};
use crate::sensor::beam::{informative_beams_from, thinned};
use crate::sensor::{BeamLikelihood, FieldLikelihood, SumOfCubes};
use crate::{Likelihood, Particles, Poses, Result};
use loc_core::Pose2;
use loc_core::error::finite;
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_maps::{GlobalSearch, LikelihoodField, OccupancyGrid, RayCaster, SearchSettings};
use loc_sensors::laser::{Beam, LaserScan};
use nalgebra::Point2;

/// A scan with the mounting pose of its scanner.
#[derive(Debug, Clone, Copy)]
pub struct MountedScan<'a> {
    /// The scan.
    pub scan: &'a LaserScan,
    /// The pose of the scanner on the robot (`base_from_laser`).
    pub mounting: Pose2,
}

/// Scans taken at one time, prepared to rate poses by a model of
/// [`SensorSettings`](super::SensorSettings).
#[derive(Debug)]
pub enum Observation<'a> {
    /// By the product over a likelihood field.
    Product(FieldLikelihood<'a>),
    /// By the sum of cubes over one.
    SumOfCubes(Box<SumOfCubes<'a>>),
    /// By the ranges that the beams should have.
    Beams(Vec<BeamLikelihood<'a>>),
}

impl Likelihood for Observation<'_> {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        match self {
            Observation::Product(scan) => scan.rate(poses, log_weights),
            Observation::SumOfCubes(scan) => scan.rate(poses, log_weights),
            Observation::Beams(scans) => {
                scans.iter().for_each(|scan| scan.rate(poses, log_weights));
            }
        }
    }
}

/// Checks a pose of the odometry and the scans taken there.
pub(super) fn check(odometry: Pose2, scans: &[MountedScan<'_>]) -> Result<()> {
    finite("x of the odometry [m]", odometry.x)?;
    finite("y of the odometry [m]", odometry.y)?;
    finite("heading of the odometry [rad]", odometry.theta)?;
    scans.iter().try_for_each(|mounted| {
        finite("mounting of a laser", mounted.mounting.to_vector().sum())?;
        Ok(mounted.scan.check()?)
    })
}

/// The valid ranges of all scans as one number; `None` without any.
pub(super) fn fingerprint(scans: &[MountedScan<'_>]) -> Option<u64> {
    let valid = |mounted: &&MountedScan<'_>| mounted.scan.ranges.iter().any(|r| r.is_finite());
    scans.iter().find(valid)?;
    let ranges = scans.iter().flat_map(|mounted| &mounted.scan.ranges);
    let mix = |hash: u64, range: &f64| (hash ^ range.to_bits()).wrapping_mul(0x0100_0000_01b3);
    Some(ranges.fold(0xcbf2_9ce4_8422_2325, mix))
}

/// Numbers of the beams of a scan to use: valid ones within the robot's limits, and those without a
/// return for a model that uses them; thinned after the others are dropped.
pub(super) fn select(
    scan: &LaserScan,
    model: &impl ScanModel,
    settings: &MclSettings,
) -> Vec<usize> {
    let range = settings.robot.laser_min_range..=settings.robot.laser_max_range;
    if model.uses_beams_without_return() {
        return informative_beams_from(scan, range.start().max(scan.range_min), settings.beams);
    }
    // A beam with the maximum range has no return.
    let returned = |beam: &Beam| beam.range < scan.range_max;
    let beams = scan.beams().filter(|beam| range.contains(&beam.range) && returned(beam));
    thinned(beams.map(|beam| beam.index).collect(), settings.beams)
}

/// Where the selected beams of all scans end, in the robot's frame, if all ranges are `offset`
/// \[m\] longer than measured.
pub(super) fn endpoints(scans: &[MountedScan<'_>], beams: &[Vec<usize>], offset: f64) -> Endpoints {
    let ends = scans.iter().zip(beams).flat_map(|(mounted, beams)| {
        let returned = beams.iter().map(|&index| (index, mounted.scan.ranges[index]));
        let returned = returned.filter(|(_, range)| mounted.scan.is_valid(*range));
        returned.map(|(index, range)| {
            let range = (range + offset).max(0.0);
            let beam = Beam { index, angle: mounted.scan.angle(index), range };
            mounted.mounting.transform(&beam.point())
        })
    });
    ends.map(|Point2 { coords }| [coords.x, coords.y]).collect()
}

/// The map prepared for the sensor model and for searches; constant.
#[derive(Debug)]
pub(super) struct PreparedMap {
    pub(super) free_space: FreeSpace,
    pub(super) field: LikelihoodField,
    /// The obstacles, where the beam model or the distance filter needs them.
    caster: Option<RayCaster>,
    pub(super) search: Option<GlobalSearch>,
    independent_beams: f64,
}

/// Where a scan fits best over the whole map.
#[derive(Debug, Default)]
pub(super) struct Candidates {
    pub(super) poses: Vec<Pose2>,
    /// The volume that they represent together \[m^2 rad\], where they are a sample of a continuum
    /// of poses.
    pub(super) volume: Option<f64>,
}

impl Candidates {
    /// A single pose.
    pub(super) fn one(pose: Pose2) -> Self {
        Candidates { poses: vec![pose], volume: None }
    }
}

/// Maximum number of candidates of a search.
const CANDIDATES: usize = 64;

/// Poses are as good as the best one if the scan is at most this much less likely there \[nats\].
const TIED: f64 = 5.0;

/// Number of poses that represent a continuum of such poses.
const TIES: usize = 10_000;

/// Number of poses that represent the particles when beams are filtered.
const SAMPLE: usize = 64;

impl PreparedMap {
    pub(super) fn new(
        map: &OccupancyGrid,
        model: &impl ScanModel,
        settings: &MclSettings,
    ) -> Result<Self> {
        let free_space = FreeSpace::new(map)?;
        let field = as_wide_as_cells(model.field(), map);
        let casts =
            model.casts_rays() || matches!(settings.novelty, Some(NoveltyFilter::Distance(_)));
        let search = settings.recovery.search.then(|| search(map, &field)).transpose()?;
        let field = LikelihoodField::new(map, &field)?;
        let caster = casts.then(|| RayCaster::new(map));
        let independent_beams = settings.independent_beams;
        Ok(PreparedMap { free_space, field, caster, search, independent_beams })
    }

    /// Pose candidates: where a scan fits best over the whole map; none without a search, or for a
    /// scan without usable beams. Where more places fit about equally well than a search lists, as
    /// along the bare wall of a hall, they are a sample of all of those.
    pub(super) fn candidates(&self, endpoints: &Endpoints) -> Candidates {
        let Some(search) = &self.search else { return Candidates::default() };
        let Ok(found) = search.search(endpoints) else { return Candidates::default() };
        let drop = TIED / self.exponent(endpoints.len());
        if let [best, .., last] = &found[..]
            && found.len() == CANDIDATES
            && best.log_likelihood - last.log_likelihood < drop
            && let Ok(ties) = search.ties(endpoints, drop, TIES)
        {
            return Candidates { poses: ties.poses, volume: Some(ties.volume) };
        }
        let poses = found.into_iter().map(|candidate| candidate.pose).collect();
        Candidates { poses, volume: None }
    }

    /// As how many independent beams each of the used ones counts.
    pub(super) fn exponent(&self, used: usize) -> f64 {
        (self.independent_beams / used.max(1) as f64).min(1.0)
    }

    /// The selected beams without those that the novelty filter drops (K3), for a robot at
    /// `predicted`.
    pub(super) fn without_novel(
        &self,
        scans: &[MountedScan<'_>],
        beams: Vec<Vec<usize>>,
        predicted: &Particles,
        filter: &NoveltyFilter,
    ) -> Result<Vec<Vec<usize>>> {
        let sample = BeliefSample::of(predicted, SAMPLE);
        let pairs = scans.iter().zip(beams);
        let kept = pairs.map(|(mounted, beams)| {
            let kept = match (filter, &self.caster) {
                (NoveltyFilter::Distance(filter), Some(caster)) => {
                    filter.keep(caster, &sample, mounted, &beams)
                }
                (NoveltyFilter::Entropy(filter), _) => {
                    filter.keep(by_field(&self.field), &sample, mounted, &beams)
                }
                (NoveltyFilter::Distance(_), None) => return Ok(beams),
            };
            Ok(kept?.beams)
        });
        kept.collect()
    }

    /// Scans, whose selected beams end at `endpoints`, for a sensor model.
    pub(super) fn view<'a>(
        &'a self,
        scans: &'a [MountedScan<'a>],
        beams: &'a [Vec<usize>],
        endpoints: &'a Endpoints,
    ) -> ScanView<'a> {
        let exponent = self.exponent(beams.iter().map(Vec::len).sum());
        let PreparedMap { field, caster, .. } = self;
        ScanView { scans, beams, endpoints, field, caster: caster.as_ref(), exponent }
    }
}

/// The search of a map, on a field as wide as the steps of the search.
fn search(map: &OccupancyGrid, field: &LikelihoodFieldSettings) -> Result<GlobalSearch> {
    let sigma_hit = field.sigma_hit.max(0.15).max(2.0 * map.frame().resolution());
    let field = LikelihoodField::new(map, &field.sigma_hit(sigma_hit))?;
    let settings = SearchSettings {
        candidates: CANDIDATES,
        separation_distance: 0.5,
        separation_angle: 15_f64.to_radians(),
        within: 0.5,
        refine: false,
        ..SearchSettings::default()
    };
    Ok(GlobalSearch::new(map, field, settings)?)
}

/// A field cannot be sharper than the map: coarse cells make coarse walls.
/// 0.05 m suits cells of 0.05 m, 0.2 m those of 0.1 m.
fn as_wide_as_cells(
    field: LikelihoodFieldSettings,
    map: &OccupancyGrid,
) -> LikelihoodFieldSettings {
    let min = 20.0 * map.resolution().powi(2);
    field.sigma_hit(field.sigma_hit.max(min))
}
