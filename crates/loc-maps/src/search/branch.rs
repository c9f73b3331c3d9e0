//! Branch and bound over windows of poses: a window is expanded only while its upper bound says
//! that it may hold an answer.
//!
//! [`Search::run`] is the algorithm. [`TopBounds`] hands out the windows of the top level from the
//! highest bounds down, [`Leaves`] holds the best poses of single cells, [`Threshold`] the sum
//! below which nothing matters, and [`Zones`] keeps answers apart.

use super::global::Threads;
use super::pyramid::{EndCells, FAN, GROUP, Level, Pyramid, RotatedScan};
use super::{SearchSettings, pyramid};
use crate::grid::GridFrame;
use std::cmp::Reverse;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// Windows that a thread expands together.
const PART: usize = 256;

/// One search: a scan at all headings before the pyramid of a map.
#[derive(Debug, Clone, Copy)]
pub(super) struct Search<'a> {
    pub(super) pyramid: &'a Pyramid,
    pub(super) rotated: &'a RotatedScan,
    pub(super) frame: &'a GridFrame,
    pub(super) settings: &'a SearchSettings,
    pub(super) threads: &'a Threads,
    /// The smallest sum of an answer, and how far below the best one it may be.
    pub(super) min_sum: u32,
    pub(super) within: u32,
}

impl Search<'_> {
    /// The answers, best first.
    ///
    /// Windows are visited in batches from the highest bounds down. An answer stands when no window
    /// that is left can hold a better one.
    pub(super) fn run(&self) -> Vec<GridPose> {
        let wanted = self.settings.candidates;
        let mut zones = Zones::new(self.settings, self.frame, self.rotated.headings());
        // Each answer keeps others out of its zone only. So the last answer is never behind as many
        // poses as all other answers' zones hold.
        let capacity = (wanted - 1).saturating_mul(zones.poses()).saturating_add(1);
        let within = if wanted == 1 { 0 } else { self.within };
        let threshold = Threshold::new(self.min_sum, within);
        let mut bounds = TopBounds::new(&self.pyramid.top, self.rotated, self.threads);
        let mut leaves = Leaves::new(capacity);
        loop {
            let left = bounds.highest_left().filter(|left| *left >= threshold.get());
            while let Some(leaf) = leaves.best() {
                if left.is_some_and(|left| leaf.sum <= left) {
                    break;
                }
                leaves.pop();
                let answer = self.answer(leaf);
                let covered = zones.cover(answer.heading, [answer.column, answer.row], 1);
                if leaf.sum >= threshold.get() && !covered {
                    zones.push(answer);
                }
                if zones.answers().len() == wanted {
                    return zones.answers().to_vec();
                }
            }
            if left.is_none() {
                return zones.answers().to_vec();
            }
            let batch = bounds.next_batch(threshold.get());
            self.expand_all(&batch, &zones, &threshold, &mut leaves);
            leaves.sort();
        }
    }

    /// About `max` of the poses at most `within` below the best one, in the order of heading and
    /// cell, and for how many each stands.
    ///
    /// Which ones are kept depends on a number mixed from the pose only, not on the order of the
    /// search.
    pub(super) fn ties(&self, max: usize) -> (Vec<GridPose>, u32) {
        let zones = Zones::new(self.settings, self.frame, self.rotated.headings());
        let threshold = Threshold::new(self.min_sum, self.within);
        let mut bounds = TopBounds::new(&self.pyramid.top, self.rotated, self.threads);
        let mut leaves = Leaves::sampled(max);
        while bounds.highest_left().is_some_and(|left| left >= threshold.get()) {
            let batch = bounds.next_batch(threshold.get());
            self.expand_all(&batch, &zones, &threshold, &mut leaves);
        }
        leaves.shrink(&threshold);
        let mut kept = leaves.leaves;
        kept.sort_unstable_by_key(|leaf| leaf.at.0);
        (kept.into_iter().map(|leaf| self.answer(leaf)).collect(), 1 << leaves.thinned.unwrap_or(0))
    }

    fn answer(&self, leaf: Leaf) -> GridPose {
        let Reverse([heading, index]) = leaf.at;
        let width = self.frame.width() as u32;
        GridPose { heading, column: index % width, row: index / width, sum: leaf.sum }
    }

    /// Expands windows, several threads different ones.
    fn expand_all(
        &self,
        batch: &[Window],
        zones: &Zones,
        threshold: &Threshold,
        leaves: &mut Leaves,
    ) {
        let capacity = leaves.capacity();
        let empty = |_| Leaves { leaves: Vec::new(), capacity, thinned: leaves.thinned };
        let mut parts: Vec<Leaves> = batch.chunks(PART).map(empty).collect();
        self.threads.for_each(batch.chunks(PART).zip(&mut parts), |(batch, leaves)| {
            let (stack, starts) = (Vec::new(), Vec::new());
            let expansion =
                Expansion { search: self, batch, zones, threshold, leaves, stack, starts };
            pulp::Arch::new().dispatch(expansion);
        });
        for part in parts {
            leaves.append(part, threshold);
        }
    }
}

