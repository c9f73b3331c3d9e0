//! The parts: squares, bounds, the fine grid, moments, stacks that move.

use super::*;
use crate::histogram::Kernel;
use crate::histogram::grid::field::LayerBounds;
use crate::histogram::grid::stack::{LayerMove, Size, Stack, Sums};
use crate::histogram::grid::window::{Step, Window};
use approx::assert_relative_eq;
use loc_core::angle;
use loc_core::motion::{DrivenPath, PathNoise};
use std::collections::BTreeMap;

#[test]
fn squares_cover_the_free_cells_once() {
    let map = room();
    for cell in [0.05, 0.1, 0.2, 0.35] {
        let space = PoseSpace::new(&map, &GridSettings { cell, ..settings() }).unwrap();
        let size = space.size();
        assert_eq!(size.headings, 36);
        let shares: f64 = (0..size.layer()).map(|place| space.share(place)).sum();
        assert_relative_eq!(36.0 * shares, 1.0, epsilon = 1e-12);
        let mut counted = 0;
        for place in 0..size.layer() {
            let corner = space.corner_of(place);
            let side = space.side();
            let free = (0..side * side)
                .filter(|k| space.is_free(corner[0] + k % side, corner[1] + k / side))
                .count();
            counted += free;
            assert_eq!(space.has_room(place), free > 0);
        }
        assert_eq!(counted, map.counts().free);
    }
}

#[test]
fn poses_lead_to_their_cells_and_back() {
    let map = room();
    let space = PoseSpace::new(&map, &settings()).unwrap();
    for layer in 0..space.size().headings {
        for place in (0..space.size().layer()).step_by(7) {
            let pose = space.pose(layer, place);
            assert_eq!(space.cell_of(pose), Some((layer, place)));
            let near = Pose2::new(pose.x + 0.06, pose.y - 0.05, pose.theta + 0.08);
            assert_eq!(space.cell_of(near), Some((layer, place)));
        }
    }
    assert_eq!(space.cell_of(Pose2::new(-50.0, 0.0, 0.0)), None);
}

/// The bound of every cell against all of its poses, rated one by one by the likelihood field.
#[test]
fn no_pose_is_likelier_than_the_bound_of_its_cell() {
    let map = room();
    let mut rng = rng("bounds");
    for cell in [0.2, 0.15, 0.05] {
        let setting = Setting::new(&map, GridSettings { cell, ..settings() });
        let Setting { space, sensor, .. } = &setting;
        let scan = setting.scan(&super::scan(&map, place(&map, &mut rng), &mut rng));
        let (mut bounds, mut slack) = (LayerBounds::default(), f64::INFINITY);
        for layer in [0, 5, 17, 30] {
            let sums = sensor.bounds.of_layer(space, &scan, layer, &mut bounds).to_vec();
            for at in (0..sums.len()).filter(|at| space.has_room(*at)) {
                let bound = scan.lowest + scan.per_code * f64::from(sums[at]);
                for pose in poses_of(space, &scan.turns, layer, at) {
                    let rated = sensor.field.log_likelihood(pose, &scan.endpoints);
                    let gap = bound - scan.exponent * rated;
                    // Single precision may put an end into the next cell.
                    assert!(gap > -0.3, "cell {cell}, layer {layer}, square {at}: {gap}");
                    slack = slack.min(gap);
                }
            }
        }
        println!("cell {cell}: tightest bound {slack:.3}");
        assert!(slack < 5.0, "bounds say nothing: {slack}");
    }
}

