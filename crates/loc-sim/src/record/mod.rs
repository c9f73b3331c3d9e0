//! The record of a run: the truth, and each method's estimates at the same stamps. A recording
//! may come without a truth; its estimates are sampled at its scans.

mod playback;

pub use playback::{Frame, MethodFrame, Playback, PlaybackRecorder};

use crate::localizer::{Method, MethodSettings};
use crate::metrics::pose_nees_with_freedom;
use crate::source::{OdometryTiming, SensorTruth, Setup};
use loc_core::{Pose2, Stamped};
use loc_filters::line_matching::LineUpdate;
use loc_filters::localizer::{
    Estimate, EstimatedMap, GridBelief, Hypothesis, Outcome, ParticleSet, SensorError,
};
use loc_sensors::event::Truth;
use std::borrow::Cow;

/// How many particles of a method are kept for a figure.
pub(crate) const MAX_PARTICLES: usize = 500;

/// A finished run of several methods over one source.
#[derive(Debug, Clone)]
pub struct Run {
    /// What was known before the first event.
    pub setup: Setup,
    /// The settings of the methods.
    pub settings: MethodSettings,
    /// Stamps of the estimates \[s\], at most 10 a second.
    pub stamps: Vec<f64>,
    /// The truth at each of the stamps; empty where it is unknown.
    pub truth: Vec<Stamped<Truth>>,
    /// Whether true headings are known; else only positions are.
    pub truth_has_heading: bool,
    /// One record per method, in the order of the request.
    pub methods: Vec<MethodRecord>,
    /// The true errors of the sensors, where a simulation keeps them.
    pub sensor_truth: SensorTruth,
    /// The time offset of the odometry, where the source has one.
    pub odometry_timing: Option<OdometryTiming>,
    /// Notes of the source (skipped data) and of the methods.
    pub notes: Vec<String>,
    /// Frames for the playback in the report, where they were recorded.
    pub playback: Option<Playback>,
}

/// The record of one method.
#[derive(Debug, Clone)]
pub struct MethodRecord {
    /// The method.
    pub method: Method,
    /// Whether it ran without a start pose, beside a record of the same method that had one.
    pub global: bool,
    /// Whether its estimates are smoothed, from all events of the run.
    pub smoothed: bool,
    /// Its estimates, one for each stamp of the run.
    pub estimates: Vec<Estimate>,
    /// Its hypotheses at the end, of a method that has several.
    pub hypotheses: Vec<Hypothesis>,
    /// Its outcomes on the measurements, with their stamps \[s\].
    pub outcomes: Vec<Stamped<Outcome>>,
    /// Its estimates of the errors of its sensors, for each stamp of the run; empty for a method
    /// that does not estimate any.
    pub sensor_errors: Vec<Vec<SensorError>>,
    /// Particle sets at some stamps, of a particle filter.
    pub snapshots: Snapshots,
    /// Probability grids at some stamps, of a grid filter.
    pub beliefs: Snapshots<GridBelief>,
    /// The scans with the largest corrections, of a method that matches lines.
    pub lines: LineMoments,
    /// The map at the end, of a method that builds one.
    pub map: Option<EstimatedMap>,
    /// The share of the last scan's beams that end on a wall at the pose estimated there, see
    /// [`BeamFit`](crate::metrics::BeamFit); `None` without a laser or a map.
    pub beam_fit: Option<f64>,
    /// Number of controls and measurements processed.
    pub updates: usize,
    /// Computing time \[s\].
    pub runtime: f64,
}

impl MethodRecord {
    /// An empty record of a method.
    pub(crate) fn new(method: Method, setup: &Setup) -> Self {
        MethodRecord {
            method,
            global: false,
            smoothed: false,
            estimates: Vec::new(),
            hypotheses: Vec::new(),
            outcomes: Vec::new(),
            sensor_errors: Vec::new(),
            snapshots: Snapshots::new(setup.kidnapped_at),
            beliefs: Snapshots::new(setup.kidnapped_at),
            lines: LineMoments::new(setup.start, setup.end),
            map: None,
            beam_fit: None,
            updates: 0,
            runtime: 0.0,
        }
    }

    /// The method's name: `ekf-smoothed` if smoothed, `mcl-global` if it ran without a start pose
    /// beside one that had it.
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

