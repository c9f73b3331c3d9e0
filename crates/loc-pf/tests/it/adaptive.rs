//! KLD-sampling: as many particles as the belief needs.

use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, gaussian::pose_belief};
use loc_pf::adaptive::KldCertainty;
use loc_pf::resample::CumulativeWeights;
use loc_pf::{Kld, KldSettings, ParticleFilter, Particles, Resampling};
use std::collections::HashSet;
use std::f64::consts::{PI, TAU};

fn settings(min_particles: usize, max_particles: usize) -> KldSettings {
    KldSettings::default().min_particles(min_particles).max_particles(max_particles)
}

fn cloud(sigmas: [f64; 3], count: usize) -> Particles {
    let belief: Gaussian<3> = pose_belief(Pose2::new(3.3, -7.1, 2.9), sigmas);
    Particles::from_gaussian(&belief, count, &mut stream(1, "cloud"))
}

fn draw(kld: &mut Kld, scheme: Resampling, cloud: &Particles) -> Vec<u32> {
    let (mut wheel, mut indices) = (CumulativeWeights::new(), vec![1, 2, 3]);
    wheel.set(cloud.log_weights());
    kld.draw(scheme, &wheel, cloud.poses(), &mut stream(2, "kld"), &mut indices);
    indices
}

#[test]
fn bound_is_the_quantile_of_chi_square() {
    // By hand for 2 bins: 10 (1 - 2/9 + 2.3263 sqrt(2/9))^3 = 65.9.
    let wide = settings(1, 1_000_000);
    assert_eq!(wide.particles_for(2).unwrap(), 66);
    assert_eq!(settings(7, 100).particles_for(0).unwrap(), 7);
    assert_eq!(settings(7, 100).particles_for(1).unwrap(), 7);
    assert_eq!(settings(70, 100).particles_for(2).unwrap(), 70);
    assert_eq!(settings(7, 100).particles_for(1000).unwrap(), 100);
    // chi-square at 0.99, from tables, with 3, 10, 50 and 100 degrees of freedom.
    for (freedom, quantile) in [(3, 11.345), (10, 23.209), (50, 76.154), (100, 135.807)] {
        let exact: f64 = quantile / (2.0 * 0.05);
        let count = wide.particles_for(freedom + 1).unwrap() as f64;
        assert!((count / exact - 1.0).abs() < 0.01, "{freedom}: {count}, not {exact}");
    }
}

#[test]
fn the_probability_is_not_taken_for_a_quantile() {
    let by = |certainty| settings(1, 100_000).certainty(certainty).particles_for(20).unwrap();
    let confident = by(KldCertainty::Confidence(0.99));
    assert_eq!(confident, by(KldCertainty::Quantile(2.326_348)));
    // nav2's reading of 0.99 is the confidence 0.839.
    assert_eq!(by(KldCertainty::Quantile(0.99)), by(KldCertainty::Confidence(0.838_913)));
    assert!(by(KldCertainty::Quantile(0.99)) < confident);
}

#[test]
fn peers_11_a_compact_particle_set_shrinks_to_the_minimum() {
    let mut kld = Kld::new(settings(50, 10_000)).unwrap();
    // One bin, and two: 3.3 lies 0.05 from the border at 3.25.
    assert_eq!(draw(&mut kld, Resampling::Systematic, &cloud([1e-3; 3], 10_000)).len(), 50);
    assert_eq!(kld.bins(), 1);
    let two = [Pose2::new(0.2, 0.0, 0.0), Pose2::new(0.3, 0.0, 0.0)];
    let two = Particles::from_poses((0..10_000).map(|k| two[k / 5000]));
    assert_eq!(draw(&mut kld, Resampling::Systematic, &two).len(), 66);
    assert_eq!(kld.bins(), 2);
    // Tracking needs some hundred, the whole map the most.
    let tracking = draw(&mut kld, Resampling::Systematic, &cloud([0.15, 0.15, 0.05], 10_000)).len();
    assert!((100..600).contains(&tracking), "{tracking}");
    let lost = draw(&mut kld, Resampling::Systematic, &cloud([20.0, 20.0, 2.0], 10_000)).len();
    assert_eq!(lost, 10_000);
    // And back, with the same memory.
    assert_eq!(draw(&mut kld, Resampling::Systematic, &cloud([1e-3; 3], 10_000)).len(), 50);
}

#[test]
fn only_bins_with_weight_count() {
    let mut cloud = cloud([20.0, 20.0, 2.0], 5000);
    let log_weights = cloud.log_weights_mut();
    log_weights[1..].fill(-80.0);
    let mut kld = Kld::new(settings(20, 5000)).unwrap();
    for scheme in Resampling::ALL {
        assert_eq!(draw(&mut kld, scheme, &cloud), [0; 20], "{scheme:?}");
    }
}

