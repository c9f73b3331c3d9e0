//! Data association of lines: how well a line of a scan fits a predicted one, and the most likely set of
//! pairs.

use super::{LineModel, PredictedLine};
use crate::association::{PairInnovation, Pairing};
use crate::extended::MeasurementModel;
use crate::innovation::Innovation;
use crate::kalman::update;
use crate::{Gate, Result};
use loc_core::{Gaussian, Pose2, angle};
use loc_maps::{LineMap, LineSegment};
use loc_sensors::features::Line;
use nalgebra::{Matrix2, RowVector3, Vector2};

/// The lines of a scan beside those that were predicted.
pub(super) struct Lines<'a> {
    pub(super) map: &'a LineMap,
    pub(super) mounting: Pose2,
    pub(super) seen: &'a [Line],
    pub(super) predicted: &'a [PredictedLine],
    /// The predicted stretches, in the map.
    pub(super) stretches: Vec<LineSegment>,
    /// Minimum share of the shorter of two lines beside the other one.
    pub(super) min_overlap: f64,
    /// How far a line may be seen beyond the stretch that is predicted \[m\].
    pub(super) slack: f64,
}

impl<'a> Lines<'a> {
    /// Of the lines that a scanner at `scanner` (`map_from_laser`) has seen and should have seen.
    pub(super) fn new(
        map: &'a LineMap,
        (scanner, mounting): (Pose2, Pose2),
        seen: &'a [Line],
        predicted: &'a [PredictedLine],
        (min_overlap, slack): (f64, f64),
    ) -> Self {
        let back = scanner.inverse();
        let stretches = predicted.iter().map(|line| line.stretch.seen_from(back)).collect();
        Lines { map, mounting, seen, predicted, stretches, min_overlap, slack }
    }

    /// (r, alpha) of a line of the scan.
    pub(super) fn measurement(&self, seen: usize) -> Vector2<f64> {
        Vector2::new(self.seen[seen].r, self.seen[seen].alpha)
    }

    /// The model of a predicted line for one that was seen.
    pub(super) fn model(&self, seen: usize, predicted: usize) -> LineModel {
        let (line, predicted) = (&self.seen[seen], &self.predicted[predicted]);
        let normal = self.map.lines()[predicted.line].normal_form();
        // On the other side of the scanner r grows where it shrank.
        let turned = (line.alpha - predicted.normal_form.alpha).cos() < 0.0;
        let mut of_map = predicted.covariance;
        if turned {
            (of_map.m12, of_map.m21) = (-of_map.m12, -of_map.m21);
        }
        LineModel::new(normal, self.mounting).measured(line.alpha, line.covariance + of_map)
    }

    /// Residual of a pair and its covariance, as a belief has them.
    pub(super) fn innovation(
        &self,
        belief: &Gaussian<3>,
        seen: usize,
        predicted: usize,
    ) -> (Vector2<f64>, Matrix2<f64>) {
        let model = self.model(seen, predicted);
        let (expected, h) = model.linearize(&belief.mean);
        let residual = model.residual(&self.measurement(seen), &expected);
        (residual, h * belief.covariance * h.transpose() + model.noise(&expected))
    }

    /// Whether two lines lie beside each other, as far as a belief knows the pose.
    pub(super) fn overlap(&self, belief: &Gaussian<3>, seen: usize, predicted: usize) -> bool {
        let (line, stretch) = (&self.seen[seen], &self.stretches[predicted]);
        let scanner = belief.pose() * self.mounting;
        let (sin, cos) = line.alpha.sin_cos();
        let along = Vector2::new(-sin, cos);
        let [a, b] = span(line.start.coords.dot(&along), line.end.coords.dot(&along));
        // The same direction in the map.
        let turned = scanner.rotation() * along;
        let place = |point: nalgebra::Point2<f64>| (point - scanner.position()).dot(&turned);
        let [c, d] = span(place(stretch.start), place(stretch.end));
        // Two standard deviations of the place along the line; a turn moves it by the distance.
        let by_pose = RowVector3::new(turned.x, turned.y, line.r);
        let variance = (by_pose * belief.covariance * by_pose.transpose()).x;
        let slack = self.slack + 2.0 * variance.max(0.0).sqrt();
        let (c, d) = (c - slack, d + slack);
        let common = b.min(d) - a.max(c);
        common > 0.0 && common >= self.min_overlap * (b - a).min(d - c)
    }
}

fn span(a: f64, b: f64) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

/// The pairs as the rules of [`association`](crate::association) see them.
pub(super) struct WithBelief<'a> {
    pub(super) lines: &'a Lines<'a>,
    pub(super) belief: &'a Gaussian<3>,
}

impl Pairing<2> for WithBelief<'_> {
    fn observations(&self) -> usize {
        self.lines.seen.len()
    }

    fn landmarks(&self) -> usize {
        self.lines.predicted.len()
    }

    fn innovation(&self, seen: usize, predicted: usize) -> Option<PairInnovation<2>> {
        let (residual, covariance) = self.lines.innovation(self.belief, seen, predicted);
        let possible = self.lines.overlap(self.belief, seen, predicted);
        possible.then_some(PairInnovation { residual, covariance })
    }

    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        let jacobian =
            |(seen, predicted)| self.lines.model(seen, predicted).jacobian(&self.belief.mean);
        jacobian(a) * self.belief.covariance * jacobian(b).transpose()
    }
}

