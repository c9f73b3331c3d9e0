//! The pyramid: the best codes of a map over windows of 1, 4, 16 and 64 cells, and their sums over
//! the beams of a scan.
//!
//! [`Pyramid`] holds a [`Level`] for each size of window. [`RotatedScan`] has the beams' ends in
//! cells at every heading; [`rows`] and [`block`] add up the codes at these ends for many
//! neighbouring windows at a time. They are plain loops over bytes, which `pulp` compiles for the
//! vector instructions of several generations of processors; the callers choose among them at run
//! time.

use crate::grid::{GridFrame, Occupancy};
use crate::likelihood_field::Endpoints;
use crate::{Error, LikelihoodField, OccupancyGrid, Result};
use std::f64::consts::TAU;
use std::ops::Range;

/// A window holds 4 x 4 of the level below.
pub(super) const FAN: usize = 4;

/// Number of neighbouring windows of the top level that are summed together.
pub(super) const GROUP: usize = 32;

/// Windows of the top level, times headings, above which there is one more level.
const MANY: usize = 1 << 25;

/// Maximum bytes of a level: indices in it fit into 31 bits.
const MAX_BYTES: usize = 3 << 29;

/// The levels of a map.
#[derive(Debug, Clone)]
pub(super) struct Pyramid {
    /// The largest windows, where a search starts.
    pub(super) top: Level,
    /// The levels below, from single cells up.
    pub(super) levels: Vec<Level>,
}

/// Codes and free cells of windows that grow.
struct Windows {
    codes: Bordered,
    free: Vec<bool>,
    free_size: [usize; 2],
}

impl Pyramid {
    pub(super) fn new(
        map: &OccupancyGrid,
        field: &LikelihoodField,
        headings: usize,
    ) -> Result<Self> {
        let size = [map.width(), map.height()];
        let windows = |shift: u32| size.iter().map(|cells| cells.div_ceil(1 << shift)).product();
        let top = if headings.saturating_mul(windows(4)) > MANY { 6 } else { 4 };
        let group = size[0].div_ceil(1 << top).next_multiple_of(GROUP);
        let layout = |shift| match shift {
            _ if shift == top => Layout { shift, margin: [group, 1], lanes: 1 },
            _ => Layout { shift, margin: [FAN; 2], lanes: FAN },
        };
        let shifts = (0..=top).step_by(2);
        let largest = shifts.clone().map(|shift| layout(shift).bytes(size)).max().unwrap_or(0);
        if largest > MAX_BYTES {
            let (what, expected) = ("map of a global search", "at most 1.5 GiB a level");
            return Err(Error::Core(loc_core::Error::Length { what, expected, found: largest }));
        }
        let mut windows = Windows::new(map, field, 1 << top);
        let levels = shifts.take_while(|shift| *shift < top).map(|shift| {
            let level = windows.level(layout(shift));
            windows.grow(1 << shift);
            level
        });
        let levels = levels.collect();
        Ok(Pyramid { top: windows.level(layout(top)), levels })
    }

    /// Memory \[bytes\].
    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().chain([&self.top]).map(Level::bytes).sum()
    }
}

impl Windows {
    /// Windows of one cell.
    fn new(map: &OccupancyGrid, field: &LikelihoodField, border: usize) -> Self {
        let is_free = |&value: &i8| Occupancy::of(value) == Occupancy::Free;
        let free = map.values().iter().map(is_free).collect();
        let codes = bordered(field, border);
        Windows { free_size: codes.size, codes, free }
    }

    /// From windows of side `side` to those of 4 x 4 of them.
    fn grow(&mut self, side: usize) {
        widen(&mut self.codes, side);
        widen(&mut self.codes, 2 * side);
        (self.free, self.free_size) = any_of(&self.free, self.free_size);
    }

    fn level(&self, layout: Layout) -> Level {
        Level::new(&self.codes, layout, self.free.clone())
    }
}

