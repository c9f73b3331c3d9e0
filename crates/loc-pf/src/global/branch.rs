//! Branch and bound: windows that can hold an answer are looked into, the others never.

use super::SearchSettings;
use super::coarse::{Coarse, Window};
use super::headings::Turned;
use super::leaves::{Floor, Leaf, Leaves};
use super::pyramid::{FAN, Pyramid};
use super::sums;
use super::zones::{Answer, Zones};
use crate::Workers;
use loc_maps::grid::GridFrame;
use std::cmp::Reverse;

/// Windows that a thread takes on together.
const PART: usize = 256;

/// One search: a scan at all headings before the pyramid of a map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) pyramid: &'a Pyramid,
    pub(super) turned: &'a Turned,
    pub(super) frame: &'a GridFrame,
    pub(super) settings: &'a SearchSettings,
    pub(super) workers: &'a Workers,
    /// The least sum of an answer, and how far below the best one it may be.
    pub(super) least: u32,
    pub(super) within: u32,
}

impl Search<'_> {
    /// The answers, best first.
    ///
    /// Windows are visited by lots from the highest bounds down. An answer stands when no window
    /// that is left can hold a better one.
    pub(super) fn run(&self) -> Vec<Answer> {
        let wanted = self.settings.candidates;
        let mut zones = Zones::new(self.settings, self.frame, self.turned.headings());
        // Each answer keeps others out of its zone only. So the last answer is never behind as many
        // poses as all other answers' zones hold.
        let enough = (wanted - 1).saturating_mul(zones.poses()).saturating_add(1);
        let within = if wanted == 1 { 0 } else { self.within };
        let floor = Floor::new(self.least, within);
        let mut coarse = Coarse::new(&self.pyramid.top, self.turned, self.workers);
        let mut leaves = Leaves::new(enough);
        loop {
            let left = coarse.highest_left().filter(|left| *left >= floor.get());
            while let Some(leaf) = leaves.best() {
                if left.is_some_and(|left| leaf.sum <= left) {
                    break;
                }
                leaves.pop();
                let answer = self.answer(leaf);
                let covered = zones.cover(answer.heading, [answer.column, answer.row], 1);
                if leaf.sum >= floor.get() && !covered {
                    zones.push(answer);
                }
                if zones.answers().len() == wanted {
                    return zones.answers().to_vec();
                }
            }
            if left.is_none() {
                return zones.answers().to_vec();
            }
            let lot = coarse.next_lot(floor.get());
            self.visit_all(&lot, &zones, &floor, &mut leaves);
            leaves.sort();
        }
    }

    fn answer(&self, leaf: Leaf) -> Answer {
        let Reverse([heading, place]) = leaf.at;
        let width = self.frame.width() as u32;
        Answer { heading, column: place % width, row: place / width, sum: leaf.sum }
    }

    /// Looks into windows, several threads at different ones.
    fn visit_all(&self, lot: &[Window], zones: &Zones, floor: &Floor, leaves: &mut Leaves) {
        let enough = leaves.enough();
        let mut parts: Vec<Leaves> = lot.chunks(PART).map(|_| Leaves::new(enough)).collect();
        self.workers.for_each(lot.chunks(PART).zip(&mut parts), |(lot, leaves)| {
            let (stack, starts) = (Vec::new(), Vec::new());
            let visit = Visit { search: self, lot, zones, floor, leaves, stack, starts };
            pulp::Arch::new().dispatch(visit);
        });
        for part in parts {
            leaves.append(part, floor);
        }
    }
}

/// Some windows to look into.
struct Visit<'a> {
    search: &'a Search<'a>,
    lot: &'a [Window],
    zones: &'a Zones,
    floor: &'a Floor,
    leaves: &'a mut Leaves,
    /// Windows still to look into: level above the one to read, column and row of the corner.
    stack: Vec<(usize, [u32; 2])>,
    starts: Vec<u32>,
}

impl pulp::WithSimd for Visit<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        let Pyramid { top, levels } = self.search.pyramid;
        let columns = top.size()[0] as u32;
        for window in self.lot {
            let corner =
                [window.index % columns, window.index / columns].map(|at| at << top.shift());
            let covered = self.zones.cover(window.heading, corner, 1 << top.shift());
            if window.bound < self.floor.get() || covered {
                continue;
            }
            self.stack.push((levels.len(), corner));
            while let Some((above, corner)) = self.stack.pop() {
                self.open(window.heading, above - 1, corner);
            }
        }
    }
}

impl Visit<'_> {
    /// Looks into a window, at its parts of level `below`.
    #[inline(always)]
    fn open(&mut self, heading: u32, below: usize, corner: [u32; 2]) {
        let Some(level) = self.search.pyramid.levels.get(below) else { return };
        let ends = self.search.turned.at(heading as usize);
        let sums = sums::block(level, corner.map(|at| at as i32), ends, &mut self.starts);
        let [column, row] = corner.map(|at| at >> level.shift());
        for (k, &sum) in (0..).zip(&sums) {
            let [column, row] = [column + k / FAN as u32, row + k % FAN as u32];
            if sum < self.floor.get() || !level.is_free(column, row) {
                continue;
            }
            let [column, row] = [column, row].map(|at| at << level.shift());
            if below > 0 {
                self.stack.push((below, [column, row]));
            } else {
                let place = row * self.search.frame.width() as u32 + column;
                self.leaves.push(Leaf { sum, at: Reverse([heading, place]) }, self.floor);
            }
        }
    }
}
