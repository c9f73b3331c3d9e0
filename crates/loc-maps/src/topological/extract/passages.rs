//! Where regions meet.

use super::ExtractSettings;
use super::clear::around;
use super::floor::Floor;
use super::regions::NONE;
use crate::grid::Cell;
use std::collections::BTreeMap;

/// Two doors are at least this many times the width of the widest door apart.
const APART: f64 = 1.5;

/// A place at which two regions meet.
pub(super) struct Passage {
    /// The two regions.
    pub(super) between: [usize; 2],
    /// Its middle: the cell with the most room.
    pub(super) cell: Cell,
    clearance: u32,
}

impl Passage {
    /// Its clear width \[m\].
    pub(super) fn width(&self, floor: &Floor) -> f64 {
        // Walls begin half a cell before the centres of their first cells.
        (2.0 * floor.metres(self.clearance) - floor.frame.resolution()).max(0.0)
    }
}

/// All passages, in order of the regions that they join and then from the bottom up.
///
/// The cells at which two regions touch fall into connected groups: two rooms may have two doors.
/// Those hardly more than a door's width apart are one, which something stands in: the widest
/// counts.
pub(super) fn between(floor: &Floor, labels: &[usize], settings: &ExtractSettings) -> Vec<Passage> {
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let mut touching: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (index, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        let mut others: Vec<usize> = around(index, width, height)
            .map(|other| labels[other])
            .filter(|&other| other != NONE && other != label)
            .collect();
        others.sort_unstable();
        others.dedup();
        for other in others {
            touching.entry([label.min(other), label.max(other)]).or_default().push(index);
        }
    }
    let near = APART * settings.max_door_width / floor.frame.resolution();
    touching
        .into_iter()
        .flat_map(|(between, cells)| {
            let groups = groups(&cells, width, height).into_iter();
            let widest = groups.filter_map(|group| {
                let index = group.into_iter().max_by_key(|&index| floor.clearance[index])?;
                let cell = Cell::new(index % width, index / width);
                Some(Passage { between, cell, clearance: floor.clearance[index] })
            });
            apart(widest.collect(), near)
        })
        .collect()
}

/// Only the widest of passages that are less than `near` cells apart, in the order they had.
fn apart(passages: Vec<Passage>, near: f64) -> Vec<Passage> {
    let distance = |a: &Passage, b: &Passage| {
        let (columns, rows) =
            (a.cell.column.abs_diff(b.cell.column), a.cell.row.abs_diff(b.cell.row));
        (columns as f64).hypot(rows as f64)
    };
    let rank = |passage: &Passage| (passage.clearance, passage.cell);
    let hidden: Vec<bool> = passages
        .iter()
        .map(|a| passages.iter().any(|b| rank(b) > rank(a) && distance(a, b) < near))
        .collect();
    passages.into_iter().zip(hidden).filter(|(_, hidden)| !hidden).map(|(p, _)| p).collect()
}

/// The connected groups of some cells, which are in order.
fn groups(cells: &[usize], width: usize, height: usize) -> Vec<Vec<usize>> {
    let mut seen = vec![false; cells.len()];
    let mut groups = Vec::new();
    for start in 0..cells.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let mut group = vec![cells[start]];
        let mut next = 0;
        while let Some(&index) = group.get(next) {
            next += 1;
            for other in around(index, width, height) {
                if let Some(k) = cells.binary_search(&other).ok().filter(|&k| !seen[k]) {
                    seen[k] = true;
                    group.push(other);
                }
            }
        }
        groups.push(group);
    }
    groups
}
