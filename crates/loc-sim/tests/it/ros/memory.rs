//! How much memory a bag takes: a chunk and an index, whatever its length.

use super::write::{bag1, channel, chunk, chunk1, connection1, message, message1, record};
use loc_ros::messages::{Header, LaserScan, Message, Stamp};
use loc_ros::{Dialect, Encoding};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::process::{Command, Stdio};

/// Bytes of messages in a bag, and of its chunks.
const BYTES: usize = 1 << 30;
const CHUNK: usize = 1 << 20;

/// Messages of a chunk, one after the other.
fn chunk_of(dialect: Dialect) -> Vec<u8> {
    let scan = LaserScan {
        header: Header::new(Stamp(1_000_000_000), "laser"),
        ranges: (0..2000).map(|k| 1.0 + (k as f32).sqrt()).collect(),
        ..LaserScan::default()
    };
    let data = scan.to_bytes(dialect);
    assert!(LaserScan::from_bytes(&data, &Encoding::Cdr).is_ok() || dialect == Dialect::Ros1);
    let message = match dialect {
        Dialect::Ros1 => message1(0, 1, &data),
        _ => message(1, 1_000_000_000, &data),
    };
    message.repeat(CHUNK / message.len())
}

/// The most memory that the command held \[MB\], looked up while it runs.
fn peak(folder: &Path, arguments: &[&str]) -> f64 {
    let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
    let command = command.current_dir(folder).args(arguments).stdout(Stdio::null());
    let mut child = command.spawn().unwrap();
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0;
    let ended = loop {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<f64>().ok());
        peak = kilobytes.map_or(peak, |kilobytes| kilobytes / 1024.0);
        match child.try_wait().unwrap() {
            Some(ended) => break ended,
            None => std::thread::sleep(std::time::Duration::from_millis(5)),
        }
    };
    assert!(ended.success());
    println!("loc-sim {}: {peak:.1} MB", arguments.join(" "));
    peak
}

#[test]
#[ignore = "writes and reads 2 GB"]
fn a_gigabyte_takes_a_chunk_and_an_index() {
    if !Path::new("/proc/self/status").exists() {
        println!("skipped: there is no /proc");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut file = BufWriter::new(File::create(path.join("a.mcap")).unwrap());
    file.write_all(b"\x89MCAP0\r\n").unwrap();
    file.write_all(&record(1, &[0; 8])).unwrap();
    file.write_all(&channel(1, "/scan", LaserScan::NAME)).unwrap();
    let chunk = chunk("", &chunk_of(Dialect::Cdr), true);
    for _ in 0..BYTES / CHUNK {
        file.write_all(&chunk).unwrap();
    }
    file.flush().unwrap();
    drop(file);
    let records = [connection1(0, "/scan", "sensor_msgs/LaserScan"), chunk_of(Dialect::Ros1)];
    let chunk = chunk1("lz4", &records.concat());
    std::fs::write(path.join("b.bag"), bag1(&vec![chunk; BYTES / CHUNK])).unwrap();
    // The program itself takes some 10 MB.
    for log in ["a.mcap", "b.bag"] {
        assert!(peak(path, &["info", log]) < 30.0);
        assert!(peak(path, &["convert", log, "c.mcap", "--to", "mcap"]) < 50.0);
        std::fs::remove_file(path.join("c.mcap")).unwrap();
    }
}
