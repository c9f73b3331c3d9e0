//! A robot in a corridor.

use approx::assert_relative_eq;
use loc_core::Error as CoreError;
use loc_filters::Error;
use loc_filters::histogram::LineGrid;

fn normal(x: f64, mean: f64, sigma: f64) -> f64 {
    (-0.5 * ((x - mean) / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt())
}

/// Without walls in reach the filter is a Kalman filter in one dimension.
#[test]
fn it_agrees_with_the_kalman_filter() {
    let mut grid = LineGrid::uniform(40.0, 0.02).unwrap();
    grid.correct(|x| normal(x, 12.0, 0.8)).unwrap();
    grid.predict(5.0, 0.5).unwrap();
    let log_evidence = grid.correct(|x| normal(x, 16.0, 0.6)).unwrap();
    let predicted = 0.64 + 0.25;
    let gain = predicted / (predicted + 0.36);
    assert_relative_eq!(grid.mean(), 17.0 - gain, epsilon = 1e-3);
    assert_relative_eq!(grid.variance(), (1.0 - gain) * predicted, max_relative = 1e-3);
    let evidence = normal(16.0, 17.0, (predicted + 0.36).sqrt());
    assert_relative_eq!(log_evidence, evidence.ln(), epsilon = 1e-3);
}

/// Three cells: everything by hand.
#[test]
fn bayes_by_hand() {
    let mut grid = LineGrid::uniform(3.0, 1.0).unwrap();
    // Means over the cells of x: 1/2, 3/2, 5/2; of x^2: 1/3, 7/3, 19/3.
    assert_relative_eq!(grid.correct(|x| x).unwrap(), 1.5_f64.ln(), epsilon = 1e-12);
    for (p, by_hand) in grid.probabilities().iter().zip([1.0, 3.0, 5.0]) {
        assert_relative_eq!(*p, by_hand / 9.0, epsilon = 1e-12);
    }
    grid.correct(|x| x * x).unwrap();
    let weights = [1.0 / 3.0, 7.0, 95.0 / 3.0];
    for (p, by_hand) in grid.probabilities().iter().zip(weights) {
        assert_relative_eq!(*p, by_hand / 39.0, epsilon = 1e-12);
    }
    // Half a cell forward: the last cell keeps half of its own and gets half of the middle one's.
    let lost = grid.predict(0.5, 0.0).unwrap();
    let (a, b, c) = (1.0 / 3.0 / 39.0, 7.0 / 39.0, 95.0 / 3.0 / 39.0);
    assert_relative_eq!(lost, 0.5 * c, epsilon = 1e-12);
    let moved = [0.5 * a, 0.5 * (a + b), 0.5 * (b + c)].map(|p| p / (1.0 - 0.5 * c));
    for (p, by_hand) in grid.probabilities().iter().zip(moved) {
        assert_relative_eq!(*p, by_hand, epsilon = 1e-12);
    }
}

#[test]
fn whole_cells_shift_exactly() {
    let mut grid = LineGrid::uniform(8.0, 0.5).unwrap();
    grid.correct(|x| if (2.0..4.0).contains(&x) { x } else { 0.0 }).unwrap();
    let before = grid.probabilities().to_vec();
    assert_eq!(grid.predict(1.5, 0.0).unwrap(), 0.0);
    assert_eq!(grid.probabilities()[7..11], before[4..8]);
    grid.predict(-1.5, 0.0).unwrap();
    assert_eq!(grid.probabilities(), before);
}

/// A direct sum over all pairs of cells, by numerical integration of the normal density.
#[test]
fn blurring_agrees_with_brute_force() {
    let mut grid = LineGrid::uniform(6.0, 0.5).unwrap();
    grid.correct(|x| 1.0 + (3.0 * x).sin()).unwrap();
    let before = grid.probabilities().to_vec();
    let (way, sigma) = (0.73, 0.4);
    let lost = grid.predict(way, sigma).unwrap();
    const FINE: usize = 200;
    let mut after = [0.0; 12];
    for (from, p) in before.iter().enumerate() {
        for part in 0..FINE {
            let at = 0.5 * (from as f64 + (part as f64 + 0.5) / FINE as f64) + way;
            for (to, after) in after.iter_mut().enumerate() {
                let (low, high) = (0.5 * to as f64, 0.5 * (to + 1) as f64);
                let within = loc_core::Normal::new(at, sigma).unwrap().probability(low, high);
                *after += p / FINE as f64 * within;
            }
        }
    }
    let sum: f64 = after.iter().sum();
    assert_relative_eq!(1.0 - lost, sum, epsilon = 1e-5);
    for (p, brute) in grid.probabilities().iter().zip(after) {
        assert_relative_eq!(*p, brute / sum, epsilon = 1e-5);
    }
    assert_relative_eq!(grid.probabilities().iter().sum::<f64>(), 1.0, epsilon = 1e-12);
}

#[test]
fn intervals_count_parts_of_cells() {
    let grid = LineGrid::uniform(10.0, 1.0).unwrap();
    assert_relative_eq!(grid.probability(2.25, 4.0), 0.175, epsilon = 1e-12);
    assert_relative_eq!(grid.probability(-3.0, 30.0), 1.0, epsilon = 1e-12);
    assert_eq!(grid.probability(5.0, 4.0), 0.0);
    assert_relative_eq!(grid.mean(), 5.0, epsilon = 1e-12);
    assert_relative_eq!(grid.variance(), 100.0 / 12.0, epsilon = 1e-12);
}

#[test]
fn bad_input_leaves_the_belief() {
    for (length, cell) in [(0.0, 1.0), (-1.0, 1.0), (1.0, 0.0), (f64::NAN, 1.0), (1.0, 1e-9)] {
        assert!(LineGrid::uniform(length, cell).is_err(), "{length} {cell}");
    }
    let mut grid = LineGrid::uniform(5.0, 1.0).unwrap();
    grid.correct(|x| x).unwrap();
    let before = grid.clone();
    assert!(matches!(grid.predict(f64::NAN, 0.1), Err(Error::Core(CoreError::OutOfRange { .. }))));
    assert!(grid.predict(1.0, -0.1).is_err());
    let left = grid.predict(100.0, 0.1).unwrap_err();
    assert!(matches!(left, Error::Core(CoreError::ImpossibleEvidence { .. })), "{left}");
    assert!(grid.correct(|_| 0.0).is_err());
    assert!(grid.correct(|_| -1.0).is_err());
    assert!(grid.correct(|_| f64::NAN).is_err());
    assert_eq!(grid, before);
}
