use approx::{assert_abs_diff_eq, assert_relative_eq};
use loc_core::probability::{Discrete, Joint, Uniform, bayes};
use loc_core::stats::RunningMoments;
use loc_core::{Error, random::stream};
use proptest::prelude::*;

const WEATHER: [&str; 4] = ["sunny", "cloudy", "rainy", "frosty"];

/// The table of the lectures: the weather in Osnabrueck and a hole in a tooth.
fn tooth_table() -> Joint<bool, &'static str> {
    let rows = [[0.225, 0.36, 0.27, 0.045], [0.025, 0.04, 0.03, 0.005]];
    Joint::new([false, true], WEATHER, &rows).unwrap()
}

fn die() -> Discrete<u8> {
    Discrete::uniform(1..=6).unwrap()
}

fn eyes(eyes: &u8) -> f64 {
    f64::from(*eyes)
}

#[test]
fn a_die_and_a_coin() {
    assert_relative_eq!(die().probability(|e| [2, 4, 6].contains(e)), 0.5);
    assert_relative_eq!(die().expectation(eyes), 3.5);
    assert_relative_eq!(die().variance(eyes), 35.0 / 12.0, epsilon = 1e-14);
    assert_relative_eq!(die().entropy(), 6_f64.ln(), epsilon = 1e-14);
    assert_relative_eq!(die().covariance(eyes, |e| 7.0 - eyes(e)), -35.0 / 12.0, epsilon = 1e-14);
    let coin = Discrete::new([(0.0, 0.5), (1.0, 0.5)]).unwrap();
    assert_eq!(coin.expectation(|&side| side), 0.5);
    let even = die().given(|e| e % 2 == 0).unwrap();
    assert_eq!(even.outcomes(), [2, 4, 6]);
    assert_relative_eq!(even.probability(|&e| e > 2), 2.0 / 3.0);
    let parity = die().map(|e| e % 2 == 0);
    assert_eq!(parity.outcomes(), [false, true]);
    assert_relative_eq!(parity.probability(|&even| even), 0.5);
    assert!(die().independent(|e| e % 2 == 0, |&e| e <= 2));
    assert!(!die().independent(|e| e % 2 == 0, |&e| e <= 3));
}

#[test]
fn the_tooth_table() {
    let table = tooth_table();
    let weather = table.second();
    for (p, printed) in weather.probabilities().iter().zip([0.25, 0.4, 0.3, 0.05]) {
        assert_relative_eq!(*p, printed, epsilon = 1e-14);
    }
    assert_relative_eq!(table.first().probability(|&hole| hole), 0.1, epsilon = 1e-14);
    assert_eq!(*weather.most_likely(), "cloudy");

    // P(sunny | no hole) = 0.225 / 0.9, which is P(sunny): the two are independent.
    let no_hole = table.second_given(&false).unwrap();
    assert_relative_eq!(no_hole.probability(|&w| w == "sunny"), 0.25, epsilon = 1e-14);
    let as_event = table.cells().given(|&(hole, _)| !hole).unwrap();
    assert_relative_eq!(as_event.probability(|&(_, w)| w == "sunny"), 0.25, epsilon = 1e-14);
    let rain = table.first_given(&"rainy").unwrap();
    assert_relative_eq!(rain.probability(|&hole| hole), 0.1, epsilon = 1e-14);
    assert!(table.is_independent());
    assert!(table.cells().independent(|&(hole, _)| hole, |&(_, w)| w == "rainy"));

    // The product rule gives the table back.
    let again = Joint::from_conditional(&table.first(), WEATHER, |hole, w| {
        table.second_given(hole).unwrap().probability(|known| known == w)
    });
    let again = again.unwrap().cells();
    for (p, q) in again.probabilities().iter().zip(table.cells().probabilities()) {
        assert_relative_eq!(p, q, epsilon = 1e-15);
    }
    let product = Joint::product(&table.first(), &weather);
    assert_relative_eq!(product.cells().probabilities()[2], 0.27, epsilon = 1e-14);
}

