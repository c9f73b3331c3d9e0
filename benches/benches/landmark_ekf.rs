//! One step of the landmark EKF: motion, then six landmarks by distance and bearing; beside it the
//! same step written out on bare nalgebra with the simple form and an inverse, the unscented filter,
//! and the step with its part of the smoothing afterwards.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::gaussian::pose_belief;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::RobotSettings;
use loc_filters::delayed::Sequential;
use loc_filters::landmark::{LandmarkEkf, LandmarkFilter, LandmarkLocalizer, LandmarkUkf};
use loc_filters::smoother::{Recorded, Smoothable};
use loc_filters::{ExtendedKalmanFilter, Localizer, NonlinearFilter};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2, Vector3};
use std::hint::black_box;

const DT: f64 = 0.1;
const TWIST: Twist2 = Twist2 { vx: 0.0, vy: 0.0, omega: 0.1 };

fn world() -> (LandmarkMap, Vec<LandmarkObservation>) {
    let places = [(4.0, 0.0), (3.0, 3.0), (0.0, 5.0), (-4.0, 1.0), (-2.0, -3.0), (2.0, -4.0)];
    let landmarks = (1..).zip(places).map(|(id, (x, y))| Landmark::planar(id, x, y));
    let map = LandmarkMap::new(landmarks).expect("valid");
    let see = |landmark: &Landmark| {
        let (x, y) = (landmark.position.x, landmark.position.y);
        let observed = Observed::RangeBearing { range: x.hypot(y), bearing: y.atan2(x) };
        LandmarkObservation { landmark: landmark.id, observed }
    };
    let observations = map.iter().map(see).collect();
    (map, observations)
}

/// Euler motion and six corrections with plain formulas (H1, H2): no checks, no gate.
fn bare(
    belief: &mut Gaussian<3>,
    map: &LandmarkMap,
    observations: &[LandmarkObservation],
    noise: &[f64; 5],
) {
    let [k_d, k_theta, k_drift, q_r, q_phi] = *noise;
    let (sin, cos) = belief.mean.z.sin_cos();
    let d = TWIST.vx * DT;
    let g = Matrix3::new(1.0, 0.0, -d * sin, 0.0, 1.0, d * cos, 0.0, 0.0, 1.0);
    let v = nalgebra::Matrix3x2::new(DT * cos, 0.0, DT * sin, 0.0, 0.0, DT);
    let speed = TWIST.vx.abs() / DT;
    let u = Matrix2::new(k_d * speed, 0.0, 0.0, k_theta * TWIST.omega.abs() / DT + k_drift * speed);
    let mut x = belief.mean + Vector3::new(d * cos, d * sin, TWIST.omega * DT);
    let mut p = g * belief.covariance * g.transpose() + v * u * v.transpose();
    let q = Matrix2::new(q_r, 0.0, 0.0, q_phi);
    for observation in observations {
        let Observed::RangeBearing { range, bearing } = observation.observed else { continue };
        let Some(landmark) = map.get(observation.landmark) else { continue };
        let (dx, dy) = (landmark.position.x - x.x, landmark.position.y - x.y);
        let r = dx.hypot(dy);
        let h = Matrix2x3::new(-dx / r, -dy / r, 0.0, dy / (r * r), -dx / (r * r), -1.0);
        let k = p * h.transpose() * (h * p * h.transpose() + q).try_inverse().expect("regular");
        let turn = loc_core::angle::wrap(bearing - (dy.atan2(dx) - x.z));
        x += k * Vector2::new(range - r, turn);
        p = (Matrix3::identity() - k * h) * p;
    }
    *belief = Gaussian { mean: x, covariance: p };
}

fn one<F: NonlinearFilter<3>>(
    mut filter: LandmarkFilter<F>,
    map: &LandmarkMap,
    observations: &[LandmarkObservation],
) -> LandmarkFilter<F> {
    filter.predict(black_box(TWIST), DT).expect("finite");
    for observation in observations {
        filter.correct(map, black_box(observation)).expect("finite");
    }
    filter
}

fn step(c: &mut Criterion) {
    let (map, observations) = world();
    let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
    let settings = RobotSettings::default().gate_probability(1.0);
    let mut group = c.benchmark_group("landmark-ekf/6-observations");

    let filter = LandmarkEkf::new(start, settings).expect("valid");
    group.bench_function("loc-filters", |bencher| {
        bencher.iter(|| one(black_box(filter), &map, &observations));
    });
    let filter = LandmarkUkf::new(start, settings).expect("valid");
    group.bench_function("loc-filters, unscented", |bencher| {
        bencher.iter(|| one(black_box(filter), &map, &observations));
    });
    // A whole drive; Criterion divides by its steps.
    const STEPS: u32 = 1000;
    group.throughput(Throughput::Elements(u64::from(STEPS)));
    group.bench_function("1000 steps and their smoothing", |bencher| {
        bencher.iter(|| {
            let shared = map.clone();
            let mut drive = LandmarkLocalizer::<Recorded<ExtendedKalmanFilter<3>, 3>>::with_filter(
                shared, settings, 0.0, start,
            )
            .expect("valid");
            for k in 1..=STEPS {
                let stamp = DT * f64::from(k);
                drive.velocity(stamp, black_box(TWIST)).expect("in order");
                drive.observations(stamp, black_box(&observations)).expect("in order");
                drive.mark(stamp).expect("in order");
            }
            drive.smoothed().expect("finite")
        });
    });
    group.throughput(Throughput::Elements(1));
    let motion = settings.odometry;
    let (q_r, q_phi) = (settings.camera.range_sigma, settings.camera.bearing_sigma);
    let noise = [motion.k_d(), motion.k_theta(), motion.k_drift(), q_r * q_r, q_phi * q_phi];
    group.bench_function("bare nalgebra", |bencher| {
        bencher.iter(|| {
            let mut belief = black_box(start);
            bare(&mut belief, &map, black_box(&observations), &noise);
            belief
        });
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = step);
criterion_main!(benches);
