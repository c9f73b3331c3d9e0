//! The line filter (H4): prediction by odometry, correction by the lines of a scan, and their result.

use super::model::{
    OdometryStep, OfPose, STATES, pose_of, predicted_lines, set_pose, with_odometry,
};
use super::pairing::{Lines, Pair, WithBelief, in_order, most_likely};
use super::{FieldOfView, LineMatchingSettings, LinePairing, PredictedLine};
use crate::association::{AssociationSettings, Associator};
use crate::delayed::Sequential;
use crate::localizer::{Decision, Estimate, Localizer, Outcome};
use crate::smoother::{Recorded, Smoothable};
use crate::{
    ExtendedKalmanFilter, Gate, Innovation, NonlinearFilter, Result, UnscentedKalmanFilter,
};
use loc_core::gaussian::{check_covariance, cholesky};
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2};
use loc_maps::{LineMap, LineSegment};
use loc_sensors::event::{Control, Measurement};
use loc_sensors::features::Line;
use loc_sensors::laser::LaserScan;
use nalgebra::{Point2, Vector2, Vector3, Vector6};
use std::sync::Arc;

/// Fewer lines say nothing about whether the robot is lost.
const MIN_LINES: usize = 2;

/// A Kalman filter over (x, y, theta) \[m, m, rad\] with the walls of a line map: [`LineEkf`] or
/// [`LineUkf`].
#[derive(Debug, Clone)]
pub struct LineFilter<F> {
    filter: F,
    map: Arc<LineMap>,
    settings: LineMatchingSettings,
    gate: Gate,
    /// The path since the last scan that fits.
    path: Option<DrivenPath>,
    tracking: Tracking,
    /// What the last scan has led to.
    last: Option<LineUpdate>,
}

/// The extended Kalman filter (H4).
pub type LineEkf = LineFilter<ExtendedKalmanFilter<STATES>>;

/// The unscented Kalman filter on the same models.
pub type LineUkf = LineFilter<UnscentedKalmanFilter<STATES>>;

impl<F: NonlinearFilter<STATES>> LineFilter<F> {
    /// A filter in a map that starts from a belief over (x, y, theta).
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for a map without lines; [`loc_core::Error`] for a belief or
    /// settings that are not valid.
    pub fn new(
        map: impl Into<Arc<LineMap>>,
        settings: LineMatchingSettings,
        start: Gaussian<3>,
    ) -> Result<Self> {
        let map = map.into();
        if map.is_empty() {
            let expected = "a map with at least one line";
            return Err(loc_core::Error::Length { what: "line map", expected, found: 0 }.into());
        }
        settings.check()?;
        let gate = Gate::probability(settings.robot.gate_probability)?;
        let systematic = settings.systematic;
        let start = with_odometry(&start, systematic.drift, systematic.scale);
        let filter = F::start(start, &[2])?;
        Ok(LineFilter {
            filter,
            map,
            settings,
            gate,
            path: None,
            tracking: Tracking::default(),
            last: None,
        })
    }

    /// The current belief.
    pub fn belief(&self) -> Gaussian<3> {
        pose_of(self.filter.belief())
    }

    /// What the odometry gets wrong all the time, as far as the filter has found out: by how much
    /// the heading drifts to the left, beyond what is reported \[rad/m\], and the share by which
    /// distances are longer than reported.
    pub fn systematic(&self) -> Gaussian<2> {
        let belief = self.filter.belief();
        Gaussian {
            mean: belief.mean.fixed_rows::<2>(3).into(),
            covariance: belief.covariance.fixed_view::<2, 2>(3, 3).into(),
        }
    }

    /// Whether the filter still fits the scans.
    pub fn tracking(&self) -> Tracking {
        self.tracking
    }

    /// The map.
    pub fn map(&self) -> &Arc<LineMap> {
        &self.map
    }

    /// The lines that a scanner at `mounting` (`base_from_laser`) should see now, in its frame.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for the mounting and the field of view.
    pub fn predicted(&self, view: FieldOfView, mounting: Pose2) -> Result<Vec<PredictedLine>> {
        self.predicted_by(&self.belief(), view, mounting)
    }

    fn predicted_by(
        &self,
        belief: &Gaussian<3>,
        view: FieldOfView,
        mounting: Pose2,
    ) -> Result<Vec<PredictedLine>> {
        predicted_lines(&self.map, belief, mounting, view, &self.settings)
    }

