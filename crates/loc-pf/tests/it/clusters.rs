//! Several hypotheses with their shares.

use approx::assert_abs_diff_eq;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2};
use loc_pf::Particles;
use loc_pf::estimate::{Cluster, ClusterSettings, Clusterer, PoseSource, moments};
use rand::RngExt;
use rand::seq::SliceRandom;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

fn clusters(poses: impl IntoIterator<Item = Pose2>) -> Vec<Cluster> {
    let mut clusterer = Clusterer::new(ClusterSettings::default()).unwrap();
    clusterer.clusters(&Particles::from_poses(poses))
}

fn cluster(at: Pose2, sigmas: [f64; 3], count: usize, seed: u64) -> Vec<Pose2> {
    let mut rng = stream(seed, "heap");
    let belief = pose_belief(at, sigmas);
    let mut draw = || Pose2::from_vector(&belief.sample(&mut rng));
    (0..count).map(|_| draw()).collect()
}

fn anywhere(side: f64, count: usize, seed: u64) -> Vec<Pose2> {
    let mut rng = stream(seed, "anywhere");
    let mut draw = |reach: f64| reach * (2.0 * rng.random::<f64>() - 1.0);
    (0..count).map(|_| Pose2::new(draw(0.5 * side), draw(0.5 * side), draw(PI))).collect()
}

/// Cells that touch, found by trying all 26 neighbours in a hash map: members of each component.
fn components(cloud: &Particles, cell: f64, headings: i64) -> Vec<Vec<usize>> {
    let mut members: HashMap<(i64, i64, i64), Vec<usize>> = HashMap::new();
    for (k, pose) in cloud.poses().iter().enumerate() {
        let square = |metres: f64| (metres / cell).round_ties_even() as i64;
        let heading = (pose.theta / TAU * headings as f64).floor() as i64;
        let heading = heading.rem_euclid(headings);
        members.entry((square(pose.x), square(pose.y), heading)).or_default().push(k);
    }
    let mut components = Vec::new();
    while let Some(&start) = members.keys().next() {
        let mut open = vec![start];
        let mut component = members.remove(&start).unwrap();
        while let Some((x, y, t)) = open.pop() {
            for (dx, dy, dt) in (0..27).map(|k| (k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)) {
                let near = (x + dx, y + dy, (t + dt).rem_euclid(headings));
                if let Some(more) = members.remove(&near) {
                    component.extend(more);
                    open.push(near);
                }
            }
        }
        component.sort_unstable();
        components.push(component);
    }
    components
}

/// Without valleys, clusters are the components, with their shares and moments.
fn assert_same_as_components(mut cloud: Particles, clusterer: &mut Clusterer, headings: i64) {
    cloud.normalize();
    let cell = clusterer.settings().cell;
    let mut expected: Vec<(f64, usize, Gaussian<3>)> = Vec::new();
    for component in components(&cloud, cell, headings) {
        let mut part = Particles::new();
        component.iter().for_each(|&k| part.push(cloud.pose(k), cloud.log_weights()[k]));
        expected.push((part.weights().sum(), component.len(), moments(&part)));
    }
    let found = clusterer.clusters(&cloud);
    assert_eq!(found.len(), expected.len());
    assert!(found.is_sorted_by(|a, b| a.share >= b.share));
    for (share, particles, belief) in expected {
        let same = |cluster: &&Cluster| {
            let mean = cluster.belief.pose_deviation(belief.pose());
            let covariance = cluster.belief.covariance - belief.covariance;
            cluster.particles == particles
                && (cluster.share - share).abs() < 1e-9
                && mean.amax() < 1e-9
                && covariance.amax() < 1e-9
        };
        assert_eq!(found.iter().filter(same).count(), 1, "{share} {particles} {belief:?}");
    }
}

#[test]
fn without_valleys_clusters_are_the_connected_components() {
    for (headings, cell) in [(24, 0.5), (3, 1.0), (64, 0.3), (18, 0.5)] {
        let heading_cell = TAU / headings as f64;
        let settings = ClusterSettings::default().cell(cell).heading_cell(heading_cell).valley(0.0);
        let mut clusterer = Clusterer::new(settings).unwrap();
        let mut rng = stream(5, "weights");
        for (side, count) in [(3.0, 40), (12.0, 300), (40.0, 2000), (12.0, 2000), (5000.0, 700)] {
            let mut cloud = Particles::from_poses(anywhere(side, count, count as u64));
            let weights = cloud.log_weights_mut().iter_mut();
            weights.for_each(|weight| *weight += 4.0 * rng.random::<f64>());
            assert_same_as_components(cloud, &mut clusterer, headings);
        }
        let tracked = cluster(Pose2::new(-2.0, 1.0, PI), [0.15, 0.15, 0.05], 500, 1);
        assert_same_as_components(Particles::from_poses(tracked), &mut clusterer, headings);
    }
}

