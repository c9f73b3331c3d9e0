//! Tempered updates leave the particle set as wide as it should be.

use loc_core::Pose2;
use loc_core::motion::OdometryNoise;
use loc_core::random::stream;
use loc_pf::motion::DifferentialStep;
use loc_pf::{ParticleFilter, Particles, Tempering};

/// Odometry good to a metre, a measurement good to centimetres: of 500 particles one or none lies
/// within the peak, and copies of it must not be the answer.
#[test]
fn a_narrow_peak_under_wide_noise_keeps_its_width() {
    let noise = OdometryNoise { alpha1: 0.2, alpha2: 0.2, alpha3: 0.2, alpha4: 0.2 };
    let step = DifferentialStep::between(Pose2::IDENTITY, Pose2::new(2.0, 0.0, 0.1), &noise);
    let step = step.unwrap();
    let at = Pose2::new(2.4, 0.5, 0.3);
    let measurement = |pose: Pose2| {
        let off = at.between(pose);
        let place = (off.x * off.x + off.y * off.y) / 0.02_f64.powi(2);
        // A floor, as of beams that end anywhere.
        (-0.5 * (place + (off.theta / 0.01).powi(2))).max(-40.0)
    };
    let mut narrow = 0;
    for seed in 0..40 {
        let cloud = Particles::from_poses(std::iter::repeat_n(Pose2::IDENTITY, 500));
        let mut filter = ParticleFilter::new(cloud, stream(seed, "filter"));
        Tempering::default().update(&mut filter, &step, &measurement, 500);
        let belief = loc_pf::estimate::moments(filter.particles());
        let deviation = belief.covariance[(0, 0)].sqrt();
        narrow += usize::from(deviation < 0.005);
    }
    assert!(narrow <= 2, "{narrow} of 40 clouds are far too sure");
}