/// The codes of the map with a border of what lies off it.
fn bordered(field: &LikelihoodField, border: usize) -> Bordered {
    let size = [field.frame().width(), field.frame().height()];
    let [width, height] = size.map(|cells| cells + 2 * border);
    let off_map = field.code_off_map();
    let mut codes = vec![off_map; width * height];
    let rows = codes.chunks_exact_mut(width).skip(border);
    for (target, row) in rows.zip(field.cell_codes().chunks_exact(size[0])) {
        target[border..border + size[0]].copy_from_slice(row);
    }
    Bordered { codes, off_map, size, border }
}

/// Best codes of windows of side `step` become those of windows twice as wide.
fn widen(windows: &mut Bordered, step: usize) {
    let width = windows.size[0] + 2 * windows.border;
    let codes = &mut windows.codes;
    for row in codes.chunks_exact_mut(width) {
        for column in 0..width.saturating_sub(step) {
            row[column] = row[column].max(row[column + step]);
        }
    }
    for row in 0..(codes.len() / width).saturating_sub(step) {
        let (lower, upper) = codes.split_at_mut((row + step) * width);
        let lower = &mut lower[row * width..][..width];
        lower.iter_mut().zip(upper).for_each(|(low, &mut up)| *low = (*low).max(up));
    }
}

/// Whether any of 4 x 4 is true.
fn any_of(free: &[bool], [width, height]: [usize; 2]) -> (Vec<bool>, [usize; 2]) {
    let size = [width.div_ceil(FAN), height.div_ceil(FAN)];
    let mut any = vec![false; size[0] * size[1]];
    for (row, line) in free.chunks_exact(width).enumerate() {
        let target = &mut any[row / FAN * size[0]..][..size[0]];
        for (target, part) in target.iter_mut().zip(line.chunks(FAN)) {
            *target |= part.contains(&true);
        }
    }
    (any, size)
}

/// How the codes of a level lie in memory, which depends on how many are read at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Sides of a window: `2^shift` cells.
    pub(super) shift: u32,
    /// Width and height of what is read at once \[windows\]; a margin as wide catches what falls
    /// off the map.
    pub(super) margin: [usize; 2],
    /// Number of vertically neighbouring windows stored together, for each row again.
    pub(super) lanes: usize,
}

/// For every cell, the largest code in the square window that has this cell in its lower-left
/// corner.
///
/// A search reads windows that lie a whole number of windows apart, many at a time. These stand
/// side by side: windows are sorted by the remainders of their column and row modulo their side,
/// and all of the same remainders form an image.
#[derive(Debug, Clone)]
pub(super) struct Level {
    shift: u32,
    margin: [i32; 2],
    lanes: i32,
    /// Windows that begin on the map, in a row and in a column of the first image.
    size: [i32; 2],
    /// From one row of an image to the next, and from one image to the next \[windows\].
    pitch: i32,
    image: i32,
    codes: Vec<u8>,
    /// Whether the windows of the first image hold a free cell.
    free: Vec<bool>,
}

/// Codes of windows for every cell of a map with a border of what lies off it.
#[derive(Debug)]
pub(super) struct Bordered {
    pub(super) codes: Vec<u8>,
    pub(super) off_map: u8,
    /// Columns and rows of the map.
    pub(super) size: [usize; 2],
    pub(super) border: usize,
}

impl Layout {
    /// Pitch and rows of an image for a map of this many cells. Right of a row lies the margin of
    /// the next one, and a column more, since the windows of column -1 reach into the map.
    fn image(self, cells: [usize; 2]) -> [usize; 2] {
        let [columns, rows] = cells.map(|cells| cells.div_ceil(1 << self.shift));
        [columns + self.margin[0] + 1, rows + 2 * self.margin[1]]
    }

    /// Bytes of the codes for a map of this many cells.
    pub(super) fn bytes(self, cells: [usize; 2]) -> usize {
        let images = self.lanes << (2 * self.shift);
        self.image(cells).into_iter().fold(images, usize::saturating_mul)
    }
}