/// Windows to expand.
struct Expansion<'a> {
    search: &'a Search<'a>,
    batch: &'a [Window],
    zones: &'a Zones,
    threshold: &'a Threshold,
    leaves: &'a mut Leaves,
    /// Windows still to expand: level above the one to read, column and row of the corner.
    stack: Vec<(usize, [u32; 2])>,
    starts: Vec<u32>,
}

impl pulp::WithSimd for Expansion<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        let Pyramid { top, levels } = self.search.pyramid;
        let columns = top.size()[0] as u32;
        for window in self.batch {
            let corner =
                [window.index % columns, window.index / columns].map(|at| at << top.shift());
            let covered = self.zones.cover(window.heading, corner, 1 << top.shift());
            if window.bound < self.threshold.get() || covered {
                continue;
            }
            self.stack.push((levels.len(), corner));
            while let Some((above, corner)) = self.stack.pop() {
                self.open(window.heading, above - 1, corner);
            }
        }
    }
}

impl Expansion<'_> {
    /// Expands a window into its parts of level `below`.
    #[inline(always)]
    fn open(&mut self, heading: u32, below: usize, corner: [u32; 2]) {
        let Some(level) = self.search.pyramid.levels.get(below) else { return };
        let ends = self.search.rotated.at(heading as usize);
        let sums = pyramid::block(level, corner.map(|at| at as i32), ends, &mut self.starts);
        let [column, row] = corner.map(|at| at >> level.shift());
        for (k, &sum) in (0..).zip(&sums) {
            let [column, row] = [column + k / FAN as u32, row + k % FAN as u32];
            if sum < self.threshold.get() || !level.is_free(column, row) {
                continue;
            }
            let [column, row] = [column, row].map(|at| at << level.shift());
            if below > 0 {
                self.stack.push((below, [column, row]));
            } else {
                let index = row * self.search.frame.width() as u32 + column;
                self.leaves.push(Leaf { sum, at: Reverse([heading, index]) }, self.threshold);
            }
        }
    }
}

/// Bounds of all windows of the top level at all headings, where the search starts: heading by
/// heading and row by row.
///
/// A bound is kept in 16 bits, as a multiple of a power of two, rounded up, plus one; 0 stands for
/// a window without free cells.
#[derive(Debug)]
pub(super) struct TopBounds {
    kept: Vec<u16>,
    /// Windows of a heading.
    windows: usize,
    /// Bits that a bound lost.
    lost: u32,
    /// The largest one of each heading.
    largest: Vec<u16>,
    /// Windows with this and more were handed out.
    handed_out: u32,
    /// Range of bounds of the next batch.
    slab: u32,
}

/// A window of the top level with its bound.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub(super) heading: u32,
    /// Row-major index among the windows of its heading.
    pub(super) index: u32,
    pub(super) bound: u32,
}

impl TopBounds {
    pub(super) fn new(top: &Level, rotated: &RotatedScan, threads: &Threads) -> Self {
        let [columns, rows] = top.size();
        let windows = columns * rows;
        let highest = 255 * rotated.beams() as u64 + 2;
        let lost = (0..32).find(|&bits| (highest >> bits) + 2 < 1 << 16).unwrap_or(32);
        let extents: Vec<Range<usize>> = (0..rows).map(|row| extent(top.free_row(row))).collect();
        let mut kept = vec![0; windows * rotated.headings()];
        let parts = kept.chunks_exact_mut(windows).enumerate();
        let mut largest = vec![0; rotated.headings()];
        threads.for_each(parts.zip(&mut largest), |((heading, kept), largest)| {
            let ends = rotated.at(heading);
            pulp::Arch::new().dispatch(Fill { top, extents: &extents, ends, lost, kept });
            *largest = kept.iter().copied().max().unwrap_or(0);
        });
        let handed_out = largest.iter().copied().max().map_or(0, |max| u32::from(max) + 1);
        TopBounds { kept, windows, lost, largest, handed_out, slab: 8 }
    }

    fn bound(&self, kept: u32) -> u32 {
        (kept - 1) << self.lost
    }

