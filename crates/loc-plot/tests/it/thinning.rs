//! Leaving out points without changing the picture.

use loc_core::random::stream;
use loc_core::{Gaussian, nalgebra::Vector2};
use loc_plot::{simplify, thin_columns};

type Point = (f64, f64);

fn distance(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let squared = dx * dx + dy * dy;
    let along = (p.0 - a.0) * dx + (p.1 - a.1) * dy;
    let share = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    f64::hypot(p.0 - a.0 - share * dx, p.1 - a.1 - share * dy)
}

/// The largest distance of any point to the thinned path.
fn deviation(points: &[Point], thinned: &[Point]) -> f64 {
    let nearest = |&p: &Point| {
        let segments = thinned.windows(2);
        segments.map(|s| distance(p, s[0], s[1])).fold(f64::INFINITY, f64::min)
    };
    points.iter().map(nearest).fold(0.0, f64::max)
}

fn random_walk(steps: usize, scale: f64) -> Vec<Point> {
    let mut rng = stream(3, "walk");
    let step = Gaussian::new(Vector2::zeros(), loc_core::nalgebra::Matrix2::identity()).unwrap();
    let mut at = Vector2::zeros();
    let mut path = Vec::new();
    for _ in 0..steps {
        at += scale * step.sample(&mut rng);
        path.push((at.x, at.y));
    }
    path
}

#[test]
fn a_thinned_path_stays_within_its_tolerance() {
    let circle =
        |k: i32| (100.0 * (f64::from(k) * 0.003).cos(), 100.0 * (f64::from(k) * 0.003).sin());
    let there_and_back = |k: i32| (f64::from((k % 100).min(100 - k % 100)), 0.0);
    let paths: [Vec<Point>; 4] = [
        (0..3000).map(circle).collect(),
        (0..3000).map(there_and_back).collect(),
        random_walk(3000, 0.1),
        random_walk(3000, 3.0),
    ];
    for path in paths {
        for tolerance in [0.05, 0.3, 2.0] {
            let thinned = simplify(&path, tolerance);
            assert!(deviation(&path, &thinned) <= tolerance + 1e-12);
            assert_eq!((thinned.first(), thinned.last()), (path.first(), path.last()));
            assert!(thinned.len() <= path.len());
        }
    }
}

#[test]
fn straight_lines_keep_their_ends_alone() {
    let line: Vec<Point> = (0..1000).map(|k| (f64::from(k), 2.0 * f64::from(k))).collect();
    assert_eq!(simplify(&line, 0.1), [line[0], line[999]]);
    assert_eq!(simplify(&line[..2], 0.1), line[..2]);
    assert_eq!(simplify(&[(1.0, 1.0)], 0.1), [(1.0, 1.0)]);
    assert!(simplify(&[], 0.1).is_empty());
}

#[test]
fn a_path_that_turns_back_keeps_its_tip() {
    let spike = [(0.0, 0.0), (10.0, 0.0), (5.0, 0.0)];
    assert_eq!(simplify(&spike, 0.3), spike);
}

#[test]
fn columns_keep_first_lowest_highest_and_last() {
    let run = [(0.1, 3.0), (0.2, 9.0), (0.3, 4.0), (0.4, -2.0), (0.5, 1.0), (1.5, 7.0)];
    let kept = [(0.1, 3.0), (0.2, 9.0), (0.4, -2.0), (0.5, 1.0), (1.5, 7.0)];
    assert_eq!(thin_columns(&run, 1.0), kept);
    let noise: Vec<Point> =
        (0..100_000).map(|k| (f64::from(k) * 1e-3, (f64::from(k) * 1.7).sin())).collect();
    assert!(thin_columns(&noise, 1.0).len() <= 404);
}
