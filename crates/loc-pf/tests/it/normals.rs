//! Many normal numbers at once: are they normal, independent, and the same everywhere?

use loc_core::Normal;
use loc_core::random::stream;
use loc_pf::normals::{LANES, Normals};

const COUNT: usize = 1_000_000;

fn draws(seed: u64) -> Vec<f32> {
    let mut numbers = vec![0.0; COUNT];
    Normals::from_rng(&mut stream(seed, "normals")).fill(&mut numbers);
    numbers
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    values.sum::<f64>() / COUNT as f64
}

#[test]
fn moments_and_tails() {
    let numbers = draws(1);
    let power = |n: i32| mean(numbers.iter().map(|&z| f64::from(z).powi(n)));
    // Four standard errors each: of z^n they are the root of E z^2n - (E z^n)^2, over 1000.
    assert!(power(1).abs() < 4e-3, "{}", power(1));
    assert!((power(2) - 1.0).abs() < 4.0 * 2_f64.sqrt() / 1e3, "{}", power(2));
    assert!(power(3).abs() < 4.0 * 15_f64.sqrt() / 1e3, "{}", power(3));
    assert!((power(4) - 3.0).abs() < 4.0 * 96_f64.sqrt() / 1e3, "{}", power(4));
    assert!((power(6) - 15.0).abs() < 4.0 * 10_170_f64.sqrt() / 1e3, "{}", power(6));
    for (sigmas, share) in [(1.0, 0.317_310_5), (2.0, 0.045_500_3), (3.0, 0.002_699_8)] {
        let beyond = mean(numbers.iter().map(|z| f64::from(u8::from(z.abs() > sigmas))));
        assert!((beyond - share).abs() < 4e-3 * share.sqrt(), "{sigmas} sigma: {beyond}");
    }
    // 63.3 of a million lie beyond 4 sigma, give or take 8, on both sides.
    let above = numbers.iter().filter(|&&z| z > 4.0).count();
    let below = numbers.iter().filter(|&&z| z < -4.0).count();
    assert!((10..60).contains(&above) && (10..60).contains(&below), "{above} {below}");
    assert!((32..96).contains(&(above + below)), "{above} {below}");
    assert!(numbers.iter().all(|z| z.abs() < 6.7));
}

#[test]
fn distribution_by_kolmogorov_and_smirnov() {
    let normal = Normal::new(0.0, 1.0).unwrap();
    for seed in [2, 3] {
        let mut numbers = draws(seed);
        numbers.sort_by(f32::total_cmp);
        // Every 20th is enough: between two of them the distance grows by at most 2e-5.
        let distance = numbers.iter().enumerate().step_by(20).map(|(rank, &z)| {
            (normal.cdf(f64::from(z)) - (rank as f64 + 0.5) / COUNT as f64).abs()
        });
        // Beyond 1.95 / sqrt(n) lies one of 1000 samples.
        let largest = distance.fold(0.0, f64::max);
        assert!(largest < 1.95e-3, "seed {seed}: {largest}");
    }
}

#[test]
fn numbers_are_independent_of_their_neighbours() {
    let numbers = draws(4);
    for lag in [1, 2, LANES, 2 * LANES, 32, 64] {
        let pairs = || numbers.iter().zip(&numbers[lag..]);
        let products = mean(pairs().map(|(&a, &b)| f64::from(a) * f64::from(b)));
        let squares = mean(pairs().map(|(&a, &b)| f64::from(a * a - 1.0) * f64::from(b * b - 1.0)));
        assert!(products.abs() < 4e-3 && squares.abs() < 8e-3, "{lag}: {products} {squares}");
    }
}

#[test]
fn seeds_differ_and_repeat() {
    assert_eq!(draws(5), draws(5));
    let (a, b) = (draws(5), draws(6));
    assert!(a.iter().zip(&b).filter(|(a, b)| a == b).count() < 10);
}

#[test]
fn any_length_is_filled() {
    for length in [0, 1, 63, 64, 65, 1000] {
        let mut numbers = vec![f32::NAN; length];
        Normals::from_rng(&mut stream(1, "normals")).fill(&mut numbers);
        assert!(numbers.iter().all(|z| z.is_finite()), "{length}");
    }
}

#[test]
fn the_same_on_every_machine() {
    let bits = super::fnv1a(draws(7)[..100_000].iter().map(|z| u64::from(z.to_bits())));
    assert_eq!(bits, 0xc166_f27c_9d49_8395, "{bits:#x}");
}
