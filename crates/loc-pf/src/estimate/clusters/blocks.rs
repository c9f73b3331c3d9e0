//! Which cells are occupied: a hash table of blocks of 4 x 4 squares, in which every square has one
//! bit for each heading. The particles of a tracked robot lie in a few blocks; those over a whole
//! map fill most squares of their blocks. [`Modes`] finds the peaks of the occupied cells and
//! attaches every cell to one.

use super::cells::{Address, MAX_HEADINGS};

/// Stands for particles that are in no cell.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Squares along the side of a block.
const SIDE: u32 = 4;

/// Squares of a block.
const SQUARES: usize = (SIDE * SIDE) as usize;

/// Cells of a block.
const BLOCK: u32 = SQUARES as u32 * MAX_HEADINGS;

/// From one key to that of the block above.
const ROW: u64 = 1 << 32;

/// The headings of a square at which there are particles.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Square {
    /// One bit for each heading.
    pub(super) headings: u64,
    /// The number of the first cell; the others follow in the order of their headings.
    first: u32,
}

impl Square {
    /// The number of the cell at a heading that is occupied.
    #[inline(always)]
    pub(super) fn cell(&self, heading: u32) -> u32 {
        self.first + (self.headings & ((1 << heading) - 1)).count_ones()
    }
}

/// Squares row by row.
#[derive(Debug)]
struct Block {
    /// Row and column, 32 bits each.
    key: u64,
    /// Where it stands in the table.
    slot: usize,
    squares: [Square; SQUARES],
}

/// Maximum number of blocks: offsets have room for 4 million, more than any map needs.
const MAX: usize = (NOWHERE / BLOCK) as usize;

/// Open addressing with linear probing: 4 bytes a slot, at most half of them taken.
#[derive(Debug)]
pub(super) struct Blocks {
    /// Index of a block plus 1; 0 is free.
    slots: Vec<u32>,
    blocks: Vec<Block>,
    /// The blocks row by row.
    order: Vec<u32>,
    /// The block used last.
    last: usize,
    /// Maximum number of blocks.
    max: usize,
}

impl Default for Blocks {
    fn default() -> Self {
        Blocks::with_max(MAX)
    }
}

/// Where a cell is among the blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct BlockOffset {
    /// The key of its block.
    pub(super) block: u64,
    /// Its square and its heading there.
    pub(super) within: u32,
}

impl BlockOffset {
    /// From a offset among some blocks to that within its block.
    #[inline(always)]
    pub(super) fn within(offset: u32) -> u32 {
        offset % BLOCK
    }

    #[inline(always)]
    pub(super) fn of(address: Address) -> BlockOffset {
        let [row, column] = address.square;
        let square = row % SIDE * SIDE + column % SIDE;
        BlockOffset {
            block: u64::from(row / SIDE) * ROW + u64::from(column / SIDE),
            within: square * MAX_HEADINGS + address.heading,
        }
    }
}

impl Blocks {
    /// A table for at most `max` blocks.
    pub(super) fn with_max(max: usize) -> Self {
        let (slots, blocks, order) = (Vec::new(), Vec::new(), Vec::new());
        Blocks { slots, blocks, order, last: 0, max }
    }

    /// Removes all blocks and keeps the memory.
    pub(super) fn clear(&mut self) {
        for block in self.blocks.drain(..) {
            self.slots[block.slot] = 0;
        }
        if self.slots.is_empty() {
            self.slots.resize(256, 0);
        }
    }

    /// Marks a cell of a block as occupied and returns its offset among all blocks, from which
    /// [`cell`](Blocks::cell) gives its number later; [`NOWHERE`] where there is no room for the
    /// block.
    #[inline(always)]
    pub(super) fn occupy(&mut self, key: u64, within: u32) -> u32 {
        // Successive particles of a tracked robot are usually in the same block.
        let index = match self.blocks.get(self.last) {
            Some(block) if block.key == key => self.last,
            _ => match self.find_or_add(key) {
                Some(index) => index,
                None => return NOWHERE,
            },
        };
        self.last = index;
        let square = &mut self.blocks[index].squares[(within / MAX_HEADINGS) as usize % SQUARES];
        square.headings |= 1 << (within % MAX_HEADINGS);
        index as u32 * BLOCK + within
    }

