//! What a run leaves behind: the truth, and each method's estimates at the same stamps. A
//! recording may come without a truth; its estimates are those at its scans.

mod film;

pub use film::{Film, Filming, Frame, Inside};

use crate::localizer::{
    Cloud, Estimate, EstimatedMap, Judgement, Method, MethodSettings, PlaceBelief, SensorError,
};
use crate::metrics::pose_nees_with_freedom;
use crate::source::{OdometryTiming, SensorTruth, Setup};
use loc_core::{Pose2, Stamped};
use loc_filters::line_matching::LineUpdate;
use loc_sensors::event::Truth;
use std::borrow::Cow;

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

// A few of the many clouds and grids of a run, for figures.

/// What one method believed, such as its clouds: at most [`Snapshots::MAX`]. The first ones are
/// all kept, since that is when a method finds the robot, and so are those after a kidnapping; the
/// others lie at even distances over the rest of the run.
///
/// ```
/// use loc_core::Pose2;
/// use loc_sim::localizer::Cloud;
/// use loc_sim::record::Snapshots;
/// let mut snapshots = Snapshots::new(Some(500.0));
/// for k in 0..1000 {
///     let pose = Pose2::new(f64::from(k), 0.0, 0.0);
///     snapshots.offer(f64::from(k), Cloud { particles: vec![(pose, 1.0)], weighed: None });
/// }
/// assert!(snapshots.len() <= Snapshots::MAX);
/// let stamps: Vec<f64> = snapshots.iter().map(|snapshot| snapshot.stamp).collect();
/// assert_eq!(stamps[..3], [0.0, 1.0, 2.0]);
/// assert!(stamps.contains(&501.0) && stamps.last() > Some(&950.0));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshots<T = Cloud> {
    kept: Vec<Stamped<T>>,
    /// Beside each one its number among those that may be left out again.
    numbers: Vec<Option<usize>>,
    kidnapped_at: Option<f64>,
    /// The last one that was offered, to tell new ones from old ones.
    last: Option<T>,
    before_kidnap: usize,
    after_kidnap: usize,
    later: usize,
    /// Of the later ones every k-th is kept, k a power of 2.
    every: usize,
}

impl Snapshots {
    /// The most that are kept.
    pub const MAX: usize = 64;
    /// How many are kept whatever comes after them: at the start, and after a kidnapping.
    pub const FIRST: usize = 16;
}

impl<T: Clone + PartialEq> Snapshots<T> {
    /// None yet, of a robot that may be kidnapped \[s\].
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

    /// Offers what there is at a time \[s\]; if it is the same as the last one, it is passed over.
    pub fn offer(&mut self, stamp: f64, value: T) {
        if self.last.as_ref() == Some(&value) {
            return;
        }
        self.last = Some(value.clone());
        let carried = self.kidnapped_at.is_some_and(|at| stamp >= at);
        let firsts = if carried { &mut self.after_kidnap } else { &mut self.before_kidnap };
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

    /// How many there are.
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

// The scans that corrected a pose most, for figures.

/// Of each part of a run the update that moved the pose most.
#[derive(Debug, Clone, PartialEq)]
pub struct LineMoments {
    start: f64,
    end: f64,
    parts: [Option<Stamped<LineUpdate>>; Self::PARTS],
}

/// A turn of 1 rad counts as much as a way of so many metres.
const LEVER: f64 = 3.0;

impl LineMoments {
    /// Number of parts.
    pub const PARTS: usize = 6;

    /// None yet, of a run between two times \[s\].
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

/// How far an update moved the pose \[m\].
fn correction(update: &LineUpdate) -> f64 {
    let (before, after) = (update.before.pose(), update.after.pose());
    f64::hypot(before.distance(after), LEVER * before.between(after).theta)
}
