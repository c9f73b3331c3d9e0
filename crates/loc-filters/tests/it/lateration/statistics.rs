use super::seen;
use loc_core::random::stream;
use loc_core::stats::chi_square_band;
use loc_filters::lateration::{
    BiasPrior, Caution, Cost, LaterationSettings, Range, RangeBias, locate,
};
use nalgebra::{Point2, Vector2};
use rand_distr::{Distribution, StandardNormal};

/// The last one lies inside of the circle around the others, so that a scale can be told from a
/// place outside of it.
const LANDMARKS: [[f64; 2]; 6] =
    [[0.0, 0.0], [10.0, 0.0], [12.0, 9.0], [-2.0, 8.0], [5.0, 14.0], [6.0, 5.0]];
const TRUTH: [f64; 2] = [4.0, 3.0];

fn noisy(seed: u64, bias: RangeBias) -> Vec<Range<2>> {
    let mut rng = stream(seed, "ranges");
    let mut ranges = seen(TRUTH, &LANDMARKS);
    for (k, range) in ranges.iter_mut().enumerate() {
        range.sigma = 0.05 * (1 + k) as f64;
        let noise: f64 = StandardNormal.sample(&mut rng);
        range.distance = bias.reported(range.distance) + range.sigma * noise;
    }
    ranges
}

/// Over 800 draws the errors are as large as the covariances say, for each cost, with and without
/// a bias to find.
#[test]
fn covariances_are_honest() {
    const DRAWS: usize = 800;
    let free_scale = LaterationSettings { bias: BiasPrior::FREE_SCALE, ..Default::default() };
    for (settings, bias) in [
        (LaterationSettings::default(), RangeBias::NONE),
        (LaterationSettings { cost: Cost::Squares, ..Default::default() }, RangeBias::NONE),
        (free_scale, RangeBias { scale: 1.07, offset: 0.0 }),
    ] {
        let (mut total, mut square) = (0.0, 0.0);
        for seed in 0..DRAWS {
            let ranges = noisy(seed as u64, bias);
            let fix = locate(&ranges, None, &settings).unwrap().best;
            let error = Vector2::from(TRUTH) - fix.position.coords;
            total += loc_core::stats::nees(&error, &fix.covariance).unwrap();
            square += error.norm_squared();
        }
        let (nees, rms) = (total / DRAWS as f64, (square / DRAWS as f64).sqrt());
        println!("{:?}: NEES {nees:.3}, RMS {rms:.4} m", settings.cost);
        // Wider than chance alone: distances bend a little over so large a sigma.
        let band = chi_square_band(2, DRAWS, 0.999).unwrap();
        assert!(nees > band.start() - 0.05 && nees < band.end() + 0.05, "{nees}");
    }
}

/// The most likely place is better than that of the lectures' SSE where distances differ.
#[test]
fn the_likely_cost_beats_the_algebraic_one() {
    let rms = |cost: Cost| {
        let settings = LaterationSettings { cost, ..Default::default() };
        let square = |seed| {
            let found = locate(&noisy(seed, RangeBias::NONE), None, &settings).unwrap().best;
            (found.position - Point2::from(TRUTH)).norm_squared()
        };
        ((0..500).map(square).sum::<f64>() / 500.0).sqrt()
    };
    let (likely, algebraic) = (rms(Cost::Distances), rms(Cost::Squares));
    println!("RMS {likely:.4} m, by squares {algebraic:.4} m");
    assert!(likely < 0.8 * algebraic);
}

/// Circles that just touch: to first order nothing is known across the line, and still the
/// covariance says how far the places scatter.
#[test]
fn touching_circles_have_an_honest_spread() {
    let mut rng = stream(5, "touch");
    let (mut square, mut claimed, mut missed) = (0.0, 0.0, 0);
    const DRAWS: usize = 500;
    for _ in 0..DRAWS {
        let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
        let ranges = [
            Range::new([0.0, 0.0], 4.0 + 0.1 * draw(), 0.1),
            Range::new([10.0, 0.0], 6.0 + 0.1 * draw(), 0.1),
        ];
        let solution = locate(&ranges, None, &LaterationSettings::default()).unwrap();
        let is_miss = |caution: &Caution| matches!(caution, Caution::NoIntersection { .. });
        missed += usize::from(solution.cautions.iter().any(is_miss));
        square += solution.best.position.y.powi(2) / DRAWS as f64;
        claimed += solution.best.covariance.m22 / DRAWS as f64;
    }
    println!("scatter {:.3} m, claimed {:.3} m, {missed} misses", square.sqrt(), claimed.sqrt());
    assert!((0.4 * DRAWS as f64..0.6 * DRAWS as f64).contains(&(missed as f64)));
    assert!((0.6..1.7).contains(&(claimed / square).sqrt()), "{}", (claimed / square).sqrt());
}
