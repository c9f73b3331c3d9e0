//! Initial particles around the candidates of a global search.

use loc_core::random::stream;
use loc_core::{Pose2, angle};
use loc_maps::search::Candidate;
use loc_pf::Error;
use loc_pf::initial::{SeedSettings, seed_particles};
use std::f64::consts::PI;

#[test]
fn particles_have_the_shares_and_spread_of_their_candidates() {
    let [here, there] = [Pose2::new(2.0, 1.0, 0.5), Pose2::new(9.0, 1.0, PI)];
    let candidates = [(here, -40.0), (there, -40.0 - 10.0 * 3_f64.ln())];
    let candidates = candidates.map(|(pose, log_likelihood)| Candidate { pose, log_likelihood });
    let settings = SeedSettings { position: 0.2, heading: 0.1, exponent: 0.1 };
    let draw = || seed_particles(&candidates, 4000, &settings, &mut stream(1, "seed")).unwrap();
    let particles = draw();
    assert_eq!(particles, draw());
    assert_eq!(particles.len(), 4000);
    let about = |at: Pose2| particles.poses().iter().filter(|pose| pose.distance(at) < 3.0).count();
    assert!(about(here).abs_diff(3000) <= 1 && about(there).abs_diff(1000) <= 1, "3 : 1");
    let (mut square, mut turn) = (0.0, 0.0);
    for pose in particles.poses().iter() {
        let at = if pose.x < 5.0 { here } else { there };
        square += (pose.x - at.x).powi(2) + (pose.y - at.y).powi(2);
        turn += angle::difference(pose.theta, at.theta).powi(2);
        assert!(pose.theta.abs() <= PI);
    }
    let [position, heading] = [square / 8000.0, turn / 4000.0].map(f64::sqrt);
    assert!((position - 0.2).abs() < 0.01 && (heading - 0.1).abs() < 0.005, "{position} {heading}");
    let none = seed_particles(&[], 10, &settings, &mut stream(1, "seed"));
    assert!(matches!(none, Err(Error::Core(_))));
    let bad = SeedSettings { exponent: 0.0, ..settings };
    assert!(seed_particles(&candidates, 10, &bad, &mut stream(1, "seed")).is_err());
}
