//! Resampling a cloud of 2000, 10000 and 100000 particles, from logarithms of weights to copied
//! poses: every scheme, and beside them the spoke wheel in its plain form. Then KLD-sampling of a
//! tracking cloud of 10000. One thread.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, gaussian::pose_belief};
use loc_pf::resample::CumulativeWeights;
use loc_pf::{Kld, KldSettings, Particles, Resampling};
use rand::RngExt;
use std::hint::black_box;

/// A tracking cloud after a measurement that leaves about half of the particles effective.
fn cloud(particles: usize) -> Particles {
    let mut rng = stream(1, "particles");
    let belief = pose_belief(Pose2::new(5.0, 5.0, 0.3), [0.15, 0.15, 0.05]);
    let mut cloud = Particles::from_gaussian(&belief, particles, &mut rng);
    let (poses, weights) = cloud.poses_and_log_weights();
    for (pose, weight) in poses.iter().zip(weights) {
        *weight -= 0.5 * ((pose.x - 5.05) / 0.1_f64).powi(2);
    }
    cloud.normalize();
    cloud
}

/// One pass with a loop that asks at every sector how many spokes it holds, and tuples copied.
fn plain(cloud: &Particles, poses: &mut Vec<Pose2>, rng: &mut ChaCha8Rng) {
    poses.clear();
    let spacing = 1.0 / cloud.len() as f64;
    let (mut spoke, mut passed) = (spacing * rng.random::<f64>(), 0.0);
    for (pose, weight) in cloud.poses().iter().zip(cloud.log_weights()) {
        passed += weight.exp();
        while spoke < passed {
            poses.push(pose);
            spoke += spacing;
        }
    }
}

fn resampling(c: &mut Criterion) {
    let mut group = c.benchmark_group("resampling");
    for particles in [2000, 10_000, 100_000] {
        group.throughput(Throughput::Elements(particles as u64));
        let (cloud, mut rng) = (cloud(particles), stream(1, "filter"));
        let (mut wheel, mut indices, mut drawn) =
            (CumulativeWeights::new(), Vec::new(), Particles::new());
        for scheme in Resampling::ALL {
            let name = format!("{scheme:?}").to_lowercase();
            group.bench_function(BenchmarkId::new(name, particles), |b| {
                b.iter(|| {
                    wheel.set(black_box(&cloud).log_weights());
                    scheme.draw_from(&wheel, particles, &mut rng, &mut indices);
                    drawn.copy_selected(&cloud, &indices);
                });
            });
        }
        let mut poses = Vec::new();
        group.bench_function(BenchmarkId::new("plain-systematic", particles), |b| {
            b.iter(|| plain(black_box(&cloud), &mut poses, &mut rng));
        });
    }
    group.finish();
    kld(c);
    weights(c);
}

fn kld(c: &mut Criterion) {
    let belief = pose_belief(Pose2::new(5.0, 5.0, 0.3), [0.15, 0.15, 0.05]);
    let mut rng = stream(1, "particles");
    let cloud = Particles::from_gaussian(&belief, 10_000, &mut rng);
    let settings = KldSettings::default().max_particles(10_000);
    let mut kld = Kld::new(settings).expect("valid");
    let (mut wheel, mut indices, mut drawn) =
        (CumulativeWeights::new(), Vec::new(), Particles::new());
    c.bench_function("kld-resampling/tracking/10000", |b| {
        b.iter(|| {
            wheel.set(black_box(&cloud).log_weights());
            kld.draw(Resampling::Systematic, &wheel, cloud.poses(), &mut rng, &mut indices);
            drawn.copy_selected(&cloud, &indices);
        });
    });
    println!("KLD-sampling asked for {} particles, {} bins", drawn.len(), kld.bins());
}

fn weights(c: &mut Criterion) {
    let mut group = c.benchmark_group("weights");
    group.throughput(Throughput::Elements(10_000));
    let mut cloud = cloud(10_000);
    group.bench_function("normalize", |b| b.iter(|| black_box(&mut cloud).normalize()));
    group.bench_function("effective-sample-size", |b| {
        b.iter(|| black_box(&cloud).effective_sample_size());
    });
    let mut wheel = CumulativeWeights::new();
    group.bench_function("wheel", |b| b.iter(|| wheel.set(black_box(&cloud).log_weights())));
    group.finish();
}

criterion_group! { name = benches; config = loc_bench::criterion(); targets = resampling }
criterion_main!(benches);