#[test]
fn peers_12_low_variance_schemes_adapt_too() {
    let cloud = cloud([0.5, 0.5, 0.2], 10_000);
    let mut sizes = Vec::new();
    for scheme in Resampling::ALL {
        let mut kld = Kld::new(settings(100, 10_000)).unwrap();
        let indices = draw(&mut kld, scheme, &cloud);
        // What the bins ask for, no more: a little fewer bins than the cloud has in all.
        assert_eq!(indices.len(), kld.settings().particles_for(kld.bins()).unwrap(), "{scheme:?}");
        sizes.push(indices.len() as f64);
        if scheme == Resampling::Systematic {
            // Equal weights, M / n spacings: never two copies, and evenly apart.
            let apart = cloud.len() / indices.len();
            let gaps = indices.windows(2).map(|pair| (pair[1] - pair[0]) as usize);
            assert!(gaps.into_iter().all(|gap| gap == apart || gap == apart + 1));
        }
    }
    let [least, most] = [f64::min, f64::max].map(|f| sizes.iter().copied().fold(sizes[0], f));
    assert!(most < 1.15 * least && least > 500.0, "{sizes:?}");
}

#[test]
fn bins_are_those_of_a_hash_set() {
    for (heading, headings) in [(10_f64.to_radians(), 36.0), (0.4, 16.0), (7.0, 1.0)] {
        let cloud = cloud([4.0, 4.0, 3.0], 3000);
        let bin = |pose: Pose2| {
            let turn = (pose.theta * headings / TAU).round_ties_even().rem_euclid(headings);
            [pose.x / 0.5, pose.y / 0.5, turn].map(|v| v.round_ties_even() as i64)
        };
        let all: HashSet<_> = cloud.poses().iter().map(bin).collect();
        // With equal weights the spoke wheel looks at every particle once.
        let all_particles = settings(3000, 3000).bin_heading(heading);
        let mut kld = Kld::new(all_particles).unwrap();
        for _ in 0..2 {
            assert_eq!(draw(&mut kld, Resampling::Systematic, &cloud).len(), 3000);
            assert_eq!(kld.bins(), all.len());
        }
    }
}

#[test]
fn particles_across_the_seam_of_headings_are_one_set() {
    let mut kld = Kld::new(settings(10, 1000)).unwrap();
    let about = |heading: f64| {
        let poses = (0..100).map(|k| Pose2::new(0.0, 0.0, heading + 0.001 * (f64::from(k) - 49.5)));
        Particles::from_poses(poses)
    };
    for heading in [0.0, PI] {
        assert_eq!(draw(&mut kld, Resampling::Systematic, &about(heading)).len(), 10);
        assert_eq!(kld.bins(), 1);
    }
}

#[test]
fn the_filter_adapts() {
    let rng = stream(3, "filter");
    let mut filter = ParticleFilter::new(cloud([10.0, 10.0, 2.0], 5000), rng);
    let mut kld = Kld::new(settings(100, 5000)).unwrap();
    assert_eq!(filter.resample_adaptively(Resampling::Systematic, &mut kld), 5000);
    // A measurement that leaves a disc of 1.5 m.
    filter.weigh(&|pose: Pose2| -0.5 * f64::hypot(pose.x - 3.0, pose.y + 7.0).powi(2) / 0.25);
    let size = filter.resample_adaptively(Resampling::Systematic, &mut kld);
    assert!((100..5000).contains(&size) && filter.particles().len() == size, "{size}");
    let mut empty = ParticleFilter::new(Particles::new(), stream(3, "filter"));
    assert_eq!(empty.resample_adaptively(Resampling::Systematic, &mut kld), 0);
}

#[test]
fn settings_are_checked() {
    let defaults = KldSettings::default;
    assert!(Kld::new(defaults()).is_ok());
    let bad = [
        defaults().error(0.0),
        defaults().certainty(KldCertainty::Confidence(1.0)),
        defaults().certainty(KldCertainty::Quantile(f64::NAN)),
        defaults().bin_position(-0.5),
        defaults().bin_heading(f64::NAN),
        settings(0, 10),
        settings(11, 10),
    ];
    for settings in bad {
        assert!(Kld::new(settings.clone()).is_err(), "{settings:?}");
    }
    let error = Kld::new(settings(11, 10)).unwrap_err().to_string();
    assert_eq!(error, "KldSettings.max_particles: expected at least min_particles, got 10");
}
