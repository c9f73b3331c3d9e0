//! Loading a map of 4000 x 4000 cells from PGM, PNG and BMP; beside it the bytes alone, read from
//! the file and copied once.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use loc_maps::grid::io::{self, ImageFormat, Mode};
use loc_maps::worlds::{self, WorldSettings};

fn load(c: &mut Criterion) {
    let size = WorldSettings { width: 4000, height: 4000, ..WorldSettings::default() };
    let office = worlds::office(&size).expect("valid").grid;
    let folder = tempfile::tempdir().expect("a folder");
    let mut group = c.benchmark_group("map-io/4000x4000");
    group.sample_size(10);
    for format in [ImageFormat::Pgm, ImageFormat::Png, ImageFormat::Bmp] {
        let name = format.extension();
        let yaml = folder.path().join(format!("{name}.yaml"));
        io::save(&office, &yaml, format, Mode::Trinary).expect("written");
        group.bench_function(format!("load {name}"), |bencher| {
            bencher.iter(|| io::load(&yaml).expect("a map"));
        });
    }
    let image = folder.path().join("pgm.pgm");
    group.bench_function("bytes of pgm", |bencher| {
        bencher.iter(|| std::fs::read(&image).map(|bytes| bytes.to_vec()).expect("a file"));
    });
    group.bench_function("save pgm", |bencher| {
        let yaml = folder.path().join("saved.yaml");
        bencher.iter(|| io::save(&office, &yaml, ImageFormat::Pgm, Mode::Trinary).expect("a map"));
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = load);
criterion_main!(benches);