    /// No window that is still to come has a higher bound; `None` when all were handed out.
    pub(super) fn highest_left(&self) -> Option<u32> {
        (self.handed_out > 1).then(|| self.bound(self.handed_out - 1))
    }

    /// The next batch of windows: all those whose bound is within a range below what was handed out
    /// and at least `threshold`, heading by heading. Every batch covers twice the range of the
    /// last.
    pub(super) fn next_batch(&mut self, threshold: u32) -> Vec<Window> {
        let last = self.handed_out.saturating_sub(1);
        let first = self.handed_out.saturating_sub(self.slab).max((threshold >> self.lost) + 1);
        (self.handed_out, self.slab) = (first.min(last), self.slab * 2);
        let range = first.min(u32::from(u16::MAX)) as u16..=last as u16;
        let mut batch = Vec::new();
        let headings = self.kept.chunks_exact(self.windows).zip(&self.largest).enumerate();
        for (heading, (kept, _)) in headings.filter(|(_, (_, max))| *max >= range.start()) {
            for (part, kept) in kept.chunks(GROUP).enumerate() {
                // Most groups have no such window; vector instructions find that out at once.
                if kept.iter().fold(false, |any, kept| any | range.contains(kept)) {
                    let inside = kept.iter().enumerate().filter(|(_, kept)| range.contains(kept));
                    batch.extend(inside.map(|(k, &kept)| Window {
                        heading: heading as u32,
                        index: (part * GROUP + k) as u32,
                        bound: self.bound(u32::from(kept)),
                    }));
                }
            }
        }
        batch
    }
}

/// The groups of windows from the first one with a free cell to the last.
fn extent(free: &[bool]) -> Range<usize> {
    let first = free.iter().position(|free| *free).unwrap_or(0) / GROUP * GROUP;
    let end = free.iter().rposition(|free| *free).map_or(0, |last| last + 1);
    first..first + end.saturating_sub(first).next_multiple_of(GROUP)
}

/// The bounds of all windows at one heading.
struct Fill<'a> {
    top: &'a Level,
    extents: &'a [Range<usize>],
    ends: EndCells<'a>,
    lost: u32,
    kept: &'a mut [u16],
}

impl pulp::WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Fill { top, extents, ends, lost, kept } = self;
        let [columns, rows] = top.size();
        let pitch = columns.next_multiple_of(GROUP);
        let mut all = vec![0; pitch * rows];
        pyramid::rows(top, extents, ends, pitch, &mut all);
        let rows = kept.chunks_exact_mut(columns).zip(all.chunks_exact(pitch)).enumerate();
        for (row, (kept, sums)) in rows {
            for ((kept, &sum), &free) in kept.iter_mut().zip(sums).zip(top.free_row(row)) {
                *kept = if free { (sum.div_ceil(1 << lost) + 1) as u16 } else { 0 };
            }
        }
    }
}

/// A pose of the search's grid with the sum of its codes.
///
/// In order of the sum; among equals that of the lower heading, and then of the lower index in
/// row-major order, is the greater. No two poses are equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Leaf {
    pub(super) sum: u32,
    /// Heading, and row-major index of the cell.
    pub(super) at: Reverse<[u32; 2]>,
}

impl Leaf {
    /// Whether it is one of the 2^-k of all poses that are kept.
    fn is_one_of(&self, k: u32) -> bool {
        let Reverse([heading, index]) = self.at;
        let mixed =
            (u64::from(heading) << 32 | u64::from(index)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed ^ mixed >> 32).wrapping_mul(0xd6e8_feb8_6659_fd93) >> (64 - k.clamp(1, 63)) == 0
            || k == 0
    }
}

/// The smallest sum that can still be an answer; it only rises, from any thread.
#[derive(Debug)]
pub(super) struct Threshold {
    min_sum: AtomicU32,
    /// How far below the best a pose may be.
    within: u32,
}

impl Threshold {
    pub(super) fn new(min_sum: u32, within: u32) -> Self {
        Threshold { min_sum: AtomicU32::new(min_sum), within }
    }

    #[inline(always)]
    pub(super) fn get(&self) -> u32 {
        self.min_sum.load(Ordering::Relaxed)
    }

    /// Raises the threshold for a pose with this sum.
    #[inline(always)]
    pub(super) fn raise_for(&self, sum: u32) {
        self.raise(sum.saturating_sub(self.within));
    }

    #[inline(always)]
    fn raise(&self, min_sum: u32) {
        if min_sum > self.get() {
            self.min_sum.fetch_max(min_sum, Ordering::Relaxed);
        }
    }
}

