//! Stacks that move.

use super::super::stack::{LayerMove, Size, Stack};
use super::rng;
use crate::histogram::Kernel;
use rand::RngExt;

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
