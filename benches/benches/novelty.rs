//! Sorting out the beams of a scan that hit people, before a tracking cloud of which 64 poses are
//! looked at: scans of 60 and 180 beams, as mapped and with 40 % of the beams cut short.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_maps::likelihood_field::LikelihoodFieldSettings;
use loc_maps::{LikelihoodField, RayCaster};
use loc_pf::Particles;
use loc_pf::mcl::MountedScan;
use loc_pf::novelty::{BeliefSample, DistanceFilter, EntropyFilter, by_field};
use loc_sensors::laser::LaserScan;
use loc_sensors::world::RangeWorld;
use std::hint::black_box;

fn scan(world: &impl RangeWorld, beams: usize, people: bool) -> LaserScan {
    let step = std::f64::consts::TAU / beams as f64;
    let mut ranges = vec![f64::INFINITY; beams];
    world.cast_fan(&[5.0, 5.0].into(), 0.3 - 3.0, step, 30.0, &mut ranges);
    let blocked = |k: usize| people && k % 5 < 2;
    let cut = |(k, range): (usize, f64)| if blocked(k) { 0.5 * range } else { range };
    LaserScan {
        angle_min: -3.0,
        angle_max: -3.0 + step * (beams - 1) as f64,
        angle_increment: step,
        time_increment: 0.0,
        scan_time: 0.1,
        range_min: 0.0,
        range_max: 30.0,
        ranges: ranges.into_iter().enumerate().map(cut).collect(),
        intensities: Vec::new(),
    }
}

fn novelty(c: &mut Criterion) {
    let grid = loc_bench::map().expect("a map");
    let caster = RayCaster::new(&grid);
    let settings = LikelihoodFieldSettings::nav2().max_range(30.0);
    let field = LikelihoodField::new(&grid, &settings).expect("valid");
    let belief = pose_belief(Pose2::new(5.0, 5.0, 0.3), [0.15, 0.15, 0.05]);
    let cloud = Particles::from_gaussian(&belief, 2000, &mut stream(1, "cloud"));
    let sample = BeliefSample::of(&cloud, 64);
    let mut group = c.benchmark_group("novelty");
    group.bench_function("sample of 2000 particles", |b| {
        b.iter(|| BeliefSample::of(black_box(&cloud), 64));
    });
    for (beams, people) in [(60, false), (60, true), (180, false), (180, true)] {
        let scan = scan(&grid, beams, people);
        let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
        let used: Vec<usize> = (0..beams).collect();
        let name = format!("{beams} beams, {}", if people { "40 % cut" } else { "as mapped" });
        let filter = DistanceFilter::default();
        group.bench_function(format!("distance, {name}"), |b| {
            b.iter(|| filter.keep(&caster, black_box(&sample), &mounted, &used));
        });
        let filter = EntropyFilter::default();
        group.bench_function(format!("entropy, {name}"), |b| {
            b.iter(|| filter.keep(by_field(&field), black_box(&sample), &mounted, &used));
        });
    }
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = novelty);
criterion_main!(benches);