/// All poses that a cell is rated by, with the headings that are so far from its middle.
fn poses_of(space: &PoseSpace, turns: &[f64], layer: usize, place: usize) -> Vec<Pose2> {
    let (corner, side) = (space.corner_of(place), space.side());
    let mut poses = Vec::new();
    let center = space.pose(layer, place);
    for k in 0..side * side {
        if !space.is_free(corner[0] + k % side, corner[1] + k / side) {
            continue;
        }
        let middle = 0.5 * (side as f64 - 1.0);
        let (u, v) = ((k % side) as f64 - middle, (k / side) as f64 - middle);
        let in_grid = Pose2::new(center.x, center.y, 0.4) * Pose2::new(0.05 * u, 0.05 * v, 0.0);
        let turned = turns.iter().map(|turn| center.theta + turn);
        poses.extend(turned.map(|theta| Pose2::new(in_grid.x, in_grid.y, theta)));
    }
    poses
}

/// A cell is as likely as its poses are on the average.
#[test]
fn squares_are_rated_by_the_mean_over_their_poses() {
    let map = room();
    let mut rng = rng("mean");
    for cell in [0.2, 0.35] {
        let setting = Setting::new(&map, GridSettings { cell, ..settings() });
        let Setting { space, sensor, .. } = &setting;
        let truth = place(&map, &mut rng);
        let scan = setting.scan(&super::scan(&map, truth, &mut rng));
        let (layer, at) = space.cell_of(truth).unwrap();
        for (layer, at) in [(layer, at), (0, at), (layer, at + 1), (20, at / 2)] {
            if !space.has_room(at) {
                continue;
            }
            let ends = scan.within_layer(space.heading_in_grid(layer));
            let rated = sensor.rate_square(space, &scan, at, &ends);
            let rate =
                |pose: &Pose2| scan.exponent * sensor.field.log_likelihood(*pose, &scan.endpoints);
            let mean = |turns: &[f64]| {
                let poses = poses_of(space, turns, layer, at);
                let sum: f64 = poses.iter().map(|pose| rate(pose).exp()).sum();
                (sum / poses.len() as f64).ln()
            };
            let same = mean(&scan.turns);
            assert!((rated - same).abs() < 0.02, "cell {cell}: {rated} {same}");
            // Many more headings change it by less than a fifth or so.
            let step = space.heading_step();
            let many: Vec<f64> =
                (0..40).map(|k| step * ((f64::from(k) + 0.5) / 40.0 - 0.5)).collect();
            let finer = mean(&many);
            assert!((rated - finer).abs() < 0.25, "cell {cell}: {rated} {finer}");
        }
    }
}

#[test]
fn the_fine_grid_takes_over_and_gives_back_all() {
    let map = room();
    let Setting { space, settings, .. } = Setting::new(&map, settings());
    let middle = place(&map, &mut rng("window"));
    let mut window = Window::at(middle, &settings.fine).unwrap();
    let (layer, at) = space.cell_of(middle).unwrap();
    let coarse = BTreeMap::from([((layer, at), 0.25), (((layer + 1) % 36, at), 0.5)]);
    let left = window.absorb(&coarse, &space, |layer, _| 1.0 + layer as f64);
    assert!(left.is_empty());
    assert_relative_eq!(window.stack().total(), 0.75, epsilon = 1e-12);
    // Each fine cell belongs to the coarse cell that it came from.
    let mut back = BTreeMap::new();
    for (layer, place, mass) in window.stack().cells() {
        *back.entry(space.cell_of(window.pose(layer, place)).unwrap()).or_insert(0.0) += mass;
        assert_eq!(window.cell_of(window.pose(layer, place)), Some((layer, place)));
    }
    assert_eq!(back.len(), 2);
    for (place, mass) in &coarse {
        assert_relative_eq!(back[place], *mass, epsilon = 1e-12);
    }
}

