//! Line matching (H4): the walls in a laser scan correct the pose in a room.

use loc_core::{Pose2, gaussian::pose_belief, random::stream};
use loc_filters::line_matching::{LineEkf, LineMatchingSettings};
use loc_maps::LineMap;
use loc_sensors::laser::{LaserScanner, LaserSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Walls as x1, y1, x2, y2 in metres.
    let room = LineMap::parse_csv("room.csv", "0,0,6,0\n6,0,6,4\n6,4,0,4\n0,4,0,0\n")?;
    let (truth, mounting) = (Pose2::new(2.5, 1.5, 0.3), Pose2::new(0.1, 0.0, 0.0));
    let scanner = LaserScanner { mounting, ..LaserScanner::new(LaserSpec::sick_lms100())? };
    let scan = scanner.scan(&room, truth, &mut stream(1, "laser"));

    let start = pose_belief(Pose2::new(2.3, 1.6, 0.25), [0.2, 0.2, 0.1]);
    let mut ekf = LineEkf::new(room, LineMatchingSettings::default(), start)?;
    println!("before: off by {:.3} m", ekf.belief().pose().distance(truth));
    let update = ekf.scan(&scan, mounting)?;
    println!("{} of {} lines matched", update.matched(), update.pairs.len());
    println!("after: off by {:.4} m", ekf.belief().pose().distance(truth));
    Ok(())
}
