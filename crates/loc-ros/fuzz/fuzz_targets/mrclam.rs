//! A folder of MRCLAM: its five files, zero bytes between them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_sim::source::Mrclam;

const FILES: [&str; 5] = [
    "Barcodes.dat",
    "Landmark_Groundtruth.dat",
    "Robot1_Groundtruth.dat",
    "Robot1_Odometry.dat",
    "Robot1_Measurement.dat",
];

fuzz_target!(|data: &[u8]| {
    loc_fuzz::files(&FILES, data);
    loc_fuzz::replay(Mrclam::open(loc_fuzz::folder(), 1));
});
