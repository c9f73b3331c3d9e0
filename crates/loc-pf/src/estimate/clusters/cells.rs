//! From particles to their occupied cells and the weight in each.

use super::blocks::{BlockOffset, Blocks, Cell, NOWHERE};
use crate::estimate::{ROUNDER, is_pose, wrapped};
use crate::workers::PART;
use crate::{Poses, Workers};
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::TAU;

/// The occupied cells of a particle set, with memory kept from one set to the next.
#[derive(Debug)]
pub(super) struct Cells {
    pub(super) raster: Raster,
    pub(super) blocks: Blocks,
    /// For each particle the key of its block.
    keys: Vec<u64>,
    /// For each particle its offset in the block, then among all blocks, at last its cell.
    offsets: Vec<u32>,
    /// The cells, numbered by where they are.
    pub(super) all: Vec<Cell>,
    /// The same for each part of the particle set, where they are few.
    of_parts: Vec<Cell>,
    parts: Vec<Part>,
}

/// A part of the particles with its own blocks, if they are few, as for a tracked robot. Then its
/// particles need not be processed in sequence with those of the other parts.
#[derive(Debug)]
struct Part {
    blocks: Blocks,
    /// For each of them its index among the blocks of the particle set.
    indices: Vec<usize>,
    /// Whether there were too many: the offsets are then those among the blocks of the particle
    /// set.
    is_scattered: bool,
}

impl Default for Part {
    fn default() -> Self {
        Part { blocks: Blocks::with_max(MAX_BLOCKS), indices: Vec::new(), is_scattered: false }
    }
}

/// Maximum number of blocks of a part.
const MAX_BLOCKS: usize = 4;

impl Cells {
    pub(super) fn new(raster: Raster) -> Self {
        Cells {
            raster,
            blocks: Blocks::default(),
            keys: Vec::new(),
            offsets: Vec::new(),
            all: Vec::new(),
            of_parts: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// For each particle its cell, or [`NOWHERE`].
    pub(super) fn of_particles(&mut self) -> &mut [u32] {
        &mut self.offsets
    }

    /// Finds the cell of every particle that has a weight, and what each cell weighs. Returns how
    /// many particles of equal weight correspond to a unit of weight, by the effective sample size.
    pub(super) fn find(&mut self, workers: &Workers, poses: Poses<'_>, weights: &[f64]) -> f64 {
        self.address(workers, poses, weights);
        self.occupy();
        let count = self.blocks.number_cells();
        let [sum, squares] = self.weigh(workers, weights, count);
        if squares > 0.0 { sum / squares } else { 0.0 }
    }

    /// Finds the block of every particle and its offset there.
    fn address(&mut self, workers: &Workers, poses: Poses<'_>, weights: &[f64]) {
        self.keys.resize(poses.len(), 0);
        self.offsets.resize(poses.len(), 0);
        self.parts.resize_with(poses.len().div_ceil(PART), Part::default);
        let raster = self.raster;
        let found = self.keys.chunks_mut(PART).zip(self.offsets.chunks_mut(PART));
        let particles = poses.chunks(PART).zip(weights.chunks(PART));
        let parts = self.parts.iter_mut().zip(particles.zip(found));
        workers.for_each(parts, |(part, ((poses, weights), (keys, offsets)))| {
            Arch::new().dispatch(FindBlocks { raster, poses, weights, keys, offsets });
            part.is_scattered = !part.occupy(keys, offsets);
        });
    }

    /// Brings the blocks of all parts together.
    fn occupy(&mut self) {
        self.blocks.clear();
        let found = self.keys.chunks(PART).zip(self.offsets.chunks_mut(PART));
        for (part, (keys, offsets)) in self.parts.iter_mut().zip(found) {
            let joined = !part.is_scattered;
            if !(joined && self.blocks.occupy_as(&part.blocks, &mut part.indices)) {
                part.is_scattered = true;
                for (key, offset) in
                    keys.iter().zip(offsets).filter(|(_, offset)| **offset != NOWHERE)
                {
                    *offset = self.blocks.occupy(*key, BlockOffset::within(*offset));
                }
            }
        }
    }

    /// Adds up the weights of every cell and turns offsets into cells. Returns the sum of all
    /// weights and that of their squares.
    fn weigh(&mut self, workers: &Workers, weights: &[f64], count: usize) -> [f64; 2] {
        let Cells { blocks, offsets, all, of_parts, parts, .. } = self;
        all.clear();
        all.extend((0..count as u32).map(|parent| Cell { weight: 0.0, count: 0, parent }));
        let particles = offsets.chunks_mut(PART).zip(weights.chunks(PART));
        let parts = parts.iter_mut().zip(particles);
        if count == 0 || count > PART {
            let sums = parts.map(|(part, (offsets, weights))| {
                weigh(part.numbered(blocks), offsets, weights, all)
            });
            return sums.fold([0.0; 2], plus);
        }
        of_parts.clear();
        of_parts.resize(parts.len() * count, Cell { weight: 0.0, count: 0, parent: 0 });
        let parts = parts.zip(of_parts.chunks_mut(count));
        let sums = workers.map(parts, |((part, (offsets, weights)), cells)| {
            weigh(part.numbered(blocks), offsets, weights, cells)
        });
        for part in of_parts.chunks(count) {
            for (cell, part) in all.iter_mut().zip(part) {
                cell.weight += part.weight;
                cell.count += part.count;
            }
        }
        sums.into_iter().fold([0.0; 2], plus)
    }
}

fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

impl Part {
    /// Occupies the cells of its particles and turns their offsets within blocks into those among
    /// its own blocks; stops and returns false where these are too many.
    fn occupy(&mut self, keys: &[u64], offsets: &mut [u32]) -> bool {
        self.blocks.clear();
        for (key, offset) in keys.iter().zip(offsets).filter(|(_, offset)| **offset != NOWHERE) {
            let found = self.blocks.occupy(*key, *offset);
            if found == NOWHERE {
                return false;
            }
            *offset = found;
        }
        true
    }

    /// The blocks that the offsets of its particles are in, with cells numbered.
    fn numbered<'a>(&'a mut self, of_set: &'a Blocks) -> &'a Blocks {
        if self.is_scattered {
            return of_set;
        }
        self.blocks.number_as(of_set, &self.indices);
        &self.blocks
    }
}

/// Adds particles to cells and turns their offsets into cells; the sum of their weights and that of
/// their squares.
fn weigh(blocks: &Blocks, offsets: &mut [u32], weights: &[f64], cells: &mut [Cell]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (offset, &weight) in offsets.iter_mut().zip(weights) {
        if *offset != NOWHERE {
            *offset = blocks.cell(*offset);
            let cell = &mut cells[*offset as usize];
            cell.weight += weight;
            cell.count += 1;
            sums = plus(sums, [weight, weight * weight]);
        }
    }
    sums
}

/// Finds the block of each particle of a part and its offset there.
struct FindBlocks<'a> {
    raster: Raster,
    poses: Poses<'a>,
    weights: &'a [f64],
    keys: &'a mut [u64],
    offsets: &'a mut [u32],
}

impl WithSimd for FindBlocks<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Poses { x, y, theta } = self.poses;
        let found = self.keys.iter_mut().zip(self.offsets);
        let poses = x.iter().zip(y).zip(theta).zip(self.weights);
        for ((((&x, &y), &theta), &weight), (key, offset)) in poses.zip(found) {
            let counts = (weight > 0.0) & Raster::is_on(x, y, theta);
            let found = BlockOffset::of(self.raster.address(x, y, theta));
            *key = found.block;
            *offset = if counts { found.within } else { NOWHERE };
        }
    }
}

