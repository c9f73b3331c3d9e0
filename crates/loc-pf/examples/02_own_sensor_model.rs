//! Monte Carlo localization with a sensor model of your own: tempering, recovery, clusters and the
//! probability of being lost work with it as with the built-in ones.

use loc_core::{Pose2, gaussian::pose_belief, random::stream};
use loc_maps::{RayCaster, worlds};
use loc_pf::mcl::{MotionSettings, MountedScan, ScanModel, ScanView};
use loc_pf::{Mcl, MclSettings};
use loc_sensors::laser::{LaserScanner, LaserSpec};

/// A robust field: no beam counts for more than a constant, wherever it ends.
struct Bounded;

impl ScanModel for Bounded {
    type Likelihood<'a> = Box<dyn Fn(Pose2) -> f64 + Sync + 'a>;

    fn likelihood<'a>(&'a self, scan: &ScanView<'a>) -> loc_pf::Result<Self::Likelihood<'a>> {
        let ScanView { field, endpoints, exponent, .. } = *scan;
        let worst = field.settings().likelihood(0.2).ln();
        Ok(Box::new(move |pose| {
            let ends = endpoints.points().map(|end| pose.transform(&end));
            exponent * ends.map(|end| field.log_likelihood_at(&end).max(worst)).sum::<f64>()
        }))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = worlds::WorldSettings { width: 300, height: 300, ..Default::default() };
    let map = worlds::office(&settings)?.grid;
    let (walls, mut rng) = (RayCaster::new(&map), stream(1, "laser"));
    let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
    let (settings, motion) = (MclSettings::default(), MotionSettings::Path);
    let mut robot = Mcl::with_models(&map, settings, motion, Bounded, stream(1, "mcl"))?;

    let start = Pose2::new(7.5, 7.5, 0.4);
    robot.start_at(&pose_belief(start, [0.3, 0.3, 0.1]))?;
    for step in 0..10 {
        let odometry = Pose2::new(0.0, 0.0, 0.15 * f64::from(step));
        let scan = laser.scan(&walls, start * odometry, &mut rng);
        robot.update(odometry, &[MountedScan { scan: &scan, mounting: Pose2::IDENTITY }])?;
        let error = robot.pose().distance(start * odometry);
        println!("{step}: off by {error:.3} m, lost with probability {:.3}", robot.lost());
    }
    Ok(())
}
