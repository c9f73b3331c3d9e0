//! The delay at which odometry and scans have turned alike.

use super::trace::Trace;
use super::{DelayEstimate, Turn};
use nalgebra::{Matrix2, Vector2};

/// Fewest pairs of scans.
const FEWEST: usize = 10;

/// Steps of the search \[s\].
const STEP: f64 = 0.01;

/// How far a turn by two scans and one by odometry differ where the delay is right \[rad\].
const NOISE: f64 = 0.005;

/// The odometry's scale is believed within these.
const SCALES: [f64; 2] = [0.7, 1.4];

/// What stamps and interpolation leave of an uncertainty \[s\].
const FLOOR: f64 = 0.002;

pub(super) fn fit(turns: &[Turn], trace: &Trace, longest: f64) -> Option<DelayEstimate> {
    let covered = |turn: &&Turn| {
        let turned = |delay: f64| trace.turn(turn.from - delay, turn.to - delay);
        turned(longest).is_some() && turned(-longest).is_some()
    };
    let turns: Vec<Turn> = turns.iter().filter(covered).copied().collect();
    if turns.len() < FEWEST {
        return None;
    }
    let count = (2.0 * longest / STEP).round() as i32;
    let delays = (0..=count).map(|k| -longest + f64::from(k) * STEP);
    let rated = delays.filter_map(|delay| Some((delay, cost(&turns, trace, delay)?)));
    let (coarse, _) = rated.min_by(|a, b| a.1.total_cmp(&b.1))?;
    refine(&turns, trace, coarse)
}

/// The robust cost of a delay, at the scale that suits it best.
fn cost(turns: &[Turn], trace: &Trace, delay: f64) -> Option<f64> {
    let odometry: Option<Vec<f64>> =
        turns.iter().map(|turn| trace.turn(turn.from - delay, turn.to - delay)).collect();
    let odometry = odometry?;
    let both = || turns.iter().zip(&odometry);
    let product: f64 = both().map(|(turn, odometry)| turn.angle * odometry).sum();
    let square: f64 = odometry.iter().map(|odometry| odometry * odometry).sum();
    let scale = if square > 0.0 { product / square } else { 1.0 };
    let scale = scale.clamp(SCALES[0], SCALES[1]);
    let errors = both().map(|(turn, odometry)| turn.angle - scale * odometry);
    Some(errors.map(|error| (error / NOISE).powi(2).ln_1p()).sum())
}

/// Delay and scale by weighted least squares from the best of the search, with the variance that
/// the errors themselves show.
fn refine(turns: &[Turn], trace: &Trace, coarse: f64) -> Option<DelayEstimate> {
    let mut state = Vector2::new(coarse, 1.0);
    let (mut information, mut scatter) = (Matrix2::zeros(), Matrix2::zeros());
    for _ in 0..20 {
        let mut gradient = Vector2::zeros();
        (information, scatter) = (Matrix2::zeros(), Matrix2::zeros());
        for turn in turns {
            let turned = |delay: f64| trace.turn(turn.from - delay, turn.to - delay);
            let (delay, scale) = (state.x, state.y);
            let Some(odometry) = turned(delay) else { continue };
            let around = turned(delay + STEP).zip(turned(delay - STEP));
            let Some((later, sooner)) = around else { continue };
            let jacobian = Vector2::new(scale * (later - sooner) / (2.0 * STEP), odometry);
            let error = turn.angle - scale * odometry;
            let weight = 1.0 / (1.0 + (error / NOISE).powi(2));
            information += weight * jacobian * jacobian.transpose();
            scatter += (weight * error).powi(2) * jacobian * jacobian.transpose();
            gradient += weight * error * jacobian;
        }
        let step = information.cholesky()?.solve(&gradient);
        let bounded = step.x.clamp(-STEP, STEP);
        state.x = (state.x + bounded).clamp(coarse - STEP, coarse + STEP);
        state.y = (state.y + step.y).clamp(SCALES[0], SCALES[1]);
        if step.x.abs() < 1e-6 {
            break;
        }
    }
    let inverse = information.try_inverse()?;
    let variance = (inverse * scatter * inverse).m11;
    let sigma = (variance + FLOOR * FLOOR).sqrt();
    let (delay, scale, pairs) = (state.x, state.y, turns.len());
    sigma.is_finite().then_some(DelayEstimate { delay, sigma, scale, pairs })
}
