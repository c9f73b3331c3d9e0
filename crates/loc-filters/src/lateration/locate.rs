//! The position from any number of ranges: D1 to D4 in one call.
//!
//! Closed forms give start positions; from each a minimum of the cost is searched. The best minimum is
//! the answer, its rivals and residuals decide on the cautions.

use super::minimize::{Minimum, OFFSET, Problem, Row, SCALE, Unknowns, minimize};
use super::{
    BiasPrior, Caution, Cost, Dilution, Fix, LaterationSettings, Loss, Range, RangeBias, Solution,
};
use crate::{Error, Result};
use loc_core::stats::chi_square_quantile;
use nalgebra::{Matrix3, Point, SVector, SymmetricEigen, Vector3};

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
    let problem = RangeProblem::new(&in_frame, LaterationSettings { bias, ..*settings });
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
    problem: &RangeProblem<D>,
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

/// Ranges in a frame in which their extent is 1.
pub(super) struct RangeProblem<'a, const D: usize> {
    ranges: &'a [Range<D>],
    settings: LaterationSettings,
    /// Typical sigma of a squared distance, the unit of the SSE.
    square: f64,
}

impl<'a, const D: usize> RangeProblem<'a, D> {
    pub(super) fn new(ranges: &'a [Range<D>], settings: LaterationSettings) -> Self {
        let total: f64 = ranges.iter().map(|r| square_sigma(r).powi(2)).sum();
        let square = (total / ranges.len().max(1) as f64).sqrt();
        RangeProblem { ranges, settings, square }
    }

    fn row(&self, range: &Range<D>, at: &Unknowns) -> Row {
        let bias = RangeBias { scale: at[SCALE], offset: at[OFFSET] };
        let from_landmark = SVector::<f64, D>::from_fn(|k, _| at[k] - range.landmark[k]);
        let distance = from_landmark.norm();
        // At a landmark the distance has no direction and says nothing to first order.
        let direction = from_landmark.try_normalize(0.0).unwrap_or_else(SVector::zeros);
        let loss = self.settings.loss;
        let mut gradient = Unknowns::zeros();
        let expected = bias.reported(distance);
        let residual = expected - range.distance;
        (0..D).for_each(|k| gradient[k] = bias.scale * direction[k]);
        gradient[SCALE] = distance;
        gradient[OFFSET] = 1.0;
        match self.settings.cost {
            Cost::Distances => Row { residual, gradient, ..Row::like(range.sigma, loss) },
            Cost::Squares => Row {
                residual: residual * (expected + range.distance),
                gradient: 2.0 * expected * gradient,
                scale: self.square,
                ..Row::like(square_sigma(range), loss)
            },
        }
    }

    /// What is known at a minimum.
    pub(super) fn fix(&self, minimum: &Minimum) -> Result<Fix<D>> {
        let position = place_of::<D>(&minimum.at);
        let bias = RangeBias { scale: minimum.at[SCALE], offset: minimum.at[OFFSET] };
        let mut fix = Fix {
            position,
            covariance: minimum.covariance.fixed_view::<D, D>(0, 0).into(),
            bias,
            bias_sigmas: [SCALE, OFFSET].map(|k| minimum.covariance[(k, k)].max(0.0).sqrt()),
            cost: minimum.cost,
            sse: 0.0,
            residuals: Vec::with_capacity(self.ranges.len()),
            weights: Vec::with_capacity(self.ranges.len()),
            dilution: Dilution::at(&position, self.ranges.iter().map(|range| range.landmark))?,
        };
        for range in self.ranges {
            let expected = bias.reported((position - range.landmark).norm());
            let Row { residual, sigma, loss, .. } = self.row(range, &minimum.at);
            fix.sse += ((expected - range.distance) * (expected + range.distance)).powi(2);
            fix.residuals.push(range.distance - expected);
            fix.weights.push(loss.weight(residual / sigma));
        }
        Ok(fix)
    }
}

impl<const D: usize> Problem for RangeProblem<'_, D> {
    fn rows(&self, at: &Unknowns, visit: &mut dyn FnMut(&Row)) {
        self.ranges.iter().for_each(|range| visit(&self.row(range, at)));
        bias_rows(&self.settings.bias, at, visit);
    }

    fn reach(&self) -> Unknowns {
        let mut reach = Unknowns::zeros();
        reach.fixed_rows_mut::<D>(0).fill(1.0);
        bias_reach(&self.settings.bias, 1.0, &mut reach);
        reach
    }
}

