//! Sensor fusion (H1): wheels, compass and a satellite receiver in one filter.

use loc_core::{Gaussian, Pose2, Twist2, gaussian::pose_belief};
use loc_filters::Localizer;
use loc_filters::delayed::Delayed;
use loc_filters::fusion::{FusedLocalizer, FusionSettings};
use loc_maps::LandmarkMap;
use loc_sensors::compass::CompassReading;
use loc_sensors::event::Measurement;
use nalgebra::{Matrix2, Vector2};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = pose_belief(Pose2::new(1.0, -1.0, 0.2), [2.0, 2.0, 0.3]);
    let filter =
        FusedLocalizer::new(LandmarkMap::default(), FusionSettings::default(), 0.0, start)?;
    let mut robot = Delayed::new(filter, 2.0)?;
    // The robot drives along the x axis at 1 m/s.
    for step in 0..300 {
        let stamp = 0.1 * f64::from(step);
        robot.velocity(stamp, Twist2::forward(1.0, 0.0))?;
        if step % 2 == 0 {
            let reading = CompassReading { heading: 0.01, strength: 20.0 };
            robot.correct(stamp, &Measurement::Compass(reading))?;
        }
        // A fix per second, 0.3 s late; none between 10 s and 20 s.
        if step % 10 == 3 && !(100..200).contains(&step) {
            let taken = stamp - 0.3;
            let fix = Gaussian::new(Vector2::new(taken + 0.4, -0.3), Matrix2::identity())?;
            robot.correct(taken, &Measurement::Position(fix))?;
        }
        if step % 50 == 49 {
            let estimate = robot.estimate(stamp)?;
            let sigma = estimate.belief().covariance[(1, 1)].sqrt();
            println!("{stamp:4.1} s: {}, sigma of y {sigma:.2} m", estimate.pose);
        }
    }
    Ok(())
}
