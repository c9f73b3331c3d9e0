//! Which occupied cells belong together: peaks of the belief and the valleys between them.

use super::blocks::{Blocks, Square};

/// How much weight lies in a cell, and which cell it hangs on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub(super) weight: f64,
    pub(super) count: u32,
    /// A cell that is higher, up to the peak, which is its own parent.
    pub(super) parent: u32,
}

/// The lowest point of the way from one peak's cells to another's.
#[derive(Debug, Clone, Copy)]
struct Saddle {
    weight: f64,
    cells: [u32; 2],
}

/// When a valley parts two peaks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Valley {
    /// At most this share of the lower peak.
    pub(super) depth: f64,
    /// Particles of equal weight that a unit of weight is worth.
    pub(super) particles_per_weight: f64,
}

impl Valley {
    /// By how many standard deviations a peak must stand out of its saddle. The square root of a
    /// count has the standard deviation 1/2, whatever the count; the difference of two has
    /// `sqrt(1/2)`.
    const SIGNIFICANCE: f64 = 3.0;

    fn parts(&self, lower_peak: f64, saddle: f64) -> bool {
        let root = |weight: f64| (weight * self.particles_per_weight).sqrt();
        let prominence = std::f64::consts::SQRT_2 * (root(lower_peak) - root(saddle));
        saddle < self.depth * lower_peak && prominence > Self::SIGNIFICANCE
    }
}

/// Scratch memory of the search for peaks.
#[derive(Debug, Default)]
pub(super) struct Modes {
    pairs: Vec<[u32; 2]>,
    saddles: Vec<Saddle>,
}

impl Modes {
    /// Hangs every cell on the peak of its cluster, and each peak on itself.
    pub(super) fn find(
        &mut self,
        blocks: &Blocks,
        headings: u32,
        valley: &Valley,
        cells: &mut [Cell],
    ) {
        self.climb(blocks, headings, cells);
        flatten(cells);
        self.list_saddles(cells);
        for saddle in &self.saddles {
            let [a, b] = saddle.cells.map(|cell| root(cells, cell));
            let [higher, lower] = if above(cells, a, b) { [a, b] } else { [b, a] };
            if !valley.parts(cells[lower as usize].weight, saddle.weight) {
                cells[lower as usize].parent = higher;
            }
        }
        flatten(cells);
    }

    /// Lists all pairs of occupied cells that touch, if only at a corner; headings go round. Hangs
    /// every cell on the highest of its neighbours, if that is higher than itself.
    fn climb(&mut self, blocks: &Blocks, headings: u32, cells: &mut [Cell]) {
        self.pairs.clear();
        let all = u64::MAX >> (u64::BITS - headings);
        let turned = |bits: u64| (bits << 1 | bits >> (headings - 1)) & all;
        let about = |bits: u64| bits | turned(bits) | (bits >> 1 | bits << (headings - 1)) & all;
        blocks.for_neighbours(|square, others| {
            for heading in bits(square.headings) {
                let cell = square.cell(heading);
                let first = self.pairs.len();
                self.join(cell, square, turned(1 << heading));
                for other in others {
                    self.join(cell, other, about(1 << heading));
                }
                hang(cell, &self.pairs[first..], cells);
            }
        });
    }

    fn join(&mut self, cell: u32, other: &Square, headings: u64) {
        for heading in bits(headings & other.headings) {
            self.pairs.push([cell, other.cell(heading)]);
        }
    }

    /// The pairs of cells on different peaks, the highest first; all cells hang on peaks directly.
    fn list_saddles(&mut self, cells: &[Cell]) {
        self.saddles.clear();
        for pair in &self.pairs {
            let [a, b] = pair.map(|cell| cells[cell as usize]);
            if a.parent != b.parent {
                self.saddles.push(Saddle { weight: a.weight.min(b.weight), cells: *pair });
            }
        }
        let descending = |a: &Saddle, b: &Saddle| {
            b.weight.total_cmp(&a.weight).then_with(|| a.cells.cmp(&b.cells))
        };
        self.saddles.sort_unstable_by(descending);
    }
}

/// Hangs a cell on the highest of some neighbours, and each of these on it, where that is higher
/// than what they hang on.
#[inline(always)]
fn hang(cell: u32, pairs: &[[u32; 2]], cells: &mut [Cell]) {
    let mut highest = cells[cell as usize].parent;
    for &[_, other] in pairs {
        if above(cells, other, highest) {
            highest = other;
        }
        if above(cells, cell, cells[other as usize].parent) {
            cells[other as usize].parent = cell;
        }
    }
    cells[cell as usize].parent = highest;
}

/// Whether one cell is higher than another; of equal ones the first is.
#[inline(always)]
fn above(cells: &[Cell], a: u32, b: u32) -> bool {
    let [x, y] = [cells[a as usize].weight, cells[b as usize].weight];
    x > y || (x >= y && a < b)
}

/// Hangs every cell on its peak directly.
fn flatten(cells: &mut [Cell]) {
    for cell in 0..cells.len() {
        let mut peak = cells[cell].parent;
        while cells[peak as usize].parent != peak {
            peak = cells[peak as usize].parent;
        }
        cells[cell].parent = peak;
    }
}

/// The peak that a cell hangs on; the way there is halved.
fn root(cells: &mut [Cell], mut cell: u32) -> u32 {
    while cells[cell as usize].parent != cell {
        let next = cells[cells[cell as usize].parent as usize].parent;
        cells[cell as usize].parent = next;
        cell = next;
    }
    cell
}

/// The places of the bits that are set.
fn bits(mut mask: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let lowest = (mask != 0).then(|| mask.trailing_zeros());
        mask &= mask.wrapping_sub(1);
        lowest
    })
}