/// What is known of scale and offset beforehand.
pub(super) fn bias_rows(bias: &BiasPrior, at: &Unknowns, visit: &mut dyn FnMut(&Row)) {
    for (k, usual, sigma) in [(SCALE, 1.0, bias.scale_sigma), (OFFSET, 0.0, bias.offset_sigma)] {
        if sigma > 0.0 && sigma.is_finite() {
            let mut gradient = Unknowns::zeros();
            gradient[k] = 1.0;
            let residual = at[k] - usual;
            visit(&Row { residual, gradient, ..Row::like(sigma, Loss::Quadratic) });
        }
    }
}

/// How far scale and offset can be off: both by as much as what they are part of.
pub(super) fn bias_reach(bias: &BiasPrior, extent: f64, reach: &mut Unknowns) {
    reach[SCALE] = if bias.scale_sigma > 0.0 { 1.0 } else { 0.0 };
    reach[OFFSET] = if bias.offset_sigma > 0.0 { extent } else { 0.0 };
}

/// A place, with a sensor that is right.
pub(super) fn unknowns_at<const D: usize>(place: &Point<f64, D>) -> Unknowns {
    let mut at = Unknowns::zeros();
    at[SCALE] = 1.0;
    at.fixed_rows_mut::<D>(0).copy_from(&place.coords);
    at
}

/// The place among the unknowns.
pub(super) fn place_of<const D: usize>(at: &Unknowns) -> Point<f64, D> {
    Point::from(at.fixed_rows::<D>(0).into_owned())
}

/// Standard deviation of a squared distance.
fn square_sigma<const D: usize>(range: &Range<D>) -> f64 {
    let linear = 2.0 * range.distance * range.sigma;
    f64::hypot(linear, std::f64::consts::SQRT_2 * range.sigma * range.sigma)
}

/// The landmarks' extent across their line (plane) may be this share of that along it before it
/// counts.
const FLAT: f64 = 1e-6;
/// Below this share of the whole extent they lie at one place.
const POINT: f64 = 1e-12;

/// Candidates for the place of ranges in a frame in which their extent is 1, of which each is near a minimum of the cost if the ranges fit: first
/// those on both sides of the line (plane) that fits the landmarks best, then, where the landmarks
/// do not lie on it, that of the linear equations.
///
/// # Errors
/// [`Error::Undetermined`] where too many directions are left out.
///
/// The difference of two equations `|x - l_i|^2 = d_i^2` is linear in x. Landmarks that do not lie on
/// one line (plane) therefore determine the position; those that do leave the direction across it
/// open, in which the mean of the equations gives the distance, to either side.
pub(super) fn candidates<const D: usize>(ranges: &[Range<D>]) -> Result<Vec<Point<f64, D>>> {
    let count = ranges.len() as f64;
    let landmarks: Vec<Vector3<f64>> = ranges.iter().map(in_space).collect();
    let middle = landmarks.iter().sum::<Vector3<f64>>() / count;
    let arms: Vec<_> = landmarks.iter().map(|landmark| landmark - middle).collect();
    let mean_square = ranges.iter().map(|r| r.distance * r.distance).sum::<f64>() / count;
    let mean_arm = arms.iter().map(Vector3::norm_squared).sum::<f64>() / count;
    // Least squares of arm . x = (|arm|^2 - mean - (d^2 - mean)) / 2.
    let right = |arm: &Vector3<f64>, r: &Range<D>| {
        0.5 * (arm.norm_squared() - mean_arm - (r.distance * r.distance - mean_square))
    };
    let sides: Vector3<f64> = arms.iter().zip(ranges).map(|(a, r)| a * right(a, r)).sum();
    let (axes, extents) = principal_axes::<D>(&arms);
    // Whole numbers below the number of coordinates.
    let (across, before) = (D - 1, D - 2);
    if extents[before] <= f64::max(FLAT * extents[0], POINT) {
        return Err(undetermined(D, extents[0] > POINT));
    }
    let along = |k: usize| axes[k] * (axes[k].dot(&sides) / extents[k].powi(2));
    let foot: Vector3<f64> = (0..across).map(along).sum();
    let squared = mean_square - mean_arm - foot.norm_squared();
    let height = axes[across] * squared.max(0.0).sqrt();
    let mut places = vec![foot + height, foot - height];
    if extents[across] > FLAT * extents[0] {
        places.push(foot + along(across));
    }
    // Distances that contradict each other may fit best somewhere else.
    let far = mean_square.sqrt();
    places.extend(axes.iter().take(D).flat_map(|axis| [axis * far, -axis * far]));
    let place = |place: Vector3<f64>| Point::from(std::array::from_fn(|k| (middle + place)[k]));
    Ok(places.into_iter().map(place).collect())
}

