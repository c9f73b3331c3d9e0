//! Bytes of a grid in tiles of 8 x 8, with a margin of one tile all round.

use super::Endpoints;

/// Side of a tile \[cells\]; the margin is as wide.
const SIDE: usize = 8;

/// How many beams are placed before their tiles are read: long enough for vector instructions,
/// short enough to stay in the fastest memory.
const BATCH: usize = 16;

/// The bits of a number in single precision that hold its digits.
const MANTISSA: u32 = (1 << (f32::MANTISSA_DIGITS - 1)) - 1;

/// 8 x 8 cells in one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Tile([u8; SIDE * SIDE]);

#[derive(Debug, Clone)]
pub(super) struct Tiles {
    tiles: Vec<Tile>,
    tiles_per_row: u32,
    /// The last column and row, margin included.
    last: [f32; 2],
    /// Added to a coordinate, it leaves the whole cells at fixed bits of the number: a power of
    /// two above every coordinate. A conversion to integers would cost three times as much.
    anchor: f32,
    /// How many bits of the fraction stand below those.
    fraction_bits: u32,
}

/// Where a cell is stored: its tile, and its place there.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    tile: u32,
    within: u32,
}

impl Tiles {
    /// Tiles for a grid, filled with the code of what lies off the map.
    pub(super) fn new(width: usize, height: usize, off_map: u8) -> Self {
        let [across, up] = [width, height].map(|cells| cells.div_ceil(SIDE) + 2);
        let last = [across, up].map(|tiles| (tiles * SIDE - 1) as f32);
        let tiles = vec![Tile([off_map; SIDE * SIDE]); across * up];
        // At most eight bits of fraction, so that 2.999 stays below 3.
        let whole_bits = (across.max(up) * SIDE).ilog2() + 1;
        let fraction_bits = f32::MANTISSA_DIGITS.saturating_sub(1 + whole_bits).min(8);
        let anchor = 2.0_f32.powi(f32::MANTISSA_DIGITS as i32 - 1 - fraction_bits as i32);
        Tiles { tiles, tiles_per_row: across as u32, last, anchor, fraction_bits }
    }

    pub(super) fn bytes(&self) -> usize {
        self.tiles.len() * size_of::<Tile>()
    }

    /// Gives a cell of the grid its code.
    pub(super) fn set(&mut self, column: usize, row: usize, code: u8) {
        let (column, row) = ((column + SIDE) as u32, (row + SIDE) as u32);
        let Place { tile, within } = self.place(column, row);
        if let Some(tile) = self.tiles.get_mut(tile as usize) {
            tile.0[within as usize % (SIDE * SIDE)] = code;
        }
    }

    /// The code at a place of the grid's frame \[cells\], on the map or off it.
    pub(super) fn at(&self, u: f32, v: f32) -> u8 {
        self.code(self.place_at(u + SIDE as f32, v + SIDE as f32))
    }

    /// The sum of the codes at the ends of beams, seen from `from` \[cells\]; `turn` is cosine and
    /// sine of the heading in cells a metre.
    pub(super) fn sum(&self, from: [f32; 2], turn: [f32; 2], endpoints: &Endpoints) -> u64 {
        let [u, v] = from.map(|coordinate| coordinate + SIDE as f32);
        let [cos, sin] = turn;
        let place = |x: f32, y: f32| self.place_at(u + cos * x - sin * y, v + sin * x + cos * y);
        // All places of a batch first, by vector instructions; then the lookups.
        let batch = |xs: &[f32; BATCH], ys: &[f32; BATCH], beams: usize| {
            let mut tiles = [0; BATCH];
            let mut withins = [0; BATCH];
            for k in 0..BATCH {
                let place = place(xs[k], ys[k]);
                (tiles[k], withins[k]) = (place.tile, place.within);
            }
            let places = tiles.into_iter().zip(withins).take(beams);
            let codes = places.map(|(tile, within)| self.code(Place { tile, within }));
            codes.map(u32::from).sum::<u32>()
        };
        let (xs, rest_xs) = endpoints.xs().as_chunks::<BATCH>();
        let (ys, rest_ys) = endpoints.ys().as_chunks::<BATCH>();
        let whole = xs.iter().zip(ys).map(|(xs, ys)| u64::from(batch(xs, ys, BATCH)));
        let (mut last_xs, mut last_ys) = ([0.0; BATCH], [0.0; BATCH]);
        last_xs[..rest_xs.len()].copy_from_slice(rest_xs);
        last_ys[..rest_ys.len()].copy_from_slice(rest_ys);
        whole.sum::<u64>() + u64::from(batch(&last_xs, &last_ys, rest_xs.len()))
    }

    /// The place of a cell by coordinates from the corner of the margin; what lies outside,
    /// however far, and NaN end up in the margin.
    #[inline(always)]
    fn place_at(&self, u: f32, v: f32) -> Place {
        // In this form NaN fails both comparisons and one instruction does each of them.
        let clamp = |x: f32, last: f32| {
            let x = if x > 0.0 { x } else { 0.0 };
            if x < last { x } else { last }
        };
        let whole = |x: f32| ((x + self.anchor).to_bits() & MANTISSA) >> self.fraction_bits;
        self.place(whole(clamp(u, self.last[0])), whole(clamp(v, self.last[1])))
    }

    #[inline(always)]
    fn place(&self, column: u32, row: u32) -> Place {
        let tile = (row / 8) * self.tiles_per_row + column / 8;
        Place { tile, within: (row % 8) * 8 + column % 8 }
    }

    #[inline(always)]
    fn code(&self, place: Place) -> u8 {
        let tile = self.tiles.get(place.tile as usize);
        tile.map_or(0, |tile| tile.0[place.within as usize % (SIDE * SIDE)])
    }
}
