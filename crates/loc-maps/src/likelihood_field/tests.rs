//! What cannot be seen from outside: the instructions that the loops were compiled for.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

use super::rating::{InTiles, LogLikelihood, Rating};
use super::{View, sin_cos, *};
use crate::grid::Cell;
use loc_core::random::stream;
use pulp::{Simd, WithSimd};
use rand::{Rng, RngExt};

fn field(width: usize, height: usize, yaw: f64) -> LikelihoodField {
    let mut rng = stream(3, "field");
    let frame = GridFrame::new(width, height, 0.05, Pose2::new(4.0, -2.0, yaw)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for _ in 0..width * height / 50 {
        let cell = Cell::new(rng.random_range(0..width), rng.random_range(0..height));
        grid.set(cell, if rng.random() { 100 } else { -1 }).unwrap();
    }
    let settings = LikelihoodFieldSettings {
        unknown_space: UnknownSpace::Likelihood(0.3),
        off_map: OffMap::Likelihood(0.02),
        ..Default::default()
    };
    LikelihoodField::new(&grid, &settings).unwrap()
}

fn poses(rng: &mut impl Rng) -> [Vec<f64>; 3] {
    let mut draw = |low: f64, high: f64| (0..150).map(|_| rng.random_range(low..high)).collect();
    let mut poses: [Vec<f64>; 3] = [draw(0.0, 9.0), draw(-5.0, 3.0), draw(-7.0, 7.0)];
    for (k, odd) in [f64::NAN, f64::INFINITY, -1e300, 1e6, -40.0].into_iter().enumerate() {
        (poses[0][k], poses[1][k + 20], poses[2][k + 40]) = (odd, odd, odd);
    }
    poses
}

/// The sum of codes in its plain form: cell by cell, each case separately.
fn naive(field: &LikelihoodField, [x, y, theta]: [f64; 3], endpoints: &Endpoints) -> u64 {
    let View { u, v, cos, sin } = View::new(&field.frame, x, y, theta);
    let view = View { u: u + 8.0, v: v + 8.0, cos, sin };
    let code = |(&x, &y): (&f32, &f32)| {
        let (u, v) = view.end(x, y);
        // Rounded to 1/256 of a cell, and counted from the corner of the margin.
        let whole = |c: f32| ((f64::from(c) * 256.0).round_ties_even() / 256.0).floor() - 8.0;
        let (column, row) = (whole(u), whole(v));
        let (width, height) = (field.frame.width() as f64, field.frame.height() as f64);
        let on_map = column >= 0.0 && row >= 0.0 && column < width && row < height;
        let log_likelihood = if on_map {
            let cell = Cell::new(column as usize, row as usize);
            field.log_likelihood_at(&field.frame.center(cell))
        } else {
            0.02_f64.ln()
        };
        ((log_likelihood - field.scale.lowest) / field.scale.step).round() as u64
    };
    endpoints.xs().iter().zip(endpoints.ys()).map(code).sum()
}

/// The sums as compiled for some instructions.
fn sums<S: Simd>(
    simd: S,
    field: &LikelihoodField,
    [x, y, theta]: &[Vec<f64>; 3],
    endpoints: &Endpoints,
) -> Vec<f64> {
    struct Task<'a>(InTiles<'a, LogLikelihood<'a>>);
    impl WithSimd for Task<'_> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            self.0.with_simd(simd);
        }
    }
    let Codes::Tiles(tiles) = &field.codes else { panic!("expected tiles") };
    let mut out = vec![0.0; x.len()];
    let reading = LogLikelihood { lowest: 0.0, step: 1.0, sum: 0, out: out.iter_mut() };
    let LikelihoodField { frame, codes, .. } = field;
    let rating = Rating { frame, codes, x, y, theta, endpoints, reading };
    simd.vectorize(Task(InTiles { tiles, rating }));
    out
}

#[test]
fn all_instruction_sets_read_what_a_naive_loop_reads() {
    let mut rng = stream(7, "field");
    for (width, height, yaw) in [(61, 43, 0.0), (60, 48, 0.9), (2000, 3, -3.0), (1, 1, 1.6)] {
        let field = field(width, height, yaw);
        for beams in [0, 1, 7, 8, 16, 60, 513, 1100] {
            let mut end = || -> f64 { rng.random_range(-3.0..3.0) };
            let mut ends: Vec<[f64; 2]> = (0..beams).map(|_| [end(), end()]).collect();
            if let Some(far) = ends.first_mut() {
                *far = [3e30, -1e30];
            }
            let endpoints: Endpoints = ends.into_iter().collect();
            let poses = poses(&mut rng);
            let pose = |k: usize| [poses[0][k], poses[1][k], poses[2][k]];
            let expected: Vec<f64> =
                (0..150).map(|k| naive(&field, pose(k), &endpoints) as f64).collect();
            assert_eq!(sums(pulp::Scalar, &field, &poses, &endpoints), expected);
            #[cfg(target_arch = "x86_64")]
            {
                let avx2 = pulp::x86::V3::try_new();
                let avx512 = pulp::x86::V4::try_new();
                println!("AVX2 {}, AVX-512 {}", avx2.is_some(), avx512.is_some());
                let avx2 = avx2.map(|simd| sums(simd, &field, &poses, &endpoints));
                let avx512 = avx512.map(|simd| sums(simd, &field, &poses, &endpoints));
                assert!(avx2.is_none_or(|found| found == expected));
                assert!(avx512.is_none_or(|found| found == expected));
            }
        }
    }
}

#[test]
fn sines_and_cosines_are_right() {
    let mut worst = 0.0_f64;
    for k in -200_000..200_000 {
        let angle = f64::from(k) * 7.3e-5;
        for angle in [angle, angle * 1e5] {
            let (sin, cos) = sin_cos(angle);
            let off =
                (f64::from(sin) - angle.sin()).abs().max((f64::from(cos) - angle.cos()).abs());
            worst = worst.max(off);
        }
    }
    println!("sine and cosine: off by {worst:e} at most");
    assert!(worst < 1e-7, "{worst:e}");
    assert!([f64::NAN, f64::INFINITY].map(sin_cos).iter().all(|(s, c)| s.is_nan() && c.is_nan()));
}
