//! The figures of a run: what `summary.json` holds.

use super::{
    Alignment, Claims, LandmarkErrors, Pair, Statistics, Unit, aligned, ape_rotation,
    ape_translation, landmark_errors, rpe_rotation, rpe_translation,
};
use crate::Result;
use crate::record::{MethodRecord, Run};
use crate::source::OdometryTiming;
use loc_core::{Pose2, angle};
use loc_maps::{DistanceMap, OccupancyGrid};
use loc_sensors::laser::LaserScan;
use serde::{Serialize, Serializer};

/// The figures of a run, by method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The recording or scenario.
    pub source: String,
    /// Seed of a simulation.
    pub seed: Option<u64>,
    /// How estimates were aligned with the frame of the truth before they were compared.
    pub align: &'static str,
    /// From the first to the last estimate.
    pub duration_s: f64,
    /// True distance travelled; null without a truth.
    pub distance_m: Option<f64>,
    /// One entry per method, in the order of the request.
    #[serde(serialize_with = "as_map")]
    pub methods: Vec<(String, MethodSummary)>,
    /// The time offset of the odometry; null where the source has none.
    pub odometry: Option<OdometryTiming>,
    /// Notes of the source (skipped data) and of the methods.
    pub notes: Vec<String>,
}

/// The figures of one method. A figure without a meaning is `None`, null in JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodSummary {
    /// Errors of the estimates; each figure null without a truth.
    #[serde(flatten, serialize_with = "errors_or_nulls")]
    pub errors: Option<PlanarErrors>,
    /// Mean normalised estimation error squared; 3 for a consistent covariance of a pose, 2
    /// where only true positions are known.
    pub nees_mean: Option<f64>,
    /// The probability of being lost, the hypotheses, and the time sure and wrong.
    #[serde(flatten)]
    pub claims: Claims,
    /// Mean normalised innovation squared of the accepted measurements.
    pub nis_mean: Option<f64>,
    /// Accepted measurements.
    pub measurements_used: usize,
    /// Rejected measurements.
    pub measurements_rejected: usize,
    /// Errors of the map that the method has built; null for one that builds none.
    pub landmarks: Option<LandmarkErrors>,
    /// The share of the beams of the last scan with a return that end within 12 cm of a wall at
    /// the pose estimated there, see [`BeamFit`]; null without a laser or a map.
    pub beam_fit_at_end: Option<f64>,
    /// Time to convergence of a method that started without a pose, see [`found`]; null for one
    /// that was given the pose, or that never converged.
    pub converged_at_s: Option<f64>,
    /// Root mean square of the distances to the truth from then on; null with `converged_at_s`.
    pub ate_since_converged_m: Option<f64>,
    /// The same in accepted measurements.
    pub converged_after_updates: Option<usize>,
    /// Time to recover after a kidnapping; null without one, or if it never recovered.
    pub recovered_after_s: Option<f64>,
    /// The same in accepted measurements.
    pub recovered_after_updates: Option<usize>,
    /// Computing time of the method.
    pub runtime_s: f64,
    /// Controls and measurements processed.
    pub updates: usize,
    /// Duration of the run over the computing time.
    pub realtime_factor: Option<f64>,
}

impl Summary {
    /// The figures of a run.
    ///
    /// # Errors
    /// [`crate::Error::UndeterminedAlignment`], and [`loc_core::Error`] for estimates that are not
    /// finite.
    pub fn of(run: &Run, seed: Option<u64>, align: Alignment) -> Result<Self> {
        let methods = run
            .methods
            .iter()
            .map(|record| Ok((record.name().into_owned(), MethodSummary::of(run, record, align)?)))
            .collect::<Result<_>>()?;
        Ok(Summary {
            source: run.setup.name.clone(),
            seed,
            align: align.name(),
            duration_s: run.duration(),
            distance_m: run.distance(),
            methods,
            odometry: run.odometry_timing,
            notes: run.notes.clone(),
        })
    }
}

