//! The clusters of a cloud with mean and covariance: about a tracked pose, and spread over a map
//! of 100 m x 100 m; beside it the plain form, hash maps of the standard library with a flood fill
//! over 26 neighbours.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2};
use loc_pf::Particles;
use loc_pf::estimate::{ClusterSettings, Clusterer, moments};
use rand::RngExt;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;

fn tracking(count: usize) -> Particles {
    let belief = pose_belief(Pose2::new(5.0, 5.0, 0.3), [0.15, 0.15, 0.05]);
    Particles::from_gaussian(&belief, count, &mut stream(1, "cloud"))
}

fn global(count: usize) -> Particles {
    let mut rng = stream(1, "cloud");
    let mut draw = |low: f64, high: f64| rng.random_range(low..high);
    let poses = (0..count).map(|_| Pose2::new(draw(0.0, 100.0), draw(0.0, 100.0), draw(-PI, PI)));
    Particles::from_poses(poses)
}

/// The same cloud with weights that differ.
fn weighted(mut cloud: Particles) -> Particles {
    let mut rng = stream(1, "weights");
    cloud.log_weights_mut().iter_mut().for_each(|weight| *weight += 3.0 * rng.random::<f64>());
    cloud.normalize();
    cloud
}

type Cell = (i64, i64, i64);

/// Shares and moments of the connected components, as one would write it down first.
fn plain(cloud: &Particles) -> Vec<(f64, Gaussian<3>)> {
    let mut members: HashMap<Cell, Vec<usize>> = HashMap::new();
    for (k, pose) in cloud.poses().iter().enumerate() {
        let heading = ((pose.theta / (TAU / 24.0)).floor() as i64).rem_euclid(24);
        let cell = ((pose.x / 0.5).round() as i64, (pose.y / 0.5).round() as i64, heading);
        members.entry(cell).or_default().push(k);
    }
    let mut clusters: Vec<(f64, Gaussian<3>)> = Vec::new();
    while let Some(&start) = members.keys().next() {
        let mut open = vec![start];
        let mut cluster = members.remove(&start).unwrap_or_default();
        while let Some((x, y, heading)) = open.pop() {
            for (dx, dy, dt) in (0..27).map(|k| (k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)) {
                let near = (x + dx, y + dy, (heading + dt).rem_euclid(24));
                if let Some(more) = members.remove(&near) {
                    cluster.extend(more);
                    open.push(near);
                }
            }
        }
        let mut part = Particles::new();
        cluster.iter().for_each(|&k| part.push(cloud.pose(k), cloud.log_weights()[k]));
        let share: f64 = part.weights().sum();
        clusters.push((share, moments(&part)));
    }
    clusters.sort_by(|a, b| b.0.total_cmp(&a.0));
    clusters
}

fn clusters(c: &mut Criterion) {
    let clouds = [
        ("tracking", tracking(2000)),
        ("tracking", tracking(10_000)),
        ("tracking", tracking(100_000)),
        ("weighted", weighted(tracking(10_000))),
        ("global", global(10_000)),
        ("global", global(100_000)),
        ("global-weighted", weighted(global(100_000))),
    ];
    let mut clusterer = Clusterer::new(ClusterSettings::default()).expect("valid");
    for (name, cloud) in &clouds {
        let mut group = c.benchmark_group(format!("clusters/{name}"));
        group.throughput(Throughput::Elements(cloud.len() as u64));
        group.bench_function(BenchmarkId::new("loc-pf", cloud.len()), |bencher| {
            bencher.iter(|| clusterer.clusters(black_box(cloud)));
        });
        group.bench_function(BenchmarkId::new("plain", cloud.len()), |bencher| {
            bencher.iter(|| plain(black_box(cloud)));
        });
        group.bench_function(BenchmarkId::new("moments-alone", cloud.len()), |bencher| {
            bencher.iter(|| moments(black_box(cloud)));
        });
        group.finish();
    }
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = clusters);
criterion_main!(benches);
