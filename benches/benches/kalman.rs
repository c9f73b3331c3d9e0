//! One predict + update of the linear Kalman filter with n states and m measurements, beside the
//! same step written out on bare nalgebra with the simple form `(I - K H) P` and an inverse.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use loc_core::Gaussian;
use loc_filters::Gate;
use loc_filters::kalman::{KalmanFilter, LinearMeasurement, LinearMotion};
use nalgebra::{Const, DimMin, SMatrix, SVector, ToTypenum};
use std::hint::black_box;

/// A chain of integrators, the first m of its states measured.
struct System<const N: usize, const M: usize> {
    a: SMatrix<f64, N, N>,
    b: SVector<f64, N>,
    c: SMatrix<f64, M, N>,
    process: SMatrix<f64, N, N>,
    sensor: SMatrix<f64, M, M>,
    start: Gaussian<N>,
}

impl<const N: usize, const M: usize> System<N, M> {
    fn new() -> Self {
        let mut a = SMatrix::<f64, N, N>::identity();
        for i in 0..N - M {
            a[(i, i + M)] = 0.1;
        }
        System {
            a,
            b: SVector::from_element(0.01),
            c: SMatrix::from_fn(|i, j| if i == j { 1.0 } else { 0.0 }),
            process: SMatrix::identity() * 0.01,
            sensor: SMatrix::identity() * 0.25,
            start: Gaussian::new(SVector::zeros(), SMatrix::identity()).expect("a covariance"),
        }
    }
}

/// The textbook's step with an explicit inverse, no checks, no gate, no innovation.
fn bare<const N: usize, const M: usize>(
    system: &System<N, M>,
    belief: &mut Gaussian<N>,
    z: &SVector<f64, M>,
) where
    Const<M>: ToTypenum + DimMin<Const<M>, Output = Const<M>>,
{
    let x = system.a * belief.mean + system.b;
    let p = system.a * belief.covariance * system.a.transpose() + system.process;
    let p_ct = p * system.c.transpose();
    let s = system.c * p_ct + system.sensor;
    let k = p_ct * s.try_inverse().expect("regular");
    belief.mean = x + k * (z - system.c * x);
    belief.covariance = (SMatrix::<f64, N, N>::identity() - k * system.c) * p;
}

fn bench<const N: usize, const M: usize>(c: &mut Criterion)
where
    Const<M>: ToTypenum + DimMin<Const<M>, Output = Const<M>>,
{
    let system = System::<N, M>::new();
    let control = SMatrix::<f64, 1, 1>::zeros();
    let motion = LinearMotion::new(system.a, system.b, control, system.process).expect("valid");
    let sensor = LinearMeasurement::new(system.c, system.sensor).expect("valid");
    let u = SVector::<f64, 1>::new(1.0);
    let z = SVector::<f64, M>::from_element(0.3);
    let mut group = c.benchmark_group(format!("kalman/{N}-{M}"));

    let mut filter = KalmanFilter::new(system.start).expect("valid");
    group.bench_function("loc-filters (Joseph form, gate, innovation)", |bencher| {
        bencher.iter(|| {
            filter.predict(black_box(&motion), black_box(&u)).expect("finite");
            filter.correct(black_box(&sensor), black_box(&z), &Gate::OPEN).expect("finite")
        });
    });
    let mut belief = system.start;
    group.bench_function("bare nalgebra (simple form, inverse)", |bencher| {
        bencher.iter(|| bare(black_box(&system), &mut belief, black_box(&z)));
    });
    group.finish();
}

fn all(c: &mut Criterion) {
    bench::<2, 1>(c);
    bench::<4, 2>(c);
    bench::<6, 3>(c);
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = all);
criterion_main!(benches);