impl MethodSummary {
    fn of(run: &Run, record: &MethodRecord, align: Alignment) -> Result<Self> {
        let both = || record.estimates.iter().zip(&run.truth);
        let pairs: Vec<_> =
            both().map(|(e, t)| Pair { estimate: e.pose, reference: t.value.pose }).collect();
        let nees = mean(both().filter_map(|(e, t)| Some(run.nees(e, t.value.pose)?.1)));
        let accepted = || record.outcomes.iter().filter(|j| j.value.accepted());
        let used = accepted().count();
        let faster = run.duration() / record.runtime;
        let errors = (!pairs.is_empty()).then(|| planar_errors(&pairs, align)).transpose()?;
        let errors = errors.map(|errors| match run.truth_has_heading {
            true => errors,
            false => errors.without_headings(),
        });
        let searched = (run.settings.global || record.global) && record.method.can_search();
        let converged = searched.then(|| found(run, record, run.setup.start)).flatten();
        let recovered = run.setup.kidnapped_at.and_then(|at| found(run, record, at));
        let (after, updates) = (|found: Found| found.after, |found: Found| found.updates);
        Ok(MethodSummary {
            errors,
            nees_mean: nees,
            claims: Claims::of(run, record),
            nis_mean: mean(accepted().filter_map(|outcome| outcome.value.nis)),
            measurements_used: used,
            measurements_rejected: record.outcomes.len() - used,
            landmarks: landmark_errors(run, record)?,
            beam_fit_at_end: record.beam_fit,
            converged_at_s: converged.map(after),
            ate_since_converged_m: converged.and_then(|found| since(run, record, found)),
            converged_after_updates: converged.map(updates),
            recovered_after_s: recovered.map(after),
            recovered_after_updates: recovered.map(updates),
            runtime_s: record.runtime,
            updates: record.updates,
            realtime_factor: faster.is_finite().then_some(faster),
        })
    }
}

/// Position RMSE from the time of convergence on.
fn since(run: &Run, record: &MethodRecord, found: Found) -> Option<f64> {
    let from = run.setup.start + found.after;
    let late = record.estimates.iter().zip(&run.truth).filter(|(_, truth)| truth.stamp >= from);
    let squares = late.map(|(estimate, truth)| estimate.pose.distance(truth.value.pose).powi(2));
    mean(squares).map(f64::sqrt)
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// The errors as they are, or null under each of their names.
fn errors_or_nulls<S: Serializer>(
    errors: &Option<PlanarErrors>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match errors {
        Some(errors) => errors.serialize(serializer),
        None => serializer.collect_map(PlanarErrors::NAMES.map(|name| (name, None::<f64>))),
    }
}

fn as_map<S: Serializer>(
    methods: &[(String, MethodSummary)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(methods.iter().map(|(name, summary)| (name, summary)))
}

/// Errors of one method over one run: planar poses that are paired already.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct PlanarErrors {
    /// Root mean square of the distances to the truth \[m\].
    pub ate_rmse_m: f64,
    /// Median of the distances to the truth \[m\].
    pub ate_median_m: f64,
    /// Largest distance to the truth \[m\].
    pub ate_max_m: f64,
    /// Root mean square of the heading errors, each in (-180, 180] \[deg\]; `None` where no true
    /// heading is known.
    pub heading_rmse_deg: Option<f64>,
    /// Distance to the truth at the end \[m\].
    pub final_error_m: f64,
    /// Root mean square of the errors of the motion from pose to pose \[m\]; `None` for one pose.
    pub rpe_trans_rmse_m: Option<f64>,
    /// Root mean square of the errors of the turn from pose to pose \[deg\]; `None` for one pose
    /// or without true headings.
    pub rpe_rot_rmse_deg: Option<f64>,
}

impl PlanarErrors {
    /// The names of the figures.
    pub const NAMES: [&str; 7] = [
        "ate_rmse_m",
        "ate_median_m",
        "ate_max_m",
        "heading_rmse_deg",
        "final_error_m",
        "rpe_trans_rmse_m",
        "rpe_rot_rmse_deg",
    ];

    /// The figures of positions alone: relative errors are in the frame of the previous pose and
    /// need its heading.
    #[must_use]
    pub fn without_headings(self) -> Self {
        PlanarErrors {
            heading_rmse_deg: None,
            rpe_trans_rmse_m: None,
            rpe_rot_rmse_deg: None,
            ..self
        }
    }
}

/// The errors over poses that are paired one to one, in order of time.
///
/// The figures are those of [`evaluate`](super::evaluate) over the same poses.
///
/// # Errors
/// [`loc_core::Error::Length`] without pairs, [`loc_core::Error::OutOfRange`] for poses that are
/// not finite, [`crate::Error::UndeterminedAlignment`].
pub fn planar_errors(pairs: &[Pair<Pose2>], align: Alignment) -> Result<PlanarErrors> {
    let pairs = aligned(pairs, align)?;
    let distances = ape_translation(&pairs);
    let position = Statistics::of(Unit::Metre, &distances)?;
    let heading = Statistics::of(Unit::Degree, &ape_rotation(&pairs))?;
    let relative = |unit, errors: Vec<f64>| match errors.as_slice() {
        [] => Ok(None),
        errors => Statistics::of(unit, errors).map(|figures| Some(figures.rmse)),
    };
    Ok(PlanarErrors {
        ate_rmse_m: position.rmse,
        ate_median_m: position.median,
        ate_max_m: position.max,
        heading_rmse_deg: Some(heading.rmse),
        final_error_m: distances[distances.len() - 1],
        rpe_trans_rmse_m: relative(Unit::Metre, rpe_translation(&pairs))?,
        rpe_rot_rmse_deg: relative(Unit::Degree, rpe_rotation(&pairs))?,
    })
}

/// Position error below which an estimate counts as localized \[m\].
const NEAR: f64 = 0.5;

/// Heading error below which an estimate counts as localized \[deg\].
const NEAR_TURN: f64 = 10.0;

/// Number of following estimates that must be near as well; fewer at the end of the run.
const STAYS: usize = 5;

/// Convergence of a method: when its estimate reached the true pose and stayed there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Time until then \[s\].
    pub after: f64,
    /// Measurements accepted until then.
    pub updates: usize,
}