    /// Marks as occupied what is so in `others`; fills `indices` with those of their blocks here.
    /// Returns whether there was room for all.
    pub(super) fn occupy_as(&mut self, others: &Blocks, indices: &mut Vec<usize>) -> bool {
        indices.clear();
        for other in &others.blocks {
            let Some(index) = self.find_or_add(other.key) else { return false };
            let squares = self.blocks[index].squares.iter_mut().zip(&other.squares);
            squares.for_each(|(square, other)| square.headings |= other.headings);
            indices.push(index);
        }
        true
    }

    /// Takes over the numbers of the cells from `others`, where the blocks have the given indices.
    pub(super) fn number_as(&mut self, others: &Blocks, indices: &[usize]) {
        for (block, &index) in self.blocks.iter_mut().zip(indices) {
            block.squares = others.blocks[index].squares;
        }
    }

    #[inline(always)]
    fn find_or_add(&mut self, key: u64) -> Option<usize> {
        match self.look_up(key) {
            Ok(index) => Some(index),
            Err(_) if self.blocks.len() >= self.max => None,
            Err(slot) => Some(self.add(key, slot)),
        }
    }

    /// The number of the cell at a offset.
    #[inline(always)]
    pub(super) fn cell(&self, offset: u32) -> u32 {
        let square = (offset / MAX_HEADINGS) as usize % SQUARES;
        self.blocks[(offset / BLOCK) as usize].squares[square].cell(offset % MAX_HEADINGS)
    }

    /// Numbers the cells by where they are, whatever the order in which they were occupied; returns
    /// how many there are.
    pub(super) fn number_cells(&mut self) -> usize {
        self.order.clear();
        self.order.extend(0..self.blocks.len() as u32);
        self.order.sort_unstable_by_key(|&index| self.blocks[index as usize].key);
        let mut next = 0;
        for &index in &self.order {
            for square in &mut self.blocks[index as usize].squares {
                square.first = next;
                next += square.headings.count_ones();
            }
        }
        next as usize
    }

    /// The index of the block with a key, or else the slot where it belongs.
    #[inline(always)]
    fn look_up(&self, key: u64) -> Result<usize, usize> {
        let mut slot = self.home(key);
        loop {
            let Some(index) = self.slots[slot].checked_sub(1) else { return Err(slot) };
            if self.blocks[index as usize].key == key {
                return Ok(index as usize);
            }
            slot = (slot + 1) & (self.slots.len() - 1);
        }
    }

    /// Where the search for a key begins (Fibonacci hashing); there are 2^k slots.
    #[inline(always)]
    fn home(&self, key: u64) -> usize {
        let mixed = (key ^ (key >> 29)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> (u64::BITS - self.slots.len().trailing_zeros())) as usize
    }

    #[cold]
    fn add(&mut self, key: u64, slot: usize) -> usize {
        let index = self.blocks.len();
        self.blocks.push(Block { key, slot, squares: [Square::default(); SQUARES] });
        self.slots[slot] = index as u32 + 1;
        if 2 * self.blocks.len() > self.slots.len() {
            self.grow();
        }
        index
    }

    fn grow(&mut self) {
        let slots = 2 * self.slots.len();
        self.slots.clear();
        self.slots.resize(slots, 0);
        for index in 0..self.blocks.len() {
            let mut slot = self.home(self.blocks[index].key);
            while self.slots[slot] != 0 {
                slot = (slot + 1) & (slots - 1);
            }
            self.slots[slot] = index as u32 + 1;
            self.blocks[index].slot = slot;
        }
    }

