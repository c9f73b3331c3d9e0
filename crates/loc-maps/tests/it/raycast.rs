use loc_core::Pose2;
use loc_maps::RayCaster;
use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use proptest::prelude::*;

/// The range to the nearest of all occupied cells, each made larger by `margin` on all sides, by
/// cutting the ray with its square.
fn brute_force(
    grid: &OccupancyGrid,
    origin: &Point2<f64>,
    direction: f64,
    max_range: f64,
    margin: f64,
) -> Option<f64> {
    let frame = grid.frame();
    let start = frame.to_cells(origin);
    let (sin, cos) = (direction - frame.origin().theta).sin_cos();
    let cut = |start: f64, along: f64, from: f64| {
        let (low, high) = (from - margin - start, from + 1.0 + margin - start);
        if along == 0.0 {
            let inside = low <= 0.0 && high >= 0.0;
            return if inside { (f64::NEG_INFINITY, f64::INFINITY) } else { (1.0, -1.0) };
        }
        ((low / along).min(high / along), (low / along).max(high / along))
    };
    let ranges = grid.iter().filter(|&(_, value)| value >= 65).filter_map(|(cell, _)| {
        let (near_u, far_u) = cut(start.x, cos, cell.column as f64);
        let (near_v, far_v) = cut(start.y, sin, cell.row as f64);
        let (near, far) = (near_u.max(near_v).max(0.0), far_u.min(far_v));
        (near <= far).then_some(near * frame.resolution())
    });
    ranges.min_by(f64::total_cmp).filter(|&range| range <= max_range)
}

/// Checks a range against brute force: it must lie between the ranges to cells a hair larger and
/// a hair smaller.
fn check<W: RangeWorld>(grid: &OccupancyGrid, world: &W, origin: [f64; 2], dir: f64, max: f64) {
    const HAIR: f64 = 1e-7;
    let origin = Point2::from(origin);
    let found = world.cast(&origin, dir, max).unwrap_or(f64::INFINITY);
    let bound = |margin, max| brute_force(grid, &origin, dir, max, margin).unwrap_or(f64::INFINITY);
    let (least, most) = (bound(HAIR, max + HAIR), bound(-HAIR, max - HAIR));
    assert!(
        least - 1e-6 <= found && found <= most + 1e-6,
        "{}: from {origin} along {dir} up to {max}: {found}, expected {least} to {most}",
        std::any::type_name::<W>()
    );
}

fn grids() -> impl Strategy<Value = OccupancyGrid> {
    let share = prop_oneof![Just(0.002), Just(0.02), Just(0.2), Just(0.9)];
    (1..180_usize, 1..90_usize, share, -4.0..4.0_f64, any::<u64>()).prop_map(
        |(width, height, share, yaw, seed)| {
            use rand::RngExt;
            let mut rng = loc_core::random::stream(seed, "cells");
            let frame = GridFrame::new(width, height, 0.1, Pose2::new(1.0, 2.0, yaw)).unwrap();
            let cells = (0..width * height).map(|_| if rng.random_bool(share) { 100 } else { 0 });
            OccupancyGrid::new(frame, cells.collect()).unwrap()
        },
    )
}

fn origins() -> impl Strategy<Value = [f64; 2]> {
    prop_oneof![
        (-25.0..25.0_f64, -25.0..25.0_f64).prop_map(|(x, y)| [x, y]),
        (-3.0..8.0_f64, -3.0..8.0_f64).prop_map(|(x, y)| [x, y]),
    ]
}

fn directions() -> impl Strategy<Value = f64> {
    use std::f64::consts::FRAC_PI_4;
    prop_oneof![-7.0..7.0_f64, (-8..9_i32).prop_map(|k| f64::from(k) * FRAC_PI_4), -0.02..0.02_f64]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, max_shrink_iters: 40, ..Default::default() })]
    #[test]
    fn both_casters_agree_with_brute_force(
        grid in grids(),
        rays in proptest::collection::vec((origins(), directions(), 0.0..40.0_f64), 20),
    ) {
        let caster = RayCaster::new(&grid);
        for (origin, direction, max_range) in rays {
            check(&grid, &grid, origin, direction, max_range);
            check(&grid, &caster, origin, direction, max_range);
            check(&grid, &caster, origin, direction + grid.origin().theta, f64::INFINITY);
            check(&grid, &grid, origin, direction + grid.origin().theta, f64::INFINITY);
        }
    }

    #[test]
    fn both_casters_agree_to_the_last_digit(
        grid in grids(),
        rays in proptest::collection::vec((origins(), -7.0..7.0_f64, 0.0..40.0_f64), 100),
    ) {
        let caster = RayCaster::new(&grid);
        for (origin, direction, max_range) in rays {
            let origin = Point2::from(origin);
            let exact = grid.cast(&origin, direction, max_range);
            prop_assert_eq!(caster.cast(&origin, direction, max_range), exact);
        }
    }
}

