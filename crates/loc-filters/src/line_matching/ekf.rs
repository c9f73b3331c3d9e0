//! The filter: odometry, then the lines of a scan (H4).

use super::lines::{Lines, WithBelief};
use super::predicted::predicted_lines;
use super::search::{Pair, in_order, most_likely};
use super::state::{OdometryStep, OfPose, STATES, pose_of, set_pose, with_odometry};
use super::update::matched_share;
use super::{
    FieldOfView, LineMatchingSettings, LinePair, LinePairing, LineUpdate, PredictedLine, Tracking,
};
use crate::association::{AssociationSettings, Associator};
use crate::smoother::Recorded;
use crate::{ExtendedKalmanFilter, Gate, NonlinearFilter, Result, UnscentedKalmanFilter};
use loc_core::gaussian::{check_covariance, cholesky};
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2};
use loc_maps::LineMap;
use loc_sensors::features::Line;
use loc_sensors::laser::LaserScan;
use nalgebra::{Vector2, Vector3, Vector6};
use std::sync::Arc;

/// A Kalman filter over (x, y, theta) \[m, m, rad\] with the walls of a line map: [`LineEkf`] or
/// [`LineUkf`].
#[derive(Debug, Clone)]
pub struct LineFilter<F> {
    filter: F,
    map: Arc<LineMap>,
    settings: LineMatchingSettings,
    gate: Gate,
    /// The way since the last scan that fits.
    path: Option<DrivenPath>,
    tracking: Tracking,
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
        let gate = settings.gate()?;
        let systematic = settings.systematic;
        let start = with_odometry(&start, systematic.drift, systematic.scale);
        let filter = F::start(start, &[2])?;
        Ok(LineFilter { filter, map, settings, gate, path: None, tracking: Tracking::default() })
    }

    /// What the filter believes now.
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

    /// Whether it still knows where the robot is.
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

    /// Starts anew from a belief, as after the robot was lost and found again.
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
        let way = self.path.get_or_insert(DrivenPath::starting_at(pose));
        let mut path = DrivenPath::starting_at(way.end());
        path.extend(pose);
        let variances = self.settings.motion.variances(&path);
        let wander = self.settings.systematic.wander(path.length());
        self.filter.predict(&OdometryStep { path, variances, wander })?;
        way.extend(pose);
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
        let motion = &self.settings.motion;
        let least = [motion.min_position, motion.min_position, motion.min_heading];
        let mut attempt = self.attempt(&seen, view, mounting, least.into())?;
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
        let gate_probability = self.settings.gate_probability;
        let settings = AssociationSettings { rule, gate_probability, ..Default::default() };
        let found = Associator::new(settings)?.associate(&WithBelief { lines, belief })?;
        let partners = found.partners.into_iter().enumerate();
        let pairs: Vec<Pair> = partners.filter_map(|(line, other)| Some((line, other?))).collect();
        in_order(lines, belief, &self.gate, &pairs)
    }

    /// Whether a scan fits; `None` where it has too few lines to tell.
    fn fits(&self, seen: &[Line], pairs: &[Option<LinePair>]) -> Option<bool> {
        let enough = seen.len() >= self.settings.lost.min_lines;
        let share = matched_share(seen, pairs).filter(|_| enough)?;
        Some(share >= self.settings.lost.min_share)
    }

    /// Believes a correction, unless the scan does not fit.
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

impl<F: NonlinearFilter<STATES>> LineFilter<Recorded<F, STATES>> {
    /// Asks for the belief of this moment, to be smoothed later.
    pub fn mark(&mut self) {
        self.filter.mark();
    }

    /// The smoothed belief at each mark since the filter was started last, in the order of the marks.
    ///
    /// # Errors
    /// Those of [`Smoother::smooth`](crate::smoother::Smoother::smooth).
    pub fn smooth(&self) -> Result<Vec<Gaussian<3>>> {
        Ok(self.filter.past().smooth_marked()?.iter().map(pose_of).collect())
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
