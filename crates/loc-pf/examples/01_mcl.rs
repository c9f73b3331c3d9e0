//! Monte Carlo localization (M1): a robot with a laser in an office, first without any idea of its
//! pose, then tracked.

use loc_core::{Pose2, random::stream};
use loc_maps::{RayCaster, worlds};
use loc_pf::{Mcl, MclSettings, mcl::MountedScan};
use loc_sensors::laser::{LaserScanner, LaserSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = worlds::WorldSettings { width: 300, height: 300, ..Default::default() };
    let map = worlds::office(&settings)?.grid;
    let (walls, mut rng) = (RayCaster::new(&map), stream(1, "laser"));
    let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
    let mut robot = Mcl::new(&map, MclSettings::default(), stream(1, "mcl"))?;

    let start = Pose2::new(7.5, 7.5, 0.4);
    for step in 0..10 {
        // The odometry counts from 0; the robot turns on the spot.
        let odometry = Pose2::new(0.0, 0.0, 0.15 * f64::from(step));
        let truth = start * odometry;
        let scan = laser.scan(&walls, truth, &mut rng);
        robot.update(odometry, &[MountedScan { scan: &scan, mounting: Pose2::IDENTITY }])?;
        println!(
            "{step}: off by {:.3} m, {} particles, {} clusters, lost with probability {:.3}",
            robot.pose().distance(truth),
            robot.particles().len(),
            robot.last_estimate().clusters.len(),
            robot.lost()
        );
    }
    Ok(())
}