impl Level {
    pub(super) fn new(from: &Bordered, layout: Layout, free: Vec<bool>) -> Self {
        let Layout { shift, margin, lanes } = layout;
        let side = 1_usize << shift;
        let [columns, rows] = from.size.map(|cells| cells.div_ceil(side));
        let [pitch, height] = layout.image(from.size);
        let image = pitch * height;
        // What is read from the last margin of all ends beyond it.
        let mut codes = vec![from.off_map; layout.bytes(from.size) + 2 * margin[0] * lanes];
        let width = from.size[0] + 2 * from.border;
        for (phase, image) in codes.chunks_exact_mut(image * lanes).take(side * side).enumerate() {
            // From row -1 on, whose windows reach into the map.
            for row in 0..=rows {
                let line = (from.border - side + phase / side + row * side) * width;
                let first = line + from.border - side + phase % side;
                let windows = from.codes[first..line + width].iter().step_by(side);
                for lane in 0..lanes {
                    let start = (row + margin[1] - 1 - lane) * pitch + margin[0] - 1;
                    let target = &mut image[start * lanes..(start + columns + 1) * lanes];
                    let target = target.iter_mut().skip(lane).step_by(lanes);
                    target.zip(windows.clone()).for_each(|(target, &code)| *target = code);
                }
            }
        }
        let [pitch, image, lanes] = [pitch, image, lanes].map(|size| size as i32);
        let [margin, size] = [margin, [columns, rows]].map(|pair| pair.map(|size| size as i32));
        Level { shift, margin, lanes, size, pitch, image, codes, free }
    }

    pub(super) fn bytes(&self) -> usize {
        self.codes.len() + self.free.len()
    }

    pub(super) fn shift(&self) -> u32 {
        self.shift
    }

    /// Windows that begin on the map a whole number of windows from cell (0, 0).
    pub(super) fn size(&self) -> [usize; 2] {
        self.size.map(|size| size as usize)
    }

    /// Whether each window of a row holds a free cell; empty above the map.
    pub(super) fn free_row(&self, row: usize) -> &[bool] {
        self.free.chunks_exact(self.size()[0]).nth(row).unwrap_or_default()
    }

    /// Whether a window holds a free cell; not off the map.
    #[inline(always)]
    pub(super) fn is_free(&self, column: u32, row: u32) -> bool {
        let inside = (column as i32) < self.size[0];
        let index = row as usize * self.size[0] as usize + column as usize;
        inside && self.free.get(index).copied().unwrap_or(false)
    }

    /// Where the codes begin of what is read from the window on that has cell (x, y), on the map
    /// or off it, in its corner.
    #[inline(always)]
    pub(super) fn start(&self, x: i32, y: i32) -> u32 {
        let mask = (1 << self.shift) - 1;
        let phase = ((y & mask) << self.shift) | (x & mask);
        let clamp = |at: i32, margin: i32, size: i32| (at >> self.shift).max(-margin).min(size);
        let column = clamp(x, self.margin[0], self.size[0]) + self.margin[0];
        let row = clamp(y, self.margin[1], self.size[1]) + self.margin[1];
        ((phase * self.image + row * self.pitch + column) * self.lanes) as u32
    }

    /// All codes; a start is where some begin.
    #[inline(always)]
    pub(super) fn codes(&self) -> &[u8] {
        &self.codes
    }
}

/// Codes whose sum fits into 16 bits: 257 x 255 = 65535.
const IN_16_BITS: usize = 257;

/// Rows of windows that are summed together: their sums stay in the first-level cache.
const BAND: usize = 16;

/// Columns and rows from the robot's cell to those in which the beams end.
pub(super) type EndCells<'a> = [&'a [i32]; 2];

/// Adds up the codes of all windows of the top level: to row `k` of `sums`, which has `pitch`
/// columns, those of the groups of windows that `extents` names.
#[inline(always)]
pub(super) fn rows(
    level: &Level,
    extents: &[Range<usize>],
    [xs, ys]: EndCells<'_>,
    pitch: usize,
    sums: &mut [u32],
) {
    let mut short = vec![0_u16; BAND * pitch];
    sums.fill(0);
    let bands = extents.chunks(BAND).zip(sums.chunks_mut(BAND * pitch)).enumerate();
    for (band, (extents, sums)) in bands {
        for (xs, ys) in xs.chunks(IN_16_BITS).zip(ys.chunks(IN_16_BITS)) {
            short.fill(0);
            for (&x, &y) in xs.iter().zip(ys) {
                for (row, (extent, short)) in
                    extents.iter().zip(short.chunks_exact_mut(pitch)).enumerate()
                {
                    let corner = [extent.start, band * BAND + row];
                    let [column, row] = corner.map(|window| (window << level.shift()) as i32);
                    let start = level.start(column + x, row + y) as usize;
                    let codes = level.codes().get(start..start + extent.len());
                    add(
                        short.get_mut(extent.clone()).unwrap_or_default(),
                        codes.unwrap_or_default(),
                    );
                }
            }
            sums.iter_mut().zip(&short).for_each(|(sum, &short)| *sum += u32::from(short));
        }
    }
}

