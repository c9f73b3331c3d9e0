//! Rating poses by the likelihood field: 2000 particles x 60 beams of one scan, about a tracked
//! pose and spread over the whole map; beside it the plain form, a row-major grid of f32 logarithms
//! read by double-precision transforms with a bounds check.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::sampling::box_muller;
use loc_maps::DistanceMap;
use loc_maps::grid::{Occupancy, OccupancyGrid};
use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
use nalgebra::Point2;
use rand::RngExt;
use std::hint::black_box;

const PARTICLES: usize = 2000;
const BEAMS: usize = 60;

fn scan() -> Vec<[f64; 2]> {
    let range = |k: usize| 3.0 + 2.0 * (k as f64 * 0.37).sin();
    let angle = |k: usize| k as f64 * std::f64::consts::TAU / BEAMS as f64;
    (0..BEAMS).map(|k| [range(k) * angle(k).cos(), range(k) * angle(k).sin()]).collect()
}

fn tracked() -> Vec<Pose2> {
    let mut rng = stream(1, "particles");
    let mut about = |mean: f64, sigma: f64| mean + sigma * box_muller(&mut rng).0;
    let mut pose = || Pose2::new(about(5.0, 0.15), about(5.0, 0.15), about(0.3, 0.05));
    (0..PARTICLES).map(|_| pose()).collect()
}

fn spread(grid: &OccupancyGrid) -> Vec<Pose2> {
    let mut rng = stream(1, "particles");
    let free: Vec<Point2<f64>> = grid.centers_of(Occupancy::Free).collect();
    let mut pose = || {
        let place = free[rng.random_range(0..free.len())];
        Pose2::new(place.x, place.y, rng.random_range(-3.1..3.1))
    };
    (0..PARTICLES).map(|_| pose()).collect()
}

/// A lookup as most localizers do it.
fn plain(field: &[f32], grid: &OccupancyGrid, pose: Pose2, scan: &[[f64; 2]]) -> f64 {
    let beam = |point: &[f64; 2]| {
        let end = pose.transform(&Point2::from(*point));
        let cell = grid.frame().cell_at(&end).and_then(|cell| grid.frame().index(cell));
        f64::from(cell.map_or(-3.0, |index| field[index]))
    };
    scan.iter().map(beam).sum()
}

fn lookups(c: &mut Criterion) {
    let grid = loc_bench::map().expect("a map");
    let settings = LikelihoodFieldSettings { max_range: 30.0, ..Default::default() };
    let field = LikelihoodField::new(&grid, &settings).expect("valid");
    let distances = DistanceMap::new(&grid, 2.0).expect("valid");
    let rows = distances.squared().iter();
    let row_major: Vec<f32> =
        rows.map(|&d| settings.likelihood(distances.to_metres(d)).ln() as f32).collect();
    let points = scan();
    let endpoints: Endpoints = points.iter().copied().collect();

    for (name, poses) in [("tracked", tracked()), ("spread", spread(&grid))] {
        let mut group = c.benchmark_group(format!("likelihood-field/{name}"));
        group.throughput(Throughput::Elements((PARTICLES * BEAMS) as u64));
        group.bench_function("loc-maps", |bencher| {
            let rate = |pose: &Pose2| field.log_likelihood(*pose, black_box(&endpoints));
            bencher.iter(|| poses.iter().map(rate).sum::<f64>());
        });
        group.bench_function("plain", |bencher| {
            let rate = |pose: &Pose2| plain(&row_major, &grid, *pose, black_box(&points));
            bencher.iter(|| poses.iter().map(rate).sum::<f64>());
        });
        group.finish();
    }
    let mut group = c.benchmark_group("likelihood-field/built");
    group.throughput(Throughput::Elements(grid.values().len() as u64));
    group.bench_function("loc-maps", |bencher| {
        bencher.iter(|| LikelihoodField::new(black_box(&grid), &settings).expect("valid"));
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = lookups);
criterion_main!(benches);
