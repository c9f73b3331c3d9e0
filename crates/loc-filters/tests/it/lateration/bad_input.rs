use super::seen;
use loc_filters::Error;
use loc_filters::lateration::{
    BiasPrior, Caution, Dilution, LaterationSettings, Loss, Range, Solution, locate,
};
use nalgebra::Point2;
use proptest::prelude::*;

fn refusal<const D: usize>(ranges: &[Range<D>]) -> String {
    locate(ranges, None, &LaterationSettings::default()).unwrap_err().to_string()
}

#[test]
fn fewer_distances_than_unknowns() {
    let ranges = seen([1.0, 1.0], &[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]);
    for (known, bias, message) in [
        (0, BiasPrior::KNOWN, "at least 2 distances, one for each unknown, got 0"),
        (1, BiasPrior::KNOWN, "at least 2 distances, one for each unknown, got 1"),
        (2, BiasPrior::FREE_SCALE, "at least 3 distances, one for each unknown, got 2"),
    ] {
        let settings = LaterationSettings { bias, ..LaterationSettings::default() };
        let error = locate(&ranges[..known], None, &settings).unwrap_err();
        assert_eq!(error.to_string(), format!("lateration: expected {message}"));
    }
    let space = seen([1.0, 1.0, 1.0], &[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    assert!(matches!(
        locate(&space, None, &LaterationSettings::default()),
        Err(Error::TooFewRanges { expected: 3, found: 2 })
    ));
    assert!(Dilution::at(&Point2::origin(), [Point2::new(1.0, 0.0)]).is_err());
}

#[test]
fn landmarks_that_determine_nothing() {
    let message =
        "lateration: expected landmarks at two different places or more, got all at one place";
    let same = [[2.0, 3.0]; 4];
    assert_eq!(refusal(&seen([1.0, 1.0], &same)), message);
    let line = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0]];
    let message = "lateration: expected landmarks that do not lie on one line, got all on one line";
    assert_eq!(refusal(&seen([1.0, 0.0, 0.0], &line)), message);
    // Two of three at one place still leave two.
    let pair = seen([1.0, 2.0], &[[0.0, 0.0], [0.0, 0.0], [5.0, 0.0]]);
    let solution = locate(&pair, Some([1.0, 1.0].into()), &LaterationSettings::default()).unwrap();
    assert!((solution.best.position.y - 2.0).abs() < 1e-9 && !solution.is_unique());
}

#[test]
fn numbers_that_are_no_distances() {
    let good = seen([1.0, 1.0], &[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]);
    let with = |range: Range<2>| refusal(&[good[0], good[1], range]);
    let at = [0.0, 4.0];
    assert_eq!(
        with(Range::new(at, -1.0, 0.1)),
        "distance to a landmark [m]: expected a finite number >= 0, got -1"
    );
    assert!(with(Range::new(at, f64::INFINITY, 0.1)).ends_with("got inf"));
    assert!(with(Range::new(at, f64::NAN, 0.1)).ends_with("got NaN"));
    assert!(with(Range::new(at, 1.0, 0.0)).starts_with("sigma of a distance [m]"));
    assert!(with(Range::new([f64::NAN, 0.0], 1.0, 0.1)).starts_with("position of a landmark [m]"));
    let start = Some([f64::NAN, 0.0].into());
    assert!(locate(&good, start, &LaterationSettings::default()).is_err());
    for settings in [
        LaterationSettings { loss: Loss::Huber(0.0), ..Default::default() },
        LaterationSettings { loss: Loss::Cauchy(f64::NAN), ..Default::default() },
        LaterationSettings {
            bias: BiasPrior { scale_sigma: -1.0, offset_sigma: 0.0 },
            ..Default::default()
        },
    ] {
        assert!(locate(&good, None, &settings).is_err());
    }
}

fn finite<const D: usize>(solution: &Solution<D>) -> bool {
    std::iter::once(&solution.best).chain(&solution.other).all(|fix| {
        let numbers = fix.position.iter().chain(fix.covariance.iter());
        numbers.chain(&fix.residuals).chain(&fix.weights).all(|number| number.is_finite())
            && fix.cost.is_finite()
            && !fix.dilution.position().is_nan()
            && fix.covariance.diagonal().iter().all(|variance| *variance >= 0.0)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// Whatever the numbers are: an answer without NaN, or a refusal.
    #[test]
    fn never_a_nan(
        places in prop::collection::vec((-3i32..4, -3i32..4, 0u32..9), 2..6),
        exponent in -80i32..80,
        robust in any::<bool>(),
        squares in any::<bool>(),
        bias in any::<bool>(),
    ) {
        let unit = 10_f64.powi(exponent);
        let ranges: Vec<Range<2>> = places
            .iter()
            .map(|&(x, y, d)| {
                let at = [unit * f64::from(x), unit * f64::from(y)];
                Range::new(at, unit * f64::from(d), 0.1 * unit)
            })
            .collect();
        let settings = LaterationSettings {
            loss: if robust { Loss::CAUCHY } else { Loss::Quadratic },
            cost: if squares { Default::default() } else { loc_filters::lateration::Cost::Squares },
            bias: if bias { BiasPrior::FREE_OFFSET } else { BiasPrior::KNOWN },
        };
        if let Ok(solution) = locate(&ranges, None, &settings) {
            prop_assert!(finite(&solution), "{:?}", solution);
        }
        let space: Vec<Range<3>> = ranges
            .iter()
            .map(|r| Range::new([r.landmark.x, r.landmark.y, 0.0], r.distance, r.sigma))
            .collect();
        if let Ok(solution) = locate(&space, None, &settings) {
            prop_assert!(finite(&solution), "{:?}", solution);
        }
    }
}

/// Distances far too long for the landmarks: an answer with its reason.
#[test]
fn contradictions_are_told() {
    let mut ranges = seen([1.0, 1.0], &[[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [4.0, 4.0]]);
    ranges.iter_mut().for_each(|range| range.distance += 20.0);
    let solution = locate(&ranges, None, &LaterationSettings::default()).unwrap();
    let reported = |caution: &Caution| matches!(caution, Caution::Contradiction { .. });
    assert!(finite(&solution) && solution.cautions.iter().any(reported), "{:?}", solution.cautions);
}
