//! EKF-SLAM (I2, I3): a robot drives a circle and builds a map of eight landmarks.

use loc_core::motion::Integration;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::Localizer;
use loc_filters::slam::{SlamLocalizer, SlamSettings};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::landmark_camera::LandmarkCamera;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let around = (0..8).map(|k| {
        let (sin, cos) = (0.8 * f64::from(k)).sin_cos();
        Landmark::planar(k, 4.0 * cos, 3.0 + 4.0 * sin)
    });
    let world = LandmarkMap::new(around.map(|l| Landmark { id: l.id + 1, ..l }))?;
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let mut robot = SlamLocalizer::new(SlamSettings::default(), 0.0, start)?;
    let camera = LandmarkCamera { max_range: 5.0, ..LandmarkCamera::default() };
    let (twist, mut rng) = (Twist2::forward(0.5, 0.2), stream(1, "camera"));
    for step in 0..320 {
        let stamp = 0.1 * f64::from(step);
        robot.velocity(stamp, twist)?;
        if step % 5 == 0 {
            let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, stamp);
            robot.observations(stamp, &camera.observe(&world, truth, &mut rng))?;
        }
    }
    for landmark in robot.slam().landmarks()? {
        let Some(truth) = world.get(landmark.id) else { continue };
        let error = (landmark.position.mean - truth.position.xy().coords).norm();
        println!(
            "landmark {}: {} observations, off by {error:.3} m",
            landmark.id, landmark.observations
        );
    }
    let truth = Integration::ExactArc.step(Pose2::IDENTITY, twist, 32.0);
    println!("robot off by {:.3} m", robot.estimate(32.0)?.pose.distance(truth));
    Ok(())
}
