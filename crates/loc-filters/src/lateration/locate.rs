//! Where the robot is: D1 to D4 in one call.

use super::frame::Frame;
use super::minimize::{Minimum, OFFSET, SCALE, minimize};
use super::place::{Place, place_of, unknowns_at};
use super::start::candidates;
use super::{Caution, Fix, LaterationSettings, Range, Solution};
use crate::{Error, Result};
use loc_core::stats::chi_square_quantile;
use nalgebra::Point;

/// Of right ranges, the share whose squared residuals count as a contradiction.
const CONTRADICTION: f64 = 1e-3;
/// With a bias to find, contradictory ranges may fit best at infinity; farther off than so many
/// times their extent is no place.
const FARTHEST: f64 = 10.0;
/// Minima nearer to each other than this share of the extent are one.
const SAME: f64 = 1e-6;

/// The place that fits the ranges best, in the plane (`D` = 2) or in space (`D` = 3).
///
/// Without a start it is sought from closed forms on both sides of the landmarks. With a start, the
/// start is one more place to search from, and decides between two places that fit alike. Without
/// one, of two such places that with the smaller bias is taken: landmarks on one circle and a free
/// scale always leave a place inside of the circle and one outside.
///
/// Circles that meet nowhere are no error: the place nearest to all of them is the answer, with
/// [`Caution::NoIntersection`].
///
/// # Errors
/// Those of [`Range::check`] and [`LaterationSettings::check`]; [`Error::TooFewRanges`] for fewer
/// ranges than unknowns, [`Error::Undetermined`] for landmarks that all lie at one place or, in
/// space, on one line, and [`loc_core::Error::OutOfRange`] for a start that is not finite.
pub fn locate<const D: usize>(
    ranges: &[Range<D>],
    start: Option<Point<f64, D>>,
    settings: &LaterationSettings,
) -> Result<Solution<D>> {
    const { assert!(D == 2 || D == 3, "lateration works in the plane and in space") };
    settings.check()?;
    ranges.iter().try_for_each(Range::check)?;
    for &coordinate in start.iter().flat_map(|start| start.iter()) {
        loc_core::error::finite("start of lateration [m]", coordinate)?;
    }
    let unknowns = D + settings.bias.free();
    if ranges.len() < unknowns {
        return Err(Error::TooFewRanges { expected: unknowns, found: ranges.len() });
    }
    let frame = Frame::of(ranges)?;
    let in_frame: Vec<Range<D>> = ranges.iter().map(|range| frame.range(range)).collect();
    let bias = frame.bias(settings.bias);
    let problem = Place::new(&in_frame, LaterationSettings { bias, ..*settings });
    let start = start.map(|start| frame.place(&start));
    let mut fixes = Vec::with_capacity(2);
    for minimum in minima(&problem, &in_frame, start)?.iter().take(2) {
        fixes.push(frame.fix_in_map(problem.fix(minimum)?));
    }
    let mut fixes = fixes.into_iter();
    let best = fixes.next().ok_or_else(|| Error::Undetermined {
        expected: "ranges with a place that fits them best",
        found: format!("{} ranges that fit better the farther off it is", ranges.len()),
    })?;
    let other = fixes.next();
    let cautions = cautions(ranges, &best, other.as_ref(), unknowns);
    Ok(Solution { best, other, cautions })
}

/// The minima of the cost, the best first; of two that fit alike, the more plausible.
fn minima<const D: usize>(
    problem: &Place<D>,
    ranges: &[Range<D>],
    start: Option<Point<f64, D>>,
) -> Result<Vec<Minimum>> {
    let mut minima: Vec<Minimum> = Vec::new();
    for place in start.into_iter().chain(candidates(ranges)?) {
        let found = minimize(problem, unknowns_at(&place));
        let Some(found) = found.filter(|found| found.at.amax() <= FARTHEST) else {
            continue;
        };
        match minima.iter_mut().find(|known| (known.at - found.at).norm() <= SAME) {
            Some(known) if found.cost < known.cost => *known = found,
            Some(_) => {}
            None => minima.push(found),
        }
    }
    minima.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let against = |minimum: &Minimum| match start {
        Some(start) => (place_of::<D>(&minimum.at) - start).norm(),
        None => (minimum.at[SCALE] - 1.0).abs() + minimum.at[OFFSET].abs(),
    };
    if let [first, second, ..] = minima.as_mut_slice()
        && second.cost - first.cost < Caution::MARGIN
        && against(second) < against(first)
    {
        std::mem::swap(first, second);
    }
    Ok(minima)
}

/// What speaks against a place that has been found with so many unknowns.
fn cautions<const D: usize>(
    ranges: &[Range<D>],
    best: &Fix<D>,
    other: Option<&Fix<D>>,
    unknowns: usize,
) -> Vec<Caution> {
    let mut cautions = Vec::new();
    let margin = other.map(|other| other.cost - best.cost);
    if let Some(margin) = margin.filter(|margin| *margin < Caution::MARGIN) {
        cautions.push(Caution::Ambiguous { margin });
    }
    let whitened = |(residual, range): (&f64, &Range<D>)| (residual / range.sigma).powi(2);
    let chi_square: f64 = best.residuals.iter().zip(ranges).map(whitened).sum();
    let gap = best.residuals.iter().fold(0.0, |most: f64, residual| most.max(residual.abs()));
    let longest = ranges.iter().fold(0.0, |most: f64, range| most.max(range.distance));
    let spare = ranges.len().saturating_sub(unknowns);
    if spare == 0 && gap > SAME * longest {
        cautions.push(Caution::NoIntersection { gap, chi_square });
    }
    let contradicts = |limit: f64| spare > 0 && chi_square > limit;
    if chi_square_quantile(spare.max(1), 1.0 - CONTRADICTION).is_ok_and(contradicts) {
        cautions.push(Caution::Contradiction { chi_square, degrees_of_freedom: spare });
    }
    let dilution = best.dilution.position();
    if dilution > Caution::DILUTION {
        cautions.push(Caution::BadGeometry { dilution });
    }
    cautions
}
