//! A sensor model of your own (M5): a function of the pose that returns a log-likelihood. Here a
//! robot in a corridor measures its distance from the end wall.

use loc_core::{Pose2, gaussian::pose_belief, random::stream};
use loc_pf::{ParticleFilter, Particles, Resampling};

fn main() {
    let mut rng = stream(1, "filter");
    let start = pose_belief(Pose2::IDENTITY, [1.0, 1.0, 0.1]);
    let mut filter = ParticleFilter::new(Particles::from_gaussian(&start, 1000, &mut rng), rng);
    // The wall is at x = 5 m; ranges are good to 0.1 m.
    for range in [4.5, 4.52, 4.47] {
        filter.weigh(&|pose: Pose2| -0.5 * ((5.0 - pose.x - range) / 0.1_f64).powi(2));
        filter.normalize();
        println!("effective sample size {:.0}", filter.particles().effective_sample_size());
        filter.resample(Resampling::Systematic, 1000);
    }
    let mean = filter.particles().poses().x.iter().sum::<f64>() / 1000.0;
    println!("x = {mean:.3} m, expected 0.503 m");
}
