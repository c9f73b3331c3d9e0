//! What a run leaves behind: the truth, and each method's estimates at the same stamps. A
//! recording may come without a truth; its estimates are those at its scans.

use crate::localizer::{
    Estimate, EstimatedMap, Judgement, Method, MethodSettings, PlaceBelief, SensorError,
};
use crate::metrics::pose_nees_with_freedom;
use crate::source::{OdometryTiming, SensorTruth, Setup};
use loc_core::{Pose2, Stamped};
use loc_sensors::event::Truth;
use std::borrow::Cow;

mod film;
mod moments;
mod snapshots;

pub use film::{Film, Filming, Frame, Inside};
pub use moments::LineMoments;
pub use snapshots::Snapshots;

/// A finished run of several methods over one source.
#[derive(Debug, Clone)]
pub struct Run {
    /// What was known before it.
    pub setup: Setup,
    /// What the methods were told.
    pub settings: MethodSettings,
    /// When the estimates were asked for \[s\]: at most 10 times a second.
    pub stamps: Vec<f64>,
    /// The truth at each of the stamps; empty where nothing is known of it.
    pub truth: Vec<Stamped<Truth>>,
    /// Whether the true headings mean anything; else only positions are known.
    pub truth_has_heading: bool,
    /// One record per method, in the order in which they were asked for.
    pub methods: Vec<MethodRecord>,
    /// The true errors of the sensors, where a simulation keeps them.
    pub sensor_truth: SensorTruth,
    /// How the odometry was moved in time, where the source says so.
    pub odometry_timing: Option<OdometryTiming>,
    /// What the source passed over, and what the methods have to say.
    pub notes: Vec<String>,
    /// What was to be seen at each of the stamps, where somebody filmed it.
    pub film: Option<Film>,
}

/// What one method did.
#[derive(Debug, Clone)]
pub struct MethodRecord {
    /// The method.
    pub method: Method,
    /// Whether it was not told where the robot starts, beside a record of the same method that was.
    pub global: bool,
    /// Whether these are its estimates after the run, smoothed by all that came later.
    pub smoothed: bool,
    /// Its estimates, one for each stamp of the run.
    pub estimates: Vec<Estimate>,
    /// Its judgements on the measurements, with their stamps \[s\].
    pub judgements: Vec<Stamped<Judgement>>,
    /// What it believed about the errors of its sensors, for each stamp of the run; empty for a
    /// method that does not ask.
    pub sensor_errors: Vec<Vec<SensorError>>,
    /// The particles of a method that has any, now and then.
    pub snapshots: Snapshots,
    /// The probabilities of the places, of a method that keeps a grid of them, now and then.
    pub beliefs: Snapshots<PlaceBelief>,
    /// The scans that moved the pose most, of a method that matches lines.
    pub lines: LineMoments,
    /// The map at the end, of a method that draws its own.
    pub map: Option<EstimatedMap>,
    /// The share of the last scan's beams that end on a wall at the pose estimated there, see
    /// [`BeamFit`](crate::metrics::BeamFit); `None` without a laser or a map.
    pub beam_fit: Option<f64>,
    /// Number of controls and measurements it took in.
    pub updates: usize,
    /// Time it took \[s\].
    pub runtime: f64,
}

impl MethodRecord {
    /// The method's name, `ekf-smoothed` for what was smoothed, `mcl-global` for what started
    /// without a pose beside what did not.
    pub fn name(&self) -> Cow<'static, str> {
        let name = self.method.name();
        match (self.smoothed, self.global) {
            (true, _) => format!("{name}-smoothed").into(),
            (false, true) => format!("{name}-global").into(),
            (false, false) => name.into(),
        }
    }
}

impl Run {
    /// Time from the first to the last estimate \[s\].
    pub fn duration(&self) -> f64 {
        match (self.stamps.first(), self.stamps.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Way that the robot really drove, through the thinned truth \[m\]; the way that it was
    /// carried does not count. `None` without a truth.
    pub fn distance(&self) -> Option<f64> {
        let drove = |pair: &&[Stamped<Truth>]| !self.was_carried(pair[0].stamp, pair[1].stamp);
        let step = |pair: &[Stamped<Truth>]| pair[0].value.pose.distance(pair[1].value.pose);
        let driven = self.truth.windows(2).filter(drove).map(step).sum();
        (!self.truth.is_empty()).then_some(driven)
    }

    /// Degrees of freedom and NEES of an estimate against a true pose of this run: of the position
    /// alone where no true heading is known. See [`pose_nees_with_freedom`].
    pub fn nees(&self, estimate: &Estimate, truth: Pose2) -> Option<(usize, f64)> {
        let mut judged = *estimate;
        if let Some(covariance) = judged.covariance.as_mut().filter(|_| !self.truth_has_heading) {
            covariance.fill_row(2, 0.0);
            covariance.fill_column(2, 0.0);
        }
        pose_nees_with_freedom(&judged, truth)
    }

    /// Whether the robot was kidnapped after the first of two times \[s\], or at the second one.
    pub fn was_carried(&self, from: f64, to: f64) -> bool {
        self.setup.kidnapped_at.is_some_and(|at| from < at && at <= to)
    }
}
