//! How likely a scan can be at best anywhere in a cell of the grid.
//!
//! Seen from anywhere in a square and a sector of headings, a beam ends somewhere in a small window
//! about where it ends seen from the middle. The highest likelihood in that window is computed
//! beforehand, for windows of several sizes; the sum over the beams is a bound for every pose of
//! the cell. Cells whose bound is low need not be looked at more closely.
//!
//! The maxima lie sorted by their column and row modulo the side of a square: the ends of one beam
//! seen from a row of squares are then neighbours in memory, and are added up many at a time.

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

/// A picture, sorted by column and row modulo the side of a square.
#[derive(Debug, Clone)]
struct Phases {
    codes: Vec<u8>,
    /// Columns and rows of each part.
    part: [usize; 2],
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
        let margin = reaches[SIZES - 1].next_multiple_of(side);
        let picture = Picture::padded(field, margin);
        let maps = reaches.iter().map(|&reach| Phases::of(&picture.highest(reach), side)).collect();
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
        let place = |corner: usize, end: f64| {
            let from_corner = (0.5 * self.side as f64 + end).floor() as isize;
            let at = corner as isize + self.margin as isize + from_corner;
            (at.rem_euclid(self.side as isize) as usize, at.div_euclid(self.side as isize))
        };
        let ((phase_x, column), (phase_y, row)) = (place(corner[0], x), place(corner[1], y));
        let part = map.part(phase_y * self.side + phase_x);
        let [columns, rows] = map.part;
        let inside = overlap(column, columns, width);
        for (k, sums) in sums.chunks_exact_mut(width).enumerate() {
            let row = usize::try_from(row + k as isize).ok().filter(|row| *row < rows);
            let inside = if row.is_some() { inside.clone() } else { 0..0 };
            let (before, rest) = sums.split_at_mut(inside.start);
            let (within, after) = rest.split_at_mut(inside.len());
            before.iter_mut().chain(after).for_each(|sum| *sum += u16::from(self.off_map));
            let first =
                row.unwrap_or(0) * columns + (column + inside.start as isize).max(0) as usize;
            let codes = part.get(first..first + within.len()).unwrap_or_default();
            within.iter_mut().zip(codes).for_each(|(sum, code)| *sum += u16::from(*code));
        }
    }
}

/// Which of `count` places from `start` on lie within `0..length`.
fn overlap(start: isize, length: usize, count: usize) -> std::ops::Range<usize> {
    let clip = |end: isize| end.clamp(0, count as isize) as usize;
    let first = clip(-start);
    first..clip(length as isize - start).max(first)
}

impl Phases {
    fn of(picture: &Picture, side: usize) -> Self {
        let part = [picture.width.div_ceil(side), picture.height().div_ceil(side)];
        let mut codes = vec![0; part[0] * part[1] * side * side];
        for (row, from) in picture.codes.chunks_exact(picture.width).enumerate() {
            for (column, &code) in from.iter().enumerate() {
                let phase = row % side * side + column % side;
                let place = (phase * part[1] + row / side) * part[0] + column / side;
                codes[place] = code;
            }
        }
        // Cells that the last squares have beyond the picture count as its last ones.
        if !picture.width.is_multiple_of(side) || !picture.height().is_multiple_of(side) {
            let last = [picture.width - 1, picture.height() - 1];
            for row in 0..part[1] * side {
                for column in 0..part[0] * side {
                    if row > last[1] || column > last[0] {
                        let code =
                            picture.codes[row.min(last[1]) * picture.width + column.min(last[0])];
                        let phase = row % side * side + column % side;
                        codes[(phase * part[1] + row / side) * part[0] + column / side] = code;
                    }
                }
            }
        }
        Phases { codes, part }
    }

    fn part(&self, phase: usize) -> &[u8] {
        let length = self.part[0] * self.part[1];
        self.codes.get(phase * length..(phase + 1) * length).unwrap_or_default()
    }
}

/// Codes row by row.
struct Picture {
    width: usize,
    codes: Vec<u8>,
}

impl Picture {
    fn padded(field: &LikelihoodField, margin: usize) -> Self {
        let (width, height) = (field.frame().width(), field.frame().height());
        let pitch = width + 2 * margin;
        let mut codes = vec![field.code_off_map(); pitch * (height + 2 * margin)];
        let rows = codes.chunks_exact_mut(pitch).skip(margin);
        for (padded, row) in rows.zip(field.cell_codes().chunks_exact(width)) {
            padded[margin..margin + width].copy_from_slice(row);
        }
        Picture { width: pitch, codes }
    }

    fn height(&self) -> usize {
        self.codes.len() / self.width
    }

    /// The highest code in the window that reaches so many cells to all sides of each cell. Cells
    /// beyond the edge are those of the edge, which is margin.
    fn highest(&self, reach: usize) -> Picture {
        let across: Vec<u8> = self
            .codes
            .chunks_exact(self.width)
            .flat_map(|row| highest_of_line(row.to_vec(), reach))
            .collect();
        let height = self.height();
        let mut codes = vec![0; across.len()];
        for column in 0..self.width {
            let line = (0..height).map(|row| across[row * self.width + column]).collect();
            for (row, code) in highest_of_line(line, reach).into_iter().enumerate() {
                codes[row * self.width + column] = code;
            }
        }
        Picture { width: self.width, codes }
    }
}

/// The highest value within `reach` of each place of a line, by windows that double in length.
fn highest_of_line(line: Vec<u8>, reach: usize) -> Vec<u8> {
    let count = line.len();
    // With `covered` values from each place on known, two such windows make one twice as long.
    let (mut ahead, mut covered) = (line, 1);
    while 2 * covered <= 2 * reach + 1 {
        for k in 0..count {
            ahead[k] = ahead[k].max(ahead[(k + covered).min(count - 1)]);
        }
        covered *= 2;
    }
    let window = |k: usize| {
        let (first, last) = (k.saturating_sub(reach), (k + reach + 1).saturating_sub(covered));
        ahead[first].max(ahead[last.max(first).min(count - 1)])
    };
    (0..count).map(window).collect()
}
