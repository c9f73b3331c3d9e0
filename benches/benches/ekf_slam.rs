//! One correction of EKF-SLAM among n landmarks, beside the same step on full nalgebra matrices, the
//! lower half by faer, and what memory alone takes: reading and writing half of the covariance. And
//! the check of a whole covariance, by faer and by nalgebra.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, Par};
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::slam::{EkfSlam, Jacobians, SlamSettings};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{DMatrix, DVector, Matrix2};
use std::hint::black_box;

/// Landmarks in rows of 20, 2 m apart.
fn place(id: u32) -> (f64, f64) {
    (2.0 * f64::from(id % 20) + 1.0, 2.0 * f64::from(id / 20) + 1.0)
}

fn see(pose: Pose2, id: u32) -> LandmarkObservation {
    let (x, y) = place(id);
    let (dx, dy) = (x - pose.x, y - pose.y);
    let bearing = loc_core::angle::wrap(dy.atan2(dx) - pose.theta);
    LandmarkObservation {
        landmark: id,
        observed: Observed::RangeBearing { range: dx.hypot(dy), bearing },
    }
}

/// A filter that has driven past n landmarks, in whose covariance everything depends on
/// everything.
fn driven(n: u32, settings: SlamSettings) -> EkfSlam {
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let mut slam = EkfSlam::new(start, settings).expect("valid");
    for id in 0..n {
        slam.predict(Twist2::forward(0.1, 0.01), 0.1).expect("finite");
        let pose = slam.pose().expect("positive").pose();
        slam.correct(&[see(pose, id)]).expect("finite");
    }
    slam
}

fn observations(slam: &EkfSlam, count: u32) -> Vec<LandmarkObservation> {
    let pose = slam.pose().expect("positive").pose();
    (0..count)
        .map(|k| {
            let id = 7 + 11 * k;
            let at = slam.landmark(id).expect("positive").expect("known").position.mean;
            let (dx, dy) = (at.x - pose.x, at.y - pose.y);
            let bearing = loc_core::angle::wrap(dy.atan2(dx) - pose.theta);
            LandmarkObservation {
                landmark: id,
                observed: Observed::RangeBearing { range: dx.hypot(dy), bearing },
            }
        })
        .collect()
}

/// `P - K H P` with all matrices in full.
fn full_update(p: &mut DMatrix<f64>, h: &DMatrix<f64>, columns: &[usize]) -> DVector<f64> {
    let mut p_ht = DMatrix::zeros(p.nrows(), 2);
    for (k, &column) in columns.iter().enumerate() {
        p_ht.ger(1.0, &p.column(column), &h.column(k), 1.0);
    }
    let mut s = Matrix2::new(0.0025, 0.0, 0.0, 0.0003);
    for (k, &row) in columns.iter().enumerate() {
        s += h.column(k) * p_ht.row(row);
    }
    let gain = &p_ht * s.try_inverse().expect("regular");
    p.gemm(-1.0, &gain, &p_ht.transpose(), 1.0);
    gain.column(0).into()
}

/// The lower half of `P - G (P H^T)^T`, of which the factors are given.
fn lower_update(p: &mut Mat<f64>, gain: &Mat<f64>, p_ht: &Mat<f64>) {
    use BlockStructure::{Rectangular, TriangularLower};
    let (lower, factors) = (TriangularLower, Rectangular);
    let transposed = p_ht.transpose();
    matmul(p, lower, Accum::Add, gain, factors, transposed, factors, -1.0, Par::Seq);
}

/// Whether a covariance is positive, as the filter asks faer, and by nalgebra's factorisation.
fn checks(c: &mut Criterion) {
    let mut group = c.benchmark_group("ekf-slam/check of 500 landmarks");
    group.sample_size(10);
    let slam = driven(500, SlamSettings::default());
    group.bench_function("loc-filters", |bencher| {
        bencher.iter(|| black_box(&slam).covariance().expect("positive"));
    });
    let mut whole = slam.covariance().expect("positive");
    let size = whole.nrows();
    (0..size).for_each(|k| whole[(k, k)] *= 1.0 + 1e-9);
    group.bench_function("nalgebra's Cholesky alone", |bencher| {
        bencher.iter_batched(|| whole.clone(), nalgebra::Cholesky::new, BatchSize::LargeInput);
    });
    group.finish();
}

