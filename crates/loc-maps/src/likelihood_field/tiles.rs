//! Bytes of a grid in tiles of 8 x 8, with a margin of one tile all round.

use super::Endpoints;

/// Side of a tile \[cells\]; the margin is as wide.
const SIDE: usize = 8;

/// How many beams are placed before their tiles are read: long enough for vector instructions,
/// short enough to stay in the fastest memory.
const BATCH: usize = 16;

/// The bits of a number in single precision that hold its digits.
const MANTISSA: u32 = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;

/// How many bytes the processor fetches together: a tile.
const LINE: usize = SIDE * SIDE;

#[derive(Debug, Clone)]
pub(super) struct Tiles {
    /// The codes tile by tile, from `start` on, so that tiles begin where cache lines do.
    codes: Vec<u8>,
    start: usize,
    tiles_per_row: u32,
    /// The last column and row, margin included.
    last: [f32; 2],
    /// Added to a coordinate, it leaves the whole cells at fixed bits of the number: a power of
    /// two above every coordinate. A conversion to integers would cost three times as much.
    anchor: f32,
    /// How many bits of the fraction stand below those.
    fraction_bits: u32,
}

impl Tiles {
    /// Tiles for a grid, filled with the code of what lies off the map.
    pub(super) fn new(width: usize, height: usize, off_map: u8) -> Self {
        let [across, up] = [width, height].map(|cells| cells.div_ceil(SIDE) + 2);
        let last = [across, up].map(|tiles| (tiles * SIDE - 1) as f32);
        let codes = vec![off_map; across * up * LINE + LINE];
        let start = codes.as_ptr().align_offset(LINE).min(LINE);
        // At most eight bits of fraction, so that 2.999 stays below 3.
        let whole_bits = (across.max(up) * SIDE).ilog2() + 1;
        let fraction_bits = f32::MANTISSA_DIGITS.saturating_sub(1 + whole_bits).min(8);
        let anchor = (1_u32 << (f32::MANTISSA_DIGITS - 1 - fraction_bits)) as f32;
        Tiles { codes, start, tiles_per_row: across as u32, last, anchor, fraction_bits }
    }

    pub(super) fn bytes(&self) -> usize {
        self.codes.len()
    }

    /// Gives a cell of the grid its code.
    pub(super) fn set(&mut self, column: usize, row: usize, code: u8) {
        let place = self.place((column + SIDE) as u32, (row + SIDE) as u32) as usize;
        if let Some(place) = self.codes.get_mut(self.start + place) {
            *place = code;
        }
    }

    /// The code at a place of the grid's frame \[cells\], on the map or off it.
    pub(super) fn at(&self, u: f32, v: f32) -> u8 {
        code(self.aligned(), self.place_at(u + SIDE as f32, v + SIDE as f32))
    }

    /// The sum of the codes at the ends of beams, seen from `from` \[cells\]; `turn` is cosine and
    /// sine of the heading in cells a metre.
    pub(super) fn sum(&self, from: [f32; 2], turn: [f32; 2], endpoints: &Endpoints) -> u64 {
        let [u, v] = from.map(|coordinate| coordinate + SIDE as f32);
        let [cos, sin] = turn;
        let codes = self.aligned();
        let place = |x: f32, y: f32| self.place_at(u + cos * x - sin * y, v + sin * x + cos * y);
        // All places of a batch first, by vector instructions; then the lookups.
        let batch = |xs: &[f32; BATCH], ys: &[f32; BATCH]| {
            let mut places = [0; BATCH];
            for (k, at) in places.iter_mut().enumerate() {
                *at = place(xs[k], ys[k]);
            }
            let mut sum = 0;
            for at in places {
                sum += u32::from(code(codes, at));
            }
            u64::from(sum)
        };
        let (xs, rest_xs) = endpoints.xs().as_chunks::<BATCH>();
        let (ys, rest_ys) = endpoints.ys().as_chunks::<BATCH>();
        let whole: u64 = xs.iter().zip(ys).map(|(xs, ys)| batch(xs, ys)).sum();
        if rest_xs.is_empty() {
            return whole;
        }
        // The rest is filled up with beams that end where they begin, which are taken off again.
        let (mut last_xs, mut last_ys) = ([0.0; BATCH], [0.0; BATCH]);
        last_xs[..rest_xs.len()].copy_from_slice(rest_xs);
        last_ys[..rest_ys.len()].copy_from_slice(rest_ys);
        let fillers = (BATCH - rest_xs.len()) as u64;
        whole + batch(&last_xs, &last_ys) - fillers * u64::from(code(codes, place(0.0, 0.0)))
    }

    fn aligned(&self) -> &[u8] {
        self.codes.get(self.start..).unwrap_or_default()
    }

    /// The place of a cell by coordinates from the corner of the margin; what lies outside,
    /// however far, and NaN end up in the margin.
    #[inline(always)]
    fn place_at(&self, u: f32, v: f32) -> u32 {
        // In this form NaN fails both comparisons and one instruction does each of them.
        let clamp = |x: f32, last: f32| {
            let x = if x > 0.0 { x } else { 0.0 };
            if x < last { x } else { last }
        };
        let whole = |x: f32| ((x + self.anchor).to_bits() & MANTISSA) >> self.fraction_bits;
        self.place(whole(clamp(u, self.last[0])), whole(clamp(v, self.last[1])))
    }

    #[inline(always)]
    fn place(&self, column: u32, row: u32) -> u32 {
        let tile = (row / 8) * self.tiles_per_row + column / 8;
        tile * LINE as u32 + (row % 8) * 8 + column % 8
    }
}

/// The code at a place, which lies in the tiles as the coordinates that it came from are clamped.
#[inline(always)]
fn code(codes: &[u8], place: u32) -> u8 {
    codes[place as usize]
}
