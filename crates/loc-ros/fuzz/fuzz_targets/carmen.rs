//! CARMEN logs, and the CSV of a reference behind a zero byte.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_sim::source::LaserRecording;
use loc_sim::source::carmen::CarmenLog;
use loc_sim::source::laser_log::{Reference, ReplayOptions, Start};
use std::io::Cursor;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    let mut parts = data.splitn(2, |byte| *byte == 0);
    let log = Cursor::new(parts.next().unwrap_or_default().to_vec());
    let reference = parts.next().map(loc_fuzz::text);
    let reference = reference.and_then(|text| Reference::parse(Path::new("a.csv"), &text).ok());
    if let Ok(log) = CarmenLog::parse("a.log", log).laser_log() {
        let options =
            ReplayOptions { start: Start::Anywhere, reference, ..ReplayOptions::default() };
        loc_fuzz::replay(LaserRecording::new(log, &options));
    }
});