/// Things that the map does not know are seen anywhere up to this distance \[m\].
const CLUTTER_RANGE: f64 = 10.0;

/// A pair that is possible: line of the scan, predicted line.
pub(super) type Pair = (usize, usize);

/// Pairs in the order in which the set grew, each line of the scan at most once, with the
/// logarithm of their likelihood over that of seeing nothing known.
#[derive(Debug, Clone, Default)]
struct PairSet {
    pairs: Vec<Pair>,
    score: f64,
}

/// The most likely set of pairs.
///
/// With a heading error of some degrees all walls are turned alike, and the nearest line of the map may
/// be the wrong one for each of them. So a set of pairs is evaluated as a whole: each pair by its
/// likelihood under the belief that the pairs before have left, each line without a partner by the
/// likelihood of an unknown object there. A set grows from one pair, each time by the pair that is most
/// likely next; it is grown from each pair that competes with the best set so far.
// ANCHOR: most-likely
pub(super) fn most_likely(
    lines: &Lines<'_>,
    belief: &Gaussian<3>,
    gate: &Gate,
) -> Result<Vec<Pair>> {
    let candidates = candidates(lines, belief, gate)?;
    let mut best = PairSet::default();
    let mut tried: Vec<Pair> = Vec::new();
    let untried = |best: &PairSet, tried: &[Pair]| {
        let open = |pair: &&Pair| !best.pairs.contains(pair) && !tried.contains(pair);
        candidates.iter().find(open).copied()
    };
    while let Some(seed) = untried(&best, &tried) {
        tried.push(seed);
        let grown = grow(lines, belief, gate, &candidates, seed)?;
        if grown.score > best.score {
            best = grown;
        }
    }
    Ok(best.pairs)
}
// ANCHOR_END: most-likely

/// Given pairs, in the order in which a set of them grows, without those
/// that do not fit it.
pub(super) fn in_order(
    lines: &Lines<'_>,
    belief: &Gaussian<3>,
    gate: &Gate,
    pairs: &[Pair],
) -> Result<Vec<Pair>> {
    let mut gains = Vec::new();
    for &pair in pairs {
        gains.extend(gain(lines, belief, gate, pair)?.map(|gain| (pair, gain)));
    }
    let seed = gains.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let grown = seed.map(|(seed, _)| grow(lines, belief, gate, pairs, *seed)).transpose()?;
    Ok(grown.unwrap_or_default().pairs)
}

/// All pairs within the gate, most likely first.
fn candidates(lines: &Lines<'_>, belief: &Gaussian<3>, gate: &Gate) -> Result<Vec<Pair>> {
    let mut candidates: Vec<(Pair, f64)> = Vec::new();
    for seen in 0..lines.seen.len() {
        for predicted in 0..lines.predicted.len() {
            if let Some(gain) = gain(lines, belief, gate, (seen, predicted))? {
                candidates.push(((seen, predicted), gain));
            }
        }
    }
    candidates.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    Ok(candidates.into_iter().map(|(pair, _)| pair).collect())
}

/// Log-likelihood of a pair over that of something unknown; `None` for a pair that is out of the
/// question.
fn gain(
    lines: &Lines<'_>,
    belief: &Gaussian<3>,
    gate: &Gate,
    (seen, predicted): Pair,
) -> Result<Option<f64>> {
    let (residual, covariance) = lines.innovation(belief, seen, predicted);
    let (innovation, _) = Innovation::new(residual, covariance, gate)?;
    let clutter = (CLUTTER_RANGE * std::f64::consts::TAU).ln();
    let gain = innovation.log_likelihood() + clutter;
    let fits = innovation.accepted && lines.overlap(belief, seen, predicted);
    Ok((fits && gain > 0.0).then_some(gain))
}

/// A set that grows from a pair.
fn grow(
    lines: &Lines<'_>,
    start: &Gaussian<3>,
    gate: &Gate,
    candidates: &[Pair],
    seed: Pair,
) -> Result<PairSet> {
    let mut belief = *start;
    let mut set = PairSet::default();
    let mut left: Vec<Pair> = candidates.to_vec();
    let mut next = gain(lines, &belief, gate, seed)?.map(|gain| (seed, gain));
    while let Some((pair, gained)) = next {
        correct(lines, &mut belief, pair)?;
        set.pairs.push(pair);
        set.score += gained;
        left.retain(|other| other.0 != pair.0);
        next = None;
        for &pair in &left {
            let gained = gain(lines, &belief, gate, pair)?;
            if let Some(gained) = gained
                && next.is_none_or(|(_, most)| gained > most)
            {
                next = Some((pair, gained));
            }
        }
    }
    Ok(set)
}

fn correct(lines: &Lines<'_>, belief: &mut Gaussian<3>, (seen, predicted): Pair) -> Result<()> {
    let model = lines.model(seen, predicted);
    let (expected, h) = model.linearize(&belief.mean);
    let residual = model.residual(&lines.measurement(seen), &expected);
    update::correct(belief, residual, &h, &model.noise(&expected), &Gate::OPEN)?;
    belief.mean.z = angle::wrap(belief.mean.z);
    Ok(())
}
