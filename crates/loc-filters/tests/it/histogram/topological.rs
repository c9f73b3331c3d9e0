//! Markov localization over the places of a topological map.

use loc_core::Pose2;
use loc_core::random::stream;
use loc_filters::histogram::{PlaceViews, TopologicalFilter};
use loc_maps::grid::Cell;
use loc_maps::topological::{Edge, Place, PlaceKind};
use loc_maps::{OccupancyGrid, TopologicalMap};
use loc_sensors::laser::{LaserScan, LaserScanner, LaserSpec};
use nalgebra::DMatrix;

/// A ring of four places with a dead end, and one place apart.
fn map() -> TopologicalMap {
    let places =
        (0..6).map(|k| Place::new(format!("place {k}"), PlaceKind::Room, 3.0 * f64::from(k), 0.0));
    let edges = [(0, 1, 3.0), (1, 2, 0.7), (2, 3, 5.0), (3, 0, 1.5), (2, 4, 2.0)];
    TopologicalMap::new(places, edges.map(|(a, b, length)| Edge::new(a, b, length))).unwrap()
}

/// exp(Q w) by the matrix exponential.
#[test]
fn drives_follow_the_matrix_exponential() {
    let map = map();
    let mut q = DMatrix::<f64>::zeros(6, 6);
    for place in 0..6 {
        let neighbours = map.neighbours(place);
        for &(to, length) in neighbours {
            let rate = 1.0 / (neighbours.len() as f64 * length);
            q[(place, to)] += rate;
            q[(place, place)] -= rate;
        }
    }
    let start = [0.5, 0.1, 0.0, 0.05, 0.15, 0.2];
    for way in [0.0, 0.3, 4.0, 60.0] {
        let mut filter = TopologicalFilter::new(map.clone()).unwrap();
        filter.start(&start).unwrap();
        filter.predict(way).unwrap();
        let expected = (q.transpose() * way).exp() * DMatrix::from_column_slice(6, 1, &start);
        for (found, expected) in filter.belief().iter().zip(expected.iter()) {
            assert!((found - expected).abs() < 1e-9, "{way} m: {found} {expected}");
        }
    }
    // One long drive is many short ones, and endless ones end.
    let run = |ways: &[f64]| {
        let mut filter = TopologicalFilter::new(map.clone()).unwrap();
        filter.start(&start).unwrap();
        ways.iter().for_each(|way| filter.predict(*way).unwrap());
        filter.belief().to_vec()
    };
    for (a, b) in run(&[3.0]).iter().zip(run(&[1.0, 0.5, 1.5])) {
        assert!((a - b).abs() < 1e-9);
    }
    let at_rest = run(&[1e9]);
    assert!((at_rest.iter().sum::<f64>() - 1.0).abs() < 1e-9 && (at_rest[5] - 0.2).abs() < 1e-9);
}

#[test]
fn bayes_by_hand_and_bad_input() {
    let mut filter = TopologicalFilter::new(map()).unwrap();
    filter.correct(&[2.0, 1.0, 1.0, 0.0, 0.0, 0.0]).unwrap();
    assert_eq!((filter.belief()[0], filter.most_likely()), (0.5, 0));
    let before = filter.belief().to_vec();
    for likelihoods in [
        &[1.0; 5][..],
        &[1.0, 1.0, f64::NAN, 1.0, 1.0, 1.0],
        &[1.0, -1.0, 1.0, 1.0, 1.0, 1.0],
        &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
    ] {
        assert!(filter.correct(likelihoods).is_err(), "{likelihoods:?}");
    }
    for way in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(filter.predict(way).is_err(), "{way}");
    }
    assert!(filter.start(&[0.0; 6]).is_err() && filter.start(&[1.0; 7]).is_err());
    assert_eq!(filter.belief(), before);
    let empty = TopologicalMap::default();
    let error = TopologicalFilter::new(empty).unwrap_err().to_string();
    assert!(error.contains("topological map: expected at least one place"), "{error}");
}

