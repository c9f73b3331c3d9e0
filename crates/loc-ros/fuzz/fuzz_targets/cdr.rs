//! Messages in the Common Data Representation, in both byte orders (its first bytes say which).
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_ros::Encoding;

fuzz_target!(|data: &[u8]| loc_fuzz::message(data, &Encoding::Cdr));
