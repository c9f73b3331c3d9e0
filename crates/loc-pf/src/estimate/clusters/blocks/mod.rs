//! Which cells are occupied: a hash table of blocks of 4 x 4 squares, in which every square has one
//! bit for each heading. A tracked cloud lies in a few blocks; a cloud all over a map fills most
//! squares of the blocks it needs.

mod neighbours;

use super::raster::{Address, MAX_HEADINGS};

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

/// Most blocks: places have room for 4 million, and a cloud that needs more is on no map.
const MAX: usize = (NOWHERE / BLOCK) as usize;

/// Open addressing with linear probing: 4 bytes a slot, at most half of them taken.
#[derive(Debug)]
pub(super) struct Blocks {
    /// Index of a block plus 1; 0 is free.
    slots: Vec<u32>,
    blocks: Vec<Block>,
    /// The blocks row by row.
    order: Vec<u32>,
    /// The block that was asked for last.
    last: usize,
    /// Most blocks that there may be.
    most: usize,
}

impl Default for Blocks {
    fn default() -> Self {
        Blocks::at_most(MAX)
    }
}

/// Where a cell is among the blocks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// The key of its block.
    pub(super) block: u64,
    /// Its square and its heading there.
    pub(super) within: u32,
}

impl Place {
    /// From a place among some blocks to that within its block.
    #[inline(always)]
    pub(super) fn within(place: u32) -> u32 {
        place % BLOCK
    }

    #[inline(always)]
    pub(super) fn of(address: Address) -> Place {
        let [row, column] = address.square;
        let square = row % SIDE * SIDE + column % SIDE;
        Place {
            block: u64::from(row / SIDE) * ROW + u64::from(column / SIDE),
            within: square * MAX_HEADINGS + address.heading,
        }
    }
}

impl Blocks {
    /// Room for so many blocks.
    pub(super) fn at_most(most: usize) -> Self {
        let (slots, blocks, order) = (Vec::new(), Vec::new(), Vec::new());
        Blocks { slots, blocks, order, last: 0, most }
    }

    /// Forgets all blocks and keeps the memory.
    pub(super) fn clear(&mut self) {
        for block in self.blocks.drain(..) {
            self.slots[block.slot] = 0;
        }
        if self.slots.is_empty() {
            self.slots.resize(256, 0);
        }
    }

    /// Marks a cell of a block as occupied and returns its place among all blocks, from which
    /// [`cell`](Blocks::cell) tells its number later; [`NOWHERE`] where there is no room for the
    /// block.
    #[inline(always)]
    pub(super) fn occupy(&mut self, key: u64, within: u32) -> u32 {
        // Particles of a tracked cloud lie in one and the same block, more often than not.
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
            Err(_) if self.blocks.len() >= self.most => None,
            Err(slot) => Some(self.add(key, slot)),
        }
    }

    /// The number of the cell at a place.
    #[inline(always)]
    pub(super) fn cell(&self, place: u32) -> u32 {
        let square = (place / MAX_HEADINGS) as usize % SQUARES;
        self.blocks[(place / BLOCK) as usize].squares[square].cell(place % MAX_HEADINGS)
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
}
