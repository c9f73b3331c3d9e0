//! One step of FastSLAM 2.0, a motion and three observations, against the number of particles and of
//! landmarks. Landmarks lie in a tree of each particle, of which an observation copies one path.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_pf::fastslam::{FastSlam, FastSlamSettings};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use std::hint::black_box;

/// Landmarks on rings around the robot.
fn see(landmark: u32) -> LandmarkObservation {
    let (range, bearing) = (2.0 + 0.01 * f64::from(landmark), f64::from(landmark % 628) * 0.01);
    let bearing = loc_core::angle::wrap(bearing);
    LandmarkObservation { landmark, observed: Observed::RangeBearing { range, bearing } }
}

fn steps(c: &mut Criterion) {
    let mut group = c.benchmark_group("fastslam/motion and 3 observations");
    for (particles, landmarks) in [(100, 100), (1000, 100), (100, 1000_u32), (1000, 1000)] {
        let settings = FastSlamSettings::default().particles(particles);
        let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
        let mut slam = FastSlam::new(start, settings, stream(1, "bench")).expect("valid");
        slam.correct(&(0..landmarks).map(see).collect::<Vec<_>>()).expect("finite");
        let seen = [3, landmarks / 2, landmarks - 5].map(see);
        let mut forward = 1.0;
        let name = BenchmarkId::new(format!("{particles} particles"), landmarks);
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                // There and back, so that the observations fit.
                forward = -forward;
                slam.predict(Twist2::forward(0.01 * forward, 0.0), 0.1).expect("finite");
                slam.correct(black_box(&seen)).expect("finite")
            });
        });
    }
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = steps);
criterion_main!(benches);
