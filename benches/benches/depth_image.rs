//! A depth image of an Xtion PRO (640 x 480) with noise and colour on the bench map, beside the
//! same picture by a ray for every pixel.
#![allow(missing_docs, clippy::expect_used)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::sampling::box_muller;
use loc_maps::RayCaster;
use loc_sensors::rgbd::{DepthCamera, DepthCameraSpec, VirtualScan};
use loc_sensors::world::{Extruded, RangeWorld};
use rand::Rng;
use std::hint::black_box;

const HEIGHT: f64 = 1.0;

/// One planar ray for each pixel, then its height decides between wall and floor.
fn bare(room: &RayCaster, pose: Pose2, camera: &DepthCamera, rng: &mut impl Rng) -> Vec<f32> {
    let spec = &camera.spec;
    let (columns, rows) = (spec.column_slopes(), spec.row_slopes());
    let (shift, step) = (spec.disparity_depth(), spec.noise.step);
    let mut depths = Vec::with_capacity(spec.width * spec.height);
    for up in &rows {
        for left in &columns {
            let range = room.cast(&pose.position(), pose.theta + left.atan(), 10.0);
            let wall = range.unwrap_or(f64::INFINITY) * left.atan().cos();
            let height = camera.height + wall * up;
            let floor = if *up < 0.0 { -camera.height / up } else { f64::INFINITY };
            let depth = if (0.0..=HEIGHT).contains(&height) { wall } else { floor };
            let noisy = shift / depth + spec.noise.sigma * box_muller(rng).0;
            let seen = shift / ((noisy / step).round() * step);
            let valid = (spec.range_min..=spec.range_max).contains(&seen);
            depths.push(if valid { seen as f32 } else { f32::NAN });
        }
    }
    depths
}

fn image(c: &mut Criterion) {
    let room = RayCaster::new(&loc_bench::map().expect("the bench map"));
    let pose = Pose2::new(5.0, 5.0, 0.3);
    let world = Extruded::new(&room, HEIGHT).expect("valid");
    let world = world.with_stripes([[200, 40, 40], [230, 230, 230]]);
    let camera = DepthCamera::new(DepthCameraSpec::xtion_pro()).expect("valid");
    let mut rng = stream(1, "camera");
    let mut group = c.benchmark_group("depth-image/xtion-pro");
    group.throughput(Throughput::Elements((camera.spec.width * camera.spec.height) as u64));

    group.bench_function("loc-sensors", |bencher| {
        bencher.iter(|| camera.capture(black_box(&world), black_box(pose), &mut rng));
    });
    let frame = camera.capture(&world, pose, &mut rng);
    group.bench_function("virtual scan of it", |bencher| {
        bencher.iter(|| VirtualScan::default().of(black_box(&frame.depth), &camera));
    });
    group.sample_size(20);
    group.bench_function("a ray for every pixel, no colour", |bencher| {
        bencher.iter(|| bare(black_box(&room), black_box(pose), &camera, &mut rng));
    });
    group.finish();
}

criterion_group!(name = benches; config = loc_bench::criterion(); targets = image);
criterion_main!(benches);
