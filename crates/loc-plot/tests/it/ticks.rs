//! Round numbers along axes, by hand.

use loc_plot::{Tick, linear_ticks, log_ticks};

fn labels(ticks: &[Tick]) -> Vec<&str> {
    ticks.iter().map(|tick| tick.label.as_str()).collect()
}

#[test]
fn linear_steps_are_one_two_or_five() {
    let cases: [(f64, f64, usize, &[&str]); 8] = [
        (0.0, 10.0, 6, &["0", "2", "4", "6", "8", "10"]),
        (0.0, 10.0, 5, &["0", "5", "10"]),
        (
            0.0,
            1.0,
            11,
            &["0.0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6", "0.7", "0.8", "0.9", "1.0"],
        ),
        (-1.0, 1.0, 3, &["−1", "0", "1"]),
        (0.013, 0.047, 5, &["0.02", "0.03", "0.04"]),
        (7.0, 8.9, 3, &["7", "8"]),
        (0.0, 2e7, 3, &["0", "1e7", "2e7"]),
        (-4e-5, 4e-5, 5, &["−4e−5", "−2e−5", "0", "2e−5", "4e−5"]),
    ];
    for (min, max, at_most, expected) in cases {
        assert_eq!(labels(&linear_ticks(min, max, at_most)), expected, "{min} to {max}");
    }
}

#[test]
fn there_are_never_more_than_asked_for() {
    for k in 1..400 {
        let (min, max) = (-0.37 * f64::from(k), 0.011 * f64::from(k * k));
        for at_most in 2..12 {
            let ticks = linear_ticks(min, max, at_most);
            assert!((1..=at_most).contains(&ticks.len()), "{min} to {max}: {ticks:?}");
            assert!(ticks.iter().all(|t| t.value >= min - 1e-9 && t.value <= max + 1e-9));
        }
    }
}

#[test]
fn a_logarithmic_axis_shows_powers_of_ten() {
    let cases: [(f64, f64, usize, &[&str]); 4] = [
        (0.5, 2000.0, 4, &["1", "10", "100", "1000"]),
        (2.0, 30.0, 6, &["2", "5", "10", "20"]),
        (1e-6, 1e6, 5, &["1e−6", "0.001", "1", "1000", "1000000"]),
        (3.0, 4.0, 3, &["3.0", "3.5", "4.0"]),
    ];
    for (min, max, at_most, expected) in cases {
        assert_eq!(labels(&log_ticks(min, max, at_most)), expected, "{min} to {max}");
    }
}

#[test]
fn intervals_that_are_none_have_no_ticks() {
    for (min, max) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert!(linear_ticks(min, max, 5).is_empty());
        assert!(log_ticks(min, max, 5).is_empty());
    }
    assert!(log_ticks(0.0, 1.0, 5).is_empty() && log_ticks(-1.0, 1.0, 5).is_empty());
    for (k, min) in super::WILD.into_iter().enumerate() {
        for max in super::WILD.into_iter().skip(k) {
            assert!(linear_ticks(min, max, 9).len() <= 10);
            assert!(log_ticks(min, max, 9).len() <= 30);
        }
    }
}
