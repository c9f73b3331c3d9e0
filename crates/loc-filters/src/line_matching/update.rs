//! What a scan told the filter.

use super::PredictedLine;
use crate::Innovation;
use loc_core::{Gaussian, Pose2};
use loc_maps::LineSegment;
use loc_sensors::features::Line;
use nalgebra::Point2;

/// Whether line matching still knows where the robot is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tracking {
    /// The last scan that had lines fits the map.
    #[default]
    Sure,
    /// This many scans in a row do not fit; the belief is carried on by odometry and by the few
    /// lines that do.
    Doubtful(usize),
    /// So many do not fit that the robot is most likely elsewhere. The filter goes on, but its
    /// covariance says nothing any more: somebody else has to find the robot, and to restart the
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
    /// them. It is accepted unless the whole scan was turned away.
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
