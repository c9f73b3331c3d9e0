//! Logs of Wean Hall, and its map, which begins with words of its own.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_sim::source::LaserRecording;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::wean::WeanLog;
use std::io::Cursor;

fuzz_target!(|data: &[u8]| {
    if data.starts_with(b"robot_specifications->") {
        let _ = loc_maps::grid::io::load(loc_fuzz::file("wean.dat", data));
    } else if let Ok(log) = WeanLog::parse("a.log", Cursor::new(data.to_vec())).laser_log() {
        let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
        loc_fuzz::replay(LaserRecording::new(log, &options));
    }
});