/// Poses that may be among the answers.
#[derive(Debug, Default)]
pub(super) struct Leaves {
    leaves: Vec<Leaf>,
    /// More than these are never needed.
    capacity: usize,
    /// `Some(k)` where one of 2^k poses is kept, whatever their sums; `None` where the best are.
    thinned: Option<u32>,
}

impl Leaves {
    pub(super) fn new(capacity: usize) -> Self {
        Leaves { leaves: Vec::new(), capacity, thinned: None }
    }

    /// Leaves of which an even sample is kept.
    pub(super) fn sampled(capacity: usize) -> Self {
        Leaves { leaves: Vec::new(), capacity, thinned: Some(0) }
    }

    #[inline(always)]
    pub(super) fn push(&mut self, leaf: Leaf, threshold: &Threshold) {
        self.leaves.push(leaf);
        threshold.raise_for(leaf.sum);
        if self.leaves.len() >= self.capacity.max(512).saturating_mul(2) {
            self.shrink(threshold);
        }
    }

    pub(super) fn capacity(&self) -> usize {
        self.capacity
    }

    /// Keeps the best ones only.
    fn shrink(&mut self, threshold: &Threshold) {
        let min_sum = threshold.get();
        self.leaves.retain(|leaf| leaf.sum >= min_sum);
        if let Some(thinned) = &mut self.thinned {
            self.leaves.retain(|leaf| leaf.is_one_of(*thinned));
            while self.leaves.len() > self.capacity {
                *thinned += 1;
                self.leaves.retain(|leaf| leaf.is_one_of(*thinned));
            }
            return;
        }
        if self.leaves.len() > self.capacity {
            let index = self.capacity - 1;
            let (_, last, _) = self.leaves.select_nth_unstable_by(index, |a, b| b.cmp(a));
            threshold.raise(last.sum);
            self.leaves.truncate(self.capacity);
        }
    }

    pub(super) fn append(&mut self, other: Leaves, threshold: &Threshold) {
        self.thinned = self.thinned.max(other.thinned);
        self.leaves.extend(other.leaves);
        self.shrink(threshold);
    }

    /// Sorts them: the best last.
    pub(super) fn sort(&mut self) {
        self.leaves.sort_unstable();
    }

    /// The best one, once they are sorted.
    pub(super) fn best(&self) -> Option<Leaf> {
        self.leaves.last().copied()
    }

    pub(super) fn pop(&mut self) {
        self.leaves.pop();
    }
}

/// The answers, best first, each with the zone in position and heading that excludes others.
#[derive(Debug)]
pub(super) struct Zones {
    answers: Vec<GridPose>,
    headings: u32,
    /// Squared distance \[cells^2\] and turn \[headings\] at which poses are apart.
    distance: f64,
    turn: f64,
}

/// An answer on the search's grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct GridPose {
    pub(super) heading: u32,
    pub(super) column: u32,
    pub(super) row: u32,
    pub(super) sum: u32,
}

impl Zones {
    pub(super) fn new(settings: &SearchSettings, frame: &GridFrame, headings: usize) -> Self {
        let distance = (settings.separation_distance / frame.resolution()).powi(2);
        let turn = settings.separation_angle * headings as f64 / std::f64::consts::TAU;
        Zones { answers: Vec::new(), headings: headings as u32, distance, turn }
    }

    /// An upper bound of the number of poses in a zone.
    pub(super) fn poses(&self) -> usize {
        let span = |reach: f64| (2.0 * reach.floor() + 1.0).min(1e9) as usize;
        let turns = span(self.turn).min(self.headings as usize);
        span(self.distance.sqrt()).saturating_pow(2).saturating_mul(turns)
    }

    /// Whether all poses at a heading in the `side` x `side` cells from (column, row) on lie in
    /// one zone.
    pub(super) fn cover(&self, heading: u32, [column, row]: [u32; 2], side: u32) -> bool {
        let farthest = |from: u32, to: u32| to.abs_diff(from).max((to + side - 1).abs_diff(from));
        self.answers.iter().any(|answer| {
            let turn = answer.heading.abs_diff(heading);
            let [x, y] =
                [farthest(answer.column, column), farthest(answer.row, row)].map(f64::from);
            f64::from(turn.min(self.headings - turn)) < self.turn && x * x + y * y < self.distance
        })
    }

    pub(super) fn push(&mut self, answer: GridPose) {
        self.answers.push(answer);
    }

    pub(super) fn answers(&self) -> &[GridPose] {
        &self.answers
    }
}
