//! The bounds of all windows of the top level at all headings: where the search starts.

use super::headings::Turned;
use super::level::Level;
use super::pyramid::GROUP;
use super::sums::{self, Ends};
use crate::Workers;
use std::ops::Range;

/// Bounds of the top level, heading by heading and row by row.
///
/// A bound is kept in 16 bits, as a multiple of a power of two, rounded up, plus one; 0 stands for
/// a window without free cells.
#[derive(Debug)]
pub(super) struct Coarse {
    kept: Vec<u16>,
    /// Windows of a heading.
    windows: usize,
    /// Bits that a bound lost.
    lost: u32,
    /// The largest one of each heading.
    largest: Vec<u16>,
    /// Windows with this and more were handed out.
    handed_out: u32,
    /// How far down the next ones go.
    slab: u32,
}

/// A window of the top level with its bound.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub(super) heading: u32,
    /// Row-major place among the windows of its heading.
    pub(super) index: u32,
    pub(super) bound: u32,
}

impl Coarse {
    pub(super) fn new(top: &Level, turned: &Turned, workers: &Workers) -> Self {
        let [columns, rows] = top.size();
        let windows = columns * rows;
        let highest = 255 * turned.beams() as u64 + 2;
        let lost = (0..32).find(|&bits| (highest >> bits) + 2 < 1 << 16).unwrap_or(32);
        let extents: Vec<Range<usize>> = (0..rows).map(|row| extent(top.free_row(row))).collect();
        let mut kept = vec![0; windows * turned.headings()];
        let parts = kept.chunks_exact_mut(windows).enumerate();
        let mut largest = vec![0; turned.headings()];
        workers.for_each(parts.zip(&mut largest), |((heading, kept), largest)| {
            let ends = turned.at(heading);
            pulp::Arch::new().dispatch(Fill { top, extents: &extents, ends, lost, kept });
            *largest = kept.iter().copied().max().unwrap_or(0);
        });
        let handed_out = largest.iter().copied().max().map_or(0, |most| u32::from(most) + 1);
        Coarse { kept, windows, lost, largest, handed_out, slab: 8 }
    }

    fn bound(&self, kept: u32) -> u32 {
        (kept - 1) << self.lost
    }

    /// No window that is still to come has a higher bound; `None` when all were handed out.
    pub(super) fn highest_left(&self) -> Option<u32> {
        (self.handed_out > 1).then(|| self.bound(self.handed_out - 1))
    }

    /// The next lot of windows: all those whose bound is within a range below what was handed out
    /// and at least `floor`, heading by heading. Every lot reaches twice as far down as the last.
    pub(super) fn next_lot(&mut self, floor: u32) -> Vec<Window> {
        let last = self.handed_out.saturating_sub(1);
        let first = self.handed_out.saturating_sub(self.slab).max((floor >> self.lost) + 1);
        (self.handed_out, self.slab) = (first.min(last), self.slab * 2);
        let range = first.min(u32::from(u16::MAX)) as u16..=last as u16;
        let mut lot = Vec::new();
        let headings = self.kept.chunks_exact(self.windows).zip(&self.largest).enumerate();
        for (heading, (kept, _)) in headings.filter(|(_, (_, most))| *most >= range.start()) {
            for (part, kept) in kept.chunks(GROUP).enumerate() {
                // Most groups have nothing: one look by vector instructions tells.
                if kept.iter().fold(false, |any, kept| any | range.contains(kept)) {
                    let inside = kept.iter().enumerate().filter(|(_, kept)| range.contains(kept));
                    lot.extend(inside.map(|(k, &kept)| Window {
                        heading: heading as u32,
                        index: (part * GROUP + k) as u32,
                        bound: self.bound(u32::from(kept)),
                    }));
                }
            }
        }
        lot
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
    ends: Ends<'a>,
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
        sums::rows(top, extents, ends, pitch, &mut all);
        let rows = kept.chunks_exact_mut(columns).zip(all.chunks_exact(pitch)).enumerate();
        for (row, (kept, sums)) in rows {
            for ((kept, &sum), &free) in kept.iter_mut().zip(sums).zip(top.free_row(row)) {
                *kept = if free { (sum.div_ceil(1 << lost) + 1) as u16 } else { 0 };
            }
        }
    }
}
