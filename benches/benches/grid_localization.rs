//! One update of Markov localization over a whole map, 0.2 m x 5 deg, 60 beams, on one thread: a
//! scan and a drive of half a metre, for a robot of which nothing is known, for a belief spread
//! over the map, and for a robot that is followed in the fine grid. Beside it a plain grid filter:
//! each cell is rated in its middle only, by the likelihood field, and each layer of headings is
//! shifted by whole cells. The map is that of the Intel lab under `LOC_DATA_DIR`, with a scan that
//! it was not made from; else an office of the same size.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2};
use loc_filters::histogram::{GridLocalizer, GridSettings};
use loc_maps::LikelihoodField;
use loc_maps::grid::{Cell, Occupancy, OccupancyGrid, io};
use loc_maps::likelihood_field::Endpoints;
use loc_maps::worlds::{self, WorldSettings};
use loc_sensors::laser::{Beam, LaserScan, LaserScanner, LaserSpec};
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::path::Path;

/// The scan of the log that is used, an odd one.
const NUMBER: usize = 401;

/// What odometry reports between two scans.
const STEP: Pose2 = Pose2 { x: 0.5, y: 0.0, theta: 0.1 };

fn intel(folder: &Path) -> (OccupancyGrid, LaserScan, Pose2) {
    let map = io::load(folder.join("carmen/intel_even.yaml")).expect("a map");
    let log = std::fs::read_to_string(folder.join("carmen/intel.log")).expect("a log");
    let line = log.lines().filter(|line| line.starts_with("FLASER")).nth(NUMBER).expect("a scan");
    let numbers: Vec<f64> = line.split(' ').skip(1).map_while(|word| word.parse().ok()).collect();
    let (ranges, rest) = numbers[1..].split_at(numbers[0] as usize);
    let increment = PI / ranges.len() as f64;
    let scan = LaserScan {
        angle_min: -0.5 * PI,
        angle_max: 0.5 * PI - increment,
        angle_increment: increment,
        time_increment: 0.0,
        scan_time: 0.0,
        range_min: 0.0,
        range_max: 80.0,
        ranges: ranges.to_vec(),
        intensities: Vec::new(),
    };
    (map, scan, Pose2::new(rest[0], rest[1], rest[2]))
}

fn office() -> (OccupancyGrid, LaserScan, Pose2) {
    let settings = WorldSettings { width: 580, height: 580, resolution: 0.05, seed: 1 };
    let map = worlds::office(&settings).expect("an office").grid;
    let laser = LaserScanner::new(LaserSpec::sick_lms100()).expect("a laser");
    let robot = Pose2::new(3.0, 2.5, 1.2);
    let scan = laser.scan(&map, robot, &mut stream(1, "sensor"));
    (map, scan, robot)
}

/// The plain filter: a probability for each heading and square, and the squares that are free.
struct Plain {
    field: LikelihoodField,
    xs: Vec<f64>,
    ys: Vec<f64>,
    free: Vec<bool>,
    columns: usize,
    cell: f64,
    headings: usize,
    belief: Vec<f64>,
}

impl Plain {
    fn new(map: &OccupancyGrid, settings: &GridSettings) -> Self {
        let field = LikelihoodField::new(map, &settings.field).expect("valid");
        let side = (settings.cell / map.resolution()).round() as usize;
        let (columns, rows) = (map.width() / side, map.height() / side);
        let middle =
            |k: usize| Cell::new(k % columns * side + side / 2, k / columns * side + side / 2);
        let centers: Vec<_> = (0..columns * rows).map(|k| map.frame().center(middle(k))).collect();
        let free: Vec<bool> =
            centers.iter().map(|center| map.occupancy_at(center) == Occupancy::Free).collect();
        let headings = (TAU / settings.heading).round() as usize;
        let belief = vec![1.0 / (free.len() * headings) as f64; free.len() * headings];
        Plain {
            field,
            xs: centers.iter().map(|center| center.x).collect(),
            ys: centers.iter().map(|center| center.y).collect(),
            free,
            columns,
            cell: settings.cell,
            headings,
            belief,
        }
    }

    fn heading(&self, layer: usize) -> f64 {
        TAU * layer as f64 / self.headings as f64
    }