    /// Starts anew from a belief, as after a relocalization.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`]; the filter is then as it was.
    pub fn restart(&mut self, belief: Gaussian<3>) -> Result<()> {
        let belief = Gaussian::new(belief.mean, belief.covariance)?;
        let mut all = *self.filter.belief();
        set_pose(&mut all, &belief);
        self.filter = F::start(all, &[2])?;
        self.tracking = Tracking::default();
        Ok(())
    }

    /// The robot's pose in its odometry; the first one only says where that frame is.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the pose.
    pub fn odometry(&mut self, pose: Pose2) -> Result<()> {
        crate::innovation::finite("pose of the odometry", &pose.to_vector())?;
        let since_fit = self.path.get_or_insert(DrivenPath::starting_at(pose));
        let mut path = DrivenPath::starting_at(since_fit.end());
        path.extend(pose);
        let variances = self.settings.robot.path.variances(&path);
        let wander = self.settings.systematic.changes(path.length());
        self.filter.predict(&OdometryStep { path, variances, wander })?;
        since_fit.extend(pose);
        Ok(())
    }

    /// Corrects with a scan from a scanner at `mounting` (`base_from_laser`).
    ///
    /// # Errors
    /// [`loc_core::Error`] for a scan or a mounting that is not valid; the belief is kept.
    pub fn scan(&mut self, scan: &LaserScan, mounting: Pose2) -> Result<LineUpdate> {
        let lines = self.settings.extractor.extract(scan)?;
        self.lines(lines, FieldOfView::of(scan), mounting)
    }

    /// Corrects with lines of a scan, in the scanner's frame. A scan without lines is fine.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for lines, [`loc_core::Error::NotACovariance`] for one whose
    /// covariance is not positive definite, [`loc_core::Error::OutOfRange`] for the mounting and
    /// the field of view; the belief is kept.
    pub fn lines(
        &mut self,
        seen: Vec<Line>,
        view: FieldOfView,
        mounting: Pose2,
    ) -> Result<LineUpdate> {
        crate::innovation::finite("mounting of the laser", &mounting.to_vector())?;
        seen.iter().try_for_each(check)?;
        let motion = &self.settings.robot.path;
        let min_sigmas = [motion.min_position, motion.min_position, motion.min_heading];
        let mut attempt = self.attempt(&seen, view, mounting, min_sigmas.into())?;
        if attempt.fits == Some(false) && motion.fault_probability > 0.0 {
            // Perhaps odometry has failed since a scan fitted, or was off as it rarely is.
            let rarely = |path| {
                3.0 * motion.variances(&path).map(f64::sqrt) + PathNoise::fault_sigmas(&path)
            };
            let fault = self.path.map_or(Vector3::zeros(), rarely);
            let wide = self.attempt(&seen, view, mounting, fault)?;
            attempt = if wide.fits == Some(true) { wide } else { attempt };
        }
        Ok(self.take(seen, mounting, attempt))
    }

    /// Tries a correction after more noise along the heading, across it, and of the heading.
    fn attempt(
        &self,
        seen: &[Line],
        view: FieldOfView,
        mounting: Pose2,
        sigmas: Vector3<f64>,
    ) -> Result<Attempt<F>> {
        let mut filter = self.filter.clone();
        filter.predict(&OdometryStep {
            path: DrivenPath::starting_at(Pose2::IDENTITY),
            variances: sigmas.component_mul(&sigmas),
            wander: Vector2::zeros(),
        })?;
        let belief = pose_of(filter.belief());
        let predicted = self.predicted_by(&belief, view, mounting)?;
        let scanner = (belief.pose() * mounting, mounting);
        let overlap = (self.settings.min_overlap, self.settings.slack);
        let lines = Lines::new(&self.map, scanner, seen, &predicted, overlap);
        let mut pairs = vec![None; seen.len()];
        for (line, predicted) in self.pairs(&lines, &belief)? {
            let model = OfPose(lines.model(line, predicted));
            let innovation = filter.correct(&model, &lines.measurement(line), &Gate::OPEN)?;
            pairs[line] = Some(LinePair { predicted, innovation });
        }
        let fits = self.fits(seen, &pairs);
        Ok(Attempt { filter, predicted, pairs, fits })
    }

