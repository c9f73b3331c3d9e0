//! Tests of private parts: each against a plain computation of the same.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

mod correction;
mod parts;

use super::correct::{Scan, Sensor};
use super::settings::GridSettings;
use super::space::PoseSpace;
use loc_core::Pose2;
use loc_core::random::{ChaCha8Rng, stream};
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame};
use loc_sensors::laser::LaserScan;
use loc_sensors::world::RangeWorld;
use rand::RngExt;

/// A room of 6 m x 4 m with a few boxes and an unknown corner, turned by 0.4 rad in the map.
fn room() -> OccupancyGrid {
    let frame = GridFrame::new(120, 80, 0.05, Pose2::new(3.0, -2.0, 0.4)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for cell in frame.cells() {
        let Cell { column, row } = cell;
        let wall = column < 3 || row < 2 || column > 116 || row > 77;
        let boxes = [(20, 30, 10), (70, 10, 7), (95, 60, 12), (45, 55, 5)];
        let in_box = |&(c, r, side): &(usize, usize, usize)| {
            (c..c + side).contains(&column) && (r..r + side).contains(&row)
        };
        if wall || boxes.iter().any(in_box) {
            grid.set(cell, 100).unwrap();
        } else if column > 105 && row < 15 {
            grid.set(cell, -1).unwrap();
        }
    }
    grid
}

fn settings() -> GridSettings {
    let heading = 10_f64.to_radians();
    GridSettings { heading, beams: 24, independent_beams: 8.0, ..GridSettings::default() }
}

struct Setting {
    settings: GridSettings,
    space: PoseSpace,
    sensor: Sensor,
}

impl Setting {
    fn new(map: &OccupancyGrid, settings: GridSettings) -> Self {
        let space = PoseSpace::new(map, &settings).unwrap();
        let sensor = Sensor::new(map, &space, &settings).unwrap();
        Setting { settings, space, sensor }
    }

    fn scan(&self, scan: &LaserScan) -> Scan {
        let mounting = Pose2::new(0.1, 0.0, 0.0);
        Scan::new(scan, mounting, &self.sensor.field, &self.space, &self.settings).unwrap()
    }
}

/// A scan from a pose, a tenth of its beams wrong.
fn scan(map: &OccupancyGrid, from: Pose2, rng: &mut ChaCha8Rng) -> LaserScan {
    let mut ranges = vec![0.0; 60];
    let increment = 4.0 / 59.0;
    let laser = from * Pose2::new(0.1, 0.0, 0.0);
    map.cast_fan(&laser.position(), laser.theta - 2.0, increment, 20.0, &mut ranges);
    for range in &mut ranges {
        *range += rng.random_range(-0.03..0.03);
        if rng.random_range(0.0..1.0) < 0.1 {
            *range = rng.random_range(0.3..15.0);
        }
    }
    LaserScan {
        angle_min: -2.0,
        angle_max: 2.0,
        angle_increment: increment,
        time_increment: 0.0,
        scan_time: 0.0,
        range_min: 0.05,
        range_max: 20.0,
        ranges,
        intensities: Vec::new(),
    }
}

/// A pose in free space.
fn place(map: &OccupancyGrid, rng: &mut ChaCha8Rng) -> Pose2 {
    loop {
        let (u, v) = (rng.random_range(0.0..120.0), rng.random_range(0.0..80.0));
        let at = map.frame().to_map(u, v);
        if map.value_at(&at) == Some(0) {
            return Pose2::new(at.x, at.y, rng.random_range(-3.1..3.1));
        }
    }
}

fn rng(name: &str) -> ChaCha8Rng {
    stream(17, name)
}
