//! Parameter files of nav2_amcl.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_sim::nav2::AmclParameters;

fuzz_target!(|data: &[u8]| {
    let _ = AmclParameters::parse("amcl.yaml", &loc_fuzz::text(data));
});