    /// Which line of the scan is which predicted one, in the order to correct with.
    fn pairs(&self, lines: &Lines<'_>, belief: &Gaussian<3>) -> Result<Vec<Pair>> {
        let LinePairing::Rule(rule) = self.settings.pairing else {
            return most_likely(lines, belief, &self.gate);
        };
        let gate_probability = self.settings.robot.gate_probability;
        let settings = AssociationSettings { rule, gate_probability, ..Default::default() };
        let found = Associator::new(settings)?.associate(&WithBelief { lines, belief })?;
        let partners = found.partners.into_iter().enumerate();
        let pairs: Vec<Pair> = partners.filter_map(|(line, other)| Some((line, other?))).collect();
        in_order(lines, belief, &self.gate, &pairs)
    }

    /// Whether a scan fits; `None` where it has too few lines to tell.
    fn fits(&self, seen: &[Line], pairs: &[Option<LinePair>]) -> Option<bool> {
        let enough = seen.len() >= MIN_LINES;
        let share = matched_share(seen, pairs).filter(|_| enough)?;
        Some(share >= self.settings.lost.min_share)
    }

    /// Accepts a correction, unless the scan does not fit.
    fn take(&mut self, seen: Vec<Line>, mounting: Pose2, attempt: Attempt<F>) -> LineUpdate {
        let before = self.belief();
        let Attempt { filter, predicted, mut pairs, fits } = attempt;
        self.tracking = self.tracking.after(fits, self.settings.lost.scans);
        if fits == Some(false) {
            pairs.iter_mut().flatten().for_each(|pair| pair.innovation.accepted = false);
        } else {
            self.filter = filter;
            self.path = self.path.map(|path| DrivenPath::starting_at(path.end()));
        }
        let (after, tracking) = (self.belief(), self.tracking);
        LineUpdate { before, after, mounting, seen, predicted, pairs, tracking }
    }
}

/// Predicts with the poses of an odometry and corrects with scans; one outcome for each line.
impl<F: NonlinearFilter<STATES>> Localizer for LineFilter<F> {
    fn predict(&mut self, _stamp: f64, control: &Control) -> Result<()> {
        let Control::Odometry(pose) = control else { return Ok(()) };
        self.odometry(*pose)
    }

    fn correct(&mut self, _stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let Measurement::Scan { scan, mounting } = measurement else { return Ok(Vec::new()) };
        let update = self.scan(scan, *mounting)?;
        let unmatched = Outcome::of(Decision::UnknownLandmark);
        let of = |pair: &Option<LinePair>| {
            pair.map_or(unmatched, |pair| Outcome::of_innovation(&pair.innovation))
        };
        let outcomes = update.pairs.iter().map(of).collect();
        self.last = Some(update);
        Ok(outcomes)
    }

    /// The belief after the last input.
    fn estimate(&self, _stamp: f64) -> Result<Estimate> {
        Ok(self.belief().into())
    }

    fn line_matches(&self) -> Option<&LineUpdate> {
        self.last.as_ref()
    }
}

impl<F: NonlinearFilter<STATES>> Sequential for LineFilter<F> {
    const USES_POSES: bool = true;

    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Scan { .. })
    }

    fn mark(&mut self, _stamp: f64) -> Result<()> {
        self.filter.mark();
        Ok(())
    }
}

/// The smoothed beliefs are those since the filter was started last.
impl<F: NonlinearFilter<STATES>> Smoothable for LineFilter<Recorded<F, STATES>> {
    fn smoothed(&self) -> Result<Vec<Estimate>> {
        Ok(self
            .filter
            .past()
            .smooth_marked()?
            .iter()
            .map(|belief| pose_of(belief).into())
            .collect())
    }
}

/// Refuses lines that no scan has.
fn check(line: &Line) -> Result<()> {
    let Line { start, end, .. } = line;
    let numbers = Vector6::new(line.r, line.alpha, start.x, start.y, end.x, end.y);
    crate::innovation::finite("line of a scan (r, alpha, start, end)", &numbers)?;
    check_covariance("covariance of a line of a scan", &line.covariance)?;
    cholesky("covariance of a line of a scan", &line.covariance)?;
    Ok(())
}

