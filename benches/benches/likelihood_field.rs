//! Rating poses by the likelihood field, on the workload on which other localizers were timed:
//! clouds about a tracked pose and over the whole map; beside it the plain form, a row-major grid
//! of f32 logarithms read by double-precision transforms with a bounds check. Figures are of one
//! particle-beam.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, gaussian::pose_belief};
use loc_maps::DistanceMap;
use loc_maps::grid::OccupancyGrid;
use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
use loc_pf::initial::FreeSpace;
use loc_pf::sensor::{BeamSkip, FieldLikelihood, SumOfCubes};
use loc_pf::{Particles, Workers};
use nalgebra::Point2;
use std::hint::black_box;

fn settings() -> LikelihoodFieldSettings {
    LikelihoodFieldSettings::nav2().max_range(30.0)
}

/// The field, and what the plain form reads.
struct Maps {
    grid: OccupancyGrid,
    field: LikelihoodField,
    row_major: Vec<f32>,
}

fn maps() -> Maps {
    let (grid, settings) = (loc_bench::map().expect("a map"), settings());
    let field = LikelihoodField::new(&grid, &settings).expect("valid");
    let distances = DistanceMap::new(&grid, settings.max_distance).expect("valid");
    let squared = distances.squared().iter();
    let log_likelihood = |&d| settings.likelihood(distances.to_metres(d)).ln() as f32;
    let row_major = squared.map(log_likelihood).collect();
    Maps { grid, field, row_major }
}

/// A scan as long as those of a room, of beams all round.
fn scan(beams: usize) -> Vec<[f64; 2]> {
    let range = |k: usize| 3.0 + 2.0 * (k as f64 * 22.2 / beams as f64).sin();
    let angle = |k: usize| k as f64 * std::f64::consts::TAU / beams as f64;
    (0..beams).map(|k| [range(k) * angle(k).cos(), range(k) * angle(k).sin()]).collect()
}

fn tracked(count: usize) -> Particles {
    let belief: Gaussian<3> = pose_belief(Pose2::new(5.0, 5.0, 0.3), [0.15, 0.15, 0.05]);
    Particles::from_gaussian(&belief, count, &mut stream(1, "particles"))
}

fn spread(count: usize, grid: &OccupancyGrid) -> Particles {
    let mut rng = stream(1, "particles");
    let free_space = FreeSpace::new(grid).expect("free cells");
    Particles::from_poses((0..count).map(|_| free_space.draw(&mut rng)))
}

/// A lookup as most localizers do it.
fn plain(maps: &Maps, pose: Pose2, scan: &[[f64; 2]]) -> f64 {
    let frame = maps.grid.frame();
    let beam = |point: &[f64; 2]| {
        let end = pose.transform(&Point2::from(*point));
        let cell = frame.cell_at(&end).and_then(|cell| frame.index(cell));
        f64::from(cell.map_or(-3.0, |index| maps.row_major[index]))
    };
    scan.iter().map(beam).sum()
}

fn rating(c: &mut Criterion) {
    let maps = maps();
    let field = &maps.field;
    let tracked = [2000, 10_000].map(|count| ("tracked", tracked(count)));
    let spread = ("spread", spread(100_000, &maps.grid));
    for (name, cloud) in tracked.into_iter().chain([spread]) {
        let all: &[usize] = if name == "spread" { &[60] } else { &[60, 180, 720] };
        for &beams in all {
            let points = scan(beams);
            let endpoints: Endpoints = points.iter().copied().collect();
            let count = cloud.len();
            let mut group = c.benchmark_group(format!("likelihood-field/{name}/{count}x{beams}"));
            group.throughput(Throughput::Elements((count * beams) as u64)).sample_size(20);
            for threads in if (count, beams) == (10_000, 180) { 1..=2 } else { 1..=1 } {
                let workers = Workers::new(threads).expect("threads");
                let (mut cloud, endpoints) = (cloud.clone(), black_box(&endpoints));
                let measurement = FieldLikelihood { field, endpoints, exponent: 1.0 };
                group.bench_function(format!("threads-{threads}"), |bencher| {
                    bencher.iter(|| workers.rate(&mut cloud, &measurement));
                });
            }
            group.bench_function("plain", |bencher| {
                let rate = |pose: Pose2| plain(&maps, pose, black_box(&points));
                bencher.iter(|| cloud.poses().iter().map(rate).sum::<f64>());
            });
            group.finish();
        }
    }
}

fn variants(c: &mut Criterion) {
    let Maps { field, .. } = maps();
    let endpoints: Endpoints = scan(180).into_iter().collect();
    let mut cloud = tracked(10_000);
    let mut group = c.benchmark_group("likelihood-field/variants/10000x180");
    group.throughput(Throughput::Elements(10_000 * 180)).sample_size(20);
    group.bench_function("sum-of-cubes", |bencher| {
        let measurement = SumOfCubes::new(&field, black_box(&endpoints));
        bencher.iter(|| Workers::one().rate(&mut cloud, &measurement));
    });
    group.bench_function("beam-skip", |bencher| {
        let skip = BeamSkip::default();
        bencher.iter(|| skip.apply(&field, cloud.poses(), black_box(&endpoints)));
    });
    group.finish();
}

fn building(c: &mut Criterion) {
    let grid = loc_bench::map().expect("a map");
    let mut group = c.benchmark_group("likelihood-field/built");
    group.throughput(Throughput::Elements(grid.values().len() as u64)).sample_size(10);
    group.bench_function("loc-maps", |bencher| {
        bencher.iter(|| LikelihoodField::new(black_box(&grid), &settings()).expect("valid"));
    });
    group.finish();
}

criterion_group!(
    name = benches;
    config = loc_bench::criterion();
    targets = rating, variants, building
);
criterion_main!(benches);