#[test]
fn covariance_and_correlation_of_a_table() {
    let dependent = Joint::new([0.0, 1.0], [0.0, 1.0], &[[0.4, 0.1], [0.2, 0.3]]).unwrap();
    // E(XY) - E(X) E(Y) = 0.3 - 0.5 * 0.4
    assert_relative_eq!(dependent.covariance(|&x| x, |&y| y), 0.1, epsilon = 1e-14);
    let correlation = 0.1 / (0.25_f64 * 0.24).sqrt();
    let found = dependent.correlation(|&x| x, |&y| y).unwrap();
    assert_relative_eq!(found, correlation, epsilon = 1e-14);
    assert!(!dependent.is_independent());
    assert!(matches!(dependent.correlation(|_| 1.0, |&y| y), Err(Error::OutOfRange { .. })));
    // Without covariance, and yet dependent: Y = X^2 on -1, 0, 1.
    let third = 1.0 / 3.0;
    let rows = [[0.0, third], [third, 0.0], [0.0, third]];
    let square = Joint::new([-1.0, 0.0, 1.0], [0.0, 1.0], &rows).unwrap();
    assert_abs_diff_eq!(square.covariance(|&x| x, |&y| y), 0.0, epsilon = 1e-15);
    assert!(!square.is_independent());
}

#[test]
fn bad_tables_are_refused() {
    let range = |result: Result<Discrete<i32>, Error>| {
        assert!(matches!(result, Err(Error::OutOfRange { .. })), "{result:?}");
    };
    range(Discrete::new([(1, 0.5), (2, 0.6)]));
    range(Discrete::new([(1, -0.5), (2, 1.5)]));
    range(Discrete::new([(1, f64::NAN), (2, 1.0)]));
    range(Discrete::new([(1, f64::INFINITY)]));
    range(Discrete::new([]));
    range(Discrete::uniform([]));
    range(Discrete::from_weights([(1, 0.0), (2, 0.0)]));
    range(Discrete::from_weights([(1, f64::MAX), (2, f64::MAX)]));
    assert!(Discrete::new([(1, 0.5), (2, 0.5 + 5e-10)]).is_ok());

    let shape = |rows: &[Vec<f64>]| Joint::new([1, 2], [1, 2], rows).unwrap_err();
    assert!(matches!(shape(&[vec![0.5, 0.5]]), Error::Length { found: 1, .. }));
    assert!(matches!(shape(&[vec![0.5, 0.5], vec![0.0]]), Error::Length { found: 1, .. }));
    assert!(matches!(shape(&[vec![0.5, 0.5], vec![0.5, 0.0]]), Error::OutOfRange { .. }));
    let none: [[f64; 0]; 0] = [];
    assert!(Joint::<i32, i32>::new([], [], &none).is_err());
    let prior = die();
    assert!(Joint::from_conditional(&prior, [1, 2], |_, _| 0.4).is_err());
    assert!(Joint::from_conditional(&prior, Vec::<i32>::new(), |_, _| 1.0).is_err());
}

#[test]
fn impossible_evidence_is_an_error() {
    let impossible = |error: Error| {
        assert!(matches!(error, Error::ImpossibleEvidence { .. }), "{error}");
    };
    impossible(die().given(|&e| e > 6).unwrap_err());
    impossible(tooth_table().first_given(&"snow").unwrap_err());
    let never = Joint::new([1, 2], [1, 2], &[[1.0, 0.0], [0.0, 0.0]]).unwrap();
    impossible(never.second_given(&2).unwrap_err());
    impossible(never.first_given(&2).unwrap_err());
    impossible(bayes::posterior(&die(), |_| 0.0).unwrap_err());
    impossible(bayes::posterior_from_log(&die(), |_| f64::NEG_INFINITY).unwrap_err());
    impossible(bayes::rule(0.0, 0.5, 0.0).unwrap_err());
    // The only likely hypothesis is one that cannot be.
    let sure = Discrete::new([("a", 1.0), ("b", 0.0)]).unwrap();
    impossible(bayes::posterior(&sure, |&h| if h == "b" { 1.0 } else { 0.0 }).unwrap_err());
}

#[test]
fn bayes_turns_the_table_round() {
    let dependent = Joint::new(["ill", "well"], [true, false], &[[0.09, 0.01], [0.18, 0.72]]);
    let dependent = dependent.unwrap();
    let positive = |h: &&str| dependent.second_given(h).unwrap().probability(|&t| t);
    let posterior = bayes::posterior(&dependent.first(), positive).unwrap();
    assert_relative_eq!(posterior.evidence(), 0.27, epsilon = 1e-14);
    assert_relative_eq!(posterior.alpha(), 1.0 / 0.27, epsilon = 1e-13);
    let ill = posterior.distribution.probability(|&h| h == "ill");
    assert_relative_eq!(ill, 1.0 / 3.0, epsilon = 1e-14);
    assert_relative_eq!(bayes::rule(0.9, 0.1, 0.27).unwrap(), 1.0 / 3.0, epsilon = 1e-14);
    let direct = dependent.first_given(&true).unwrap();
    assert_relative_eq!(direct.probabilities()[0], ill, epsilon = 1e-14);
    assert!(bayes::rule(0.9, 0.5, 0.2).is_err(), "P(e | h) P(h) > P(e)");
    assert!(bayes::rule(1.1, 0.5, 0.9).is_err());
    assert_eq!(bayes::rule(1.0, 0.3, 0.3).unwrap(), 1.0);
}

