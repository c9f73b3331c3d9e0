//! Messages of a bag joined to a recording: stamps, frames, odometry, whatever they claim.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{RosOptions, RosRecording};

fuzz_target!(|data: &[u8]| {
    let bag = loc_fuzz::file("a.mcap", data);
    let options = ReplayOptions { start: Start::Anywhere, ..ReplayOptions::default() };
    loc_fuzz::replay(RosRecording::open(&bag, &options, &RosOptions::default()));
});
