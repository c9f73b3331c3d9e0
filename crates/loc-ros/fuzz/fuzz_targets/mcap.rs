//! MCAP files.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_ros::McapReader;
use std::io::Cursor;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    loc_fuzz::drain(McapReader::read(Path::new("a.mcap"), Cursor::new(data.to_vec())));
});
