//! A second of sensor fusion: 100 samples of an inertial unit, 20 readings of the wheels, 10 headings
//! of a compass, a position of a satellite receiver and 5 ranges to radio beacons, in the order of
//! their stamps. Each of the 136 inputs is a prediction and a correction of twelve states.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::{Gaussian, Pose2, Twist2, gaussian::pose_belief};
use loc_filters::delayed::Delayed;
use loc_filters::fusion::state::STATES;
use loc_filters::fusion::{FusedLocalizer, FusionSettings};
use loc_filters::{ExtendedKalmanFilter, Localizer, NonlinearFilter, UnscentedKalmanFilter};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::compass::CompassReading;
use loc_sensors::event::Measurement;
use loc_sensors::imu::ImuReading;
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix2, Vector2, Vector3};
use std::hint::black_box;

const BEACON: (f64, f64) = (20.0, 15.0);
const SPEED: f64 = 1.0;

/// Gives the inputs of the second that begins at `start` \[s\] of a robot on the x axis.
fn second<F: NonlinearFilter<STATES>>(robot: &mut Delayed<FusedLocalizer<F>>, start: f64) {
    let ahead = ImuReading { angular_velocity: Vector3::zeros(), acceleration: Vector3::zeros() };
    for k in 0..100 {
        let stamp = start + 0.01 * f64::from(k);
        if k % 5 == 0 {
            robot.velocity(stamp, black_box(Twist2::forward(SPEED, 0.0))).expect("in order");
        }
        robot.correct(stamp + 0.01, &Measurement::Inertial(black_box(ahead))).expect("in order");
        if k % 10 == 5 {
            robot
                .correct(
                    stamp,
                    &Measurement::Compass(CompassReading {
                        heading: black_box(0.0),
                        strength: 20.0,
                    }),
                )
                .expect("in order");
        }
        let x = SPEED * stamp;
        if k % 20 == 8 {
            let range = (BEACON.0 - x).hypot(BEACON.1);
            let observation =
                LandmarkObservation { landmark: 1, observed: Observed::Range { range } };
            robot.observations(stamp, &[black_box(observation)]).expect("in order");
        }
        if k == 50 {
            let fix = Gaussian { mean: Vector2::new(x, 0.0), covariance: Matrix2::identity() };
            robot.correct(stamp, &Measurement::Position(black_box(fix))).expect("in order");
        }
    }
}

fn bench<F: NonlinearFilter<STATES>>(c: &mut Criterion, name: &str) {
    let map = LandmarkMap::new([Landmark::planar(1, BEACON.0, BEACON.1)]).expect("valid");
    let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
    let settings = FusionSettings::default();
    let robot = FusedLocalizer::<F>::with_filter(map, settings, 0.0, start);
    let mut robot = Delayed::new(robot.expect("valid settings"), 2.0).expect("valid horizon");
    second(&mut robot, 0.0);
    let mut group = c.benchmark_group("fusion/second of 136 inputs");
    group.throughput(Throughput::Elements(136));
    let mut stamp = 0.0;
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            stamp += 1.0;
            second(&mut robot, stamp);
        });
    });
    group.finish();
}

fn all(c: &mut Criterion) {
    bench::<ExtendedKalmanFilter<STATES>>(c, "extended");
    bench::<UnscentedKalmanFilter<STATES>>(c, "unscented");
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = all);
criterion_main!(benches);