fn updates(c: &mut Criterion) {
    let mut group = c.benchmark_group("ekf-slam/1-observation");
    for n in [100, 500, 1000, 2000_u32] {
        let mut slam = driven(n, SlamSettings::default());
        let seen = observations(&slam, 1);
        group.bench_function(BenchmarkId::new("loc-filters", n), |bencher| {
            bencher.iter(|| slam.correct(black_box(&seen)).expect("finite"));
        });
        let textbook = SlamSettings::default().jacobians(Jacobians::Current);
        let mut slam = driven(n, textbook);
        let seen = observations(&slam, 1);
        group.bench_function(BenchmarkId::new("loc-filters, textbook", n), |bencher| {
            bencher.iter(|| slam.correct(black_box(&seen)).expect("finite"));
        });
        let size = 3 + 2 * n as usize;
        let mut half = vec![1.0_f64; size * (size + 1) / 2];
        group.bench_function(BenchmarkId::new("read and write half", n), |bencher| {
            bencher.iter(|| black_box(&mut half).iter_mut().for_each(|value| *value *= 0.999_999));
        });
        if n <= 1000 {
            let mut p = DMatrix::from_fn(size, size, |i, j| if i == j { 1.0 } else { 0.3 });
            let h = DMatrix::from_row_slice(
                2,
                5,
                &[-0.6, -0.8, 0.0, 0.6, 0.8, 0.16, -0.12, -1.0, -0.16, 0.12],
            );
            let columns = [0, 1, 2, 9, 10];
            group.bench_function(BenchmarkId::new("full nalgebra", n), |bencher| {
                bencher.iter(|| full_update(black_box(&mut p), &h, &columns));
            });
        }
        let mut p = Mat::from_fn(size, size, |i, j| if i == j { 1.0 } else { 0.3 });
        let factor = Mat::from_fn(size, 2, |i, k| 1e-9 * (i + k) as f64);
        group.bench_function(
            BenchmarkId::new("lower half by faer, its product alone", n),
            |bencher| {
                bencher.iter(|| lower_update(black_box(&mut p), &factor, &factor));
            },
        );
    }
    group.finish();

    let mut group = c.benchmark_group("ekf-slam/8-observations");
    let mut slam = driven(1000, SlamSettings::default());
    let seen = observations(&slam, 8);
    group.bench_function("one pass", |bencher| {
        bencher.iter(|| slam.correct(black_box(&seen)).expect("finite"));
    });
    group.bench_function("eight passes", |bencher| {
        bencher.iter(|| {
            for one in black_box(&seen) {
                slam.correct(std::slice::from_ref(one)).expect("finite");
            }
        });
    });
    group.finish();

    checks(c);
    submap(c);

    let mut group = c.benchmark_group("ekf-slam/motion");
    for n in [100, 1000_u32] {
        let slam = driven(n, SlamSettings::default());
        group.bench_function(BenchmarkId::from_parameter(n), |bencher| {
            bencher.iter_batched_ref(
                || slam.clone(),
                |slam| {
                    for _ in 0..10 {
                        slam.predict(black_box(Twist2::forward(0.1, 0.1)), 0.1).expect("finite");
                    }
                },
                BatchSize::LargeInput,
            );
        });
    }
    group.finish();
}

/// 20 of 2000 landmarks in hand: a step among them, and what leaving them costs.
fn submap(c: &mut Criterion) {
    let mut group = c.benchmark_group("ekf-slam/20-of-2000");
    // So small that the landmarks in hand are those that were seen, and no others.
    let settings = SlamSettings::default().submap_radius(Some(0.1)).jacobians(Jacobians::First);
    let mut slam = driven(2000, settings);
    let seen = observations(&slam, 20);
    slam.correct(&seen).expect("finite");
    let mut forward = 1.0;
    group.bench_function("motion and 1 observation", |bencher| {
        bencher.iter(|| {
            forward = -forward;
            slam.predict(black_box(Twist2::forward(0.01 * forward, 0.0)), 0.1).expect("finite");
            slam.correct(black_box(&seen[..1])).expect("finite")
        });
    });
    let elsewhere = see(slam.pose().expect("positive").pose(), 1999);
    group.sample_size(10).bench_function("leaving and coming back", |bencher| {
        bencher.iter(|| {
            slam.correct(&[elsewhere]).expect("finite");
            slam.correct(black_box(&seen)).expect("finite")
        });
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = updates);
criterion_main!(benches);
