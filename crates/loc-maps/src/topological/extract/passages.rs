//! Where regions meet.

use super::clear::around;
use super::floor::Floor;
use super::regions::NONE;
use crate::grid::Cell;
use std::collections::BTreeMap;

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
pub(super) fn between(floor: &Floor, labels: &[usize]) -> Vec<Passage> {
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
    let mut passages = Vec::new();
    for (between, cells) in touching {
        for group in groups(&cells, width, height) {
            let Some(&middle) = group.iter().max_by_key(|&&index| floor.clearance[index]) else {
                continue;
            };
            let cell = Cell::new(middle % width, middle / width);
            passages.push(Passage { between, cell, clearance: floor.clearance[middle] });
        }
    }
    passages
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
