//! How probability spreads over cells.

use approx::assert_relative_eq;
use loc_core::Error as CoreError;
use loc_core::random::stream;
use loc_filters::Error;
use loc_filters::histogram::Kernel;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

#[test]
fn whole_cells_move_as_they_are() {
    for cells in [-7_i8, -1, 0, 1, 12] {
        let kernel = Kernel::new(f64::from(cells), 0.0).unwrap();
        assert_eq!((kernel.first(), kernel.weights()), (isize::from(cells), &[1.0][..]));
    }
}

/// A box shifted by a part of a cell overlaps two cells.
#[test]
fn parts_of_cells_are_shared_by_overlap() {
    let kernel = Kernel::new(-2.25, 0.0).unwrap();
    assert_eq!((kernel.first(), kernel.weights()), (-3, &[0.25, 0.75][..]));
}

#[test]
fn mass_mean_and_variance_are_those_of_the_motion() {
    for (shift, sigma) in [(0.0, 0.01), (0.3, 0.2), (-4.7, 1.0), (12.5, 8.0), (0.5, 300.0)] {
        let kernel = Kernel::new(shift, sigma).unwrap();
        let sum: f64 = kernel.weights().iter().sum();
        let mean: f64 = kernel.iter().map(|(k, w)| k as f64 * w).sum();
        let variance: f64 = kernel.iter().map(|(k, w)| w * (k as f64 - mean).powi(2)).sum();
        assert_relative_eq!(sum, 1.0, epsilon = 1e-12);
        assert!((mean - shift).abs() < 1e-6 * (1.0 + sigma), "{shift} {sigma}: {mean}");
        // A cell is a box before and after: half of the variance of both comes on top.
        if sigma > 0.5 {
            assert_relative_eq!(variance, sigma * sigma + 1.0 / 6.0, max_relative = 1e-4);
        }
    }
}

/// The shares against points drawn in the cell and moved one by one.
#[test]
fn shares_are_those_of_many_points() {
    let mut rng = stream(11, "kernel");
    for (shift, sigma) in [(0.4, 0.3), (-1.8, 0.05), (2.2, 1.4)] {
        let kernel = Kernel::new(shift, sigma).unwrap();
        const POINTS: usize = 200_000;
        let mut counts = vec![0_usize; kernel.weights().len()];
        for _ in 0..POINTS {
            let z: f64 = StandardNormal.sample(&mut rng);
            let end = rng.random_range(-0.5..0.5) + shift + sigma * z;
            let place = (end + 0.5).floor() as isize - kernel.first();
            if let Some(count) = usize::try_from(place).ok().and_then(|k| counts.get_mut(k)) {
                *count += 1;
            }
        }
        for (count, weight) in counts.iter().zip(kernel.weights()) {
            let found = *count as f64 / POINTS as f64;
            let error = 5.0 * (weight / POINTS as f64).sqrt() + 1e-4;
            assert!((found - weight).abs() < error, "{shift} {sigma}: {found} {weight}");
        }
    }
}

#[test]
fn absurd_motions_are_refused() {
    for (shift, sigma) in
        [(f64::NAN, 1.0), (f64::INFINITY, 1.0), (1e9, 1.0), (0.0, -1.0), (0.0, 1e9)]
    {
        let error = Kernel::new(shift, sigma).unwrap_err();
        assert!(matches!(error, Error::Core(CoreError::OutOfRange { .. })), "{error}");
    }
}