#[test]
fn likelihoods_beyond_the_range_of_numbers() {
    let prior = Discrete::uniform([0, 1, 2]).unwrap();
    let log = bayes::posterior_from_log(&prior, |&h| -5000.0 - f64::from(h) * 2_f64.ln());
    let log = log.unwrap();
    assert_relative_eq!(log.distribution.probabilities()[0], 4.0 / 7.0, epsilon = 1e-12);
    assert_relative_eq!(log.log_evidence, -5000.0 + (1.75_f64 / 3.0).ln(), epsilon = 1e-9);
    assert_eq!(log.evidence(), 0.0);
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(bayes::posterior(&prior, |_| bad), Err(Error::OutOfRange { .. })));
        let log = bayes::posterior_from_log(&prior, |_| bad);
        assert!(matches!(log, Err(Error::OutOfRange { .. })));
    }
    assert!(bayes::posterior(&prior, |_| -0.1).is_err());
}

#[test]
fn a_uniform_temperature() {
    let temperature = Uniform::new(18.0, 26.0).unwrap();
    assert_relative_eq!(temperature.probability(20.0, 22.0), 0.25);
    assert_eq!(temperature.probability(20.5, 20.5), 0.0);
    assert_eq!(temperature.density(20.5), 0.125);
    assert_eq!((temperature.density(17.9), temperature.density(26.1)), (0.0, 0.0));
    assert_eq!(temperature.probability(f64::NEG_INFINITY, 22.0), 0.5);
    assert_eq!(temperature.probability(22.0, 20.0), 0.0);
    assert!(temperature.probability(f64::NAN, 20.0).is_nan());
    assert!(temperature.probability(20.0, f64::NAN).is_nan());
    assert_eq!((temperature.mean(), temperature.variance()), (22.0, 64.0 / 12.0));
    assert_eq!(temperature.quantile(0.25).unwrap(), 20.0);
    assert!(temperature.quantile(1.5).is_err());
    for (low, high) in
        [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (-1e308, 1e308)]
    {
        assert!(matches!(Uniform::new(low, high), Err(Error::OutOfRange { .. })));
    }
    let mut rng = stream(5, "uniform");
    let moments = RunningMoments::of((0..50_000).map(|_| temperature.sample(&mut rng))).unwrap();
    assert_abs_diff_eq!(moments.mean().unwrap(), 22.0, epsilon = 0.05);
    assert_abs_diff_eq!(moments.variance().unwrap(), 64.0 / 12.0, epsilon = 0.1);
    assert!(moments.min().unwrap() >= 18.0 && moments.max().unwrap() <= 26.0);
}

#[test]
fn draws_follow_the_probabilities() {
    let loaded = Discrete::new([("never", 0.0), ("seldom", 0.1), ("often", 0.9)]).unwrap();
    let mut rng = stream(6, "discrete");
    let mut counts = [0_u32; 3];
    for _ in 0..50_000 {
        let drawn = loaded.sample(&mut rng);
        counts[loaded.outcomes().iter().position(|o| o == drawn).unwrap()] += 1;
    }
    assert_eq!(counts[0], 0);
    assert_abs_diff_eq!(f64::from(counts[1]) / 5e4, 0.1, epsilon = 0.005);
    assert_eq!(Discrete::uniform([1]).unwrap().entropy(), 0.0);
}

proptest! {
    #[test]
    fn the_order_of_independent_measurements_does_not_matter(
        weights in prop::collection::vec(0.01..1.0_f64, 4),
        first in prop::collection::vec(0.01..5.0_f64, 4),
        second in prop::collection::vec(0.01..5.0_f64, 4),
    ) {
        let prior = Discrete::from_weights(weights.into_iter().enumerate()).unwrap();
        let ab = bayes::posterior(&prior, |&h| first[h]).unwrap();
        let ab_then = bayes::posterior(&ab.distribution, |&h| second[h]).unwrap();
        let both = bayes::posterior(&prior, |&h| first[h] * second[h]).unwrap();
        for h in 0..4 {
            let (p, q) = (ab_then.distribution.probabilities()[h], both.distribution.probabilities()[h]);
            prop_assert!((p - q).abs() < 1e-12);
        }
        let chained = ab.log_evidence + ab_then.log_evidence;
        prop_assert!((chained - both.log_evidence).abs() < 1e-12);
    }
}
