//! Which lines are the same: the most likely set of pairs.
//!
//! A robot whose heading is off by some degrees sees all walls turned alike, and the nearest line
//! of the map may be the wrong one for each of them. So a set of pairs is judged as a whole: each
//! pair by its likelihood under the belief that the pairs before have left, each line without a
//! partner by the likelihood of seeing something unknown there. A set grows from one pair, always
//! by the pair that is most likely next; it is grown from each pair that competes with the best
//! set so far.

use super::pairs::Pairs;
use crate::extended::MeasurementModel;
use crate::innovation::Innovation;
use crate::kalman::update;
use crate::{Gate, Result};
use loc_core::{Gaussian, angle};

/// Things that the map does not know are seen anywhere up to this distance \[m\].
const CLUTTER_RANGE: f64 = 10.0;

/// For each line of the scan its partner, with the logarithm of their likelihood, relative to that
/// of seeing nothing known.
#[derive(Debug, Clone)]
pub(super) struct PairSet {
    pub(super) partners: Vec<Option<usize>>,
    score: f64,
}

/// A pair that is possible: line of the scan, predicted line.
type Pair = (usize, usize);

/// The most likely set of pairs.
pub(super) fn most_likely(
    pairs: &Pairs<'_>,
    belief: &Gaussian<3>,
    gate: &Gate,
) -> Result<Vec<Option<usize>>> {
    let candidates = candidates(pairs, belief, gate)?;
    let mut best = PairSet { partners: vec![None; pairs.seen.len()], score: 0.0 };
    let mut waiting: Vec<Pair> = Vec::new();
    let Some(first) = candidates.first() else { return Ok(best.partners) };
    waiting.push(first.0);
    let mut tried = Vec::new();
    while let Some(seed) = waiting.pop() {
        tried.push(seed);
        let grown = grow(pairs, belief, gate, &candidates, seed)?;
        if grown.score > best.score {
            best = grown;
        }
        if waiting.is_empty() {
            let open = |pair: &Pair| best.partners[pair.0] != Some(pair.1) && !tried.contains(pair);
            waiting.extend(candidates.iter().map(|c| c.0).filter(open).take(1));
        }
    }
    Ok(best.partners)
}

/// All pairs within the gate, most likely first.
fn candidates(pairs: &Pairs<'_>, belief: &Gaussian<3>, gate: &Gate) -> Result<Vec<(Pair, f64)>> {
    let mut candidates = Vec::new();
    for seen in 0..pairs.seen.len() {
        for predicted in 0..pairs.predicted.len() {
            if let Some(gain) = gain(pairs, belief, gate, (seen, predicted))? {
                candidates.push(((seen, predicted), gain));
            }
        }
    }
    candidates.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    Ok(candidates)
}

/// Log-likelihood of a pair over that of something unknown; `None` for a pair that is out of the
/// question.
fn gain(
    pairs: &Pairs<'_>,
    belief: &Gaussian<3>,
    gate: &Gate,
    (seen, predicted): Pair,
) -> Result<Option<f64>> {
    let (residual, covariance) = pairs.innovation(belief, seen, predicted);
    let (innovation, _) = Innovation::new(residual, covariance, gate)?;
    let clutter = (CLUTTER_RANGE * std::f64::consts::TAU).ln();
    let gain = innovation.log_likelihood() + clutter;
    let fits = innovation.accepted && pairs.overlap(belief, seen, predicted);
    Ok((fits && gain > 0.0).then_some(gain))
}

/// A set that grows from a pair.
fn grow(
    pairs: &Pairs<'_>,
    start: &Gaussian<3>,
    gate: &Gate,
    candidates: &[(Pair, f64)],
    seed: Pair,
) -> Result<PairSet> {
    let mut belief = *start;
    let mut set = PairSet { partners: vec![None; pairs.seen.len()], score: 0.0 };
    let mut next = gain(pairs, &belief, gate, seed)?.map(|gain| (seed, gain));
    while let Some(((seen, predicted), gained)) = next {
        correct(pairs, &mut belief, (seen, predicted))?;
        set.partners[seen] = Some(predicted);
        set.score += gained;
        next = None;
        for &(pair, _) in candidates.iter().filter(|c| set.partners[c.0.0].is_none()) {
            let gained = gain(pairs, &belief, gate, pair)?;
            if let Some(gained) = gained
                && next.is_none_or(|(_, most)| gained > most)
            {
                next = Some((pair, gained));
            }
        }
    }
    Ok(set)
}

fn correct(pairs: &Pairs<'_>, belief: &mut Gaussian<3>, (seen, predicted): Pair) -> Result<()> {
    let model = pairs.model(seen, predicted);
    let (expected, h) = model.linearize(&belief.mean);
    let residual = model.residual(&pairs.measurement(seen), &expected);
    update::correct(belief, residual, &h, &model.noise(&expected), &Gate::OPEN)?;
    belief.mean.z = angle::wrap(belief.mean.z);
    Ok(())
}
