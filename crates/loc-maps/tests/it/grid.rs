use approx::assert_abs_diff_eq;
use loc_core::Pose2;
use loc_maps::Error;
use loc_maps::grid::{Cell, GridFrame, Occupancy, OccupancyGrid};
use nalgebra::Point2;

fn frame(yaw: f64) -> GridFrame {
    GridFrame::new(30, 20, 0.05, Pose2::new(1.0, -2.0, yaw)).unwrap()
}

#[test]
fn every_cell_is_found_at_its_centre_and_near_its_corners() {
    for yaw in [0.0, 1.0, 3.1, -2.0] {
        let frame = frame(yaw);
        for cell in frame.cells() {
            let (u, v) = (cell.column as f64, cell.row as f64);
            assert_eq!(frame.cell_at(&frame.center(cell)), Some(cell));
            for (du, dv) in [(0.001, 0.001), (0.999, 0.001), (0.001, 0.999), (0.999, 0.999)] {
                assert_eq!(frame.cell_at(&frame.to_map(u + du, v + dv)), Some(cell));
            }
        }
    }
}

#[test]
fn origin_is_the_corner_of_the_first_cell_and_yaw_turns_about_it() {
    let turned = frame(std::f64::consts::FRAC_PI_2);
    let corners = turned.corners();
    assert_abs_diff_eq!(corners[0], Point2::new(1.0, -2.0), epsilon = 1e-12);
    assert_abs_diff_eq!(corners[1], Point2::new(1.0, -0.5), epsilon = 1e-12);
    assert_abs_diff_eq!(corners[3], Point2::new(0.0, -2.0), epsilon = 1e-12);
    assert_abs_diff_eq!(turned.to_cells(&corners[2]), Point2::new(30.0, 20.0), epsilon = 1e-9);
    assert_abs_diff_eq!(
        turned.center(Cell::new(0, 0)),
        Point2::new(0.975, -1.975),
        epsilon = 1e-12
    );
}

#[test]
fn outside_is_unknown_and_never_panics() {
    let grid = OccupancyGrid::filled(frame(0.3), 0);
    for (x, y) in [(0.0, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 1.0), (1e300, -1e300)] {
        assert_eq!(grid.value_at(&Point2::new(x, y)), None);
        assert_eq!(grid.occupancy_at(&Point2::new(x, y)), Occupancy::Unknown);
    }
    assert_eq!(grid.value(Cell::new(30, 0)), None);
    assert_eq!(grid.value(Cell::new(usize::MAX, usize::MAX)), None);
    assert!(grid.row(20).is_empty() && grid.row(19).len() == 30);
}

#[test]
fn classes_and_counts() {
    let classes = [(-1, Occupancy::Unknown), (0, Occupancy::Free), (19, Occupancy::Free)];
    let more = [(20, Occupancy::Unknown), (64, Occupancy::Unknown), (65, Occupancy::Occupied)];
    for (value, class) in classes.into_iter().chain(more) {
        assert_eq!(Occupancy::of(value), class, "{value}");
        assert_eq!(Occupancy::of(class.value()), class);
    }
    let mut grid = OccupancyGrid::filled(frame(0.0), -1);
    grid.set(Cell::new(29, 19), 100).unwrap();
    grid.set(Cell::new(0, 0), 0).unwrap();
    let counts = grid.counts();
    assert_eq!((counts.free, counts.occupied, counts.unknown), (1, 1, 598));
    let wall: Vec<_> = grid.centers_of(Occupancy::Occupied).collect();
    assert_eq!(wall, [grid.frame().center(Cell::new(29, 19))]);
}

#[test]
fn bad_grids_are_refused() {
    let pose = Pose2::IDENTITY;
    for (width, height, resolution) in
        [(0, 5, 0.1), (5, 0, 0.1), (100_000, 100_000, 0.1), (usize::MAX, 2, 0.1), (5, 5, 0.0)]
            .into_iter()
            .chain([(5, 5, -0.1), (5, 5, f64::NAN), (5, 5, f64::INFINITY)])
    {
        assert!(GridFrame::new(width, height, resolution, pose).is_err());
    }
    assert!(GridFrame::new(5, 5, 0.1, Pose2 { theta: f64::NAN, ..pose }).is_err());
    let frame = GridFrame::new(2, 2, 0.1, pose).unwrap();
    let error = OccupancyGrid::new(frame, vec![0; 3]).unwrap_err();
    assert_eq!(error.to_string(), "grid: expected 2 x 2 values, got 3");
    let error = OccupancyGrid::new(frame, vec![0, 0, 101, 0]).unwrap_err();
    assert_eq!(error.to_string(), "cell (0, 1): expected a value of -1 to 100, got 101");
    let mut grid = OccupancyGrid::filled(frame, 0);
    assert!(matches!(grid.set(Cell::new(2, 0), 0), Err(Error::OutsideGrid { .. })));
    assert!(matches!(grid.set(Cell::new(1, 0), -2), Err(Error::CellValue { .. })));
}
