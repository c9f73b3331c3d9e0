//! One sensor in a room (B8): a laser scan of four walls and a pillar, and the walls found in it.

use loc_core::{Pose2, random::stream};
use loc_sensors::features::LineExtractor;
use loc_sensors::laser::{LaserScanner, LaserSpec};
use loc_sensors::world::Room;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let room = Room::new([-3.0, -2.0], [3.0, 2.0])?.with_pillar([1.5, 1.0], 0.2)?;
    let scanner = LaserScanner::new(LaserSpec::hokuyo_ust_10lx())?;
    let scan = scanner.scan(&room, Pose2::IDENTITY, &mut stream(7, "laser"));
    println!("{} beams, {} with a return", scan.ranges.len(), scan.beams().count());
    for wall in LineExtractor::new(scanner.spec.noise).extract(&scan)? {
        println!("wall {:.2} m away, {:.1} m of it in view", wall.r, wall.length());
    }
    Ok(())
}