    /// True distance travelled, along the thinned truth \[m\], without the jump of a kidnapping.
    /// `None` without a truth.
    pub fn distance(&self) -> Option<f64> {
        let drove = |pair: &&[Stamped<Truth>]| !self.was_kidnapped(pair[0].stamp, pair[1].stamp);
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
    pub fn was_kidnapped(&self, from: f64, to: f64) -> bool {
        self.setup.kidnapped_at.is_some_and(|at| from < at && at <= to)
    }
}

/// Snapshots of the belief of one method for figures, such as particle sets: at most
/// [`Snapshots::MAX`]. The first ones are all kept, because a method converges then, and so are
/// those after a kidnapping; the others are spread evenly over the rest of the run.
///
/// ```
/// use loc_core::Pose2;
/// use loc_filters::localizer::ParticleSet;
/// use loc_sim::record::Snapshots;
/// let mut snapshots = Snapshots::new(Some(500.0));
/// for k in 0..1000 {
///     let pose = Pose2::new(f64::from(k), 0.0, 0.0);
///     snapshots.offer(f64::from(k), ParticleSet { particles: vec![(pose, 1.0)], weighted: None });
/// }
/// assert!(snapshots.len() <= Snapshots::MAX);
/// let stamps: Vec<f64> = snapshots.iter().map(|snapshot| snapshot.stamp).collect();
/// assert_eq!(stamps[..3], [0.0, 1.0, 2.0]);
/// assert!(stamps.contains(&501.0) && stamps.last() > Some(&950.0));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshots<T = ParticleSet> {
    kept: Vec<Stamped<T>>,
    /// For each one its number among those that may be removed later.
    numbers: Vec<Option<usize>>,
    kidnapped_at: Option<f64>,
    /// The last one that was offered, to detect equal ones.
    last: Option<T>,
    before_kidnap: usize,
    after_kidnap: usize,
    later: usize,
    /// Of the later ones every k-th is kept, k a power of 2.
    every: usize,
}

impl Snapshots {
    /// Largest number that is kept.
    pub const MAX: usize = 64;
    /// Number that is always kept at the start, and after a kidnapping.
    pub const FIRST: usize = 16;
}

impl<T: Clone + PartialEq> Snapshots<T> {
    /// No snapshots yet; with the time of a kidnapping \[s\].
    pub fn new(kidnapped_at: Option<f64>) -> Self {
        Snapshots {
            kept: Vec::new(),
            numbers: Vec::new(),
            kidnapped_at,
            last: None,
            before_kidnap: 0,
            after_kidnap: 0,
            later: 0,
            every: 1,
        }
    }

    /// Offers the belief of a time \[s\]; one that equals the last is skipped.
    pub fn offer(&mut self, stamp: f64, value: T) {
        if self.last.as_ref() == Some(&value) {
            return;
        }
        self.last = Some(value.clone());
        let kidnapped = self.kidnapped_at.is_some_and(|at| stamp >= at);
        let firsts = if kidnapped { &mut self.after_kidnap } else { &mut self.before_kidnap };
        if *firsts < Snapshots::FIRST {
            *firsts += 1;
            self.keep(None, stamp, value);
            return;
        }
        let number = self.later;
        self.later += 1;
        if number.is_multiple_of(self.every.max(1)) {
            self.keep(Some(number), stamp, value);
        }
    }

    fn keep(&mut self, number: Option<usize>, stamp: f64, value: T) {
        self.kept.push(Stamped { stamp, value });
        self.numbers.push(number);
        if self.kept.len() > Snapshots::MAX {
            self.every = 2 * self.every.max(1);
            let every = self.every;
            let stays = |number: &Option<usize>| number.is_none_or(|n| n.is_multiple_of(every));
            let mut numbers = self.numbers.iter();
            self.kept.retain(|_| numbers.next().is_some_and(stays));
            self.numbers.retain(stays);
        }
    }

    /// Number of snapshots.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// All of them in order of time.
    pub fn iter(&self) -> std::slice::Iter<'_, Stamped<T>> {
        self.kept.iter()
    }
}

/// For each part of a run the line update with the largest correction of the pose, for figures.
#[derive(Debug, Clone, PartialEq)]
pub struct LineMoments {
    start: f64,
    end: f64,
    parts: [Option<Stamped<LineUpdate>>; Self::PARTS],
}

/// Lever arm by which a rotation \[rad\] counts as a translation \[m\].
const LEVER: f64 = 3.0;

impl LineMoments {
    /// Number of parts.
    pub const PARTS: usize = 6;

    /// No updates yet, of a run between two times \[s\].
    pub fn new(start: f64, end: f64) -> Self {
        LineMoments { start, end, parts: Default::default() }
    }

    /// Offers an update at a time \[s\].
    pub fn offer(&mut self, stamp: f64, update: &LineUpdate) {
        let share = (stamp - self.start) / (self.end - self.start);
        // The cast saturates, NaN becomes 0.
        let part = ((share * Self::PARTS as f64) as usize).min(Self::PARTS - 1);
        let kept = self.parts[part].as_ref().map(|kept| correction(&kept.value));
        if kept.is_none_or(|kept| correction(update) > kept) {
            self.parts[part] = Some(Stamped { stamp, value: update.clone() });
        }
    }

    /// The updates in order of time.
    pub fn iter(&self) -> impl Iterator<Item = &Stamped<LineUpdate>> {
        self.parts.iter().flatten()
    }
}

/// Size of the correction by an update \[m\].
fn correction(update: &LineUpdate) -> f64 {
    let (before, after) = (update.before.pose(), update.after.pose());
    f64::hypot(before.distance(after), LEVER * before.between(after).theta)
}
