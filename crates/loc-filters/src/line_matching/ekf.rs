//! The filter: odometry, then the lines of a scan (H4).

use super::pairs::Pairs;
use super::{
    FieldOfView, LineMatchingSettings, LinePair, LineUpdate, PredictedLine, Tracking,
    predicted_lines,
};
use crate::extended::{LinearizedMotion, MotionModel};
use crate::{ExtendedKalmanFilter, Gate, Innovation, Result};
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2};
use loc_maps::LineMap;
use loc_sensors::features::Line;
use loc_sensors::laser::LaserScan;
use nalgebra::Vector3;
use std::sync::Arc;

/// Extended Kalman filter over (x, y, theta) \[m, m, rad\] with the walls of a line map.
#[derive(Debug, Clone)]
pub struct LineEkf {
    filter: ExtendedKalmanFilter<3>,
    map: Arc<LineMap>,
    settings: LineMatchingSettings,
    gate: Gate,
    /// Where odometry was last.
    odometry: Option<Pose2>,
    tracking: Tracking,
}

impl LineEkf {
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
        let filter = ExtendedKalmanFilter::new(start)?.with_angles(&[2]);
        Ok(LineEkf { filter, map, settings, gate, odometry: None, tracking: Tracking::default() })
    }

    /// What the filter believes now.
    pub fn belief(&self) -> &Gaussian<3> {
        self.filter.belief()
    }

    /// Whether it still knows where the robot is.
    pub fn tracking(&self) -> Tracking {
        self.tracking
    }

    /// The map.
    pub fn map(&self) -> &Arc<LineMap> {
        &self.map
    }

    /// Starts anew from a belief, as after the robot was lost and found again.
    ///
    /// # Errors
    /// Those of [`Gaussian::new`]; the filter is then as it was.
    pub fn restart(&mut self, belief: Gaussian<3>) -> Result<()> {
        self.filter = ExtendedKalmanFilter::new(belief)?.with_angles(&[2]);
        self.tracking = Tracking::default();
        Ok(())
    }

    /// The robot's pose in its odometry; the first one only says where that frame is.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for the pose.
    pub fn odometry(&mut self, pose: Pose2) -> Result<()> {
        crate::innovation::finite("pose of the odometry", &pose.to_vector())?;
        if let Some(before) = self.odometry {
            let mut path = DrivenPath::starting_at(before);
            path.extend(pose);
            let variances = self.settings.motion.variances(&path);
            self.filter.predict(&OdometryStep { path, variances })?;
        }
        self.odometry = Some(pose);
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
        let before = *self.belief();
        let mut filter = self.filter;
        filter.predict(&self.least_noise())?;
        let predicted = self.predicted(filter.belief(), view, mounting)?;
        let pairs = self.correct(&mut filter, &seen, &predicted, mounting)?;
        self.filter = filter;
        let (after, tracking) = (*filter.belief(), self.tracking);
        let mut update = LineUpdate { before, after, mounting, seen, predicted, pairs, tracking };
        self.tracking = tracking.after(self.fits(&update), self.settings.lost.scans);
        update.tracking = self.tracking;
        Ok(update)
    }

    /// The noise that every update has, in the place where the robot is.
    fn least_noise(&self) -> OdometryStep {
        let PathNoise { least_position, least_heading, .. } = self.settings.motion;
        let least = Vector3::new(least_position, least_position, least_heading);
        let path = DrivenPath::starting_at(Pose2::IDENTITY);
        OdometryStep { path, variances: least.component_mul(&least) }
    }

    fn predicted(
        &self,
        belief: &Gaussian<3>,
        view: FieldOfView,
        mounting: Pose2,
    ) -> Result<Vec<PredictedLine>> {
        let LineMatchingSettings { min_map_length, map_sigma, .. } = self.settings;
        predicted_lines(&self.map, belief.pose() * mounting, view, min_map_length, map_sigma)
    }

    /// Finds pairs and corrects with one after the other.
    fn correct(
        &self,
        filter: &mut ExtendedKalmanFilter<3>,
        seen: &[Line],
        predicted: &[PredictedLine],
        mounting: Pose2,
    ) -> Result<Vec<Option<LinePair>>> {
        let belief = *filter.belief();
        let LineMatchingSettings { min_overlap, slack, .. } = self.settings;
        let map = &self.map;
        let pairs = Pairs { belief: &belief, map, mounting, seen, predicted, min_overlap, slack };
        let partners = pairs.most_likely(&self.gate)?;
        let mut answers = vec![None; seen.len()];
        for (index, partner) in partners.iter().enumerate() {
            let Some(partner) = *partner else { continue };
            let model = pairs.model(index, partner);
            let z = pairs.measurement(index);
            let innovation: Innovation<2> = filter.correct(&model, &z, &self.gate)?;
            answers[index] = Some(LinePair { predicted: partner, innovation });
        }
        Ok(answers)
    }

    /// Whether a scan fits; `None` where it has too few lines to tell.
    fn fits(&self, update: &LineUpdate) -> Option<bool> {
        let enough = update.seen.len() >= self.settings.lost.min_lines;
        let share = update.matched_share().filter(|_| enough)?;
        Some(share >= self.settings.lost.min_share)
    }
}

/// A step of the odometry with the variances along it, across it and of the heading.
struct OdometryStep {
    path: DrivenPath,
    variances: Vector3<f64>,
}

impl MotionModel<3> for OdometryStep {
    fn predict(&self, state: &Vector3<f64>) -> Vector3<f64> {
        (Pose2::from_vector(state) * self.path.step()).to_vector()
    }

    fn linearize(&self, state: &Vector3<f64>) -> LinearizedMotion<3> {
        let step = PathNoise::step(&self.path, Pose2::from_vector(state), &self.variances);
        LinearizedMotion { state: step.pose.to_vector(), jacobian: step.by_pose, noise: step.noise }
    }
}
