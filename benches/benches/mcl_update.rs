//! The whole update of Monte Carlo localization: motion, weighing, resampling, estimate.
//!
//! `plain` weighs once, as other localizers do, with a fixed number of particles; `tempered` is the
//! filter as its defaults have it. Both stand in the same map and see the same scan, from a cloud
//! about the true pose; every update drives 0.3 m, which is taken back by the next one.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_maps::{OccupancyGrid, RayCaster};
use loc_pf::adaptive::KldSettings;
use loc_pf::mcl::{MountedScan, RecoverySettings};
use loc_pf::{Mcl, MclSettings};
use loc_sensors::laser::{LaserNoise, LaserScan, LaserScanner, LaserSpec};

/// Where the scans of the bench were taken; free in the generated office as well.
const PLACE: Pose2 = Pose2 { x: 5.0, y: 5.0, theta: 0.3 };

fn scan(map: &OccupancyGrid, beams: usize) -> LaserScan {
    let spec = LaserSpec {
        angle_min: -std::f64::consts::PI,
        angle_increment: std::f64::consts::TAU / beams as f64,
        beams,
        range_max: 30.0,
        noise: LaserNoise { sigma: 0.02, sigma_per_m: 0.0 },
        ..LaserSpec::sick_lms100()
    };
    let laser = LaserScanner { spec, ..LaserScanner::default() };
    laser.scan(&RayCaster::new(map), PLACE, &mut stream(1, "scan"))
}

fn filter(particles: usize, beams: usize, threads: usize) -> MclSettings {
    let particles = KldSettings::default().min_particles(particles).max_particles(particles);
    let recovery = RecoverySettings::default().search(false).suspicion(None).augmented(None);
    MclSettings::default()
        .particles(particles)
        .beams(beams)
        .threads(threads)
        .recovery(recovery)
        .tempering(None)
}

/// Times updates of a filter that drives to and fro about the place.
fn time(bencher: &mut criterion::Bencher<'_>, map: &OccupancyGrid, settings: MclSettings) {
    let scan = scan(map, settings.beams);
    let scans = [MountedScan { scan: &scan, mounting: Pose2::IDENTITY }];
    let Ok(mut mcl) = Mcl::new(map, settings, stream(1, "mcl")) else { return };
    if mcl.start_at(&pose_belief(PLACE, [0.15, 0.15, 0.05])).is_err() {
        return;
    }
    let mut odometry = Pose2::IDENTITY;
    let mut forth = false;
    bencher.iter(|| {
        // The odometry goes to and fro; the scan says that the robot stays about its place.
        forth = !forth;
        odometry.x = if forth { 0.0 } else { 0.11 };
        mcl.update(odometry, &scans)
    });
}

fn bench(criterion: &mut Criterion) {
    let Ok(map) = loc_bench::map() else { return };
    let mut group = criterion.benchmark_group("mcl_update");
    for (particles, beams) in [(500, 60), (2000, 60), (2000, 180), (2000, 720), (10_000, 180)] {
        let name = format!("{particles}x{beams}");
        for threads in [1, 2] {
            let id = BenchmarkId::new(format!("plain_{threads}_threads"), &name);
            let settings = filter(particles, beams, threads);
            group.bench_function(id, |bencher| time(bencher, &map, settings.clone()));
        }
    }
    group.bench_function("tempered_defaults", |bencher| {
        time(bencher, &map, MclSettings::default());
    });
    group.finish();
}

criterion_group! { name = benches; config = loc_bench::criterion(); targets = bench }
criterion_main!(benches);
