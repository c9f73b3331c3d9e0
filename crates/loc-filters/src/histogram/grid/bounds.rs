//! How likely a scan can be at best anywhere in a cell of the grid.
//!
//! Seen from anywhere in a square and a sector of headings, a beam ends somewhere in a small window
//! about where it ends seen from the middle. The highest likelihood in that window is computed
//! beforehand, for windows of several sizes; the sum over the beams is a bound for every pose of
//! the cell. Cells whose bound is low need not be looked at more closely.
//!
//! The maxima lie sorted by their column and row modulo the side of a square: the ends of one beam
//! seen from a row of squares are then neighbours in memory, and are added up many at a time.

use super::picture::{Phases, Picture};
use super::scan::Scan;
use super::space::PoseSpace;
use loc_maps::LikelihoodField;

/// How many sizes of windows there are.
const SIZES: usize = 7;

/// From one size to the next, about.
const GROWTH: f64 = 1.4;

/// As many codes as 16 bits can hold the sum of.
const IN_16_BITS: usize = 257;

/// Rounding of an end in cells.
const ROUNDING: f64 = 1e-6;

/// The highest codes in windows about all cells.
#[derive(Debug, Clone)]
pub(super) struct BoundMaps {
    /// Windows reach so many cells beyond the one in their middle, in ascending order.
    reaches: Vec<usize>,
    maps: Vec<Phases>,
    /// Cells of margin around the map.
    margin: usize,
    side: usize,
    off_map: u8,
}

/// The sums of a layer.
#[derive(Debug, Clone, Default)]
pub(super) struct LayerBounds {
    sums: Vec<u32>,
    short: Vec<u16>,
}

impl BoundMaps {
    pub(super) fn new(field: &LikelihoodField, side: usize) -> Self {
        let mut reaches = vec![(side - 1).div_ceil(2).max(1)];
        while reaches.len() < SIZES {
            let last = reaches[reaches.len() - 1];
            reaches.push(((last as f64 * GROWTH) as usize).max(last + 1));
        }
        // So wide that what lies at its edge sees nothing of the map.
        let margin = (2 * reaches[SIZES - 1]).next_multiple_of(side);
        let picture = Picture::padded(field, margin);
        let highest = |&reach: &usize| Phases::of(&picture.highest(reach), side);
        let maps = reaches.iter().map(highest).collect();
        BoundMaps { reaches, maps, margin, side, off_map: field.code_off_map() }
    }

    /// For each square the highest sum of codes that any of its poses can have, in the layer with
    /// this number.
    pub(super) fn of_layer<'a>(
        &self,
        space: &PoseSpace,
        scan: &Scan,
        layer: usize,
        bounds: &'a mut LayerBounds,
    ) -> &'a [u32] {
        let squares = space.size();
        let LayerBounds { sums, short } = bounds;
        sums.clear();
        sums.resize(squares.layer(), 0);
        let ends = scan.turned(space.heading_in_grid(layer));
        for ends in ends.chunks(IN_16_BITS) {
            short.clear();
            short.resize(squares.layer(), 0);
            for &end in ends {
                self.add(space, end, scan.widest_turn(), squares.columns, short);
            }
            sums.iter_mut().zip(&*short).for_each(|(sum, short)| *sum += u32::from(*short));
        }
        sums
    }

    /// Adds the codes of one beam that ends `x` columns and `y` rows from the robot.
    fn add(&self, space: &PoseSpace, [x, y]: [f64; 2], turn: f64, width: usize, sums: &mut [u16]) {
        let half = 0.5 * (self.side - 1) as f64;
        let (sin, versed) = (turn.sin(), 1.0 - turn.cos());
        let moved = (y.abs() * sin + x.abs() * versed).max(x.abs() * sin + y.abs() * versed);
        let reach = (half + moved + ROUNDING).ceil() as usize;
        let size = self.reaches.partition_point(|known| *known < reach);
        let Some(map) = self.maps.get(size) else {
            // Too far away to be told anything of.
            sums.iter_mut().for_each(|sum| *sum += 255);
            return;
        };
        let corner = space.corner_of(0);
        let ((phase_x, column), (phase_y, row)) =
            (self.place(corner[0], x), self.place(corner[1], y));
        let part = map.part(phase_x, phase_y);
        let [columns, rows] = map.part_size();
        let inside = overlap(column, columns, width);
        let off_map = u16::from(self.off_map);
        for (k, sums) in sums.chunks_exact_mut(width).enumerate() {
            let Some(row) = usize::try_from(row + k as isize).ok().filter(|row| *row < rows) else {
                sums.iter_mut().for_each(|sum| *sum += off_map);
                continue;
            };
            let (before, rest) = sums.split_at_mut(inside.start);
            let (within, after) = rest.split_at_mut(inside.len());
            before.iter_mut().for_each(|sum| *sum += off_map);
            after.iter_mut().for_each(|sum| *sum += off_map);
            let first = row * columns + (column + inside.start as isize).max(0) as usize;
            let codes = part.get(first..first + within.len()).unwrap_or_default();
            within.iter_mut().zip(codes).for_each(|(sum, code)| *sum += u16::from(*code));
        }
    }

    /// Phase and place of the cell in which a beam ends from the middle of the first square, along
    /// one axis.
    fn place(&self, corner: usize, end: f64) -> (usize, isize) {
        let from_corner = (0.5 * self.side as f64 + end).floor() as isize;
        let at = (corner + self.margin) as isize + from_corner;
        let side = self.side as isize;
        (at.rem_euclid(side) as usize, at.div_euclid(side))
    }
}

/// Which of `count` places from `start` on lie within `0..length`.
fn overlap(start: isize, length: usize, count: usize) -> std::ops::Range<usize> {
    let clip = |end: isize| end.clamp(0, count as isize) as usize;
    let first = clip(-start);
    first..clip(length as isize - start).max(first)
}