/// A correction that was tried.
struct Attempt<F> {
    filter: F,
    predicted: Vec<PredictedLine>,
    pairs: Vec<Option<LinePair>>,
    fits: Option<bool>,
}

/// Whether the scans fit the belief.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tracking {
    /// The last scan that had lines fits the map.
    #[default]
    Sure,
    /// This many scans in a row do not fit; the belief is predicted by odometry and by the few
    /// lines that do.
    Doubtful(usize),
    /// So many do not fit that the robot is most likely elsewhere (delocalized). The filter goes on, but
    /// its covariance is no longer valid: the robot has to be relocalized by other means, to restart the
    /// filter there.
    Lost(usize),
}

/// The lines of one scan, what was predicted, and which of them are the same.
#[derive(Debug, Clone, PartialEq)]
pub struct LineUpdate {
    /// The belief before the correction.
    pub before: Gaussian<3>,
    /// The belief after it.
    pub after: Gaussian<3>,
    /// The scanner on the robot (`base_from_laser`).
    pub mounting: Pose2,
    /// Lines of the scan, in the scanner's frame.
    pub seen: Vec<Line>,
    /// Lines that the belief before the correction predicts, in the scanner's frame.
    pub predicted: Vec<PredictedLine>,
    /// For each line of the scan its pair, where it has one.
    pub pairs: Vec<Option<LinePair>>,
    /// Whether the robot is still known to be there.
    pub tracking: Tracking,
}

/// A line of a scan and the predicted one that it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinePair {
    /// Index among the predicted lines.
    pub predicted: usize,
    /// Residual of (r, alpha) and its covariance, as the belief that earlier pairs had left has
    /// them. It is accepted unless the whole scan was rejected.
    pub innovation: Innovation<2>,
}

impl LineUpdate {
    /// Number of lines that have corrected the pose.
    pub fn matched(&self) -> usize {
        self.pairs.iter().flatten().filter(|pair| pair.innovation.accepted).count()
    }

    /// The share of the scan's lines that have, by length; `None` without any lines.
    pub fn matched_share(&self) -> Option<f64> {
        matched_share(&self.seen, &self.pairs)
    }

    /// The lines of the scan in the map, seen from the corrected pose, with their pairs.
    pub fn seen_in_map(&self) -> impl Iterator<Item = (LineSegment, Option<&LinePair>)> {
        let scanner = self.after.pose() * self.mounting;
        self.seen
            .iter()
            .zip(&self.pairs)
            .map(move |(line, pair)| (in_map(scanner, line.start, line.end), pair.as_ref()))
    }

    /// The predicted stretches in the map.
    pub fn predicted_in_map(&self) -> impl Iterator<Item = LineSegment> {
        let scanner = self.before.pose() * self.mounting;
        let stretches = self.predicted.iter().map(|predicted| predicted.stretch);
        stretches.map(move |stretch| in_map(scanner, stretch.start, stretch.end))
    }
}

/// The share of lines, by length, that have an accepted partner; `None` without any lines.
pub(super) fn matched_share(seen: &[Line], pairs: &[Option<LinePair>]) -> Option<f64> {
    let accepted = |pair: &Option<LinePair>| pair.is_some_and(|pair| pair.innovation.accepted);
    let matched = seen.iter().zip(pairs).filter(|(_, pair)| accepted(pair));
    let total: f64 = seen.iter().map(Line::length).sum();
    (total > 0.0).then(|| matched.map(|(line, _)| line.length()).sum::<f64>() / total)
}

fn in_map(scanner: Pose2, start: Point2<f64>, end: Point2<f64>) -> LineSegment {
    LineSegment { start: scanner.transform(&start), end: scanner.transform(&end) }
}

impl Tracking {
    /// After one more scan; a scan that says nothing changes nothing.
    pub(super) fn after(self, fits: Option<bool>, patience: usize) -> Self {
        match (fits, self) {
            (None, before) => before,
            (Some(true), _) => Tracking::Sure,
            (Some(false), Tracking::Sure) => Tracking::of(1, patience),
            (Some(false), Tracking::Doubtful(scans) | Tracking::Lost(scans)) => {
                Tracking::of(scans.saturating_add(1), patience)
            }
        }
    }

    fn of(scans: usize, patience: usize) -> Self {
        if scans >= patience { Tracking::Lost(scans) } else { Tracking::Doubtful(scans) }
    }
}