/// Two rooms of 8 m x 8 m and 3 m x 3 m, with a corridor of 8 m x 1.6 m between them.
fn flat() -> OccupancyGrid {
    let frame = loc_maps::grid::GridFrame::new(400, 180, 0.05, Pose2::IDENTITY).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 100);
    for (x, y, width, height) in [
        (5, 5, 160, 160),
        (165, 60, 10, 20),
        (175, 54, 160, 32),
        (335, 60, 5, 20),
        (340, 40, 55, 60),
    ] {
        for k in 0..width * height {
            grid.set(Cell::new(x + k % width, y + k / width), 0).unwrap();
        }
    }
    grid
}

/// Spots in each of the three places, two headings each.
fn scans(grid: &OccupancyGrid, seed: u64) -> Vec<Vec<LaserScan>> {
    let laser = LaserScanner::new(LaserSpec::sick_lms100()).unwrap();
    let mut rng = stream(seed, "views");
    let spots = |from: [f64; 2], to: [f64; 2]| -> Vec<Pose2> {
        let between = |k: usize, j: usize| from[k] + (to[k] - from[k]) * j as f64 / 4.0;
        (0..25).map(|j| Pose2::new(between(0, j % 5), between(1, j / 5), j as f64)).collect()
    };
    let places = [
        spots([1.0, 1.0], [7.5, 7.5]),
        spots([9.5, 3.2], [16.0, 3.8]),
        spots([17.5, 2.5], [19.2, 4.4]),
    ];
    places
        .map(|spots| spots.into_iter().map(|pose| laser.scan(grid, pose, &mut rng)).collect())
        .into()
}

/// Looks learned from some scans tell where others were taken, over several seeds.
#[test]
fn places_are_told_by_their_looks() {
    let grid = flat();
    let views = PlaceViews::new(&scans(&grid, 1), 0.5, 0.01).unwrap();
    for seed in 2..5 {
        let (mut right, mut all) = (0, 0);
        for (place, scans) in scans(&grid, seed).iter().enumerate() {
            for scan in scans {
                let likelihoods = views.likelihoods(scan).unwrap().unwrap();
                let best = (0..3).max_by(|a, b| likelihoods[*a].total_cmp(&likelihoods[*b]));
                right += usize::from(best == Some(place));
                all += 1;
                assert!(likelihoods.iter().all(|l| *l > 0.0 && l.is_finite()));
            }
        }
        assert!(right * 10 >= all * 9, "seed {seed}: {right} of {all}");
    }
}

#[test]
fn views_refuse_what_says_nothing() {
    let grid = flat();
    let good = scans(&grid, 1);
    let blind =
        LaserScan { ranges: vec![f64::INFINITY; good[0][0].ranges.len()], ..good[0][0].clone() };
    for places in [vec![good[0].clone(), Vec::new()], vec![vec![blind.clone()]]] {
        let error = PlaceViews::new(&places, 0.5, 0.01).unwrap_err().to_string();
        assert!(error.contains("scans of a place: expected at least one that sees"), "{error}");
    }
    assert!(
        PlaceViews::new(&good, 0.0, 0.01).is_err() && PlaceViews::new(&good, 0.5, 2.0).is_err()
    );
    let views = PlaceViews::new(&good, 0.5, 0.01).unwrap();
    assert_eq!(views.likelihoods(&blind).unwrap(), None);
    let broken = LaserScan { angle_increment: f64::NAN, ..blind };
    assert!(views.likelihoods(&broken).is_err());
    // Only half of the beams came back.
    let mut half = good[1][3].clone();
    half.ranges.iter_mut().step_by(2).for_each(|range| *range = f64::NAN);
    let likelihoods = views.likelihoods(&half).unwrap().unwrap();
    assert!(likelihoods[1] > likelihoods[0] && likelihoods[1] > likelihoods[2], "{likelihoods:?}");
}
