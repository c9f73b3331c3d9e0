//! Moving 10000 particles by one step with noise: each motion model, and beside them the odometry
//! model in its plain form, one particle at a time with the normal numbers of `rand_distr` and the
//! sine and cosine of the standard library. One thread.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use loc_core::kinematics::Ackermann;
use loc_core::motion::{Integration, OdometryMotion, OdometryNoise, VelocityNoise};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2, gaussian::pose_belief};
use loc_pf::motion::{
    AckermannStep, DifferentialStep, OmnidirectionalNoise, OmnidirectionalStep, VelocityStep,
};
use loc_pf::normals::Normals;
use loc_pf::{Motion, Particles, Workers};
use std::hint::black_box;

const PARTICLES: usize = 10_000;
const NOISE: OdometryNoise = OdometryNoise { alpha1: 0.2, alpha2: 0.2, alpha3: 0.2, alpha4: 0.2 };

fn cloud() -> Particles {
    let belief = pose_belief(Pose2::new(5.0, 5.0, 0.3), [0.15, 0.15, 0.05]);
    Particles::from_gaussian(&belief, PARTICLES, &mut stream(1, "particles"))
}

fn motion(c: &mut Criterion) {
    let mut group = c.benchmark_group("motion");
    group.throughput(Throughput::Elements(PARTICLES as u64));
    let (from, to) = (Pose2::IDENTITY, Pose2::new(0.25, 0.02, 0.1));
    let step = OdometryMotion::between(from, to);
    let plain = move |pose: Pose2, rng: &mut ChaCha8Rng| step.sample(&NOISE, rng).apply(pose);
    let mut bench = |name: &str, motion: &dyn Fn(&mut Particles, &mut ChaCha8Rng)| {
        let (mut cloud, mut rng) = (cloud(), stream(1, "motion"));
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter(|| motion(black_box(&mut cloud), &mut rng));
        });
    };
    let workers = Workers::one();
    bench("plain", &|cloud, rng| plain.sample(cloud.poses_mut(), rng));
    let step = DifferentialStep::between(from, to, &NOISE).expect("valid");
    bench("differential", &|cloud, rng| workers.sample(cloud, &step, rng));
    let noise = OmnidirectionalNoise::default();
    let step = OmnidirectionalStep::between(from, to, &noise).expect("valid");
    bench("omnidirectional", &|cloud, rng| workers.sample(cloud, &step, rng));
    let (noise, twist) = (VelocityNoise::default(), Twist2::forward(1.0, 0.4));
    for (name, rule) in ["velocity-euler", "velocity-midpoint", "velocity-exact-arc"]
        .into_iter()
        .zip(Integration::ALL)
    {
        let step = VelocityStep::new(twist, 0.25, &noise, rule).expect("valid");
        bench(name, &|cloud, rng| workers.sample(cloud, &step, rng));
    }
    let car = Ackermann::new(0.5).expect("valid");
    let step = AckermannStep::new(&car, [1.0, 0.1], [0.05, 0.02], 0.25).expect("valid");
    bench("ackermann", &|cloud, rng| workers.sample(cloud, &step, rng));
    group.finish();
    normals(c);
}

fn normals(c: &mut Criterion) {
    let mut group = c.benchmark_group("normal-numbers");
    group.throughput(Throughput::Elements(PARTICLES as u64));
    let mut numbers = vec![0.0; PARTICLES];
    let mut source = Normals::from_rng(&mut stream(1, "noise"));
    group.bench_function("side-by-side", |b| b.iter(|| source.fill(black_box(&mut numbers))));
    group.finish();
}

criterion_group! { name = benches; config = loc_bench::criterion(); targets = motion }
criterion_main!(benches);
