//! The particle filter with landmarks: 10000 particles, six landmarks by distance and direction.
//! The weighing alone, beside the plain form in double precision; the whole step of motion,
//! weighing, normalising and systematic resampling; and the step of `LandmarkMcl`, which draws the
//! motion of all velocities at once, keeps the past for late inputs and watches how observations fit.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use loc_core::angle;
use loc_core::gaussian::pose_belief;
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_filters::Localizer;
use loc_filters::RobotSettings;
use loc_filters::delayed::Delayed;
use loc_maps::{Landmark, LandmarkMap};
use loc_pf::motion::VelocityStep;
use loc_pf::sensor::landmark::{LandmarkLikelihood, ObservationModel};
use loc_pf::{LandmarkMcl, LandmarkMclSettings, ParticleFilter, Particles, Resampling};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use std::hint::black_box;

const PARTICLES: usize = 10_000;
const DT: f64 = 0.1;
/// Turning on the spot, so that the observations fit at every step.
const TWIST: Twist2 = Twist2 { vx: 0.0, vy: 0.0, omega: 0.1 };
const NOISE: LandmarkNoise =
    LandmarkNoise { range_sigma: 0.1, range_sigma_per_m: 0.0, bearing_sigma: 0.05 };

fn map() -> LandmarkMap {
    let places = [(4.0, 0.0), (3.0, 3.0), (0.0, 5.0), (-4.0, 1.0), (-2.0, -3.0), (2.0, -4.0)];
    let landmarks = (1..).zip(places).map(|(id, (x, y))| Landmark::planar(id, x, y));
    LandmarkMap::new(landmarks).expect("valid")
}

/// What a robot at the origin sees without error at a heading \[rad\].
fn observations(map: &LandmarkMap, heading: f64) -> Vec<LandmarkObservation> {
    let see = |landmark: &Landmark| {
        let (x, y) = (landmark.position.x, landmark.position.y);
        let bearing = angle::wrap(y.atan2(x) - heading);
        let observed = Observed::RangeBearing { range: x.hypot(y), bearing };
        LandmarkObservation { landmark: landmark.id, observed }
    };
    map.iter().map(see).collect()
}

fn model(outlier_share: f64) -> ObservationModel {
    ObservationModel { noise: NOISE, outlier_share, ..ObservationModel::default() }
}

fn cloud(rng: &mut ChaCha8Rng) -> Particles {
    Particles::from_gaussian(&pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]), PARTICLES, rng)
}

fn weigh(c: &mut Criterion) {
    let mut group = c.benchmark_group("landmark-mcl/weigh 10000 x 6");
    let (map, mut rng) = (map(), stream(1, "bench"));
    let seen = observations(&map, 0.0);
    for (name, share) in [("normal", 0.0), ("with outliers", 0.01)] {
        let likelihood = LandmarkLikelihood::new(&map, &seen, &model(share)).expect("valid");
        let start = cloud(&mut rng);
        let mut filter = ParticleFilter::new(start.clone(), rng.clone());
        group.bench_function(name, |bencher| bencher.iter(|| filter.weigh(black_box(&likelihood))));
        let mut filter = ParticleFilter::new(start, rng.clone());
        let plain = |pose: Pose2| likelihood.log_likelihood(pose);
        group.bench_function(format!("{name}, plain f64"), |bencher| {
            bencher.iter(|| filter.weigh(black_box(&plain)));
        });
    }
    group.finish();
}

fn step(c: &mut Criterion) {
    let mut group = c.benchmark_group("landmark-mcl/step 10000 x 6");
    let (map, noise) = (map(), VelocityNoise::default());
    let motion = VelocityStep::new(TWIST, DT, &noise, Integration::Midpoint).expect("valid");
    let mut rng = stream(1, "bench");
    let start = cloud(&mut rng);
    let mut filter = ParticleFilter::new(start.clone(), rng.clone());
    group.bench_function("motion alone", |bencher| bencher.iter(|| filter.predict(&motion)));
    let mut filter = ParticleFilter::new(start.clone(), rng.clone());
    group.bench_function("resampling alone", |bencher| {
        bencher.iter(|| filter.resample(Resampling::Systematic, PARTICLES));
    });
    for (name, share) in [("normal", 0.0), ("with outliers", 0.01)] {
        let mut filter = ParticleFilter::new(start.clone(), rng.clone());
        let mut heading = 0.0;
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                heading += TWIST.omega * DT;
                let seen = observations(&map, heading);
                filter.predict(black_box(&motion));
                let seen = LandmarkLikelihood::new(&map, &seen, &model(share)).expect("valid");
                filter.weigh(&seen);
                filter.normalize();
                filter.resample(Resampling::Systematic, PARTICLES);
            });
        });
    }
    let settings = LandmarkMclSettings::default()
        .robot(RobotSettings::default().camera(NOISE))
        .particles(PARTICLES);
    let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
    let mcl = LandmarkMcl::new(map.clone(), settings, 0.0, &start, rng).expect("valid");
    let mut mcl = Delayed::new(mcl, 2.0).expect("valid");
    mcl.velocity(0.0, TWIST).expect("finite");
    let mut stamp = 0.0;
    group.bench_function("LandmarkMcl", |bencher| {
        bencher.iter(|| {
            stamp += DT;
            let seen = observations(&map, TWIST.omega * stamp);
            mcl.velocity(stamp - DT, TWIST).expect("in time");
            mcl.observations(stamp, black_box(&seen)).expect("in time")
        });
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = weigh, step);
criterion_main!(benches);
