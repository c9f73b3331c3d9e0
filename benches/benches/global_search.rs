//! Global search over 2000 x 2000 cells at 5 cm and 1 deg: a map made ready, and the best pose for
//! scans of 60, 180 and 720 beams, on one thread; 180 beams on two threads, with five candidates
//! refined, and with a fifth of the beams cut short. Beside it brute force, as fast as the
//! likelihood field rates poses: 50 x 50 cells about the true pose at all headings. Both report
//! poses a second; brute force over the whole map takes the ratio of the two longer, less what
//! the cache gains from the small piece.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::grid::{Cell, OccupancyGrid};
use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
use loc_maps::{GlobalSearch, SearchSettings};
use rand::RngExt;
use std::hint::black_box;
use std::path::Path;

/// Where the scans were taken.
const TRUTH: Pose2 = Pose2 { x: 5.0, y: 5.0, theta: 0.3 };

/// The scan that belongs to the map, or one of the generated office.
fn scan(map: &OccupancyGrid, beams: usize) -> Vec<(f64, f64)> {
    if let Some(folder) = std::env::var_os("LOC_DATA_DIR") {
        let file = Path::new(&folder).join(format!("bench/synth_scan_{beams}.csv"));
        let text = std::fs::read_to_string(file).expect("a scan");
        let lines = text.lines().skip(1).filter_map(|line| line.split_once(','));
        return lines
            .filter_map(|(r, angle)| Some((angle.parse().ok()?, r.parse().ok()?)))
            .collect();
    }
    let mut rng = stream(1, "scan");
    let angle = |k: usize| (k as f64 / beams as f64 - 0.5) * std::f64::consts::TAU;
    let mut ranges = vec![f64::INFINITY; beams];
    let (origin, step) = (TRUTH.position(), std::f64::consts::TAU / beams as f64);
    use loc_sensors::world::RangeWorld;
    map.cast_fan(&origin, TRUTH.theta + angle(0), step, 30.0, &mut ranges);
    let noisy = |(k, range): (usize, &f64)| (angle(k), range + rng.random_range(-0.03..0.03));
    ranges.iter().enumerate().map(noisy).collect()
}

fn ends(scan: &[(f64, f64)]) -> Endpoints {
    let (angles, ranges): (Vec<f64>, Vec<f64>) = scan.iter().copied().unzip();
    Endpoints::from_scan(&angles, &ranges)
}

/// A fifth of the beams ends on people.
fn blocked(scan: &[(f64, f64)]) -> Endpoints {
    let mut rng = stream(2, "people");
    let shorten = |&(angle, range): &(f64, f64)| {
        let share: f64 = if rng.random::<f64>() < 0.2 { rng.random() } else { 1.0 };
        (angle, range * share)
    };
    ends(&scan.iter().map(shorten).collect::<Vec<_>>())
}

fn global_search(c: &mut Criterion) {
    let map = loc_bench::map().expect("a map");
    let settings = LikelihoodFieldSettings::nav2().max_range(30.0);
    let field = LikelihoodField::new(&map, &settings).expect("valid");
    let one = SearchSettings { candidates: 1, refine: false, ..Default::default() };
    let build = |settings: &SearchSettings| {
        GlobalSearch::new(&map, field.clone(), settings.clone()).expect("free cells")
    };
    let mut group = c.benchmark_group("global-search");
    group.sample_size(10);
    group.bench_function("built", |bencher| bencher.iter(|| build(black_box(&one))));

    let single = build(&one);
    let poses = map.counts().free as u64 * 360;
    group.throughput(Throughput::Elements(poses));
    for beams in [60, 180, 720] {
        let ends = ends(&scan(&map, beams));
        let found = single.search(&ends).expect("beams");
        assert!(found[0].pose.distance(TRUTH) < 0.1, "{found:?}");
        let id = BenchmarkId::new("best", beams);
        group.bench_function(id, |bencher| bencher.iter(|| single.search(black_box(&ends))));
    }
    let scan = scan(&map, 180);
    let (ends, blocked) = (ends(&scan), blocked(&scan));
    let two = build(&SearchSettings { threads: 2, ..one.clone() });
    let five = build(&SearchSettings::default());
    for (name, search, ends) in [
        ("best, 2 threads", &two, &ends),
        ("five refined", &five, &ends),
        ("best, blocked", &single, &blocked),
    ] {
        let id = BenchmarkId::new(name, 180);
        group.bench_function(id, |bencher| bencher.iter(|| search.search(black_box(ends))));
    }

    let (xs, ys, thetas) = piece(&map);
    let mut rated = vec![0.0; xs.len()];
    group.throughput(Throughput::Elements(xs.len() as u64));
    group.bench_function(BenchmarkId::new("brute force, 50 x 50 cells", 180), |bencher| {
        bencher.iter(|| {
            field.log_likelihoods([&xs, &ys, &thetas], black_box(&ends), &mut rated);
            rated.iter().copied().fold(f64::NEG_INFINITY, f64::max)
        });
    });
    group.finish();
}

/// All poses of 50 x 50 cells about the true one.
fn piece(map: &OccupancyGrid) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let (mut xs, mut ys, mut thetas) = (Vec::new(), Vec::new(), Vec::new());
    let middle = map.frame().cell_at(&TRUTH.position()).expect("on the map");
    for heading in 0..360_u16 {
        for cell in 0..2500 {
            let [column, row] = [middle.column + cell % 50, middle.row + cell / 50];
            let at = map.frame().center(Cell::new(column - 25, row - 25));
            xs.push(at.x);
            ys.push(at.y);
            thetas.push(f64::from(heading).to_radians());
        }
    }
    (xs, ys, thetas)
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = global_search);
criterion_main!(benches);
