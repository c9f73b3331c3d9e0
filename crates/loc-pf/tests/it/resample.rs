//! Resampling: fair, and as even as each scheme promises.

use loc_core::random::stream;
use loc_pf::resample::CumulativeWeights;
use loc_pf::{Particles, Resampling};
use rand::RngExt;

fn drawn(scheme: Resampling, log_weights: &[f64], count: usize, seed: u64) -> Vec<u32> {
    let mut indices = vec![7; 3];
    scheme.draw(log_weights, count, &mut stream(seed, "resample"), &mut indices);
    indices
}

fn counts(indices: &[u32], particles: usize) -> Vec<usize> {
    let mut counts = vec![0; particles];
    indices.iter().for_each(|&index| counts[index as usize] += 1);
    counts
}

/// Weights over many orders of magnitude, a few of them 0, not normalised.
fn uneven(particles: usize) -> Vec<f64> {
    let mut rng = stream(particles as u64, "weights");
    let mut weight = |k: usize| match k % 17 {
        5 => f64::NEG_INFINITY,
        _ => -700.0 - 12.0 * rng.random::<f64>().powi(2),
    };
    (0..particles).map(&mut weight).collect()
}

#[test]
fn spoke_wheel_and_strata_are_those_of_the_textbook() {
    for particles in [1, 2, 63, 64, 65, 1000, 5003] {
        let log_weights = uneven(particles);
        let weights: Vec<f64> = log_weights.iter().map(|w| (w + 700.0).exp()).collect();
        let total: f64 = weights.iter().sum();
        for count in [1, 10, particles, 3 * particles] {
            for scheme in [Resampling::Systematic, Resampling::Stratified] {
                let mut rng = stream(11, "resample");
                let mut open = || (f64::from(rng.random::<u32>()) + 0.5) / 2_f64.powi(32);
                let turn = open();
                let place = |k: usize| match (scheme, k) {
                    (Resampling::Systematic, _) | (_, 0) => turn,
                    _ => open(),
                };
                let places: Vec<f64> = (0..count).map(place).collect();
                let (mut passed, mut index) = (weights[0], 0);
                let textbook = places.iter().enumerate().map(|(k, place)| {
                    while passed <= (k as f64 + place) * total / count as f64 {
                        index += 1;
                        passed += weights[index];
                    }
                    index as u32
                });
                let textbook: Vec<u32> = textbook.collect();
                assert_eq!(drawn(scheme, &log_weights, count, 11), textbook, "{scheme:?} {count}");
            }
        }
    }
}

#[test]
fn every_scheme_is_fair() {
    // One draw per seed, so that the counts are multinomial and chi-square applies.
    let weights = [0.05, 0.3, 0.0, 0.15, 0.4, 0.1];
    let log_weights = weights.map(f64::ln);
    for scheme in Resampling::ALL {
        let draws = 20_000;
        let one = |seed| drawn(scheme, &log_weights, 1, seed)[0];
        let ones = counts(&(0..draws).map(one).collect::<Vec<_>>(), weights.len());
        assert_eq!(ones[2], 0, "{scheme:?} draws what cannot be");
        let chi_square: f64 = (0..6)
            .filter(|&k| k != 2)
            .map(|k| {
                (ones[k] as f64 - draws as f64 * weights[k]).powi(2) / (draws as f64 * weights[k])
            })
            .sum();
        // The share 0.999 of chi-square with 4 degrees of freedom.
        assert!(chi_square < 18.47, "{scheme:?}: {chi_square}");
        // Thirteen at a time: the mean count is the share, within five standard errors.
        let runs = 4000;
        let mut sums = [0.0; 6];
        for seed in 0..runs {
            let counts = counts(&drawn(scheme, &log_weights, 13, seed), 6);
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count as f64);
        }
        for (sum, weight) in sums.iter().zip(weights) {
            let (mean, share) = (sum / runs as f64, 13.0 * weight);
            let error = 5.0 * (share.max(1e-12) / runs as f64).sqrt();
            assert!((mean - share).abs() < error, "{scheme:?}: {mean} of {share}");
        }
    }
}

