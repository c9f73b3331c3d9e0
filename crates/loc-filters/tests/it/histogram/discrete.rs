//! Named states.

use approx::assert_relative_eq;
use loc_core::probability::Discrete;
use loc_filters::histogram::DiscreteFilter;

/// A robot that moves clockwise through three rooms, and stays with probability 0.25.
fn clockwise(from: &u8, to: &u8) -> f64 {
    match (*to + 3 - *from) % 3 {
        0 => 0.25,
        1 => 0.75,
        _ => 0.0,
    }
}

#[test]
fn three_rooms_by_hand() {
    let start = Discrete::new([(0, 0.5), (1, 0.5), (2, 0.0)]).unwrap();
    let mut filter = DiscreteFilter::new(start);
    filter.predict(clockwise).unwrap();
    assert_eq!(filter.belief().probabilities(), [0.125, 0.5, 0.375]);
    let log_evidence = filter.correct(|&room| [0.8, 0.1, 0.4][usize::from(room)]).unwrap();
    assert_relative_eq!(log_evidence, 0.3_f64.ln(), epsilon = 1e-12);
    for (p, by_hand) in filter.belief().probabilities().iter().zip([1.0 / 3.0, 1.0 / 6.0, 0.5]) {
        assert_relative_eq!(*p, by_hand, epsilon = 1e-12);
    }
}

/// Without measurements the belief tends to the stationary distribution of the chain.
#[test]
fn motion_alone_forgets_the_start() {
    let start = Discrete::new([(0, 1.0), (1, 0.0), (2, 0.0)]).unwrap();
    let mut filter = DiscreteFilter::new(start);
    for _ in 0..200 {
        filter.predict(clockwise).unwrap();
    }
    for p in filter.belief().probabilities() {
        assert_relative_eq!(*p, 1.0 / 3.0, epsilon = 1e-9);
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let mut filter = DiscreteFilter::new(Discrete::uniform([0_u8, 1, 2]).unwrap());
    let before = filter.clone();
    let error = filter.predict(|_, _| 0.5).unwrap_err().to_string();
    assert_eq!(error, "sum of the transitions from a state: expected 1 within 1e-9, got 1.5");
    assert!(filter.predict(|_, _| f64::NAN).is_err());
    assert!(filter.correct(|_| 0.0).is_err());
    assert!(filter.correct(|_| f64::INFINITY).is_err());
    assert_eq!(filter, before);
}
