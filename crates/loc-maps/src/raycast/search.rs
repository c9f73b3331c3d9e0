//! The search for the first bit that a ray meets in lines of bits.

use super::bits::{BitLines, GROUP, WINDOW};

/// A ray among lines: it runs more along them than across.
///
/// Positions along the lines are whole numbers with `fraction_bits` binary places, so that the
/// cells of a group of lines are exactly those of its lines.
#[derive(Debug)]
pub(super) struct Search<'a> {
    pub(super) lines: &'a BitLines,
    /// The line that the ray starts in, and the cell there.
    pub(super) line: usize,
    pub(super) cell: usize,
    /// How many lines it crosses at most.
    pub(super) crossed: usize,
    pub(super) upward: bool,
    /// Where it leaves the first line, and how far it runs in each line.
    pub(super) leaving: i64,
    pub(super) run: i64,
    pub(super) fraction_bits: u32,
}

impl Search<'_> {
    /// The line and the cell in it that the ray meets first; `None` where it ends before.
    #[inline(always)]
    pub(super) fn first_hit(&self) -> Option<(usize, usize)> {
        // A reading holds the cells of a group, of a line, or only a part of them.
        let run = (self.run.unsigned_abs() >> self.fraction_bits) as usize;
        match (self.run >= 0, run) {
            (true, ..GROUP_RUN) => self.by_groups::<true>(),
            (false, ..GROUP_RUN) => self.by_groups::<false>(),
            (true, ..LINE_RUN) => self.by_lines::<true, true>(0, self.crossed),
            (false, ..LINE_RUN) => self.by_lines::<false, true>(0, self.crossed),
            (true, _) => self.by_lines::<true, false>(0, self.crossed),
            (false, _) => self.by_lines::<false, false>(0, self.crossed),
        }
    }

    /// Group after group, and line after line where a group holds something near the ray.
    #[inline(always)]
    fn by_groups<const FORWARD: bool>(&self) -> Option<(usize, usize)> {
        let within = self.line % GROUP;
        let rest = if self.upward { GROUP - 1 - within } else { within };
        let mut group = self.line / GROUP;
        let (mut from, mut leaving) = (self.cell, self.leaving + rest as i64 * self.run);
        let (step, run) = (if self.upward { 1 } else { usize::MAX }, GROUP as i64 * self.run);
        // The first and the last line of the part of the ray in this group, counted from its start.
        let mut first = 0;
        let mut last = rest;
        while first <= self.crossed {
            let to = (leaving >> self.fraction_bits) as usize;
            let lowest = if FORWARD { from } else { to };
            let set = self.lines.group(group, lowest) & span::<FORWARD>(from, to);
            if set != 0 {
                let hit = self.by_lines::<FORWARD, true>(first, last);
                if hit.is_some() {
                    return hit;
                }
            }
            (from, leaving) = (to, leaving + run);
            group = group.wrapping_add(step);
            (first, last) = (last + 1, last + GROUP);
        }
        None
    }

    /// Line after line, from the `first` that the ray passes to the `last`. `SHORT`: a reading
    /// holds all cells of the ray in a line.
    #[inline(always)]
    fn by_lines<const FORWARD: bool, const SHORT: bool>(
        &self,
        first: usize,
        last: usize,
    ) -> Option<(usize, usize)> {
        let mut leaving = self.leaving + first as i64 * self.run;
        let before = ((leaving - self.run) >> self.fraction_bits) as usize;
        let mut from = if first == 0 { self.cell } else { before };
        for passed in first..=last {
            // A long run may end below the wall before the line.
            let to = leaving >> self.fraction_bits;
            let to = if SHORT { to } else { to.max(0) } as usize;
            let line =
                if self.upward { self.line + passed } else { self.line.wrapping_sub(passed) };
            let found = if SHORT {
                self.in_window::<FORWARD>(line, from, to)
            } else {
                self.in_run::<FORWARD>(line, from, to)
            };
            if let Some(cell) = found {
                return Some((line, cell));
            }
            (from, leaving) = (to, leaving + self.run);
        }
        None
    }

    /// The first cell set from `from` to `to`, which one reading holds.
    #[inline(always)]
    fn in_window<const FORWARD: bool>(&self, line: usize, from: usize, to: usize) -> Option<usize> {
        let lowest = if FORWARD { from } else { to };
        let set = self.lines.line(line, lowest) & span::<FORWARD>(from, to);
        let bit = if FORWARD { set.trailing_zeros() } else { 63 - (set | 1).leading_zeros() };
        (set != 0).then_some(lowest + bit as usize)
    }

    /// The same for runs of any length, one reading after the other.
    fn in_run<const FORWARD: bool>(
        &self,
        line: usize,
        mut from: usize,
        to: usize,
    ) -> Option<usize> {
        loop {
            let end = if FORWARD {
                to.min(from + WINDOW - 1)
            } else {
                to.max(from.saturating_sub(WINDOW - 1))
            };
            let found = self.in_window::<FORWARD>(line, from, end);
            if found.is_some() || end == to {
                return found;
            }
            from = end;
        }
    }
}

/// The longest run in a line for which a reading holds all cells of a group.
const GROUP_RUN: usize = (WINDOW - 2) / GROUP - 1;

/// The longest run for which a reading holds all cells of a line.
const LINE_RUN: usize = WINDOW - 2;

/// The lowest bits, as many as there are cells from `from` to `to`.
#[inline(always)]
fn span<const FORWARD: bool>(from: usize, to: usize) -> u64 {
    let cells = if FORWARD { to.wrapping_sub(from) } else { from.wrapping_sub(to) };
    u64::MAX >> (63_usize.wrapping_sub(cells) & 63)
}
