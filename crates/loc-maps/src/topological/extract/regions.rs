//! The watershed: the regions of the floor, and the passages between them.

use super::{ExtractSettings, Floor, around};
use crate::grid::Cell;
use std::collections::{BTreeMap, HashMap};

/// The label of cells that belong to no region.
pub(super) const NONE: usize = usize::MAX;

/// Basins of the watershed (a union-find forest).
struct Basins {
    /// Each basin's parent; roots are their own.
    parent: Vec<usize>,
    /// The deepest clearance of each root \[m\].
    depth: Vec<f64>,
}

impl Basins {
    fn root(&mut self, mut basin: usize) -> usize {
        while self.parent[basin] != basin {
            self.parent[basin] = self.parent[self.parent[basin]];
            basin = self.parent[basin];
        }
        basin
    }

    /// Merges the shallower of two roots into the deeper.
    fn merge(&mut self, a: usize, b: usize) {
        let (deep, shallow) = if self.depth[a] >= self.depth[b] { (a, b) } else { (b, a) };
        self.parent[shallow] = deep;
    }

    /// Whether a threshold of this clearance between two roots is a door.
    fn is_door(&self, a: usize, b: usize, clearance: f64, settings: &ExtractSettings) -> bool {
        let narrower = self.depth[a].min(self.depth[b]);
        2.0 * narrower >= settings.min_width
            && 2.0 * clearance <= settings.max_door_width
            && clearance <= settings.narrowing * narrower
    }
}

/// The region of every cell: numbers from 0 in order of their first cells, or [`NONE`].
pub(super) fn label(floor: &Floor, settings: &ExtractSettings) -> Vec<usize> {
    let mut labels = flood(floor, settings);
    merge_small(floor, settings, &mut labels);
    renumber(&mut labels);
    labels
}

/// Numbers the regions from 0 in order of their first cells.
pub(super) fn renumber(labels: &mut [usize]) {
    let mut numbers = HashMap::new();
    for label in labels.iter_mut().filter(|label| **label != NONE) {
        let next = numbers.len();
        *label = *numbers.entry(*label).or_insert(next);
    }
}

fn flood(floor: &Floor, settings: &ExtractSettings) -> Vec<usize> {
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let mut order: Vec<usize> =
        (0..floor.clearance.len()).filter(|&index| floor.clearance[index] > 0).collect();
    order.sort_by_key(|&index| std::cmp::Reverse(floor.clearance[index]));
    let mut labels = vec![NONE; floor.clearance.len()];
    let mut basins = Basins { parent: Vec::new(), depth: Vec::new() };
    for index in order {
        let clearance = floor.metres(floor.clearance[index]);
        // The deepest neighbour decides where the cell belongs, so that basins meet at the
        // narrowest place.
        let mut best: Option<(u32, usize)> = None;
        for other in around(index, width, height) {
            if labels[other] == NONE {
                continue;
            }
            let root = basins.root(labels[other]);
            let deep = floor.clearance[other];
            let Some((best_deep, best_root)) = best else {
                best = Some((deep, root));
                continue;
            };
            let best_root = basins.root(best_root);
            if root != best_root && !basins.is_door(root, best_root, clearance, settings) {
                basins.merge(root, best_root);
            }
            best = Some(if deep > best_deep { (deep, root) } else { (best_deep, best_root) });
        }
        labels[index] = best.map_or(basins.parent.len(), |(_, root)| root);
        if best.is_none() {
            basins.parent.push(labels[index]);
            basins.depth.push(clearance);
        }
    }
    for label in labels.iter_mut().filter(|label| **label != NONE) {
        *label = basins.root(*label);
    }
    labels
}

/// Gives regions that are too small to the neighbour with the widest passage, and drops those
/// without a neighbour.
fn merge_small(floor: &Floor, settings: &ExtractSettings, labels: &mut [usize]) {
    let cell = floor.frame.resolution() * floor.frame.resolution();
    let mut areas: BTreeMap<usize, f64> = BTreeMap::new();
    for &label in labels.iter().filter(|label| **label != NONE) {
        *areas.entry(label).or_default() += cell;
    }
    let mut contacts = contacts(floor, labels);
    let mut becomes: HashMap<usize, usize> = HashMap::new();
    let smallest = |areas: &BTreeMap<usize, f64>| {
        let least = areas.iter().min_by(|a, b| a.1.total_cmp(b.1))?;
        (*least.1 < settings.min_area).then_some((*least.0, *least.1))
    };
    while let Some((small, area)) = smallest(&areas) {
        areas.remove(&small);
        let beside = contacts.remove(&small).unwrap_or_default();
        let widest = beside.iter().max_by_key(|(other, width)| (**width, **other)).map(|w| *w.0);
        becomes.insert(small, widest.unwrap_or(NONE));
        let Some(into) = widest else { continue };
        *areas.entry(into).or_default() += area;
        for (other, width) in beside {
            let theirs = contacts.entry(other).or_default();
            theirs.remove(&small);
            if other != into {
                join(&mut contacts, into, other, width);
            }
        }
    }
    for label in labels.iter_mut() {
        while let Some(&into) = becomes.get(label) {
            *label = into;
        }
    }
}

/// For every region its neighbours, with the squared clearance of the widest contact.
type Contacts = BTreeMap<usize, BTreeMap<usize, u32>>;

fn contacts(floor: &Floor, labels: &[usize]) -> Contacts {
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let mut contacts = Contacts::new();
    for (index, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        for other in around(index, width, height).filter(|&other| other > index) {
            if labels[other] != NONE && labels[other] != label {
                let clearance = floor.clearance[index].min(floor.clearance[other]);
                join(&mut contacts, label, labels[other], clearance);
            }
        }
    }
    contacts
}

fn join(contacts: &mut Contacts, a: usize, b: usize, clearance: u32) {
    for (from, to) in [(a, b), (b, a)] {
        let known = contacts.entry(from).or_default().entry(to).or_default();
        *known = clearance.max(*known);
    }
}

/// Minimum distance of two doors, as a multiple of the width of the widest door.
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
/// Groups hardly more than a door's width apart are one passage with an obstacle in it: the widest
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