#[test]
fn counts_stray_least_with_the_spoke_wheel() {
    let mut rng = stream(1, "weights");
    let log_weights: Vec<f64> = (0..50).map(|_| (0.2 + rng.random::<f64>()).ln()).collect();
    let total: f64 = log_weights.iter().map(|w| w.exp()).sum();
    let variance = |scheme| {
        let runs = 400;
        let stray = |seed| {
            let counts = counts(&drawn(scheme, &log_weights, 50, seed), 50);
            let shares = log_weights.iter().map(|w| 50.0 * w.exp() / total);
            counts.iter().zip(shares).map(|(&n, share)| (n as f64 - share).powi(2)).sum::<f64>()
        };
        (0..runs).map(stray).sum::<f64>() / runs as f64
    };
    let [roulette, residual, stratified, systematic] = Resampling::ALL.map(variance);
    assert!((45.0..54.0).contains(&roulette), "M (1 - sum w^2): {roulette}");
    assert!(roulette > 1.5 * residual, "{roulette} {residual}");
    assert!(roulette > 1.5 * stratified, "{roulette} {stratified}");
    assert!(stratified > 1.1 * systematic, "{stratified} {systematic}");
}

#[test]
fn systematic_and_residual_never_lose_a_whole_share() {
    let log_weights = uneven(300);
    let total: f64 = log_weights.iter().map(|w| (w + 700.0).exp()).sum();
    for seed in 0..20 {
        for scheme in [Resampling::Systematic, Resampling::Residual] {
            let counts = counts(&drawn(scheme, &log_weights, 500, seed), 300);
            for (&count, weight) in counts.iter().zip(&log_weights) {
                let share = 500.0 * (weight + 700.0).exp() / total;
                assert!(count as f64 >= (share - 1e-6).floor(), "{scheme:?}: {count} of {share}");
                let most = (share + 1e-6).ceil();
                assert!(scheme == Resampling::Residual || count as f64 <= most, "{count} {share}");
            }
        }
    }
}

#[test]
fn m11_equal_weights_stay_as_they_are() {
    for particles in [1, 2, 3, 7, 64, 65, 1000, 4097, 100_000] {
        let everyone: Vec<u32> = (0..particles as u32).collect();
        for (seed, weight) in [(1, 0.0), (2, -1234.5), (3, -(particles as f64).ln()), (4, f64::MIN)]
        {
            let weights = vec![weight; particles];
            for scheme in [Resampling::Systematic, Resampling::Residual, Resampling::Stratified] {
                assert_eq!(drawn(scheme, &weights, particles, seed), everyone, "{scheme:?}");
            }
        }
    }
}

#[test]
fn m11_a_robot_that_stands_still_keeps_its_particles_only_with_the_spoke_wheel() {
    let survivors = |scheme: Resampling| {
        let (mut ancestors, mut rng) = ((0..100).collect::<Vec<u32>>(), stream(1, "diversity"));
        let mut indices = Vec::new();
        for _ in 0..1000 {
            scheme.draw(&[0.0; 100], 100, &mut rng, &mut indices);
            ancestors = indices.iter().map(|&index| ancestors[index as usize]).collect();
        }
        ancestors.dedup();
        ancestors.len()
    };
    assert_eq!(survivors(Resampling::Roulette), 1);
    assert_eq!(survivors(Resampling::Systematic), 100);
}

