//! Text tables: the first byte says which, TUM in the plane and in space, maps of landmarks, points
//! and lines as CSV, references of a log.
#![no_main]

use libfuzzer_sys::fuzz_target;
use loc_core::Trajectory;
use loc_maps::{LandmarkMap, LineMap, PointMap};
use loc_sim::metrics::SpatialTrajectory;
use loc_sim::source::laser_log::Reference;
use std::path::Path;

fuzz_target!(|data: &[u8]| {
    let Some((kind, rest)) = data.split_first() else { return };
    let text = loc_fuzz::text(rest);
    match kind % 6 {
        0 => {
            let read = Trajectory::read_tum(loc_fuzz::file("a.tum", text.as_bytes()));
            // Headings are normalised, so that only the number of poses must stay.
            if let Ok(read) = read {
                let written = loc_fuzz::file("b.tum", read.to_tum().as_bytes());
                assert_eq!(
                    Trajectory::read_tum(written).map(|again| again.len()).ok(),
                    Some(read.len())
                );
            }
        }
        1 => drop(SpatialTrajectory::parse_tum("a.tum", &text)),
        2 => drop(LandmarkMap::parse_csv("a.csv", &text)),
        3 => drop(PointMap::parse_csv("a.csv", &text)),
        4 => drop(LineMap::parse_csv("a.csv", &text)),
        _ => drop(Reference::parse(Path::new("a.csv"), &text)),
    }
});
