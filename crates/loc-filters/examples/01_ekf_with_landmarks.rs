//! The extended Kalman filter with landmarks (H2): a robot drives an arc past two landmarks, and the
//! camera's observations arrive 0.3 s late.

use loc_core::motion::Integration;
use loc_core::random::stream;
use loc_core::{Pose2, Twist2, gaussian::pose_belief};
use loc_filters::Localizer;
use loc_filters::RobotSettings;
use loc_filters::delayed::Delayed;
use loc_filters::landmark::LandmarkLocalizer;
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::landmark_camera::LandmarkCamera;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let map = LandmarkMap::new([Landmark::planar(1, 4.0, 1.0), Landmark::planar(2, 2.0, 4.0)])?;
    // The start is known to 0.3 m and 0.1 rad.
    let start = pose_belief(Pose2::new(0.2, -0.2, 0.05), [0.3, 0.3, 0.1]);
    let localizer = LandmarkLocalizer::new(map.clone(), RobotSettings::default(), 0.0, start)?;
    // `Delayed` applies inputs that come up to 1 s late at their own time.
    let mut robot = Delayed::new(localizer, 1.0)?;

    let camera = LandmarkCamera { max_range: 10.0, ..LandmarkCamera::default() };
    let (twist, mut rng) = (Twist2::forward(0.5, 0.2), stream(1, "camera"));
    let mut pending = Vec::new();
    for step in 0..50 {
        let stamp = 0.1 * f64::from(step);
        robot.velocity(stamp, twist)?;
        let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, stamp);
        if step % 5 == 0 {
            pending.push((stamp, camera.observe(&map, truth, &mut rng)));
        }
        if let Some((taken, observations)) = pending.pop_if(|(taken, _)| *taken + 0.3 <= stamp) {
            for outcome in robot.observations(taken, &observations)? {
                let (landmark, decision) = (outcome.landmark, outcome.decision);
                println!("{taken:.1} s: landmark {landmark:?} {decision:?}, NIS {:?}", outcome.nis);
            }
        }
    }
    let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, 5.0);
    let estimate = robot.estimate(5.0)?;
    println!("estimate {}, error {:.3} m", estimate.pose, estimate.pose.distance(truth));
    Ok(())
}
