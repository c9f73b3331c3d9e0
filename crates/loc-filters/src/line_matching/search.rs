//! Which lines are the same: the most likely set of pairs.
//!
//! A robot whose heading is off by some degrees sees all walls turned alike, and the nearest line
//! of the map may be the wrong one for each of them. So a set of pairs is judged as a whole: each
//! pair by its likelihood under the belief that the pairs before have left, each line without a
//! partner by the likelihood of seeing something unknown there. A set grows from one pair, always
//! by the pair that is most likely next; it is grown from each pair that competes with the best
//! set so far.

use super::lines::Lines;
use crate::extended::MeasurementModel;
use crate::innovation::Innovation;
use crate::kalman::update;
use crate::{Gate, Result};
use loc_core::{Gaussian, angle};

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

/// Pairs that somebody else has found, in the order in which a set of them grows, without those
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