#[test]
fn clusters_hold_together_across_pi() {
    let found = clusters(cluster(Pose2::new(2.0, -3.0, PI), [0.1, 0.1, 0.2], 1000, 1));
    assert_eq!(found.len(), 1);
    assert!(found[0].belief.mean.z.abs() > PI - 0.03);
    assert_abs_diff_eq!(found[0].belief.covariance.m33.sqrt(), 0.2, epsilon = 0.02);
}

#[test]
fn the_order_of_the_particles_does_not_matter() {
    let mut poses = anywhere(30.0, 3000, 2);
    poses.extend(cluster(Pose2::new(1.0, 1.0, 0.0), [0.4, 0.4, 0.3], 1500, 3));
    poses.extend(cluster(Pose2::new(4.0, 1.0, 0.0), [0.4, 0.4, 0.3], 1500, 4));
    let first = clusters(poses.iter().copied());
    for seed in 0..5 {
        poses.shuffle(&mut stream(seed, "order"));
        let other = clusters(poses.iter().copied());
        assert_eq!(other.len(), first.len());
        for (a, b) in first.iter().zip(&other) {
            assert_eq!(a.particles, b.particles);
            assert_abs_diff_eq!(a.share, b.share, epsilon = 1e-12);
            assert_abs_diff_eq!(a.belief.mean, b.belief.mean, epsilon = 1e-10);
            assert_abs_diff_eq!(a.belief.covariance, b.belief.covariance, epsilon = 1e-10);
        }
    }
}

#[test]
fn of_equal_clusters_the_lower_one_comes_first() {
    let pair = |at: Pose2| [at, at];
    let places =
        [Pose2::new(5.0, 5.0, 0.0), Pose2::new(-5.0, -5.0, 0.0), Pose2::new(0.0, -5.0, 0.0)];
    let found = clusters(places.into_iter().flat_map(pair));
    let means: Vec<[f64; 2]> = found.iter().map(|c| [c.belief.mean.x, c.belief.mean.y]).collect();
    assert_eq!(means, [[-5.0, -5.0], [0.0, -5.0], [5.0, 5.0]]);
}

/// Two modes 3 m apart with strays between them, the case for which touching is not enough.
#[test]
fn a_few_strays_between_two_modes_do_not_join_them() {
    for seed in 0..20 {
        let mut poses = cluster(Pose2::new(0.0, 0.0, 0.0), [0.15, 0.15, 0.05], 600, seed);
        poses.extend(cluster(Pose2::new(3.0, 0.0, 0.0), [0.15, 0.15, 0.05], 400, seed + 100));
        poses.extend((1..12).map(|k| Pose2::new(0.25 * f64::from(k), 0.0, 0.02)));
        let found = clusters(poses.iter().copied());
        assert_eq!(found.len(), 2, "seed {seed}");
        assert!(found[0].share > 0.59 && found[0].belief.mean.x.abs() < 0.1);
        assert!(found[1].share > 0.39 && (found[1].belief.mean.x - 3.0).abs() < 0.1);

        let settings = ClusterSettings::default().valley(0.0);
        let joined = Clusterer::new(settings).unwrap().clusters(&Particles::from_poses(poses));
        assert_eq!(joined.len(), 1);
    }
}

#[test]
fn opposite_headings_at_one_place_are_two_hypotheses() {
    let mut poses = cluster(Pose2::new(1.0, 1.0, 0.4), [0.1, 0.1, 0.1], 500, 1);
    poses.extend(cluster(Pose2::new(1.0, 1.0, 0.4 - PI), [0.1, 0.1, 0.1], 500, 2));
    let found = clusters(poses);
    assert_eq!(found.len(), 2);
    assert!((found[0].share - 0.5).abs() < 1e-9);
}