/// Without noise the fine grid moves as a whole, each layer by the way of its own heading.
#[test]
fn the_fine_grid_moves_with_the_odometry() {
    let still = PathNoise::default()
        .along(0.0)
        .across(0.0)
        .drift(0.0)
        .turn(0.0)
        .pivot(0.0)
        .min_position(0.0)
        .min_heading(0.0)
        .fault_probability(0.0);
    let middle = Pose2::new(5.0, 1.0, 0.7);
    let mut window = Window::at(middle, &settings().fine).unwrap();
    let (layer, place) = window.cell_of(middle).unwrap();
    let turned = layer + 9;
    window.stack_mut().add(layer, place, 0.6);
    window.stack_mut().add(turned, place, 0.4);
    let mut path = DrivenPath::starting_at(Pose2::IDENTITY);
    let driven = Pose2::new(0.4, 0.1, 0.3);
    path.extend(driven);
    window.follow(&Step::usual(&path, &still), 1.0).unwrap();
    let after = |layer: usize| {
        let cells = || {
            let cells = window.stack().cells().filter(move |cell| cell.0 == layer);
            cells.map(|(layer, place, mass)| (window.pose(layer, place), mass))
        };
        Sums::gaussian(cells, 0.0, 0.0).unwrap()
    };
    let (mass, straight) = after(layer);
    assert_relative_eq!(mass, 0.6, epsilon = 1e-9);
    assert_relative_eq!(straight.pose().distance(middle * driven), 0.0, epsilon = 1e-9);
    let (mass, aside) = after(turned);
    let heading = Pose2::new(middle.x, middle.y, middle.theta + 4.5_f64.to_radians());
    assert_relative_eq!(mass, 0.4, epsilon = 1e-9);
    assert_relative_eq!(aside.pose().distance(heading * driven), 0.0, epsilon = 1e-9);
    assert_relative_eq!(aside.pose().theta, (heading * driven).theta, epsilon = 1e-9);
    let before = window.stack().total();
    window.recenter(aside.pose()).unwrap();
    assert_relative_eq!(window.stack().total(), before, epsilon = 1e-12);
}

#[test]
fn moments_are_those_of_the_textbook() {
    let poses = [
        (Pose2::new(1.0, 2.0, 3.0), 0.2),
        (Pose2::new(2.0, 0.0, -3.1), 0.3),
        (Pose2::new(0.5, 1.0, 2.9), 0.5),
    ];
    let (weight, gaussian) = Sums::gaussian(|| poses.iter().copied(), 0.2, 0.1).unwrap();
    assert_relative_eq!(weight, 1.0, epsilon = 1e-12);
    let mean = gaussian.pose();
    assert_relative_eq!(mean.x, 1.05, epsilon = 1e-12);
    assert_relative_eq!(mean.y, 0.9, epsilon = 1e-12);
    let expected = angle::weighted_circular_mean(poses.map(|(p, w)| (p.theta, w))).unwrap();
    assert_relative_eq!(mean.theta, expected, epsilon = 1e-12);
    let xx: f64 = poses.iter().map(|(p, w)| w * (p.x - 1.05).powi(2)).sum();
    assert_relative_eq!(gaussian.covariance.m11, xx + 0.04 / 12.0, epsilon = 1e-12);
    let xy: f64 = poses.iter().map(|(p, w)| w * (p.x - 1.05) * (p.y - 0.9)).sum();
    assert_relative_eq!(gaussian.covariance.m12, xy, epsilon = 1e-12);
    assert!(Sums::gaussian(std::iter::empty, 0.1, 0.1).is_none());
}

const SIZE: Size = Size { headings: 7, rows: 12, columns: 15 };

fn kernel(shift: f64, sigma: f64) -> Kernel {
    Kernel::new(shift, sigma).unwrap()
}

/// Some cells of a stack in the given rows and columns.
fn filled(rows: std::ops::Range<usize>, columns: std::ops::Range<usize>) -> Stack {
    let (mut rng, mut stack) = (rng("stack"), Stack::new(SIZE));
    for heading in [0, 2, 6] {
        for row in rows.clone() {
            for column in columns.clone() {
                if rng.random_range(0..3) > 0 {
                    let place = row * SIZE.columns + column;
                    stack.add(heading, place, rng.random_range(0.0..1.0));
                }
            }
        }
    }
    stack
}

