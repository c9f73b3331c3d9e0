//! The exact distance transform of a 2000 x 2000 map with a cut-off of 2 m; beside it the plain
//! form of the same method, with a division for each pair of parabolas and no cut-off within.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_maps::DistanceMap;
use loc_maps::grid::{Occupancy, OccupancyGrid};
use std::hint::black_box;

/// Felzenszwalb and Huttenlocher's two passes as printed, over f32.
fn as_printed(grid: &OccupancyGrid) -> Vec<f32> {
    let (width, height) = (grid.width(), grid.height());
    let occupied = |&value: &i8| Occupancy::of(value) == Occupancy::Occupied;
    let start = |value| if occupied(value) { 0.0 } else { 1e20 };
    let mut field: Vec<f32> = grid.values().iter().map(start).collect();
    for column in 0..width {
        let line: Vec<f32> = (0..height).map(|row| field[row * width + column]).collect();
        for (row, value) in one_dimension(&line).into_iter().enumerate() {
            field[row * width + column] = value;
        }
    }
    field.chunks_exact(width).flat_map(one_dimension).collect()
}

fn one_dimension(f: &[f32]) -> Vec<f32> {
    let (mut v, mut z) = (vec![0_usize], vec![f32::NEG_INFINITY]);
    for q in 1..f.len() {
        let meet =
            |p: usize| ((f[q] + (q * q) as f32) - (f[p] + (p * p) as f32)) / (2.0 * (q - p) as f32);
        while v.len() > 1 && meet(v[v.len() - 1]) <= z[z.len() - 1] {
            v.pop();
            z.pop();
        }
        z.push(meet(v[v.len() - 1]));
        v.push(q);
    }
    let mut k = 0;
    let lowest = |q: usize| {
        while k + 1 < v.len() && z[k + 1] < q as f32 {
            k += 1;
        }
        let dx = q as f32 - v[k] as f32;
        dx * dx + f[v[k]]
    };
    (0..f.len()).map(lowest).collect()
}

fn transform(c: &mut Criterion) {
    let grid = loc_bench::map().expect("a map");
    let mut group = c.benchmark_group("distance-transform");
    group.throughput(Throughput::Elements(grid.values().len() as u64));
    group.bench_function("exact, cut-off 2 m", |bencher| {
        bencher.iter(|| DistanceMap::new(black_box(&grid), 2.0).expect("valid"));
    });
    group.bench_function("exact, no cut-off", |bencher| {
        bencher.iter(|| DistanceMap::new(black_box(&grid), f64::INFINITY).expect("valid"));
    });
    group.sample_size(10);
    group.bench_function("as printed", |bencher| bencher.iter(|| as_printed(black_box(&grid))));
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = transform);
criterion_main!(benches);