/// Maximum number of headings: a square of the floor has one bit for each.
pub(super) const MAX_HEADINGS: u32 = 64;

/// A cell: its square of the floor and the number of its heading.
#[derive(Debug, Clone, Copy)]
pub(super) struct Address {
    /// Row and column of the square, both counted from 2^31 in the middle.
    pub(super) square: [u32; 2],
    pub(super) heading: u32,
}

/// The division of the space of poses (x, y, theta) into cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Raster {
    squares_per_metre: f64,
    headings_per_radian: f64,
    /// Number of headings, at most 64.
    pub(super) headings: u32,
}

impl Raster {
    /// Cells of `side` \[m\] and about `width` \[rad\], so that a whole number of them fills a
    /// turn.
    pub(super) fn new(side: f64, width: f64) -> Self {
        let headings = (TAU / width).round().clamp(3.0, f64::from(MAX_HEADINGS));
        Raster {
            squares_per_metre: 1.0 / side,
            headings_per_radian: headings / TAU,
            headings: headings as u32,
        }
    }

    /// Whether three numbers can be a pose.
    #[inline(always)]
    pub(super) fn is_on(x: f64, y: f64, theta: f64) -> bool {
        is_pose(x, y, theta)
    }

    /// The cell of a pose; some cell for what is no pose.
    #[inline(always)]
    pub(super) fn address(&self, x: f64, y: f64, theta: f64) -> Address {
        // Squares more than 2^31 away share numbers with nearer ones, outside any map.
        let nearest = |metres: f64| {
            let rounded = (metres * self.squares_per_metre + ROUNDER).to_bits() as u32;
            rounded ^ 1 << 31
        };
        let turned = wrapped(theta) * self.headings_per_radian;
        let (truncated, all) = (turned as i32, self.headings as i32);
        let below = truncated - i32::from(f64::from(truncated) > turned);
        let from_zero = if below < 0 { below + all } else { below };
        let heading = if from_zero >= all { from_zero - all } else { from_zero } as u32;
        Address { square: [nearest(y), nearest(x)], heading }
    }
}
