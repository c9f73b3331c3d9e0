//! Squares that touch each other.

use super::{Blocks, ROW, SIDE, SQUARES, Square};

impl Blocks {
    /// Hands out every occupied square with its neighbours to the right, above left, above, and
    /// above right, so that each two squares that touch come together once.
    pub(in super::super) fn for_neighbours(&self, mut work: impl FnMut(&Square, [&Square; 4])) {
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
