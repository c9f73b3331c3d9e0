//! The watershed: which cells of the floor belong together.

use super::ExtractSettings;
use super::clear::around;
use super::floor::Floor;
use std::collections::{BTreeMap, HashMap};

/// The label of cells that belong to no region.
pub(super) const NONE: usize = usize::MAX;

/// Basins that rise and merge.
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

    /// Lets the shallower of two roots become part of the deeper.
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
