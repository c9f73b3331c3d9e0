//! Rays of about 100 cells on the average: one at a time from anywhere in free space, and in fans
//! of 60 from one pose; the accelerated caster, and beside it the exact traversal as reference.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::RayCaster;
use loc_maps::grid::{Occupancy, OccupancyGrid};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use rand::RngExt;
use std::hint::black_box;

const RAYS: usize = 6000;
const BEAMS: usize = 60;
const MAX_RANGE: f64 = 30.0;

fn poses(grid: &OccupancyGrid, count: usize) -> Vec<Pose2> {
    let mut rng = stream(1, "rays");
    let free: Vec<Point2<f64>> = grid.centers_of(Occupancy::Free).collect();
    let mut pose = || {
        let place = free[rng.random_range(0..free.len())];
        let mut off = || rng.random_range(-0.5..0.5) * grid.resolution();
        let (x, y) = (place.x + off(), place.y + off());
        Pose2::new(x, y, rng.random_range(-3.1..3.1))
    };
    (0..count).map(|_| pose()).collect()
}

fn single(world: &impl RangeWorld, poses: &[Pose2]) -> f64 {
    let range = |pose: &Pose2| world.cast(&pose.position(), pose.theta, MAX_RANGE);
    poses.iter().map(|pose| range(pose).unwrap_or(MAX_RANGE)).sum()
}

fn fans(world: &impl RangeWorld, poses: &[Pose2]) -> f64 {
    let mut ranges = [0.0; BEAMS];
    let step = std::f64::consts::TAU / BEAMS as f64;
    let fan = |pose: &Pose2| {
        world.cast_fan(&pose.position(), pose.theta, step, MAX_RANGE, &mut ranges);
        ranges.iter().map(|range| range.min(MAX_RANGE)).sum::<f64>()
    };
    poses.iter().map(fan).sum()
}

fn rays(c: &mut Criterion) {
    let grid = loc_bench::map().expect("a map");
    let caster = RayCaster::new(&grid);
    let poses = poses(&grid, RAYS);
    let cells =
        single(&grid, &poses) / RAYS as f64 / grid.resolution() * 4.0 / std::f64::consts::PI;
    println!("mean ray {cells:.0} cells, memory {:.2} MiB", caster.bytes() as f64 / 1048576.0);

    let mut group = c.benchmark_group("raycast/single");
    group.throughput(Throughput::Elements(RAYS as u64));
    group.bench_function("exact", |b| b.iter(|| single(black_box(&grid), &poses)));
    group.bench_function("accelerated", |b| b.iter(|| single(black_box(&caster), &poses)));
    group.finish();

    let mut group = c.benchmark_group("raycast/fans");
    let poses = &poses[..RAYS / BEAMS];
    group.throughput(Throughput::Elements(RAYS as u64));
    group.bench_function("exact", |b| b.iter(|| fans(black_box(&grid), poses)));
    group.bench_function("accelerated", |b| b.iter(|| fans(black_box(&caster), poses)));
    group.finish();

    let mut group = c.benchmark_group("raycast/built");
    group.sample_size(10);
    group.bench_function("accelerated", |b| b.iter(|| RayCaster::new(black_box(&grid))));
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = rays);
criterion_main!(benches);
