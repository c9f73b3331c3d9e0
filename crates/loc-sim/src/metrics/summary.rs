//! The figures of a run: what `summary.json` holds.

use super::{
    Alignment, Found, LandmarkErrors, Pair, PlanarErrors, found, landmark_errors, planar_errors,
};
use crate::Result;
use crate::record::{MethodRecord, Run};
use crate::source::OdometryTiming;
use serde::{Serialize, Serializer};

/// The figures of a run, by method.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// The recording or scenario.
    pub source: String,
    /// Seed of a simulation.
    pub seed: Option<u64>,
    /// How estimates were carried into the frame of the truth before they were compared.
    pub align: &'static str,
    /// From the first to the last estimate.
    pub duration_s: f64,
    /// Way that the robot really drove; null without a truth.
    pub distance_m: Option<f64>,
    /// One entry per method, in the order in which they were asked for.
    #[serde(serialize_with = "as_map")]
    pub methods: Vec<(String, MethodSummary)>,
    /// How the odometry was moved in time; null where nothing says so.
    pub odometry: Option<OdometryTiming>,
    /// What the source passed over, and what the methods have to say.
    pub notes: Vec<String>,
}

/// The figures of one method. A figure without a meaning is `None`, null in JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MethodSummary {
    /// How far the estimates are off; each figure null without a truth.
    #[serde(flatten, serialize_with = "errors_or_nulls")]
    pub errors: Option<PlanarErrors>,
    /// Mean normalised estimation error squared; 3 for an honest covariance of a pose, 2 where
    /// only true positions are known.
    pub nees_mean: Option<f64>,
    /// Mean normalised innovation squared of the accepted measurements.
    pub nis_mean: Option<f64>,
    /// Measurements that changed the belief.
    pub measurements_used: usize,
    /// Measurements that did not.
    pub measurements_rejected: usize,
    /// How good the map is that the method has drawn; null for one that draws none.
    pub landmarks: Option<LandmarkErrors>,
    /// The share of the beams of the last scan with a return that end within 12 cm of a wall at
    /// the pose estimated there, see [`BeamFit`](super::BeamFit); null without a laser or a map.
    pub beam_fit_at_end: Option<f64>,
    /// How long a method that started without a pose needed to find it, see [`found`]; null for
    /// one that was given it, or that never did.
    pub converged_at_s: Option<f64>,
    /// Root mean square of the distances to the truth from then on; null with `converged_at_s`.
    pub ate_since_converged_m: Option<f64>,
    /// The same in measurements that it used.
    pub converged_after_updates: Option<usize>,
    /// How long a method needed after a kidnapping; null without one, or if it never recovered.
    pub recovered_after_s: Option<f64>,
    /// The same in measurements that it used.
    pub recovered_after_updates: Option<usize>,
    /// Time that the method took.
    pub runtime_s: f64,
    /// Controls and measurements that it took in.
    pub updates: usize,
    /// How many times faster than the robot it was.
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
        let accepted = || record.judgements.iter().filter(|j| j.value.accepted);
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
            nis_mean: mean(accepted().filter_map(|judgement| judgement.value.nis)),
            measurements_used: used,
            measurements_rejected: record.judgements.len() - used,
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

/// RMSE from the time at which a method has found the robot.
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
