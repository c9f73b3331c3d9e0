//! Bags of ROS 1.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_ros::Bag1;
use std::io::Cursor;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    loc_fuzz::drain(Bag1::read(Path::new("a.bag"), Cursor::new(data.to_vec())));
});
