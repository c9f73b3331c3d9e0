//! A full scan of a UST-10LX (1081 beams) with noise on the bench map, through the ray caster,
//! beside the same scan written out plainly: one exact walk over the grid and one normal number of
//! Box and Muller for each beam. The rays alone show what is left for the scanner. Then the lines
//! in that scan.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::random::stream;
use loc_core::sampling::box_muller;
use loc_core::{Pose2, Twist2};
use loc_maps::{OccupancyGrid, RayCaster};
use loc_sensors::features::LineExtractor;
use loc_sensors::laser::{LaserFaults, LaserScanner, LaserSpec};
use loc_sensors::world::RangeWorld;
use rand::Rng;
use std::hint::black_box;

/// The plain loop.
fn bare(world: &OccupancyGrid, pose: Pose2, spec: &LaserSpec, rng: &mut impl Rng) -> Vec<f64> {
    let mut ranges = Vec::with_capacity(spec.beams);
    for k in 0..spec.beams {
        let direction = pose.theta + spec.angle_min + k as f64 * spec.angle_increment;
        let range = world.cast(&pose.position(), direction, spec.range_max);
        let noise = spec.noise.sigma * box_muller(rng).0;
        ranges.push(range.map_or(f64::INFINITY, |range| range + noise));
    }
    ranges
}

fn scan(c: &mut Criterion) {
    let grid = loc_bench::map().expect("the bench map");
    let (world, pose) = (RayCaster::new(&grid), Pose2::new(5.0, 5.0, 0.3));
    let spec = LaserSpec::hokuyo_ust_10lx();
    let scanner = LaserScanner::new(spec).expect("valid");
    let mut rng = stream(1, "laser");
    let mut group = c.benchmark_group("laser-scan/ust-10lx");
    group.throughput(Throughput::Elements(spec.beams as u64));

    group.bench_function("loc-sensors", |bencher| {
        bencher.iter(|| scanner.scan(black_box(&world), black_box(pose), &mut rng));
    });
    let faults = LaserFaults { dropout: 0.02, erroneous: 0.01, short: 0.05 };
    let faulty = LaserScanner { faults, ..scanner };
    group.bench_function("loc-sensors, moving, with faults", |bencher| {
        let twist = Twist2::forward(0.5, 0.3);
        bencher.iter(|| faulty.scan_moving(black_box(&world), black_box(pose), twist, &mut rng));
    });
    group.bench_function("plain loop", |bencher| {
        bencher.iter(|| bare(black_box(&grid), black_box(pose), &spec, &mut rng));
    });
    let mut ranges = vec![0.0; spec.beams];
    group.bench_function("the rays alone", |bencher| {
        bencher.iter(|| {
            let first = pose.theta + spec.angle_min;
            let (step, reach) = (spec.angle_increment, spec.range_max);
            world.cast_fan(black_box(&pose.position()), first, step, reach, &mut ranges);
        });
    });
    group.finish();

    let seen = scanner.scan(&world, pose, &mut rng);
    let extractor = LineExtractor::new(spec.noise);
    c.bench_function("line-extraction/ust-10lx", |bencher| {
        bencher.iter(|| extractor.extract(black_box(&seen)).expect("a valid scan"));
    });
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = scan);
criterion_main!(benches);
