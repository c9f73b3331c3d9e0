//! Rays of about 100 cells on the average, in fans of 60 from the poses of a tracking filter and
//! from poses anywhere in free space, by fans and one by one; the accelerated caster, and beside
//! it the exact traversal as reference.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::sampling::box_muller;
use loc_maps::RayCaster;
use loc_maps::grid::{Occupancy, OccupancyGrid};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use rand::RngExt;
use std::hint::black_box;

const RAYS: usize = 6000;
const BEAMS: usize = 60;
const MAX_RANGE: f64 = 30.0;

fn free(grid: &OccupancyGrid) -> Vec<Point2<f64>> {
    grid.centers_of(Occupancy::Free).collect()
}

/// Poses about the free place nearest to (5, 5), as a filter that tracks the robot has them.
fn tracked(grid: &OccupancyGrid, count: usize) -> Vec<Pose2> {
    let far = |place: &Point2<f64>| nalgebra::distance(place, &Point2::new(5.0, 5.0));
    let places = free(grid);
    let place = places.iter().min_by(|a, b| far(a).total_cmp(&far(b))).expect("a free cell");
    let mut rng = stream(1, "tracked");
    let mut about = |mean: f64, sigma: f64| mean + sigma * box_muller(&mut rng).0;
    let mut pose = || Pose2::new(about(place.x, 0.15), about(place.y, 0.15), about(0.3, 0.05));
    (0..count).map(|_| pose()).collect()
}

/// Poses anywhere in free space.
fn spread(grid: &OccupancyGrid, count: usize) -> Vec<Pose2> {
    let mut rng = stream(1, "spread");
    let free = free(grid);
    let mut pose = || {
        let place = free[rng.random_range(0..free.len())];
        let mut off = || rng.random_range(-0.5..0.5) * grid.resolution();
        let (x, y) = (place.x + off(), place.y + off());
        Pose2::new(x, y, rng.random_range(-3.1..3.1))
    };
    (0..count).map(|_| pose()).collect()
}

/// The rays of fans one by one.
fn beams(poses: &[Pose2]) -> Vec<Pose2> {
    let step = std::f64::consts::TAU / BEAMS as f64;
    let beams = |pose: &Pose2| {
        let Pose2 { x, y, theta } = *pose;
        (0..BEAMS).map(move |k| Pose2::new(x, y, theta + k as f64 * step))
    };
    poses.iter().flat_map(beams).collect()
}

/// Cells that a ray passes on the average.
fn mean_cells(grid: &OccupancyGrid, rays: &[Pose2]) -> f64 {
    let cells = |pose: &Pose2| {
        let range = grid.cast(&pose.position(), pose.theta, MAX_RANGE).unwrap_or(MAX_RANGE);
        let (sin, cos) = (pose.theta - grid.origin().theta).sin_cos();
        range / grid.resolution() * (sin.abs() + cos.abs())
    };
    rays.iter().map(cells).sum::<f64>() / rays.len() as f64
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
    println!("memory of the accelerated caster: {:.2} MiB", caster.bytes() as f64 / 1048576.0);
    let count = RAYS / BEAMS;
    let clouds = [("tracked", tracked(&grid, count)), ("spread", spread(&grid, count))];
    for (name, poses) in &clouds {
        let rays = beams(poses);
        println!("{name}: {:.0} cells a ray on the average", mean_cells(&grid, &rays));
        let mut group = c.benchmark_group(format!("raycast/{name}"));
        group.throughput(Throughput::Elements(RAYS as u64));
        group.bench_function("exact, single", |b| b.iter(|| single(black_box(&grid), &rays)));
        group.bench_function("exact, fans", |b| b.iter(|| fans(black_box(&grid), poses)));
        group.bench_function("accelerated, single", |b| {
            b.iter(|| single(black_box(&caster), &rays));
        });
        group.bench_function("accelerated, fans", |b| b.iter(|| fans(black_box(&caster), poses)));
        group.finish();
    }

    let rays = spread(&grid, RAYS);
    let mut group = c.benchmark_group("raycast/each ray from elsewhere");
    group.throughput(Throughput::Elements(RAYS as u64));
    group.bench_function("exact", |b| b.iter(|| single(black_box(&grid), &rays)));
    group.bench_function("accelerated", |b| b.iter(|| single(black_box(&caster), &rays)));
    group.finish();

    let mut group = c.benchmark_group("raycast/built");
    group.sample_size(10);
    group.bench_function("accelerated", |b| b.iter(|| RayCaster::new(black_box(&grid))));
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = rays);
criterion_main!(benches);
