use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::DistanceMap;
use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
use rand::RngExt;

/// A grid whose cells are occupied with a probability.
fn scattered(seed: u64, width: usize, height: usize, share: f64) -> OccupancyGrid {
    let mut rng = stream(seed, "distance");
    let frame = GridFrame::new(width, height, 0.1, Pose2::new(3.0, -1.0, 0.7)).unwrap();
    let cells = (0..width * height).map(|_| if rng.random_bool(share) { 100 } else { 0 });
    OccupancyGrid::new(frame, cells.collect()).unwrap()
}

fn brute_force(grid: &OccupancyGrid, cell: Cell) -> u32 {
    let obstacles = grid.iter().filter(|&(_, value)| value == 100);
    let squared = |other: Cell| {
        let (dx, dy) = (other.column.abs_diff(cell.column), other.row.abs_diff(cell.row));
        (dx * dx + dy * dy) as u32
    };
    obstacles.map(|(other, _)| squared(other)).min().unwrap_or(u32::MAX)
}

#[test]
fn distances_are_those_of_brute_force() {
    for (seed, (width, height, share)) in
        [(1, 1, 0.5), (40, 1, 0.1), (1, 40, 0.1), (37, 23, 0.02), (23, 37, 0.2), (30, 30, 0.002)]
            .into_iter()
            .cycle()
            .take(60)
            .enumerate()
    {
        let grid = scattered(seed as u64, width, height, share);
        for cut_off in [0.05, 0.3, 0.71, 1.5, 100.0, f64::INFINITY] {
            let map = DistanceMap::new(&grid, cut_off).unwrap();
            for cell in grid.frame().cells() {
                let squared = brute_force(&grid, cell);
                let distance = f64::from(squared).sqrt() * 0.1;
                let expected = if squared == u32::MAX { cut_off } else { distance.min(cut_off) };
                let found = map.distance(cell).unwrap();
                assert_eq!(found, expected, "seed {seed}, cut-off {cut_off}, {cell:?}");
                match map.nearest_obstacle(cell) {
                    Some((obstacle, distance)) => {
                        assert_eq!(grid.value(obstacle), Some(100));
                        assert_eq!(distance, expected);
                        let (dx, dy) = (
                            obstacle.column.abs_diff(cell.column) as f64,
                            obstacle.row.abs_diff(cell.row) as f64,
                        );
                        assert!((dx.hypot(dy) * 0.1 - distance).abs() < 1e-12);
                    }
                    None => assert!(squared == u32::MAX || distance > cut_off - 1e-12),
                }
            }
        }
    }
}

#[test]
fn large_and_narrow_grids_keep_their_limits() {
    let frame = GridFrame::new(100_000, 1, 0.01, Pose2::IDENTITY).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    grid.set(Cell::new(7, 0), 100).unwrap();
    let map = DistanceMap::new(&grid, f64::INFINITY).unwrap();
    assert_eq!(map.squared_cells(Cell::new(30_007, 0)), Some(900_000_000));
    assert_eq!(map.distance(Cell::new(99_999, 0)), Some(f64::INFINITY));
    assert_eq!(map.nearest_obstacle(Cell::new(99_999, 0)), None);
    assert_eq!(map.distance_at(&[0.205, 0.005].into()), Some(0.13));
}

#[test]
fn any_cells_can_be_obstacles_and_bad_cut_offs_are_refused() {
    let frame = GridFrame::new(3, 1, 1.0, Pose2::IDENTITY).unwrap();
    let grid = OccupancyGrid::new(frame, vec![100, 0, -1]).unwrap();
    let to_unknown = DistanceMap::to_cells(&grid, 9.0, |value| value == -1).unwrap();
    assert_eq!(to_unknown.squared(), [4, 1, 0]);
    assert_eq!(to_unknown.distance(Cell::new(3, 0)), None);
    for cut_off in [0.0, -1.0, f64::NAN] {
        assert!(DistanceMap::new(&grid, cut_off).is_err());
    }
}
