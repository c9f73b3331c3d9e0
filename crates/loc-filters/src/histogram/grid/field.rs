//! The likelihood field of a map in the two forms that a grid needs: padded with a margin, to rate a whole
//! square at once, and as maxima over windows, to bound the likelihood of a cell.

use super::correct::Scan;
use super::space::PoseSpace;
use loc_maps::LikelihoodField;

/// Codes row by row, with a margin that stands for what lies off the map.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    width: usize,
    codes: Vec<u8>,
}

impl Picture {
    /// The codes of a field with a margin of so many cells.
    pub(super) fn padded(field: &LikelihoodField, margin: usize) -> Self {
        let (width, height) = (field.frame().width(), field.frame().height());
        let pitch = width + 2 * margin;
        let mut codes = vec![field.code_off_map(); pitch * (height + 2 * margin)];
        let rows = codes.chunks_exact_mut(pitch).skip(margin);
        for (padded, row) in rows.zip(field.cell_codes().chunks_exact(width)) {
            padded[margin..margin + width].copy_from_slice(row);
        }
        Picture { width: pitch, codes }
    }

    /// Columns, margin included.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// The codes row by row.
    pub(super) fn codes(&self) -> &[u8] {
        &self.codes
    }

    /// The highest code in the window that reaches so many cells to all sides of each cell, at most
    /// as many as the margin is wide.
    ///
    /// Rows are taken as one long line: what a window sees of the row before or after it is margin,
    /// as what it would see beyond the edge is.
    pub(super) fn highest(&self, reach: usize) -> Picture {
        let across = highest_of_line(&self.codes, reach, 1);
        Picture { width: self.width, codes: highest_of_line(&across, reach, self.width) }
    }
}

/// The highest value within `reach` steps of each place, by windows that double in length.
fn highest_of_line(line: &[u8], reach: usize, step: usize) -> Vec<u8> {
    // `ahead` holds the highest of `covered` values from each place on; two of them side by side
    // make one that covers twice as many.
    let (mut ahead, mut covered) = (line.to_vec(), 1);
    while 2 * covered <= 2 * reach + 1 {
        let mut twice = ahead.clone();
        take_higher(&mut twice, ahead.get(covered * step..).unwrap_or_default());
        ahead = twice;
        covered *= 2;
    }
    // One window from the first place within reach on, and one up to the last.
    let mut highest = line.to_vec();
    for back in [reach, covered - reach - 1] {
        take_higher(highest.get_mut(back * step..).unwrap_or_default(), &ahead);
    }
    highest
}

fn take_higher(values: &mut [u8], others: &[u8]) {
    values.iter_mut().zip(others).for_each(|(value, other)| *value = (*value).max(*other));
}

/// A picture sorted by column and row modulo the side of a square: each part holds every `side`-th
/// column of every `side`-th row.
#[derive(Debug, Clone)]
pub(super) struct Phases {
    codes: Vec<u8>,
    side: usize,
    /// Columns and rows of each part.
    part: [usize; 2],
}

impl Phases {
    pub(super) fn of(picture: &Picture, side: usize) -> Self {
        let height = picture.codes.len() / picture.width;
        let part = [picture.width.div_ceil(side), height.div_ceil(side)];
        let last = [picture.width - 1, height - 1];
        let mut codes = Vec::with_capacity(part[0] * part[1] * side * side);
        // What the last squares have beyond the picture counts as its edge, which is margin.
        for phase in 0..side * side {
            let (phase_x, phase_y) = (phase % side, phase / side);
            for row in (0..part[1]).map(|row| (row * side + phase_y).min(last[1])) {
                let row = &picture.codes[row * picture.width..(row + 1) * picture.width];
                let column = |column: usize| (column * side + phase_x).min(last[0]);
                codes.extend((0..part[0]).map(|k| row[column(k)]));
            }
        }
        Phases { codes, side, part }
    }

    /// Columns and rows of each part.
    pub(super) fn part_size(&self) -> [usize; 2] {
        self.part
    }

    /// The part of these columns and rows, row by row.
    pub(super) fn part(&self, phase_x: usize, phase_y: usize) -> &[u8] {
        let length = self.part[0] * self.part[1];
        let first = (phase_y * self.side + phase_x) * length;
        self.codes.get(first..first + length).unwrap_or_default()
    }
}

