//! Rating poses by the beam model: 10000 particles about a tracked pose, scans of 60 and 180 beams
//! (those under `LOC_DATA_DIR`, else cast in the generated office); beside it the plain form, the
//! exact traversal of the map and the mixture computed for every ray. Also how long a scan takes
//! to prepare.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::sampling::box_muller;
use loc_maps::RayCaster;
use loc_maps::grid::OccupancyGrid;
use loc_pf::Particles;
use loc_pf::mcl::MountedScan;
use loc_pf::sensor::Likelihood;
use loc_pf::sensor::beam::{
    BeamLikelihood, BeamModel, BeamModelSettings, RangeModel, informative_beams,
};
use loc_sensors::laser::LaserScan;
use loc_sensors::world::RangeWorld;
use std::hint::black_box;
use std::path::Path;

const PARTICLES: usize = 10_000;
/// The plain form needs fewer to be measured.
const PLAIN: usize = 500;
const MAX_RANGE: f64 = 30.0;

/// The recorded scan, or one cast where the cloud is.
fn scan(grid: &OccupancyGrid, beams: usize) -> LaserScan {
    let step = std::f64::consts::TAU / beams as f64;
    let first = -std::f64::consts::PI;
    let mut ranges = vec![f64::INFINITY; beams];
    grid.cast_fan(&[5.0, 5.0].into(), 0.3 + first, step, MAX_RANGE, &mut ranges);
    if let Some(folder) = std::env::var_os("LOC_DATA_DIR") {
        let file = Path::new(&folder).join(format!("bench/synth_scan_{beams}.csv"));
        let text = std::fs::read_to_string(file).expect("the scan");
        let range = |line: &str| line.split(',').next().and_then(|word| word.parse().ok());
        ranges = text.lines().skip(1).map(|line| range(line).expect("a range")).collect();
    }
    LaserScan {
        angle_min: first,
        angle_max: first + step * (beams - 1) as f64,
        angle_increment: step,
        time_increment: 0.0,
        scan_time: 0.1,
        range_min: 0.0,
        range_max: MAX_RANGE,
        ranges,
        intensities: Vec::new(),
    }
}

fn cloud() -> Particles {
    let mut rng = stream(1, "particles");
    let mut about = |mean: f64, sigma: f64| mean + sigma * box_muller(&mut rng).0;
    let mut pose = || Pose2::new(about(5.0, 0.15), about(5.0, 0.15), about(0.3, 0.05));
    Particles::from_poses((0..PARTICLES).map(|_| pose()))
}

/// The beam model as most localizers do it.
fn plain(grid: &OccupancyGrid, model: &BeamModel, scan: &LaserScan, pose: Pose2) -> f64 {
    let beam = |(k, range): (usize, &f64)| {
        let expected = grid.cast(&pose.position(), pose.theta + scan.angle(k), MAX_RANGE);
        model.log_density(expected.unwrap_or(f64::INFINITY), *range)
    };
    scan.ranges.iter().enumerate().map(beam).sum()
}

fn beam_model(c: &mut Criterion) {
    let grid = loc_bench::map().expect("a map");
    let caster = RayCaster::new(&grid);
    let settings = BeamModelSettings::default().max_range(MAX_RANGE);
    let model = BeamModel::new(&settings).expect("valid");
    let mut cloud = cloud();
    for beams in [60, 180] {
        let scan = scan(&grid, beams);
        let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
        let used = informative_beams(&scan, beams);
        let prepare =
            || BeamLikelihood::new(&caster, &settings, &mounted, &used, 1.0).expect("valid");
        let likelihood = prepare();
        println!("{beams} beams: tables of {:.0} KiB", likelihood.bytes() as f64 / 1024.0);

        let mut group = c.benchmark_group(format!("beam-model/tracking, {beams} beams"));
        group.sample_size(10).throughput(Throughput::Elements((PARTICLES * beams) as u64));
        group.bench_function("loc-pf", |b| {
            b.iter(|| {
                let (poses, weights) = cloud.poses_and_log_weights();
                weights.fill(0.0);
                black_box(&likelihood).rate(poses, weights);
            });
        });
        group.throughput(Throughput::Elements((PLAIN * beams) as u64));
        group.bench_function("plain", |b| {
            let rate = |k: usize| plain(&grid, &model, black_box(&scan), cloud.pose(k));
            b.iter(|| (0..PLAIN).map(rate).sum::<f64>());
        });
        group.throughput(Throughput::Elements(beams as u64));
        group.bench_function("a scan prepared", |b| b.iter(prepare));
        group.finish();
    }
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = beam_model);
criterion_main!(benches);