/// A landmark with zeros for the coordinates that it has not.
fn in_space<const D: usize>(range: &Range<D>) -> Vector3<f64> {
    Vector3::from_fn(|k, _| range.landmark.coords.get(k).copied().unwrap_or(0.0))
}

/// The principal axes of points about their middle, and the extents along them, the longest first.
/// Coordinates that the points have not come last.
fn principal_axes<const D: usize>(arms: &[Vector3<f64>]) -> ([Vector3<f64>; 3], [f64; 3]) {
    let mut scatter: Matrix3<f64> = arms.iter().map(|arm| arm * arm.transpose()).sum();
    for k in D..3 {
        scatter[(k, k)] = -scatter.trace();
    }
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(scatter);
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigenvalues[j].total_cmp(&eigenvalues[i]));
    (
        order.map(|k| eigenvectors.column(k).into_owned()),
        order.map(|k| eigenvalues[k].max(0.0).sqrt()),
    )
}

fn undetermined(coordinates: usize, apart: bool) -> Error {
    let expected = match coordinates {
        2 => "landmarks at two different places or more",
        _ => "landmarks that do not lie on one line",
    };
    Error::Undetermined {
        expected,
        found: ["all at one place", "all on one line"][usize::from(apart)].into(),
    }
}

/// Extents whose fourth powers are neither 0 nor infinite.
const EXTENTS: std::ops::RangeInclusive<f64> = 1e-70..=1e70;

/// Where ranges lie and how large they are.
///
/// Ranges are shifted by their centroid and divided by their extent, so that coordinates of millions of
/// metres and ranges of millimetres keep all their digits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame<const D: usize> {
    middle: SVector<f64, D>,
    extent: f64,
}

impl<const D: usize> Frame<D> {
    /// The frame of ranges that are checked.
    ///
    /// # Errors
    /// [`Error::Undetermined`] for sizes that no square can hold.
    pub(super) fn of(ranges: &[Range<D>]) -> Result<Self> {
        let share = 1.0 / ranges.len().max(1) as f64;
        let middle: SVector<f64, D> = ranges.iter().map(|r| r.landmark.coords * share).sum();
        let size = |r: &Range<D>| (r.landmark.coords - middle).norm() + r.distance + r.sigma;
        let extent = ranges.iter().map(size).fold(f64::MIN_POSITIVE, f64::max);
        if !EXTENTS.contains(&extent) {
            return Err(Error::Undetermined {
                expected: "coordinates and distances from 1e-70 m to 1e70 m",
                found: format!("{extent:e} m"),
            });
        }
        Ok(Frame { middle, extent })
    }

    /// A place of the map in this frame.
    pub(super) fn place(&self, place: &Point<f64, D>) -> Point<f64, D> {
        Point::from((place.coords - self.middle) / self.extent)
    }

    /// A range of the map in this frame.
    pub(super) fn range(&self, range: &Range<D>) -> Range<D> {
        Range {
            landmark: self.place(&range.landmark),
            distance: range.distance / self.extent,
            sigma: range.sigma / self.extent,
        }
    }

    /// What is known of the bias, in this frame.
    pub(super) fn bias(&self, bias: BiasPrior) -> BiasPrior {
        BiasPrior { offset_sigma: bias.offset_sigma / self.extent, ..bias }
    }

    /// A fix of this frame in the map.
    pub(super) fn fix_in_map(&self, mut fix: Fix<D>) -> Fix<D> {
        fix.position = Point::from(self.middle + fix.position.coords * self.extent);
        fix.covariance *= self.extent * self.extent;
        fix.bias.offset *= self.extent;
        fix.bias_sigmas[1] *= self.extent;
        fix.sse *= self.extent.powi(4);
        fix.residuals.iter_mut().for_each(|residual| *residual *= self.extent);
        fix
    }
}