/// The first estimate from `since` \[s\] on that lies within 0.5 m and 10 deg of the truth and
/// whose next five do so too; `None` where there is none, or no truth.
///
/// Updates are the measurements that the method accepted from `since` up to that estimate.
pub fn found(run: &Run, record: &MethodRecord, since: f64) -> Option<Found> {
    let near: Vec<bool> = (0..run.truth.len())
        .map(|k| run.truth[k].stamp >= since && is_near(run, record, k))
        .collect();
    let stays = |k: usize| near[k..].iter().take(STAYS + 1).all(|near| *near);
    let at = run.truth.get((0..near.len()).find(|&k| stays(k))?)?.stamp;
    let until = record.outcomes.iter().filter(|j| j.stamp >= since && j.stamp <= at);
    let updates = until.filter(|outcome| outcome.value.accepted()).count();
    Some(Found { after: at - since, updates })
}

fn is_near(run: &Run, record: &MethodRecord, k: usize) -> bool {
    let (truth, Some(estimate)) = (run.truth[k].value.pose, record.estimates.get(k)) else {
        return false;
    };
    let turn = angle::difference(estimate.pose.theta, truth.theta).abs();
    estimate.pose.distance(truth) <= NEAR && turn <= NEAR_TURN.to_radians()
}

/// Whether a method is localized at the end of a run: its last six estimates lie within
/// 0.5 m and 10 deg of the truth. `None` without a truth.
pub fn ends_near(run: &Run, record: &MethodRecord) -> Option<bool> {
    let count = run.truth.len();
    let first = count.saturating_sub(STAYS + 1);
    (count > 0).then(|| (first..count).all(|k| is_near(run, record, k)))
}

/// The share of a scan's beams that end on the walls of a map: a quality measure of a pose where no
/// true pose is known.
///
/// ```
/// use loc_core::Pose2;
/// use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
/// use loc_sensors::laser::LaserScan;
/// use loc_sim::metrics::BeamFit;
/// let mut map = OccupancyGrid::filled(GridFrame::new(60, 60, 0.1, Pose2::IDENTITY)?, 0);
/// (0..60).try_for_each(|row| map.set(Cell::new(40, row), 100))?;
/// let scan = LaserScan {
///     angle_min: 0.0,
///     angle_max: 0.1,
///     angle_increment: 0.1,
///     time_increment: 0.0,
///     scan_time: 0.1,
///     range_min: 0.1,
///     range_max: 9.0,
///     ranges: vec![2.05, 3.0],
///     intensities: Vec::new(),
/// };
/// let walls = BeamFit::new(&map)?;
/// // The first beam ends on the wall at x = 4.05 m, the second one behind it.
/// assert_eq!(walls.share(Pose2::new(2.0, 3.0, 0.0), &scan, Pose2::IDENTITY), Some(0.5));
/// # Ok::<(), loc_sim::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BeamFit {
    walls: DistanceMap,
}

impl BeamFit {
    /// Largest distance between the end of a fitting beam and a wall \[m\].
    pub const WITHIN: f64 = 0.12;

    /// The walls are the occupied cells.
    ///
    /// # Errors
    /// [`loc_maps::Error`].
    pub fn new(map: &OccupancyGrid) -> Result<Self> {
        // The reach of the distance map is in whole cells.
        let reach = BeamFit::WITHIN + 2.0 * map.frame().resolution();
        Ok(BeamFit { walls: DistanceMap::new(map, reach)? })
    }

    /// The share of the beams with a return whose end lies within [`BeamFit::WITHIN`] of a wall,
    /// from the centre of its cell to that of the wall's, in \[0, 1\]; for a robot at `pose` with
    /// its laser at `mounting` (`base_from_laser`). `None` for a scan without any return; the
    /// greatest range is none, and a beam that ends off the map does not fit.
    pub fn share(&self, pose: Pose2, scan: &LaserScan, mounting: Pose2) -> Option<f64> {
        let laser = pose * mounting;
        let (mut count, mut fitting) = (0_u32, 0_u32);
        for beam in scan.beams().filter(|beam| beam.range < scan.range_max) {
            let distance = self.walls.distance_at(&laser.transform(&beam.point()));
            count += 1;
            fitting += u32::from(distance.is_some_and(|distance| distance <= BeamFit::WITHIN));
        }
        (count > 0).then(|| f64::from(fitting) / f64::from(count))
    }
}
