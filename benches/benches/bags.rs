//! Reading bags from the page cache: 64 MB of scans as MCAP (as one writes it here, and with chunks
//! packed by lz4 and zstd) and as a bag of ROS 1, in bytes of messages a second; beside it the bare
//! bytes of the file. With `LOC_DATA_DIR` also the recording of the TurtleBot, read, made events,
//! and replayed with the particle filter: its 46 s at 200 times the speed are 0.23 s.
#![allow(missing_docs, dead_code, clippy::unwrap_used, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_filters::RobotSettings;
use loc_maps::grid::io;
use loc_ros::messages::{Header, LaserScan, Message, Stamp};
use loc_ros::{Dialect, McapWriter, open};
use loc_sim::localizer::Method;
use loc_sim::runner;
use loc_sim::scenario::{RecordingConfig, recording};
use loc_sim::source::Source;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{RosOptions, RosRecording};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The tests' own way of writing bags.
#[path = "../../crates/loc-ros/tests/it/write.rs"]
mod write;

/// Bytes of messages in each bag.
const BYTES: usize = 64 << 20;

/// Messages of a chunk.
const OF_A_CHUNK: usize = 128;

/// Scans of 720 beams that differ from one another, as walls and noise make them.
fn scans(dialect: Dialect) -> Vec<Vec<u8>> {
    let scan = |k: usize| {
        let beam = |b: usize| {
            let wall = 2.0 + ((b + k) as f32 * 0.01).sin();
            wall + 1e-3 * ((b * 7919 + k * 104_729) % 31) as f32
        };
        let message = LaserScan {
            header: Header::new(Stamp(k as i64 * 100_000_000), "laser"),
            ranges: (0..720).map(beam).collect(),
            ..LaserScan::default()
        };
        message.to_bytes(dialect)
    };
    let length = scan(0).len();
    (0..BYTES / length).map(scan).collect()
}

/// Writes the bags; gives their names, paths and the bytes of their messages.
fn bags(folder: &Path) -> Vec<(&'static str, PathBuf, u64)> {
    let (cdr, ros1) = (scans(Dialect::Cdr), scans(Dialect::Ros1));
    let total = |scans: &[Vec<u8>]| scans.iter().map(|scan| scan.len() as u64).sum();
    let mut bags = Vec::new();
    let indexed = folder.join("indexed.mcap");
    let mut writer = McapWriter::create(&indexed).expect("a file");
    for (k, scan) in (0..).zip(&cdr) {
        writer.write_bytes("/scan", LaserScan::NAME, k, scan).expect("written");
    }
    writer.finish().expect("written");
    bags.push(("mcap", indexed, total(&cdr)));
    for compression in ["lz4", "zstd"] {
        let chunk = |(index, scans): (usize, &[Vec<u8>])| {
            let channel = write::channel(1, "/scan", LaserScan::NAME);
            let channel = if index == 0 { channel } else { Vec::new() };
            let messages = scans.iter().flat_map(|scan| write::message(1, 1, scan));
            let records: Vec<u8> = channel.into_iter().chain(messages).collect();
            write::chunk(compression, &records, true)
        };
        let chunks: Vec<Vec<u8>> = cdr.chunks(OF_A_CHUNK).enumerate().map(chunk).collect();
        let path = folder.join(format!("{compression}.mcap"));
        std::fs::write(&path, write::mcap(&chunks)).expect("written");
        let name = if compression == "lz4" { "mcap lz4" } else { "mcap zstd" };
        bags.push((name, path, total(&cdr)));
    }
    let connection = write::connection1(0, "/scan", "sensor_msgs/LaserScan");
    for (name, compression) in [("ros 1", "none"), ("ros 1 lz4", "lz4")] {
        let chunk = |scans: &[Vec<u8>]| {
            let messages = scans.iter().flat_map(|scan| write::message1(0, 1, scan));
            let records: Vec<u8> = connection.iter().copied().chain(messages).collect();
            write::chunk1(compression, &records)
        };
        let chunks: Vec<Vec<u8>> = ros1.chunks(OF_A_CHUNK).map(chunk).collect();
        let path = folder.join(format!("{name}.bag"));
        std::fs::write(&path, write::bag1(&chunks)).expect("written");
        bags.push((name, path, total(&ros1)));
    }
    bags
}

/// Reads a bag to its end; the bytes of its messages.
fn drain(bag: &Path) -> u64 {
    let (mut bag, mut bytes) = (open(bag).expect("a bag"), 0);
    while let Some(message) = bag.next_message().expect("a message") {
        bytes += message.data.len() as u64;
    }
    bytes
}

fn read(c: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut group = c.benchmark_group("bags/64 MB");
    group.sample_size(10);
    for (name, path, bytes) in bags(folder.path()) {
        assert_eq!(drain(&path), bytes, "{name}");
        group.throughput(Throughput::Bytes(bytes));
        group.bench_function(name, |bencher| bencher.iter(|| drain(&path)));
    }
    let bare = folder.path().join("indexed.mcap");
    let mut piece = vec![0; 1 << 20];
    group.bench_function("bare bytes of mcap", |bencher| {
        bencher.iter(|| {
            let (mut file, mut sum) = (std::fs::File::open(&bare).expect("a file"), 0);
            while let Ok(read @ 1..) = file.read(&mut piece) {
                sum += read;
            }
            sum
        });
    });
    group.finish();
}

fn turtlebot(c: &mut Criterion) {
    let Some(data) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return;
    };
    let bag = Path::new(&data).join("ros_bags/turtlebot4");
    let map = Arc::new(io::load(bag.join("mac_1st_floor_9_23.yaml")).expect("a map"));
    let config = RecordingConfig::parse("lasers", recording::LASER, &[]).expect("settings");
    let settings = config.settings(RobotSettings::default()).expect("settings");
    let start = Start::At(Pose2::IDENTITY);
    let start_sigmas = config.start_sigma.sigmas().expect("settings");
    let options = ReplayOptions { map: Some(map), start, start_sigmas, ..ReplayOptions::default() };
    let events = || RosRecording::open(&bag, &options, &RosOptions::default()).expect("a bag");
    let mut group = c.benchmark_group("bags/turtlebot4");
    group.sample_size(10);
    group.bench_function("read", |bencher| bencher.iter(|| drain(&bag)));
    group.bench_function("events", |bencher| {
        bencher.iter(|| {
            let mut recording = events();
            std::iter::from_fn(|| recording.next_event().expect("an event")).count()
        });
    });
    group.bench_function("replay with mcl", |bencher| {
        bencher.iter(|| {
            runner::run(&mut events(), &[Method::Mcl], &settings, &mut |_| {}).expect("a run")
        });
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = read, turtlebot);
criterion_main!(benches);