#[inline(always)]
fn add(sums: &mut [u16], codes: &[u8]) {
    let groups = sums.as_chunks_mut::<GROUP>().0.iter_mut().zip(codes.as_chunks::<GROUP>().0);
    for (sums, codes) in groups {
        let mut group = *sums;
        for k in 0..GROUP {
            group[k] += u16::from(codes[k]);
        }
        *sums = group;
    }
}

/// The sums of [`FAN`] x [`FAN`] windows from that with cell (x, y) in its corner on, column by
/// column. `starts` is scratch.
#[inline(always)]
pub(super) fn block(
    level: &Level,
    [x, y]: [i32; 2],
    [xs, ys]: EndCells<'_>,
    starts: &mut Vec<u32>,
) -> [u32; FAN * FAN] {
    starts.clear();
    starts.extend(xs.iter().zip(ys).map(|(dx, dy)| level.start(x + dx, y + dy)));
    let mut sums = [0; FAN * FAN];
    for starts in starts.chunks(IN_16_BITS) {
        let mut short = [0_u16; FAN * FAN];
        for &start in starts {
            let codes = level.codes().get(start as usize..).and_then(<[u8]>::first_chunk);
            let codes: &[u8; FAN * FAN] = codes.unwrap_or(&[0; FAN * FAN]);
            short.iter_mut().zip(codes).for_each(|(sum, &code)| *sum += u16::from(code));
        }
        sums.iter_mut().zip(short).for_each(|(sum, short)| *sum += u32::from(short));
    }
    sums
}

/// The scan rotated to every heading of the search: the ends of all beams in whole cells from the
/// robot's.
#[derive(Debug)]
pub(super) struct RotatedScan {
    beams: usize,
    headings: usize,
    xs: Vec<i32>,
    ys: Vec<i32>,
}

/// No beam reaches farther \[cells\]; added to a cell of a map, it fits into 32 bits.
const FARTHEST: f64 = (1 << 29) as f64;

/// Heading `index` of `count` in the map \[rad\], in (-pi, pi].
pub(super) fn heading(index: u32, count: usize) -> f64 {
    loc_core::angle::wrap(f64::from(index) * TAU / count as f64)
}

impl RotatedScan {
    pub(super) fn new(endpoints: &Endpoints, frame: &GridFrame, headings: usize) -> Self {
        let beams = endpoints.len();
        let [mut xs, mut ys] = [(); 2].map(|()| Vec::with_capacity(beams * headings));
        // The robot is in the middle of its cell.
        let cell = |length: f64| (length / frame.resolution() + 0.5).floor();
        let cell = |length: f64| cell(length).clamp(-FARTHEST, FARTHEST) as i32;
        for index in 0..headings as u32 {
            let (sin, cos) = (heading(index, headings) - frame.origin().theta).sin_cos();
            for (&x, &y) in endpoints.xs().iter().zip(endpoints.ys()) {
                let (x, y) = (f64::from(x), f64::from(y));
                xs.push(cell(cos * x - sin * y));
                ys.push(cell(sin * x + cos * y));
            }
        }
        RotatedScan { beams, headings, xs, ys }
    }

    pub(super) fn beams(&self) -> usize {
        self.beams
    }

    pub(super) fn headings(&self) -> usize {
        self.headings
    }

    /// The ends at one heading.
    pub(super) fn at(&self, heading: usize) -> EndCells<'_> {
        let range = heading * self.beams..(heading + 1) * self.beams;
        [&self.xs, &self.ys].map(|ends| ends.get(range.clone()).unwrap_or_default())
    }
}