    /// Calls `work` for every occupied square with its neighbours to the right, above left, above,
    /// and above right, so that each two squares that touch come together once.
    pub(in crate::estimate::clusters) fn for_neighbours(
        &self,
        mut work: impl FnMut(&Square, [&Square; 4]),
    ) {
        const WIDTH: usize = SIDE as usize + 2;
        let free = [Square::default(); SQUARES];
        for &index in &self.order {
            let block = &self.blocks[index as usize];
            let at = |up: u64, right: u64| {
                // One more to the right than is meant.
                let key = block.key.wrapping_add(up * ROW + right).wrapping_sub(1);
                self.look_up(key).map_or(&free, |index| &self.blocks[index].squares)
            };
            let [left, right] = [at(0, 0), at(0, 2)];
            let above = [at(1, 0), at(1, 1), at(1, 2)];
            // The block with a border of one square, but for the side below.
            let row = |row: usize| {
                let [left, own, right] =
                    if row < SIDE as usize { [left, &block.squares, right] } else { above };
                let first = row % SIDE as usize * SIDE as usize;
                let [a, b, c, d] = std::array::from_fn(|k| &own[first + k]);
                [&left[first + SIDE as usize - 1], a, b, c, d, &right[first]]
            };
            let mut lower: [&Square; WIDTH] = row(0);
            for upper in (1..=SIDE as usize).map(row) {
                for k in 1..WIDTH - 1 {
                    if lower[k].headings != 0 {
                        work(lower[k], [lower[k + 1], upper[k - 1], upper[k], upper[k + 1]]);
                    }
                }
                lower = upper;
            }
        }
    }
}

/// The weight in a cell, and the cell it is attached to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    pub(super) weight: f64,
    pub(super) count: u32,
    /// A cell that is higher, up to the peak, which is its own parent.
    pub(super) parent: u32,
}

/// The lowest point between the cells of two peaks.
#[derive(Debug, Clone, Copy)]
struct Saddle {
    weight: f64,
    cells: [u32; 2],
}

/// When a valley separates two peaks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Valley {
    /// At most this share of the lower peak.
    pub(super) depth: f64,
    /// Particles of equal weight for a unit of weight.
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
    /// Attaches every cell to the peak of its cluster, and each peak to itself.
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

    /// Lists all pairs of occupied cells that touch, if only at a corner; headings go round.
    /// Attaches every cell to the highest of its neighbours, if that is higher than itself.
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
                attach(cell, &self.pairs[first..], cells);
            }
        });
    }

    fn join(&mut self, cell: u32, other: &Square, headings: u64) {
        for heading in bits(headings & other.headings) {
            self.pairs.push([cell, other.cell(heading)]);
        }
    }

    /// The pairs of cells on different peaks, the highest first; all cells are attached to peaks
    /// directly.
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

/// Attaches a cell to the highest of some neighbours, and each of these to it, where that is higher
/// than the cell they are attached to.
#[inline(always)]
fn attach(cell: u32, pairs: &[[u32; 2]], cells: &mut [Cell]) {
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

/// Attaches every cell to its peak directly.
fn flatten(cells: &mut [Cell]) {
    for cell in 0..cells.len() {
        let mut peak = cells[cell].parent;
        while cells[peak as usize].parent != peak {
            peak = cells[peak as usize].parent;
        }
        cells[cell].parent = peak;
    }
}

/// The peak that a cell is attached to (union-find with path halving).
fn root(cells: &mut [Cell], mut cell: u32) -> u32 {
    while cells[cell as usize].parent != cell {
        let next = cells[cells[cell as usize].parent as usize].parent;
        cells[cell as usize].parent = next;
        cell = next;
    }
    cell
}

/// The positions of the bits that are set.
fn bits(mut mask: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let lowest = (mask != 0).then(|| mask.trailing_zeros());
        mask &= mask.wrapping_sub(1);
        lowest
    })
}
