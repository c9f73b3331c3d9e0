//! Messages in the serialisation of ROS 1.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_ros::Encoding;

fuzz_target!(|data: &[u8]| loc_fuzz::message(data, &Encoding::Ros1));