/// A room with one pillar, cells of 1 m.
fn pillar(yaw: f64) -> OccupancyGrid {
    let frame = GridFrame::new(20, 20, 1.0, Pose2::new(0.0, 0.0, yaw)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    grid.set(Cell::new(10, 10), 100).unwrap();
    grid
}

#[test]
fn hits_from_all_sides_inside_and_outside_the_map() {
    use std::f64::consts::{FRAC_PI_2, PI};
    for yaw in [0.0, 0.7, FRAC_PI_2, 3.1] {
        let grid = pillar(yaw);
        let caster = RayCaster::new(&grid);
        let to_map = |u, v| grid.frame().to_map(u, v);
        for (u, v, direction, range) in [
            (10.5, 2.5, FRAC_PI_2, 7.5),
            (10.5, 18.5, -FRAC_PI_2, 7.5),
            (2.5, 10.5, 0.0, 7.5),
            (18.5, 10.5, PI, 7.5),
            (-100.0, 10.5, 0.0, 110.0),
            (10.5, 200.0, -FRAC_PI_2, 189.0),
            (10.2, 10.9, 0.3, 0.0),
        ] {
            for world in [&grid as &dyn RangeWorld, &caster] {
                let found = world.cast(&to_map(u, v), direction + yaw, 1000.0).unwrap();
                assert!((found - range).abs() < 1e-9, "{yaw} {u} {v} {direction}: {found}");
                let short = world.cast(&to_map(u, v), direction + yaw, range - 0.01);
                assert!(short.is_none() || range == 0.0);
            }
        }
    }
}

#[test]
fn nothing_to_hit_and_nonsense() {
    let grid = pillar(0.0);
    let caster = RayCaster::new(&grid);
    let nan = f64::NAN;
    let inf = f64::INFINITY;
    for (x, y, direction, max_range) in [
        (1.0, 1.0, 0.0, 1e9),
        (1.0, 1.0, 0.0, inf),
        (-1.0, 10.5, 3.0, 100.0),
        (nan, 1.0, 0.0, 10.0),
        (inf, 10.5, 3.0, inf),
        (1.0, -inf, 1.0, 10.0),
        (1.0, 10.5, nan, 10.0),
        (1.0, 10.5, inf, 10.0),
        (1.0, 10.5, 0.0, nan),
        (1.0, 10.5, 0.0, -1.0),
        (1e300, 1e300, 1.0, inf),
    ] {
        for world in [&grid as &dyn RangeWorld, &caster] {
            let found = world.cast(&Point2::new(x, y), direction, max_range);
            assert_eq!(found, None, "{x} {y} {direction} {max_range}");
        }
    }
}

#[test]
fn a_fan_is_its_rays() {
    let grid = pillar(0.4);
    let caster = RayCaster::new(&grid);
    let origin = Point2::new(3.0, 9.0);
    let mut ranges = vec![0.0; 2000];
    caster.cast_fan(&origin, -3.0, 0.003, 30.0, &mut ranges);
    for (k, &range) in ranges.iter().enumerate() {
        let direction = -3.0 + k as f64 * 0.003;
        let alone = caster.cast(&origin, direction, 30.0).unwrap_or(f64::INFINITY);
        assert!(range == alone || (range - alone).abs() < 1e-9, "{k}: {range} {alone}");
    }
    assert!(ranges.iter().any(|range| range.is_finite()));
}

/// Rays in the known space stop at unknown cells as at obstacles, and at nothing else.
#[test]
fn rays_in_the_known_space_end_where_it_ends() {
    let mut grid = pillar(0.3);
    let frame = *grid.frame();
    (0..frame.height()).for_each(|row| grid.set(Cell::new(1, row), -1).unwrap());
    let mut walls = grid.clone();
    (0..frame.height()).for_each(|row| walls.set(Cell::new(1, row), 100).unwrap());
    let (known, all, free) =
        (RayCaster::within_known(&grid), RayCaster::new(&walls), RayCaster::new(&grid));
    let origin = frame.center(Cell::new(3, 1));
    let mut stopped = 0;
    for k in 0..360 {
        let direction = f64::from(k).to_radians();
        let range = known.cast(&origin, direction, 50.0);
        assert_eq!(range, all.cast(&origin, direction, 50.0));
        stopped += u32::from(range != free.cast(&origin, direction, 50.0));
    }
    assert!(stopped > 50, "{stopped}");
}