fn each_layer(heading: usize) -> LayerMove {
    let shift = heading as f64;
    LayerMove { across: kernel(0.3 * shift - 0.7, 0.8), up: kernel(1.2 - 0.4 * shift, 0.5) }
}

/// Every pair of cells, one by one.
fn brute_force(from: &Stack, turn: &Kernel, wraps: bool) -> Vec<f64> {
    let mut to = vec![0.0; SIZE.count()];
    for (heading, place, mass) in from.cells() {
        let by = each_layer(heading);
        for (turned, a) in turn.iter() {
            for (up, b) in by.up.iter() {
                for (across, c) in by.across.iter() {
                    let mut layer = heading as isize + turned;
                    if wraps {
                        layer = layer.rem_euclid(SIZE.headings as isize);
                    }
                    let row = (place / SIZE.columns) as isize + up;
                    let column = (place % SIZE.columns) as isize + across;
                    let inside = |k: isize, n: usize| (0..n as isize).contains(&k);
                    if inside(layer, SIZE.headings)
                        && inside(row, SIZE.rows)
                        && inside(column, SIZE.columns)
                    {
                        let place = row * SIZE.columns as isize + column;
                        let index = layer * SIZE.layer() as isize + place;
                        to[index as usize] += mass * a * b * c;
                    }
                }
            }
        }
    }
    to
}

#[test]
fn moved_stacks_are_those_of_brute_force() {
    let turn = kernel(2.6, 0.7);
    for (rows, columns) in [(0..SIZE.rows, 0..SIZE.columns), (4..7, 5..9), (0..1, 14..15)] {
        for wraps in [true, false] {
            let from = filled(rows.clone(), columns.clone());
            let mut to = Stack::new(SIZE);
            to.add_moved(&from, 0.7, |k| Ok(each_layer(k)), &turn, wraps).unwrap();
            let expected = brute_force(&from, &turn, wraps);
            for (index, expected) in expected.iter().enumerate() {
                let found = to.get(index / SIZE.layer(), index % SIZE.layer());
                assert!((found - 0.7 * expected).abs() < 1e-12, "{index}: {found} {expected}");
            }
            // What lies outside of the extents is 0.
            assert!((to.total() - 0.7 * expected.iter().sum::<f64>()).abs() < 1e-12);
        }
    }
}

#[test]
fn mass_is_kept_where_nothing_leaves() {
    let from = filled(5..7, 6..9);
    let small = LayerMove { across: kernel(0.37, 0.3), up: kernel(-0.6, 0.2) };
    let mut to = Stack::new(SIZE);
    to.add_moved(&from, 1.0, |_| Ok(small.clone()), &kernel(-1.3, 1.0), true).unwrap();
    assert!((to.total() - from.total()).abs() < 1e-12);
}

#[test]
fn whole_cells_and_full_turns_are_exact() {
    let from = filled(3..6, 4..8);
    let by = LayerMove { across: kernel(-3.0, 0.0), up: kernel(5.0, 0.0) };
    let mut to = Stack::new(SIZE);
    to.add_moved(&from, 1.0, |_| Ok(by.clone()), &kernel(9.0, 0.0), true).unwrap();
    let moved: Vec<_> = from
        .cells()
        .map(|(k, place, mass)| ((k + 9) % 7, place + 5 * SIZE.columns - 3, mass))
        .collect();
    assert_eq!(to.cells().count(), moved.len());
    assert!(moved.iter().all(|&(k, place, mass)| to.get(k, place) == mass));
}

#[test]
fn cleared_stacks_are_empty() {
    let mut stack = filled(0..12, 0..15);
    stack.clear();
    assert!((0..SIZE.headings).all(|k| stack.layer(k).iter().all(|mass| *mass == 0.0)));
    assert!((0..SIZE.headings).all(|k| stack.extent(k).is_empty()));
}
