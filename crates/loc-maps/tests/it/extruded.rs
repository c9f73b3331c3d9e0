//! Grids whose walls stand up, and landmarks behind walls.

use loc_core::Pose2;
use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
use loc_maps::{ExtrudedGrid, Landmark, LandmarkMap, Occluded};
use loc_sensors::world::{LandmarkWorld, RangeWorld, WallHit, WallWorld};
use nalgebra::Point2;

/// A wall at x = 9 m, a table of 0.6 m x 0.6 m in the middle, turned by `yaw` about the origin.
fn room(yaw: f64) -> OccupancyGrid {
    let frame = GridFrame::new(100, 60, 0.1, Pose2::new(0.0, 0.0, yaw)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for row in 0..60 {
        grid.set(Cell::new(90, row), 100).unwrap();
    }
    for (column, row) in (50..56).flat_map(|column| (27..33).map(move |row| (column, row))) {
        grid.set(Cell::new(column, row), 100).unwrap();
    }
    grid
}

fn hits(world: &ExtrudedGrid, origin: [f64; 2], direction: f64, reach: f64) -> Vec<WallHit> {
    let mut hits = Vec::new();
    world.visit_walls(&Point2::from(origin), direction, reach, &mut |wall| {
        hits.push(wall);
        true
    });
    hits
}

#[test]
fn furniture_is_low_and_walls_are_high() {
    let world = ExtrudedGrid::new(room(0.0), 2.5).unwrap();
    let seen = hits(&world, [1.0, 3.0], 0.0, 20.0);
    assert_eq!(seen.len(), 2, "each body once, however many cells the ray passes in it");
    assert!((seen[0].range - 4.0).abs() < 1e-9 && (0.3..1.3).contains(&seen[0].height));
    assert!((seen[1].range - 8.0).abs() < 1e-9 && seen[1].height == 2.5);
    assert_ne!(seen[0].color, seen[1].color);
    assert_eq!(hits(&world, [1.0, 3.0], 0.0, 6.0).len(), 1);
    assert!(hits(&world, [1.0, 3.0], std::f64::consts::PI, 20.0).is_empty());
    assert!(hits(&world, [f64::NAN, 3.0], 0.0, 20.0).is_empty());
}

/// The first body is met where a ray is cast, whatever the yaw of the grid.
#[test]
fn the_first_body_is_where_the_ray_ends() {
    for yaw in [0.0, 0.4, 2.0, -3.0] {
        let (grid, world) = (room(yaw), ExtrudedGrid::new(room(yaw), 2.5).unwrap());
        let origin = Pose2::new(0.0, 0.0, yaw).transform(&Point2::new(2.0, 1.7));
        for k in 0..40 {
            let direction = f64::from(k) * 0.157;
            let first = hits(&world, [origin.x, origin.y], direction, 15.0).first().copied();
            let cast = grid.cast(&origin, direction, 15.0);
            assert_eq!(first.map(|hit| hit.range), cast, "yaw {yaw}, direction {direction}");
        }
    }
}

#[test]
fn heights_must_be_positive() {
    for height in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(ExtrudedGrid::new(room(0.0), height).is_err());
    }
}

#[test]
fn landmarks_behind_walls_are_not_there() {
    let planar = Landmark::planar;
    let map = [planar(1, 4.0, 3.0), planar(2, 5.0, 3.0), planar(3, 8.0, 3.0), planar(4, 8.0, 0.5)];
    let landmarks = LandmarkMap::new(map).unwrap();
    let walls = room(0.0);
    let seen = |slack: f64, reach: f64| {
        let mut seen = Vec::new();
        let world = Occluded { landmarks: &landmarks, walls: &walls, slack };
        world.visit_landmarks(&Point2::new(1.0, 3.0), reach, &mut |id, _| seen.push(id));
        seen
    };
    assert_eq!(seen(0.1, 20.0), [1, 2, 4], "2 hangs on the table, 3 is behind it");
    assert_eq!(seen(0.1, 3.5), [1]);
    assert_eq!(seen(5.0, 20.0), [1, 2, 3, 4]);
}
