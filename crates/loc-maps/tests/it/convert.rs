use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_core::angle::difference;
use loc_maps::convert::{Surface, VectorizeSettings};
use loc_maps::grid::{Cell, GridFrame, Occupancy};
use loc_maps::{LineMap, LineSegment, OccupancyGrid, PointMap};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use proptest::prelude::*;

fn map(lines: &[[f64; 4]]) -> LineMap {
    LineMap::new(lines.iter().map(|l| LineSegment::new([l[0], l[1]], [l[2], l[3]]))).unwrap()
}

fn turned_frame() -> GridFrame {
    GridFrame::new(60, 40, 0.1, Pose2::new(-2.0, 1.0, 0.4)).unwrap()
}

proptest! {
    #[test]
    fn every_cell_that_a_line_touches_is_occupied_and_no_other(
        lines in prop::collection::vec(prop::array::uniform4(-6.0..8.0), 1..8),
    ) {
        let (map, frame) = (map(&lines), turned_frame());
        let grid = map.rasterize(&frame);
        for line in map.lines() {
            for k in 0..=1000 {
                let point = line.at(f64::from(k) / 1000.0);
                let class = grid.occupancy_at(&point);
                let outside = frame.cell_at(&point).is_none();
                prop_assert!(outside || class == Occupancy::Occupied, "{point} of {line:?}");
            }
        }
        let half = 0.1 * std::f64::consts::FRAC_1_SQRT_2 + 1e-9;
        for center in grid.centers_of(Occupancy::Occupied) {
            prop_assert!(map.nearest(&center).unwrap().distance <= half, "{center}");
        }
    }
}

#[test]
fn lines_along_cell_borders_fill_one_row_of_cells() {
    let frame = GridFrame::new(10, 10, 1.0, Pose2::IDENTITY).unwrap();
    let grid = map(&[[2.0, 3.0, 5.5, 3.0], [8.0, 0.0, 8.0, 20.0]]).rasterize(&frame);
    let occupied: Vec<Cell> =
        grid.iter().filter(|(_, v)| *v == 100).map(|(cell, _)| cell).collect();
    let expected = |k: usize| match k {
        3..=6 => Cell::new(k - 1, 3),
        7 => Cell::new(8, 3),
        _ => Cell::new(8, if k < 3 { k } else { k - 4 }),
    };
    assert_eq!(occupied, (0..14).map(expected).collect::<Vec<_>>());
}

#[test]
fn grids_around_maps_hold_them() {
    let lines = map(&[[0.0, 0.0, 1.0, 0.5], [1.0, 0.5, 1.0, 2.0]]);
    let grid = lines.to_grid(0.25, 0.0).unwrap();
    assert_eq!((grid.width(), grid.height()), (5, 9));
    assert_eq!(grid.occupancy_at(&[1.0, 2.0].into()), Occupancy::Occupied);
    let points = PointMap::from_lines(&lines, 0.1).unwrap();
    assert_eq!(points.len(), 13 + 16);
    let grid = points.to_grid(0.25, 1.0).unwrap();
    assert!(points.points().iter().all(|p| grid.occupancy_at(p) == Occupancy::Occupied));
    assert_eq!(LineMap::new([]).unwrap().to_grid(0.1, 0.0).unwrap().frame().cell_count(), 1);
    for (resolution, margin) in [(0.0, 1.0), (f64::NAN, 1.0), (0.1, -1.0), (1e-9, 0.0)] {
        assert!(lines.to_grid(resolution, margin).is_err());
    }
    assert!(PointMap::from_lines(&lines, 0.0).is_err());
    assert!(PointMap::from_lines(&lines, 1e-9).is_err());
}

#[test]
fn cells_become_points_at_their_centres() {
    let mut grid = OccupancyGrid::filled(turned_frame(), 100);
    grid.set(Cell::new(10, 10), 0).unwrap();
    grid.set(Cell::new(59, 39), 0).unwrap();
    let all = PointMap::from_grid(&grid, Surface::All).unwrap();
    assert_eq!(all.len(), 60 * 40 - 2);
    let boundary = PointMap::from_grid(&grid, Surface::Boundary).unwrap();
    assert_eq!(boundary.len(), 8 + 3);
    assert_eq!(boundary.points()[0], grid.frame().center(Cell::new(9, 9)));
    // No beam slips between the cells of a diagonal wall.
    let wall = map(&[[3.0, -3.0, 4.5, 3.0]]).to_grid(0.05, 0.1).unwrap();
    let wall = PointMap::from_grid(&wall, Surface::All).unwrap();
    for k in -600..600 {
        assert!(wall.cast(&[0.0, 0.0].into(), f64::from(k) * 0.0009, 10.0).is_some());
    }
}

#[test]
fn drawn_walls_are_found_again() {
    let walls = map(&[
        [0.0, 0.0, 6.0, 1.0],
        [6.0, 1.0, 5.0, 7.0],
        [5.0, 7.0, -1.0, 6.0],
        [-1.0, 6.0, 0.0, 0.0],
        [2.0, 3.0, 2.5, 5.0],
    ]);
    let found =
        LineMap::from_grid(&walls.to_grid(0.05, 0.2).unwrap(), &Default::default()).unwrap();
    assert_eq!(found.len(), walls.len(), "{found:?}");
    for wall in walls.lines() {
        let middle = wall.at(0.5);
        let near = found.nearest(&middle).unwrap();
        let line = found.lines()[near.line];
        assert!(near.distance < 0.03, "{wall:?} {line:?}");
        let turn = difference(2.0 * line.direction(), 2.0 * wall.direction()) / 2.0;
        assert!(turn.abs() < 0.01, "{wall:?} {line:?}");
        assert_relative_eq!(line.length(), wall.length(), epsilon = 0.25);
    }
    let longest_first = found.lines().windows(2).all(|pair| pair[0].length() >= pair[1].length());
    assert!(longest_first);
}

