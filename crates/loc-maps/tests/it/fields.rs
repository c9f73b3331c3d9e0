use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::grid::{Cell, GridFrame, Occupancy, OccupancyGrid};
use loc_maps::likelihood_field::{
    Endpoints, LikelihoodField, LikelihoodFieldSettings, Obstacles, OffMap, UnknownSpace,
};
use loc_maps::{DistanceMap, likelihood_field};
use nalgebra::Point2;
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

fn grid(yaw: f64) -> OccupancyGrid {
    let mut rng = stream(3, "field");
    let frame = GridFrame::new(61, 43, 0.05, Pose2::new(4.0, -2.0, yaw)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for _ in 0..40 {
        let cell = Cell::new(rng.random_range(0..61), rng.random_range(0..43));
        grid.set(cell, if rng.random() { 100 } else { -1 }).unwrap();
    }
    grid
}

/// The worst loss by rounding to a byte that the settings allow.
fn half_step(settings: &LikelihoodFieldSettings) -> f64 {
    let far = settings.likelihood(settings.max_distance);
    0.5 * (settings.likelihood(0.0) / far).ln() / 255.0
}

#[test]
fn the_byte_loses_half_a_step_at_most() {
    let settings = LikelihoodFieldSettings::nav2();
    let grid = grid(0.4);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    let distances = DistanceMap::new(&grid, settings.max_distance).unwrap();
    let (mut worst, mut squares) = (0.0_f64, 0.0);
    for cell in grid.frame().cells() {
        let exact = settings.likelihood(distances.distance(cell).unwrap()).ln();
        let loss = field.log_likelihood_at(&grid.frame().center(cell)) - exact;
        worst = worst.max(loss.abs());
        squares += loss * loss;
    }
    let rms = (squares / grid.frame().cell_count() as f64).sqrt();
    println!("loss: {worst:.5} at most, {rms:.5} root mean square");
    assert!(worst <= half_step(&settings) * 1.000_001 && rms < 0.7 * worst);
    assert!((half_step(&settings) - 0.0063).abs() < 0.0001, "{}", half_step(&settings));
}

#[test]
fn a_scan_is_the_sum_of_its_beams_on_the_map_and_off_it() {
    let settings = LikelihoodFieldSettings::nav2();
    let grid = grid(-1.1);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    let mut rng = stream(5, "field");
    for beams in [0, 1, 31, 32, 33, 200] {
        let points: Vec<[f64; 2]> = (0..beams)
            .map(|_| [rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0)])
            .collect();
        let endpoints: Endpoints = points.iter().copied().collect();
        let pose = Pose2::new(5.0, -1.0, rng.random_range(-3.0..3.0));
        let at = |p: &[f64; 2]| field.log_likelihood_at(&pose.transform(&Point2::from(*p)));
        let sum: f64 = points.iter().map(at).sum();
        let found = field.log_likelihood(pose, &endpoints);
        // Single precision may put a beam that ends on the edge of a cell into the next one.
        assert!((found - sum).abs() <= 1e-9 + 0.002 * f64::from(beams), "{found} {sum}");
    }
}

#[test]
fn off_the_map_is_far_from_everything() {
    let settings = LikelihoodFieldSettings::nav2();
    let field = LikelihoodField::new(&grid(0.0), &settings).unwrap();
    let far = settings.likelihood(2.0).ln();
    for (x, y) in [(0.0, 0.0), (1e30, -1e30), (f64::INFINITY, 0.0), (3.99, -1.99), (f64::NAN, 0.0)]
    {
        let found = field.log_likelihood_at(&Point2::new(x, y));
        assert!((found - far).abs() < 1e-9, "{x} {y}: {found} {far}");
    }
    let nothing = Endpoints::from_scan(&[0.0, 0.1], &[f64::INFINITY, f64::NAN]);
    assert!(nothing.is_empty() && field.log_likelihood(Pose2::IDENTITY, &nothing) == 0.0);
}

#[test]
fn unknown_space_has_a_likelihood_of_its_own() {
    let unknown_space = UnknownSpace::Likelihood(1.0 / 12.0);
    let settings = LikelihoodFieldSettings::nav2().unknown_space(unknown_space);
    let grid = grid(0.0);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    for center in grid.centers_of(Occupancy::Unknown) {
        let loss = field.log_likelihood_at(&center) - (1.0_f64 / 12.0).ln();
        assert!(loss.abs() <= half_step(&settings) * 1.01);
    }
}

#[test]
fn bad_settings_are_refused() {
    let good = LikelihoodFieldSettings::nav2();
    let bad = [
        good.sigma_hit(0.0),
        good.z_hit(-0.1),
        good.z_rand(0.0),
        good.max_range(f64::INFINITY),
        good.max_distance(f64::NAN),
        good.unknown_space(UnknownSpace::Likelihood(0.0)),
        good.off_map(OffMap::Likelihood(f64::NAN)),
    ];
    for settings in bad {
        assert!(likelihood_field::LikelihoodField::new(&grid(0.0), &settings).is_err());
    }
}

/// Poses about the grid, among them some that are nowhere.
fn poses(count: usize) -> [Vec<f64>; 3] {
    let mut rng = stream(8, "field");
    let mut draw = |low, high| (0..count).map(|_| rng.random_range(low..high)).collect();
    let mut poses: [Vec<f64>; 3] = [draw(2.0, 8.0), draw(-4.0, 2.0), draw(-7.0, 7.0)];
    (poses[0][0], poses[1][1], poses[2][2], poses[0][3]) = (f64::NAN, 1e9, f64::INFINITY, -90.0);
    poses
}