#[test]
fn odd_weights_have_defined_results() {
    let (zero, nan) = (f64::NEG_INFINITY, f64::NAN);
    for scheme in Resampling::ALL {
        assert!(drawn(scheme, &[], 10, 1).is_empty(), "no particles");
        assert!(drawn(scheme, &[0.0, 1.0], 0, 1).is_empty(), "none asked for");
        assert_eq!(drawn(scheme, &[-3.0], 5, 1), [0; 5], "one particle");
        assert_eq!(drawn(scheme, &[zero, -1e5, zero], 4, 1), [1; 4], "one of weight");
        assert_eq!(drawn(scheme, &[nan, -1.0, nan], 4, 1), [1; 4], "NaN is no weight");
        assert_eq!(drawn(scheme, &[-2000.0, 0.0], 4, 1), [1; 4], "far below");
        for all in [zero, nan, f64::INFINITY] {
            let mut mixed = counts(&drawn(scheme, &[all; 8], 800, 1), 8);
            mixed.sort_unstable();
            assert!(mixed[0] > 60, "{scheme:?}: all {all} count as equal, {mixed:?}");
        }
        for (particles, count) in [(3, 1000), (1000, 3), (100, 99)] {
            let indices = drawn(scheme, &uneven(particles), count, 1);
            assert_eq!(indices.len(), count);
            assert!(indices.iter().all(|&index| (index as usize) < particles));
            assert!(indices.iter().all(|&index| index % 17 != 5), "{scheme:?} draws a weight of 0");
        }
    }
}

#[test]
fn places_on_the_wheel() {
    let mut wheel = CumulativeWeights::new();
    assert!(wheel.is_empty() && wheel.index_at(0.5) == 0);
    wheel.set(&[f64::NEG_INFINITY, 0.0, 3_f64.ln(), f64::NEG_INFINITY]);
    assert_eq!(wheel.len(), 4);
    let at = [0.0, 0.2499, 0.2501, 0.9999, 1.0].map(|share| wheel.index_at(share));
    assert_eq!(at, [1, 1, 2, 2, 2]);
}

#[test]
fn weights_are_normalised_as_one_by_one() {
    let mut cloud = Particles::from_poses(vec![loc_core::Pose2::IDENTITY; 1003]);
    cloud.log_weights_mut().copy_from_slice(&uneven(1003));
    let weights: Vec<f64> = uneven(1003).iter().map(|w| (w + 700.0).exp()).collect();
    let total: f64 = weights.iter().sum();
    let effective = total * total / weights.iter().map(|w| w * w).sum::<f64>();
    assert!((cloud.effective_sample_size() / effective - 1.0).abs() < 1e-12);
    let (mut relative, largest) = (vec![7.0; 3], weights.iter().copied().fold(0.0, f64::max));
    cloud.relative_weights(&mut relative);
    assert_eq!(relative.len(), weights.len());
    for (ours, weight) in relative.iter().zip(&weights) {
        assert!((ours - weight / largest).abs() < 1e-13);
    }
    let sum = cloud.normalize();
    assert!((sum - (total.ln() - 700.0)).abs() < 1e-10, "{sum}");
    assert!((cloud.effective_sample_size() / effective - 1.0).abs() < 1e-12);
    for (ours, weight) in cloud.weights().zip(&weights) {
        assert!((ours - weight / total).abs() < 1e-14);
    }
}

#[test]
fn odd_weights_are_normalised_to_something() {
    for all in [f64::NEG_INFINITY, f64::NAN, f64::INFINITY] {
        let mut cloud = Particles::from_poses(vec![loc_core::Pose2::IDENTITY; 4]);
        cloud.log_weights_mut().fill(all);
        let mut relative = Vec::new();
        cloud.relative_weights(&mut relative);
        assert_eq!(relative, [1.0; 4]);
        assert_eq!(cloud.normalize(), f64::NEG_INFINITY);
        assert!((cloud.effective_sample_size() - 4.0).abs() < 1e-12);
        cloud.log_weights_mut()[1] = f64::NAN;
        assert!(cloud.normalize().is_finite());
        assert_eq!(cloud.weight(1), 0.0);
        assert!((cloud.effective_sample_size() - 3.0).abs() < 1e-12);
    }
    assert_eq!(Particles::new().effective_sample_size(), 0.0);
}