#[test]
fn specks_are_no_lines_and_absurd_settings_are_refused() {
    let mut grid = OccupancyGrid::filled(turned_frame(), 0);
    for k in 0..10 {
        grid.set(Cell::new(5 * k + 3, (7 * k) % 40), 100).unwrap();
    }
    assert!(LineMap::from_grid(&grid, &VectorizeSettings::default()).unwrap().is_empty());
    for bad in [0.0, -1.0, f64::NAN] {
        let base = VectorizeSettings::default();
        for settings in [
            VectorizeSettings { min_length: bad, ..base },
            VectorizeSettings { max_gap: bad, ..base },
            VectorizeSettings { tolerance: bad, ..base },
            VectorizeSettings { min_cover: bad, ..base },
        ] {
            assert!(LineMap::from_grid(&grid, &settings).is_err());
        }
    }
    let too_much = VectorizeSettings { min_cover: 1.1, ..VectorizeSettings::default() };
    assert!(LineMap::from_grid(&grid, &too_much).is_err());
}

#[test]
fn scans_of_a_room_give_its_grid() {
    let room = map(&[
        [0.0, 0.0, 4.0, 0.0],
        [4.0, 0.0, 4.0, 3.0],
        [4.0, 3.0, 0.0, 3.0],
        [0.0, 3.0, 0.0, 0.0],
    ]);
    let scan = |pose: Pose2| -> Vec<Point2<f64>> {
        let beams = (0..720).map(|k| f64::from(k) * 0.5_f64.to_radians());
        let end = |a: f64| {
            room.cast(&pose.position(), pose.theta + a, 10.0)
                .map(|r| Point2::new(r * a.cos(), r * a.sin()))
        };
        beams.filter_map(end).collect()
    };
    let poses = [Pose2::new(1.0, 1.0, 0.3), Pose2::new(3.0, 2.0, -2.0)];
    let scans: Vec<_> = poses.map(|pose| (pose, scan(pose))).into();
    let slices = scans.iter().map(|(pose, points)| (*pose, points.as_slice()));
    let points = PointMap::from_scans(slices, 0.05).unwrap();
    // In the corners, points of two walls become one.
    assert!(points.points().iter().all(|p| room.nearest(p).unwrap().distance < 0.03));
    let sampled = PointMap::from_lines(&room, 0.05).unwrap();
    assert!(sampled.points().iter().all(|p| points.nearest(p).unwrap().distance < 0.06));
}

#[test]
fn walls_of_a_real_building_become_lines() {
    let Some(folder) = crate::data("carmen") else { return };
    let grid = loc_maps::grid::io::load(folder.join("intel.yaml")).unwrap();
    let lines = LineMap::from_grid(&grid, &VectorizeSettings::default()).unwrap();
    assert!((200..400).contains(&lines.len()), "{}", lines.len());
    let cells = PointMap::from_grid(&grid, Surface::Boundary).unwrap();
    let near = cells.points().iter().filter(|p| lines.nearest(p).unwrap().distance < 0.1);
    let share = near.count() as f64 / cells.len() as f64;
    assert!(share > 0.75, "{share}");
    for line in lines.lines().iter().filter(|line| line.length() > 2.0) {
        let far = (0..=20).map(|k| cells.nearest(&line.at(f64::from(k) / 20.0)).unwrap().distance);
        assert!(far.fold(0.0, f64::max) < 0.2, "{line:?}");
    }
}

/// Rays of the outline end where rays of the grid do, and every line is as long as it can be.
#[test]
fn the_outline_of_a_grid_is_where_its_rays_end() {
    let mut grid = OccupancyGrid::filled(turned_frame(), 100);
    for cell in grid.frame().cells() {
        let is_room = (2..58).contains(&cell.column) && (2..38).contains(&cell.row);
        let is_table = (20..30).contains(&cell.column) && (10..15).contains(&cell.row);
        let step = (cell.column, cell.row) == (30, 10);
        if is_room && !is_table && !step {
            grid.set(cell, 0).unwrap();
        }
    }
    // What was not seen is no wall.
    (0..40).for_each(|row| grid.set(Cell::new(59, row), -1).unwrap());
    let outline = LineMap::outline(&grid).unwrap();
    // Four walls, four sides of the table, of which the lower runs on along the step, and the other
    // two sides of that.
    assert_eq!(outline.len(), 4 + 4 + 2);
    assert_relative_eq!(outline.lines()[0].length(), 5.6, epsilon = 1e-12);
    let origin = grid.frame().to_map(10.5, 20.25);
    for k in 0..1000 {
        let direction = 0.00631 * f64::from(k);
        let [a, b] = [outline.cast(&origin, direction, 10.0), grid.cast(&origin, direction, 10.0)];
        assert_relative_eq!(a.unwrap(), b.unwrap(), epsilon = 1e-9);
    }
    assert!(LineMap::outline(&OccupancyGrid::filled(turned_frame(), 0)).unwrap().is_empty());
}