/// The other danger: one wide mode must not fall apart by the chance of drawing particles.
#[test]
fn one_mode_stays_one_however_wide_and_sparse() {
    for (sigmas, count) in [
        ([0.15, 0.15, 0.05], 500),
        ([0.5, 0.5, 0.2], 500),
        ([0.5, 0.5, 0.2], 10_000),
        ([1.0, 1.0, 0.3], 5000),
        ([3.0, 0.2, 0.1], 2000),
        ([2.0, 2.0, 0.3], 10_000),
    ] {
        for seed in 0..10 {
            let found = clusters(cluster(Pose2::new(3.0, 2.0, 3.0), sigmas, count, seed));
            assert!(found[0].share > 0.97, "{sigmas:?} {count} {seed}: {}", found[0].share);
        }
    }
}

/// The particles of 4000 that were left after a resampling with few survivors: copies that the
/// motion has moved apart a little.
#[test]
fn copies_of_few_particles_stay_together() {
    for seed in 0..10 {
        let parents = cluster(Pose2::new(0.0, 0.0, 1.0), [0.3, 0.3, 0.1], 40, seed);
        let copies = parents.iter().enumerate().flat_map(|(k, &parent)| {
            cluster(parent, [0.05, 0.05, 0.03], 100, seed * 100 + k as u64)
        });
        let found = clusters(copies);
        assert!(found[0].share > 0.97, "seed {seed}: {}", found[0].share);
    }
}

#[test]
fn the_pose_is_that_of_the_heaviest_cluster_or_of_all() {
    let mut poses = cluster(Pose2::new(0.0, 0.0, 0.0), [0.1, 0.1, 0.1], 600, 1);
    poses.extend(cluster(Pose2::new(10.0, 0.0, 0.0), [0.1, 0.1, 0.1], 400, 2));
    let cloud = Particles::from_poses(poses);
    let estimate = |pose| {
        let settings = ClusterSettings::default().pose(pose);
        Clusterer::new(settings).unwrap().estimate(&cloud)
    };
    let heaviest = estimate(PoseSource::HeaviestCluster);
    assert!(heaviest.belief.mean.x.abs() < 0.02 && heaviest.belief == heaviest.clusters[0].belief);
    assert_abs_diff_eq!(heaviest.share(), 0.6, epsilon = 1e-9);
    let whole = estimate(PoseSource::WholeCloud);
    assert!((whole.belief.mean.x - 4.0).abs() < 0.02 && whole.clusters.len() == 2);
}

#[test]
fn bad_particles_give_nothing_and_never_nan() {
    let mut clusterer = Clusterer::new(ClusterSettings::default()).unwrap();
    assert!(clusterer.clusters(&Particles::new()).is_empty());
    let empty = clusterer.estimate(&Particles::new());
    assert!(empty.share() == 0.0 && empty.belief.mean.iter().all(|value| value.is_finite()));

    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300];
    let mut cloud = Particles::new();
    for value in bad {
        cloud.push(Pose2 { x: value, y: 0.0, theta: 0.0 }, 0.0);
        cloud.push(Pose2 { x: 0.0, y: value, theta: 0.0 }, 0.0);
        cloud.push(Pose2 { x: 0.0, y: 0.0, theta: value }, 0.0);
    }
    assert!(clusterer.clusters(&cloud).is_empty());
    cloud.push(Pose2::new(1.0, 2.0, 3.0), -800.0);
    cloud.push(Pose2 { x: 9e8, y: -9e8, theta: 9e8 }, -801.0);
    cloud.push(Pose2::new(5.0, 2.0, 3.0), f64::NEG_INFINITY);
    // The particles that are no poses have all the weight there is, and still it does not count.
    let found = clusterer.clusters(&cloud);
    assert!(found.iter().all(|cluster| cluster.share.is_finite()), "{found:?}");

    let mut weightless = Particles::from_poses([Pose2::IDENTITY, Pose2::IDENTITY]);
    weightless.log_weights_mut().fill(f64::NEG_INFINITY);
    let found = clusterer.clusters(&weightless);
    assert!(found.len() == 1 && found[0].particles == 2);

    let fine = ClusterSettings::default().cell(1e-9).heading_cell(TAU / 64.0);
    let cloud = Particles::from_poses(anywhere(1e9, 500, 1));
    assert_eq!(Clusterer::new(fine).unwrap().clusters(&cloud).len(), 500);
}

#[test]
fn settings_out_of_range_are_refused() {
    let good = ClusterSettings::default();
    assert!(good.check().is_ok());
    for bad in [
        good.cell(0.0),
        good.cell(f64::NAN),
        good.heading_cell(0.01),
        good.heading_cell(3.0),
        good.valley(1.5),
    ] {
        assert!(Clusterer::new(bad).is_err(), "{bad:?}");
    }
}