fn scan(beams: usize) -> Endpoints {
    let mut rng = stream(9, "field");
    (0..beams).map(|_| [rng.random_range(-2.0..2.0), rng.random_range(-2.0..2.0)]).collect()
}

#[test]
fn many_poses_are_rated_as_one_by_one() {
    let field = LikelihoodField::new(&grid(0.7), &LikelihoodFieldSettings::nav2()).unwrap();
    let [x, y, theta] = poses(200);
    for (beams, count) in [(0, 200), (61, 200), (600, 130), (60, 64), (60, 0)] {
        let scan = scan(beams);
        let mut out = vec![7.0; 200];
        field.log_likelihoods([&x, &y[..count], &theta], &scan, &mut out);
        for k in 0..200 {
            let pose = Pose2 { x: x[k], y: y[k], theta: theta[k] };
            let expected = if k < count { field.log_likelihood(pose, &scan) } else { 7.0 };
            assert!(out[k].to_bits() == expected.to_bits() && out[k].is_finite());
        }
    }
}

#[test]
fn sums_and_hits_are_those_of_single_beams() {
    let settings = LikelihoodFieldSettings::nav2();
    let field = LikelihoodField::new(&grid(0.7), &settings).unwrap();
    let ([x, y, theta], scan) = (poses(100), scan(75));
    let cubes = field.table(|log_likelihood| (3.0 * log_likelihood).exp());
    let mut sums = vec![0.0; 100];
    field.sums(&cubes, [&x, &y, &theta], &scan, &mut sums);
    let hits = field.hits(0.2, [&x, &y, &theta], &scan);
    let (mut counts, least) = (vec![0; 75], settings.likelihood(0.2).ln());
    for k in 0..100 {
        let pose = Pose2 { x: x[k], y: y[k], theta: theta[k] };
        let mut sum = 0.0;
        for (beam, count) in counts.iter_mut().enumerate() {
            let mut only = [false; 75];
            only[beam] = true;
            let log_likelihood = field.log_likelihood(pose, &scan.selected(&only));
            sum += (3.0 * log_likelihood).exp();
            *count += u32::from(log_likelihood >= least - half_step(&settings));
        }
        assert!((sums[k] - sum).abs() < 1e-12 * sum, "{} {sum}", sums[k]);
    }
    assert_eq!(hits, counts);
    assert!(hits.iter().sum::<u32>() > 100);
}

/// Cells of a side that single precision could not distinguish are distinct.
#[test]
fn a_long_map_is_read_exactly() {
    let frame = GridFrame::new(300_000, 3, 0.05, Pose2::new(0.0, 1.0, 0.3)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    grid.set(Cell::new(299_990, 1), 100).unwrap();
    let settings = LikelihoodFieldSettings::nav2().max_distance(0.5);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    let scan: Endpoints = [[1.0, 0.0], [9.0, 0.0]].into_iter().collect();
    let far = settings.likelihood(0.5).ln();
    for cells in 0..8 {
        let at = frame.to_map(299_990.5 - 20.0 + f64::from(cells), 1.5);
        let found = field.log_likelihood(Pose2::new(at.x, at.y, 0.3), &scan);
        let expected = settings.likelihood(0.05 * f64::from(cells)).ln() + far;
        let loss = (found - expected).abs();
        assert!(loss < 0.014, "{cells} cells: {found} {expected}");
    }
}

#[test]
fn off_the_map_has_a_likelihood_of_its_own() {
    let off_map = OffMap::Likelihood(1.0 / 30.0);
    let settings = LikelihoodFieldSettings::nav2().off_map(off_map);
    let field = LikelihoodField::new(&grid(0.2), &settings).unwrap();
    let found = field.log_likelihood_at(&Point2::new(0.0, 0.0));
    assert!((found - (1.0_f64 / 30.0).ln()).abs() < 1e-9, "{found}");
}

/// A block of 11 x 11 cells: its middle is far from all surfaces, which are where they were.
#[test]
fn no_beam_ends_inside_a_thick_wall() {
    let frame = GridFrame::new(40, 40, 0.1, Pose2::IDENTITY).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for cell in frame.cells().filter(|cell| cell.row.abs_diff(15).max(cell.column.abs_diff(15)) < 6)
    {
        grid.set(cell, 100).unwrap();
    }
    let settings = LikelihoodFieldSettings::nav2();
    let thick = LikelihoodField::new(&grid, &settings).unwrap();
    let surfaces = settings.obstacles(Obstacles::Surfaces);
    let surfaces = LikelihoodField::new(&grid, &surfaces).unwrap();
    for cell in frame.cells() {
        let at = frame.center(cell);
        let (thick, surface) = (thick.log_likelihood_at(&at), surfaces.log_likelihood_at(&at));
        let depth = 6_usize.saturating_sub(cell.row.abs_diff(15).max(cell.column.abs_diff(15)));
        let loss = match depth {
            0 | 1 => (thick - surface).abs(),
            _ => {
                let expected = settings.likelihood(0.1 * (depth - 1) as f64).ln();
                assert!(thick > surface);
                (surface - expected).abs()
            }
        };
        assert!(loss <= 1.01 * half_step(&settings), "{cell:?}: {thick} {surface}");
    }
}