/// The codes of the field row by row, with a margin that stands for all that lies off the map.
#[derive(Debug, Clone)]
pub(super) struct PaddedCodes {
    picture: Picture,
    /// Columns and rows of the map.
    map: [usize; 2],
    /// Cells along the side of a square; the margin is as wide.
    side: usize,
}

/// Where beams end, as columns and rows from the robot's cell.
pub(super) type Ends = [[i32; 2]];

impl PaddedCodes {
    pub(super) fn new(field: &LikelihoodField, side: usize) -> Self {
        let map = [field.frame().width(), field.frame().height()];
        PaddedCodes { picture: Picture::padded(field, side), map, side }
    }

    /// For each cell of the square with this corner, the sum of the codes at the ends of beams from
    /// its middle; row by row into `sums`.
    pub(super) fn sums(&self, corner: [usize; 2], ends: &Ends, sums: &mut [u32]) {
        sums.fill(0);
        match self.side {
            1 => self.add::<1>(corner, ends, sums),
            2 => self.add::<2>(corner, ends, sums),
            3 => self.add::<3>(corner, ends, sums),
            4 => self.add::<4>(corner, ends, sums),
            5 => self.add::<5>(corner, ends, sums),
            6 => self.add::<6>(corner, ends, sums),
            8 => self.add::<8>(corner, ends, sums),
            10 => self.add::<10>(corner, ends, sums),
            _ => self.add_any(corner, ends, sums),
        }
    }

    /// The place of the first code of a square whose beams end there; squares beyond the margin are
    /// moved into it.
    #[inline(always)]
    fn start(&self, [column, row]: [usize; 2], [dx, dy]: [i32; 2]) -> usize {
        let place = |at: usize, by: i32, cells: usize| {
            let padded = at as i64 + i64::from(by) + self.side as i64;
            padded.clamp(0, (cells + self.side) as i64) as usize
        };
        place(row, dy, self.map[1]) * self.picture.width() + place(column, dx, self.map[0])
    }

    #[inline(always)]
    fn add<const SIDE: usize>(&self, corner: [usize; 2], ends: &Ends, sums: &mut [u32]) {
        let (codes, pitch) = (self.picture.codes(), self.picture.width());
        let mut of_square = [[0_u32; SIDE]; SIDE];
        for &end in ends {
            let start = self.start(corner, end);
            for (row, sums) in of_square.iter_mut().enumerate() {
                let ahead = codes.get(start + row * pitch..);
                let codes: &[u8; SIDE] = ahead.and_then(<[u8]>::first_chunk).unwrap_or(&[0; SIDE]);
                for (sum, &code) in sums.iter_mut().zip(codes) {
                    *sum += u32::from(code);
                }
            }
        }
        sums.iter_mut().zip(of_square.as_flattened()).for_each(|(sum, code)| *sum += code);
    }

    fn add_any(&self, corner: [usize; 2], ends: &Ends, sums: &mut [u32]) {
        let (codes, pitch) = (self.picture.codes(), self.picture.width());
        for &end in ends {
            let start = self.start(corner, end);
            for (row, sums) in sums.chunks_exact_mut(self.side).enumerate() {
                let first = start + row * pitch;
                let codes = codes.get(first..first + self.side).unwrap_or_default();
                sums.iter_mut().zip(codes).for_each(|(sum, &code)| *sum += u32::from(code));
            }
        }
    }
}

/// How many sizes of windows there are.
const SIZES: usize = 7;

/// From one size to the next, about.
const GROWTH: f64 = 1.4;

/// As many codes as 16 bits can hold the sum of.
const IN_16_BITS: usize = 257;

/// Rounding of an end in cells.
const ROUNDING: f64 = 1e-6;

/// The highest codes in windows about all cells.
///
/// Seen from any pose of a square and a sector of headings, a beam ends within a small window about its
/// end as seen from the middle. The highest likelihood in that window is computed beforehand, for
/// windows of several sizes; the sum over the beams bounds the likelihood of every pose of the cell.
///
/// The maxima are sorted by their column and row modulo the side of a square: the ends of one beam
/// seen from a row of squares are then neighbours in memory, and are added many at a time.
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
            // Beyond the largest window: no bound but the highest code.
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