    /// Each layer by whole cells, then a blur of three cells along both axes and the headings.
    fn predict(&mut self, step: Pose2) {
        let length = self.free.len();
        let turned = (step.theta * self.headings as f64 / TAU).round() as usize;
        let mut after = vec![0.0; self.belief.len()];
        for layer in 0..self.headings {
            let (sin, cos) = self.heading(layer).sin_cos();
            let across = ((cos * step.x - sin * step.y) / self.cell).round() as isize;
            let up = ((sin * step.x + cos * step.y) / self.cell).round() as isize;
            let shift = up * self.columns as isize + across;
            let from = &self.belief[layer * length..(layer + 1) * length];
            let to = (layer + turned) % self.headings * length;
            for (k, p) in from.iter().enumerate() {
                let place = k as isize + shift;
                if (0..length as isize).contains(&place) {
                    after[to + place as usize] += p;
                }
            }
        }
        for stride in [1, self.columns, length] {
            let before = after.clone();
            for k in stride..before.len() - stride {
                after[k] = 0.25 * (before[k - stride] + before[k + stride]) + 0.5 * before[k];
            }
        }
        self.belief = after;
    }

    fn correct(&mut self, ends: &Endpoints, exponent: f64) -> f64 {
        let length = self.free.len();
        let mut logs = vec![0.0; length];
        let mut highest = f64::NEG_INFINITY;
        for layer in 0..self.headings {
            let thetas = vec![self.heading(layer); length];
            self.field.log_likelihoods([&self.xs, &self.ys, &thetas], ends, &mut logs);
            for (k, log) in logs.iter().enumerate() {
                let p = &mut self.belief[layer * length + k];
                *p = if self.free[k] { (*p).ln() + exponent * log } else { f64::NEG_INFINITY };
                highest = highest.max(*p);
            }
        }
        self.belief.iter_mut().for_each(|log| *log = (*log - highest).exp());
        let sum: f64 = self.belief.iter().sum();
        self.belief.iter_mut().for_each(|p| *p /= sum);
        highest
    }
}

fn ends(scan: &LaserScan, settings: &GridSettings) -> Endpoints {
    let points = scan.thinned(settings.beams).into_iter().map(Beam::point);
    points.map(|end| [end.x, end.y]).collect()
}

fn grid_localization(c: &mut Criterion) {
    let folder = std::env::var_os("LOC_DATA_DIR");
    let (map, scan, truth) = folder.map_or_else(office, |folder| intel(Path::new(&folder)));
    let settings = GridSettings::default();
    let lost = GridLocalizer::new(&map, settings).expect("a map");
    let mut group = c.benchmark_group("grid-localization");
    group.sample_size(10);

    // The way leads to where the scan was taken.
    let before = truth * STEP.inverse();
    let started = |belief: &Gaussian<3>| {
        let mut localizer = lost.clone();
        localizer.start_at(belief).expect("free space");
        localizer.odometry(Pose2::IDENTITY).expect("finite");
        localizer
    };
    let spread = started(&pose_belief(before, [6.0, 6.0, 2.0]));
    let followed = started(&pose_belief(before, [0.05, 0.05, 0.02]));
    for (name, localizer) in
        [("nothing known", &lost), ("belief over the map", &spread), ("followed", &followed)]
    {
        let update = |localizer: &mut GridLocalizer| {
            localizer.update(STEP, black_box(&scan), Pose2::IDENTITY).expect("a scan")
        };
        let mut check = localizer.clone();
        println!("{name}: {:?}", update(&mut check));
        let found = check.belief().pose();
        assert!(found.distance(truth) < 0.2, "{name}: {found:?} instead of {truth:?}");
        group.bench_function(name, |bencher| {
            let fresh = || localizer.clone();
            bencher.iter_batched_ref(fresh, update, BatchSize::PerIteration);
        });
    }

    let ends = ends(&scan, &settings);
    let exponent = settings.independent_beams / ends.len() as f64;
    let mut plain = Plain::new(&map, &settings);
    group.bench_function("plain, middles of cells", |bencher| {
        bencher.iter(|| {
            plain.predict(STEP);
            plain.correct(black_box(&ends), exponent)
        });
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = grid_localization);
criterion_main!(benches);
