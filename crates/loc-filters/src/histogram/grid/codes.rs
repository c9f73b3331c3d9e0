//! The likelihood field with a margin, for rating a whole square at once.

use super::picture::Picture;
use loc_maps::LikelihoodField;

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
