//! Bytes of a grid in tiles of 8 x 8, with a margin of one tile all round.

use super::Endpoints;

/// Side of a tile \[cells\]; the margin is as wide.
const SIDE: usize = 8;

/// How many beams are placed before their tiles are read: long enough for vector instructions,
/// short enough to stay in the fastest memory.
const BATCH: usize = 32;

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
}

impl Tiles {
    /// Tiles for a grid, filled with the code of what lies off the map.
    pub(super) fn new(width: usize, height: usize, off_map: u8) -> Self {
        let [across, up] = [width, height].map(|cells| cells.div_ceil(SIDE) + 2);
        let last = [across, up].map(|tiles| (tiles * SIDE - 1) as f32);
        let tiles = vec![Tile([off_map; SIDE * SIDE]); across * up];
        Tiles { tiles, tiles_per_row: across as u32, last }
    }

    pub(super) fn bytes(&self) -> usize {
        self.tiles.len() * size_of::<Tile>()
    }

    /// Gives a cell of the grid its code.
    pub(super) fn set(&mut self, column: usize, row: usize, code: u8) {
        let place = self.place((column + SIDE) as f32, (row + SIDE) as f32);
        if let Some(tile) = self.tiles.get_mut(place as usize / 64) {
            tile.0[place as usize % 64] = code;
        }
    }

    /// The code at a place of the grid's frame \[cells\], on the map or off it.
    pub(super) fn at(&self, u: f32, v: f32) -> u8 {
        self.code(self.place(u + SIDE as f32, v + SIDE as f32))
    }

    /// The sum of the codes at the ends of beams, seen from `from` \[cells\]; `turn` is cosine and
    /// sine of the heading in cells a metre.
    pub(super) fn sum(&self, from: [f32; 2], turn: [f32; 2], endpoints: &Endpoints) -> u64 {
        let [u, v] = from.map(|coordinate| coordinate + SIDE as f32);
        let [cos, sin] = turn;
        let mut sum = 0;
        let batches = endpoints.xs().chunks(BATCH).zip(endpoints.ys().chunks(BATCH));
        for (xs, ys) in batches {
            let mut places = [0_u32; BATCH];
            for (place, (&x, &y)) in places.iter_mut().zip(xs.iter().zip(ys)) {
                *place = self.place(u + cos * x - sin * y, v + sin * x + cos * y);
            }
            let codes = places.iter().take(xs.len()).map(|&place| u32::from(self.code(place)));
            sum += u64::from(codes.sum::<u32>());
        }
        sum
    }

    /// Where a cell is stored, its coordinates counted from the corner of the margin.
    #[inline]
    fn place(&self, u: f32, v: f32) -> u32 {
        // What lies outside, however far, ends up in the margin; NaN does too.
        let column = u.max(0.0).min(self.last[0]) as i32 as u32;
        let row = v.max(0.0).min(self.last[1]) as i32 as u32;
        let tile = (row / 8) * self.tiles_per_row + column / 8;
        tile * 64 + (row % 8) * 8 + column % 8
    }

    #[inline]
    fn code(&self, place: u32) -> u8 {
        self.tiles.get((place / 64) as usize).map_or(0, |tile| tile.0[(place % 64) as usize])
    }
}
